#!/bin/sh
# fitpatch from the outside: two inputs that must belong together, hand edits, damage, and the figures that known parts must reach.
# shellcheck source=tests/tools/tap.sh
. "${ROOT:-.}/tests/tools/tap.sh"

# ready NAME [OPTIONS of the generator]: NAME.rectify.ply and NAME.fitcurves.ply
ready() {
	part "$@"
	"$BIN/curv" "$1.stl" -o "$1.curv.ply"
	"$BIN/segment" "$1.curv.ply" -o "$1.segment.ply"
	"$BIN/rectify" "$1.segment.ply" -o "$1.rectify.ply"
	"$BIN/fitcurves" -q "$1.rectify.ply" -o "$1.fitcurves.ply"
}
# fit NAME [OPTIONS]: NAME.fitpatch.ply, and what is said in NAME.said
fit() {
	name=$1
	shift
	"$BIN/fitpatch" -v --mesh "$name.rectify.ply" "$name.fitcurves.ply" -o "$name.fitpatch.ply" "$@" 2>"$name.said"
}
# line ELEMENT ROW FILE: the line number of a row of an ascii PLY file
line() {
	awk -v want="$1" -v row="$2" '$1 == "element" && !here {if ($2 == want) here = 1; else before += $3}
		$1 == "end_header" {print NR + before + row + 1; exit}' "$3"
}
# rows ELEMENT FILE: all its rows
rows() {
	rows_count=$(awk -v want="$1" '$1 == "element" && $2 == want {print $3} $1 == "end_header" {exit}' "$2")
	tail -n +"$(line "$1" 0 "$2")" "$2" | head -n "$rows_count"
}
# edit ELEMENT ROW FIELD VALUE FILE: the file with one number changed, on stdout
edit() {
	awk -v at="$(line "$1" "$2" "$5")" -v field="$3" -v value="$4" 'NR == at {$field = value} {print}' "$5"
}
# without ELEMENT ROW FILE: the file less one row, on stdout
without() {
	awk -v at="$(line "$1" "$2" "$3")" -v want="$1" '$1 == "element" && $2 == want && !done {$3--; done = 1} NR != at {print}' "$3"
}
# refuses EXIT PATTERN DESCRIPTION ARGUMENTS: one line that matches, no output
refuses() {
	code=$1 pattern=$2 what=$3
	shift 3
	rm -f out.ply
	"$BIN/fitpatch" "$@" -o out.ply 2>said
	is "$code" $? "$what: exit $code"
	if [ "$(wc -l <said)" -eq 1 ] && grep -q "^fitpatch: $pattern\$" said && [ ! -e out.ply ]; then
		ok 0 "... one line, no output"
	else
		ok 1 "... one line, no output"
		sed 's/^/# /' said
	fi
}
# survives DESCRIPTION ARGUMENTS: a result or a refusal in one line, never a crash
survives() {
	what=$1
	shift
	rm -f out.ply
	timeout 60 "$BIN/fitpatch" "$@" -o out.ply 2>said
	got=$?
	case $got in
	0) [ -s out.ply ] ;;
	3) [ "$(wc -l <said)" -eq 1 ] && [ ! -e out.ply ] ;;
	*) false ;;
	esac
	ok $? "$what"
	[ "$got" -eq 0 ] || [ "$got" -eq 3 ] || echo "# exit $got: $(head -1 said)"
}
# worst NAME [KIND]: the largest error of any patch (of that kind) in per cent of the longest side, from NAME.said
worst() {
	sed -n "s/^fitpatch: patch [0-9]* kind ${2:-[0-9]}: .* max \([^%]*\)% .*/\1/p" "$1.said" | sort -g | tail -1
}
# points FILE: control points of the whole cage: those of the network and those within patches
points() {
	rows vertex "$1" | awk '$5 < 0 {inside++} {if ($5 >= 0 && !seen[$5]++) net++} END {print inside + net}'
}
# column NUMBER OF net in vertex rows is 5 (x y z corner net): checked first of all

ready cylinder --size 800
ready plate1 --size 600

# --- options and streams ---
refuses 2 '--mesh is missing: which dense mesh do the patches lie on?' 'no mesh' cylinder.fitcurves.ply
refuses 2 "--sd must be sided, abs, point or tangent, not 'round'" 'unknown distance' --mesh cylinder.rectify.ply --sd round cylinder.fitcurves.ply
refuses 2 '.*level.*' 'level 0' --mesh cylinder.rectify.ply --level 0 cylinder.fitcurves.ply
refuses 2 '.*rounds.*' 'rounds below 0' --mesh cylinder.rectify.ply --rounds -1 cylinder.fitcurves.ply
refuses 2 '.*tol.*' 'tolerance 0' --mesh cylinder.rectify.ply --tol 0 cylinder.fitcurves.ply
refuses 4 'nosuch.ply: No such file or directory' 'no such mesh' --mesh nosuch.ply cylinder.fitcurves.ply
refuses 4 'nosuch.ply: No such file or directory' 'no such network' --mesh cylinder.rectify.ply nosuch.ply

