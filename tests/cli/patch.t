#!/bin/sh
# pipelines/patch.mk: what it makes, what it makes again after an edit, and what is left when it is killed.
. "${ROOT:-.}/tests/tools/tap.sh"

part plate1 --facets 32
part filleted --nasty
cp plate1.stl given.stl
stages='curv.ply segment.ply rectify.ply fitcurves.ply fitpatch.ply assemble.ply polish.ply ffx stl'

# same FOLDER FOLDER PART: the same bytes of every stage
same() {
	for stage in $stages; do
		cmp "$1/$3.$stage" "$2/$3.$stage" || return 1
	done
}
# later PART FILE: stages of the part in folder a that are newer than FILE
later() {
	for stage in $stages; do
		[ -n "$(find "a/$1.$stage" -newer "$2")" ] && printf '%s ' "$stage"
	done
}

patch EFFORT=0 IN=plate1.stl OUT=a > log 2>&1
ok $? 'packs a part'
for stage in $stages; do
	[ -s a/plate1.$stage ]
	ok $? "... and makes plate1.$stage"
done
is 1 "$(grep -c '^plate1: [0-9]* bytes, mean .* largest .* within its bounds' log)" '... and says how large and how near it is'
at_most "$(value sym_mean_side a/plate1.report)" 0.001 '... within the mean'
at_most "$(value sym_max_side a/plate1.report)" 0.01 '... within the maximum'
is '0 0' "$(value b_open_edges a/plate1.report) $(value b_nonmanifold_edges a/plate1.report)" '... watertight'
"$BIN/unpack" --check a/plate1.ffx
ok $? '... with a sound stream'
is '' "$(find a -name '.*.??????')" '... and leaves nothing else'
cmp -s plate1.stl given.stl
ok $? '... and the part as it was'

sleep 1.1
touch stamp
patch EFFORT=0 IN=plate1.stl OUT=a > log 2>&1
ok $? 'a second time'
is '' "$(later plate1 stamp)" '... nothing is made again'
patch EFFORT=0 IN=plate1.stl OUT=a TOL=0.2% > log 2>&1
is 'fitcurves.ply fitpatch.ply assemble.ply polish.ply ffx stl ' "$(later plate1 stamp)" 'another bound concerns the stages that know it'
patch EFFORT=0 IN=plate1.stl OUT=a > log 2>&1

# One point of the hole's lower rim, the one farthest along x, moved by 6 further out. The curve is a cubic B-spline: it passes
# (a + 4 b + c) / 6 near the point b, and moves by two thirds as much.
awk -v by=6 '
	/^element/ {order[++kinds] = $2; count[$2] = $3}
	header == 0 {if ($0 == "end_header") {header = NR; line = NR; for (i = 1; i <= kinds; i++) {first[order[i]] = line + 1; line += count[order[i]]}} ; text[NR] = $0; next}
	{text[NR] = $0}
	END {
		for (n = first["curve"]; n < first["curve"] + count["curve"]; n++) {
			split(text[n], f, " ")
			if (f[4] == 1 && found == 0) {
				found = n; m = f[7]
				for (i = 1; i <= m; i++) {point[i - 1] = f[7 + i]; split(text[first["vertex"] + f[7 + i]], p, " "); x[i - 1] = p[1]; y[i - 1] = p[2]; z[i - 1] = p[3]}
			}
		}
		best = 0
		for (i = 1; i < m; i++) if (x[i] > x[best]) best = i
		a = (best + m - 1) % m; c = (best + 1) % m
		printf "%.9g %.9g %.9g\n", (x[a] + 4 * x[best] + x[c]) / 6, (y[a] + 4 * y[best] + y[c]) / 6, z[best] > "old-place"
		printf "%.9g %.9g %.9g\n", (x[a] + 4 * (x[best] + by) + x[c]) / 6, (y[a] + 4 * y[best] + y[c]) / 6, z[best] > "new-place"
		n = first["vertex"] + point[best]
		split(text[n], p, " ")
		text[n] = sprintf("%.9g %s %s %s", p[1] + by, p[2], p[3], p[4])
		for (n = 1; n <= NR; n++) print text[n]
	}' a/plate1.fitcurves.ply > edited.ply