fit cylinder
is 0 $? 'fits a cylinder'
is 'vertex face netpoint curve patch' "$(for e in vertex face netpoint curve patch; do grep -o "^element $e " cylinder.fitpatch.ply | sed 's/element //'; done | tr -d '\n' | sed 's/ $//')" \
	'elements of the output'
is 'x y z corner net' "$(awk '$1 == "element" {on = $2 == "vertex"} $1 == "property" && on {printf "%s%s", sep, $3; sep = " "}' cylinder.fitpatch.ply)" 'columns of vertex'
is 1 "$(grep -c '^comment cagewright fitpatch 1 level=2 iter=5 sd=sided$' cylinder.fitpatch.ply)" 'says what was done'
is 1 "$(grep -c '^comment cagewright scheme quadtri$' cylinder.fitpatch.ply)" 'names the scheme'
"$BIN/fitpatch" --mesh cylinder.rectify.ply <cylinder.fitcurves.ply >stdin.ply && cmp -s cylinder.fitpatch.ply stdin.ply
ok $? 'stdin to stdout, and the same bytes on a second run'
OMP_NUM_THREADS=1 "$BIN/fitpatch" --mesh plate1.rectify.ply plate1.fitcurves.ply -o one.ply
OMP_NUM_THREADS=2 "$BIN/fitpatch" --mesh plate1.rectify.ply plate1.fitcurves.ply -o two.ply
cmp one.ply two.ply
ok $? 'the same bytes with one thread and with two'
"$BIN/fitpatch" --mesh cylinder.rectify.ply cylinder.fitcurves.ply --no-provenance | grep -q 'cagewright fitpatch'
is 1 $? '--no-provenance'
"$BIN/fitpatch" --mesh cylinder.rectify.ply cylinder.fitcurves.ply --binary | head -2 | grep -q binary_little_endian
ok $? '--binary'
sed 's/^end_header/comment by hand\
end_header/' cylinder.fitcurves.ply >hand.ply
"$BIN/fitpatch" --mesh cylinder.rectify.ply hand.ply | grep -q '^comment by hand$'
ok $? 'comments pass'
for sd in sided abs point tangent; do
	fit cylinder --sd $sd --no-provenance
	is 0 $? "--sd $sd"
	at_most "$(worst cylinder)" 0.5 '... within the tolerance or close to it'
	cp cylinder.fitpatch.ply "$sd.ply"
done
cmp -s point.ply tangent.ply
is 1 $? 'point and tangent distance are not the same'
fit plate1 --rounds 0
is 1 "$(grep -c '^fitpatch: round ' plate1.said)" '--rounds 0: no refinement'
fit cylinder --iter 0 --rounds 0
is "$(rows vertex cylinder.fitcurves.ply | cut -d' ' -f1-3)" "$(rows netpoint cylinder.fitpatch.ply | cut -d' ' -f1-3)" '--iter 0: control points stay where they are'

# --- files that do not belong together ---
refuses 3 "cylinder.stl:1: not a PLY file: the first line is not 'ply'" 'an STL file for the mesh' --mesh cylinder.stl cylinder.fitcurves.ply
refuses 3 "cylinder.fitcurves.ply: there is no element 'face'" 'a network for the mesh' --mesh cylinder.fitcurves.ply cylinder.fitcurves.ply
refuses 3 "cylinder.rectify.ply: there is no element 'curve'" 'a mesh for the network' --mesh cylinder.rectify.ply cylinder.rectify.ply
refuses 3 "cylinder.fitpatch.ply: element 'vertex' has no property 'kind'" 'its own output for the network' --mesh cylinder.rectify.ply cylinder.fitpatch.ply
refuses 3 'cylinder.curv.ply: .*patch.*' 'a mesh without patches' --mesh cylinder.curv.ply cylinder.fitcurves.ply
refuses 3 'plate1.fitcurves.ply: 7 patches, but cylinder.rectify.ply has 3: files of different parts' 'another part' --mesh cylinder.rectify.ply plate1.fitcurves.ply
ready frustum --size 600
refuses 3 'frustum.fitcurves.ply: patch [0-9]* has area [0-9.]*, but [0-9.]* in cylinder.rectify.ply: files of different parts' 'another part with as many patches' \
	--mesh cylinder.rectify.ply frustum.fitcurves.ply
right=$(rows curve cylinder.fitcurves.ply | sed -n 1p | cut -d' ' -f2)
for k in "$right" 3; do
	edit curve 0 1 "$k" cylinder.fitcurves.ply >other.ply
	refuses 3 "other.ply: curve 0: cylinder.rectify.ply has no such border between patches $k and [0-9]*" "a curve of patch $k" --mesh cylinder.rectify.ply other.ply
done
edit curve 0 1 2000000000 cylinder.fitcurves.ply >other.ply
refuses 3 'other.ply: .*' 'a curve of patch two milliards' --mesh cylinder.rectify.ply other.ply

# --- a hand edit ---
x=$(rows vertex cylinder.fitcurves.ply | sed -n 1p | cut -d' ' -f1)
moved=$(awk -v x="$x" 'BEGIN {printf "%.3f", x * 1.05 + 0.5}')
edit vertex 0 1 "$moved" cylinder.fitcurves.ply >moved.ply
curve=$(rows curve moved.ply | awk '{for (i = 8; i <= NF; i++) if ($i == 0) {for (k = 8; k <= NF; k++) print $k; exit}}')
"$BIN/fitpatch" --mesh cylinder.rectify.ply moved.ply -o moved.fitpatch.ply
is 0 $? 'fits with a control point moved by hand'
rows vertex moved.ply | cut -d' ' -f1-3 >before
rows netpoint moved.fitpatch.ply | cut -d' ' -f1-3 >after
same=0
for i in $curve; do
	[ "$(sed -n "$((i + 1))p" before)" = "$(sed -n "$((i + 1))p" after)" ] || same=1
done
ok $same 'it stays exactly there, and so does its curve'
is "$moved" "$(head -1 after | cut -d' ' -f1)" '... where it was put'
! cmp -s before after
ok $? 'other curves are fitted as ever'
edit vertex 0 3 1e5 cylinder.fitcurves.ply >far.ply
refuses 3 'far.ply: vertex 0 lies more than 10 longest sides away from the mesh' 'a point out of reach' --mesh cylinder.rectify.ply far.ply

# --- damage ---
edit vertex 1 2 nan cylinder.fitcurves.ply >nan.ply
refuses 3 'nan.ply: vertex 1: y is not a finite number' 'NaN in the network' --mesh cylinder.rectify.ply nan.ply
edit vertex 1 2 inf cylinder.rectify.ply >nan.ply
refuses 3 'nan.ply: vertex 1: y is not a finite number' 'infinity in the mesh' --mesh nan.ply cylinder.fitcurves.ply
edit curve 0 8 999 cylinder.fitcurves.ply >index.ply
refuses 3 'index.ply: curve 0: vertex_indices: 999 is not within 0 to [0-9]*' 'a control point that is not there' --mesh cylinder.rectify.ply index.ply
edit face 5 2 99999 cylinder.rectify.ply >index.ply
refuses 3 'index.ply: face 5: vertex_indices: 99999 is not within 0 to [0-9]*' 'a mesh vertex that is not there' --mesh index.ply cylinder.fitcurves.ply
sed 's/^comment cagewright fitcurves 1/comment cagewright fitcurves 9/' cylinder.fitcurves.ply >newer.ply
refuses 3 'newer.ply: .*9.*' 'a newer schema' --mesh cylinder.rectify.ply newer.ply
without curve 0 cylinder.fitcurves.ply >missing.ply
refuses 3 'missing.ply: patch [0-9]*: a border loop has 0 control points, needs 3' 'a curve deleted' --mesh cylinder.rectify.ply missing.ply
without curve 0 missing.ply >none.ply
refuses 3 'none.ply: patch 0: a border loop has 0 control points, needs 3' 'no curves' --mesh cylinder.rectify.ply none.ply
awk -v from="$(line face 0 cylinder.rectify.ply)" -v count="$(rows face cylinder.rectify.ply | wc -l)" \
	'NR >= from && NR < from + count {$NF = 0} {print}' cylinder.rectify.ply >closed.ply
refuses 3 'none.ply: patch 0 has no border: rectify cuts such patches' 'one closed patch' --mesh closed.ply none.ply
for share in 10 50 90 99; do
	for f in fitcurves rectify; do
		head -c "$(($(wc -c <cylinder.$f.ply) * share / 100))" cylinder.$f.ply >cut.ply
		if [ $f = fitcurves ]; then
			refuses 3 'cut.ply:.*' "$share % of a network" --mesh cylinder.rectify.ply cut.ply
		else
			refuses 3 'cut.ply:.*' "$share % of a mesh" --mesh cut.ply cylinder.fitcurves.ply
		fi
	done