is 2 "$(diff a/plate1.fitcurves.ply edited.ply | grep -c '^[<>]')" 'one line of the network is edited'
# nearest PLACE: distance of the nearest point of a crease of the packed part
nearest() {
	"$BIN/unpack" --cage a/plate1.ffx | "$BIN/refine" --level 5 | awk -v place="$(cat "$1")" '
		BEGIN {split(place, p, " "); best = 1e30}
		/^element/ {order[++kinds] = $2; count[$2] = $3}
		go {
			while (row >= count[order[kind]]) {kind++; row = 0}
			if (order[kind] == "vertex") {x[row] = $1; y[row] = $2; z[row] = $3}
			else if (order[kind] == "edge" && $3 == 1) for (i = 1; i <= 2; i++) {
				d = (x[$i] - p[1]) ^ 2 + (y[$i] - p[2]) ^ 2 + (z[$i] - p[3]) ^ 2
				if (d < best) best = d
			}
			row++
		}
		/^end_header/ {go = 1; kind = 1; row = 0}
		END {print sqrt(best)}'
}
at_most "$(nearest old-place)" 1 'before the edit the rim is at its old place'
at_most 2.5 "$(nearest new-place)" '... and not at the new one'
sleep 1.1
touch stamp
cp edited.ply a/plate1.fitcurves.ply
patch EFFORT=0 IN=plate1.stl OUT=a > log 2>&1
ok $? 'the pipeline goes on from the edited network'
is 'fitcurves.ply fitpatch.ply assemble.ply polish.ply ffx stl ' "$(later plate1 stamp)" '... making only what depends on it'
cmp -s edited.ply a/plate1.fitcurves.ply
ok $? '... and not the network'
at_most "$(nearest new-place)" 1 '... the rim passes where it was moved to'
at_most 2.5 "$(nearest old-place)" '... and no longer where it was'
"$BIN/deviate" plate1.stl a/plate1.stl > deviation
is '0 0' "$(value b_open_edges deviation) $(value b_nonmanifold_edges deviation)" '... and the part is still watertight'

# Several parts, threads, again.
gzip -c filleted.stl > filleted.stl.gz
patch -j2 EFFORT=0 IN='plate1.stl filleted.stl.gz' OUT=b > log 2>&1
ok $? 'two parts at a time, one of them compressed'
[ -s b/plate1.ffx ] && [ -s b/filleted.ffx ]
ok $? '... both are packed'
OMP_NUM_THREADS=1 patch EFFORT=0 IN=plate1.stl OUT=c > log 2>&1 && OMP_NUM_THREADS=1 patch EFFORT=0 IN=filleted.stl OUT=c >> log 2>&1
ok $? 'one after the other with one thread'
OMP_NUM_THREADS=2 patch EFFORT=0 IN=plate1.stl OUT=d > log 2>&1 && OMP_NUM_THREADS=2 patch EFFORT=0 IN=filleted.stl OUT=d >> log 2>&1
ok $? '... with two threads'
same b c plate1 && same b c filleted
ok $? '... the same bytes as together'
same c d plate1 && same c d filleted
ok $? '... the same bytes with one thread and two'

# Killed half way: what is there is whole, and the next run goes on from it.
for delay in 0.1 0.3 0.6; do
	rm -rf k
	(cd "$work" && exec timeout -s TERM $delay make -f "$ROOT/pipelines/patch.mk" BIN="$BIN/" EFFORT=0 IN=plate1.stl OUT=k) > log 2>&1
	partial=0
	for stage in $stages; do
		[ ! -e k/plate1.$stage ] || cmp -s k/plate1.$stage b/plate1.$stage || partial=$((partial + 1))
	done
	is 0 $partial "killed after $delay seconds: every file is whole or absent"
	patch EFFORT=0 IN=plate1.stl OUT=k > log 2>&1 && same k b plate1
	ok $? '... and the next run ends as if nothing had been'
done

# What cannot be packed.
printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n' > broken.stl
patch EFFORT=0 IN=broken.stl OUT=e > log 2>&1
is 2 $? 'a broken part stops make'
is 1 "$(grep -c '^curv: broken.stl' log)" '... with the message of the stage'
is '' "$(find e -name 'broken.*' ! -name '*.bounds')" '... and no file'
patch -k EFFORT=0 IN='broken.stl filleted.stl' OUT=e > log 2>&1
cmp -s e/filleted.ffx b/filleted.ffx
ok $? '-k: the other part is packed all the same'
patch EFFORT=0 IN=plate1.stl OUT=b TOL=0.00001% MAX=0.0001% > log 2>&1
is 1 "$(grep -c '^plate1: .* MISSES its bounds' log)" 'bounds that are not kept are called missed'
mkdir other
cp plate1.stl other
patch EFFORT=0 IN='plate1.stl other/plate1.stl' OUT=f > log 2>&1
is 2 $? 'two parts of one name'
is 1 "$(grep -c 'same part name' log)" '... are refused'
patch EFFORT=0 IN=plate1.stl OUT=. > log 2>&1
is 1 "$(grep -c 'would be overwritten' log)" 'the folder of the part itself is refused'
cmp -s plate1.stl given.stl
ok $? '... and the part stays'
plan