done
: >empty.ply
refuses 3 'empty.ply.*' 'an empty file' --mesh empty.ply cylinder.fitcurves.ply
# Edits that leave a valid file: anything may come of them but a crash or a hang.
last=$(rows face cylinder.rectify.ply | head -1 | awk '{print NF}')
for face in 0 30 100; do
	edit face $face "$last" 1 cylinder.rectify.ply >relabelled.ply
	survives "triangle $face relabelled" --rounds 1 --mesh relabelled.ply cylinder.fitcurves.ply
done
edit vertex 2 1 "$(rows vertex cylinder.fitcurves.ply | sed -n 2p | cut -d' ' -f1)" cylinder.fitcurves.ply >close.ply
survives 'a control point moved beside another' --rounds 1 --mesh cylinder.rectify.ply close.ply
edit curve 0 9 "$(rows curve cylinder.fitcurves.ply | sed -n 1p | cut -d' ' -f8)" cylinder.fitcurves.ply >twice.ply
survives 'a control point twice in a curve' --rounds 1 --mesh cylinder.rectify.ply twice.ply
for v in 0 7 20; do
	edit vertex $v 3 15 cylinder.rectify.ply >bent.ply
	survives "mesh vertex $v moved" --rounds 1 --mesh bent.ply cylinder.fitcurves.ply
done

# --- the numbers of patches do not matter ---
# renumbered COUNT FILE: patch p is called p + 1, the last one 0
renumbered() {
	awk -v count="$1" '
		function new(p) {return p < 0 ? p : (p + 1) % count}
		!body {
			if ($1 == "element") {name[++elements] = $2; left[elements] = $3}
			body = $1 == "end_header"
			at = 1
			print
			next
		}
		{
			while (left[at] == 0) at++
			left[at]--
		}
		name[at] == "face" {$NF = new($NF)}
		name[at] == "curve" {$1 = new($1); $2 = new($2)}
		name[at] == "patch" {
			$1 = new($1); $NF = new($NF); row[$1] = $0
			for (p = 0; left[at] == 0 && p < count; p++) print row[p]
			next
		}
		{print}' "$2"
}
for known in plate1 cylinder; do
	count=$(rows patch "$known.rectify.ply" | wc -l)
	renumbered "$count" "$known.rectify.ply" >other.rectify.ply
	renumbered "$count" "$known.fitcurves.ply" >other.fitcurves.ply
	fit "$known" && fit other
	is "$(rows vertex "$known.fitpatch.ply")" "$(rows vertex other.fitpatch.ply)" "$known: the same points, whatever the patches are called"
	is "$(rows face "$known.fitpatch.ply" | sed 's/ [0-9]*$//')" "$(rows face other.fitpatch.ply | sed 's/ [0-9]*$//')" '... and faces'
	is "$(rows face "$known.fitpatch.ply" | awk -v n="$count" '{print ($NF + 1) % n}')" "$(rows face other.fitpatch.ply | awk '{print $NF}')" '... which keep their new numbers'
done

# --- known parts, section 5.7 of the method: per cent of the longest side ---
ready cube --size 600
fit cube
is "$(printf '6\n4')" "$(rows face cube.fitpatch.ply | wc -l; rows face cube.fitpatch.ply | cut -d' ' -f1 | sort -u)" 'cube: a quad a face'
at_most "$(worst cube)" 1e-12 'cube: no error'
is 8 "$(points cube.fitpatch.ply)" 'cube: no inner points'
ready plate1
fit plate1
at_most "$(worst plate1 0)" 1e-10 'plate with a hole: flat to 1e-12'
hole=$(sed -n 's/^fitpatch: patch \([0-9]*\) kind 1:.*/\1/p' plate1.said)
at_most "$(rows face plate1.fitpatch.ply | awk -v hole="$hole" '$NF != hole {n[$NF]++} END {for (p in n) if (n[p] > most) most = n[p]; print most}')" 4 'plate with a hole: at most four faces'
ready dome
fit dome
at_most "$(worst dome)" 0.4 'half sphere: within the tolerance'
ready saddle
fit saddle
at_most "$(worst saddle)" 0.4 'saddle: within the tolerance'
ready icosphere
fit icosphere
at_most "$(worst icosphere)" 0.25 'sphere: within 5e-3 of its radius'
at_most "$(points icosphere.fitpatch.ply)" 26 'sphere: few points'
is 0 "$(rows curve icosphere.fitpatch.ply | awk '$3 != 1' | wc -l)" 'sphere: all curves smooth'
ready ring
fit ring
is 4 "$(rows face ring.fitpatch.ply | cut -d' ' -f1 | sort -u)" 'torus: all quads'
at_most "$(worst ring)" 0.4 'torus: within the tolerance'
is "$(rows curve ring.fitpatch.ply | wc -l)" "$(rows curve ring.fitpatch.ply | awk '$3 == 1' | wc -l)" 'torus: all curves smooth'
plan
