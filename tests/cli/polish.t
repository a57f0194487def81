#!/bin/sh
# polish from the outside: fewer bytes within the same bounds, the grid that facefix takes, hand edits, bad input.
# shellcheck source=tests/tools/tap.sh
. "${ROOT:-.}/tests/tools/tap.sh"

# line ELEMENT ROW FILE: the line number of a row of an ascii PLY file
line() {
	awk -v want="$1" -v row="$2" '$1 == "element" && !here {if ($2 == want) here = 1; else before += $3}
		$1 == "end_header" {print NR + before + row + 1; exit}' "$3"
}
# edit ELEMENT ROW FIELD VALUE FILE: the file with one number changed, on stdout
edit() {
	awk -v at="$(line "$1" "$2" "$5")" -v field="$3" -v value="$4" 'NR == at {$field = value} {print}' "$5"
}
# field ELEMENT ROW FIELD FILE
field() {
	sed -n "$(line "$1" "$2" "$4")p" "$4" | cut -d' ' -f"$3"
}
# size FILE: its bytes
size() {
	wc -c <"$1" | tr -d ' '
}
# refuses EXIT PATTERN DESCRIPTION ARGUMENTS: one line that matches, and the old output stays
refuses() {
	code=$1 pattern=$2 what=$3
	shift 3
	echo old >kept.ply
	"$BIN/polish" "$@" -o kept.ply 2>said
	is "$code" $? "$what: exit $code"
	if [ "$(wc -l <said)" -eq 1 ] && grep -q "^polish: $pattern\$" said && [ "$(cat kept.ply)" = old ]; then
		ok 0 "... one line, and the old output stays"
	else
		ok 1 "... one line, and the old output stays"
		sed 's/^/# /' said
	fi
}

# --- through the pipeline ---
for name in cylinder plate1; do
	part $name --facets 24
	patch IN=$name.stl OUT=plain EFFORT=0 >log 2>&1
	ok $? "$name: packed without a search"
	patch IN=$name.stl OUT=small EFFORT=3 >log 2>&1
	ok $? "$name: with one"
	at_most "$(size small/$name.ffx)" "$(size plain/$name.ffx)" "$name: ... in no more bytes"
	is 1 "$(grep -c "^$name: .* within its bounds" log)" "$name: ... within its bounds"
	"$BIN/deviate" --mean 0.1% --max 1% $name.stl small/$name.stl >report
	ok $? "$name: ... as deviate measures"
	is '0 0' "$(value b_open_edges report) $(value b_nonmanifold_edges report)" "$name: ... watertight"
	is 1 "$(grep -c '^comment cagewright polish 1 mean=0.1% max=1% effort=3 level=4$' small/$name.polish.ply)" "$name: ... and says what was done"
done
# A cage with far more points than it needs: the facets of the cylinder themselves.
"$BIN/curv" cylinder.stl -o c.curv.ply && "$BIN/segment" c.curv.ply | "$BIN/rectify" -o c.rectify.ply && "$BIN/fitcurves" c.rectify.ply --mean 0.005% --tol 0.05% -o c.fitcurves.ply &&
	"$BIN/fitpatch" --mesh c.rectify.ply --mean 0.005% --tol 0.05% c.fitcurves.ply 2>/dev/null | "$BIN/assemble" -o dense.ply
ok $? 'a cage made for closer bounds'
"$BIN/polish" -v --effort 3 --mesh c.curv.ply dense.ply -o fewer.ply 2>said
ok $? '... is polished for wider ones'
vertices() {
	sed -n 's/^element vertex //p' "$1"
}
at_most "$(vertices fewer.ply)" "$(vertices dense.ply)" '... to no more vertices'
is 1 "$(grep -c "^polish: dense.ply: $(vertices dense.ply) vertices, .* before; $(vertices fewer.ply) vertices, .* after\$" said)" '... and -v says so'
is 1 "$(grep -c '^polish: bytes=[0-9]* mean_side=[0-9.e-]* max_side=[0-9.e-]*$' said)" '... and how many bytes, how near'
"$BIN/facefix" fewer.ply -o fewer.ffx
at_most "$(size fewer.ffx)" "$(sed -n 's/^polish: bytes=\([0-9]*\) .*/\1/p' said)" '... which facefix needs'

# --- the same bytes ---
assemble=small/plate1.assemble.ply
for threads in 1 2; do
	OMP_NUM_THREADS=$threads "$BIN/polish" --effort 3 --mesh plate1.stl $assemble -o t$threads.ply
	cmp small/plate1.polish.ply t$threads.ply
	ok $? "the same bytes again, with threads: $threads"
done
"$BIN/polish" --effort 0 --mesh plate1.stl <$assemble >stdin.ply && "$BIN/polish" --effort 0 -m plate1.stl $assemble | cmp - stdin.ply
ok $? 'standard input gives the same as a file'
"$BIN/polish" --effort 0 --mesh plate1.stl --no-provenance $assemble | grep -q 'cagewright polish'
is 1 $? '--no-provenance'
"$BIN/polish" --effort 0 --mesh plate1.stl --binary $assemble | head -n 2 | grep -q binary_little_endian
ok $? '--binary'
sed 's/^end_header/comment by hand\
element mine 1\
property double it\
end_header/' $assemble >hand.ply
echo 0.25 >>hand.ply
"$BIN/polish" --effort 0 --mesh plate1.stl hand.ply -o passed.ply
is 'comment by hand 0.25' "$(grep '^comment by hand$' passed.ply) $(field mine 0 1 passed.ply)" 'comments and unknown elements pass'
# polished once more: it is a cage like any other, and ends with one grid
"$BIN/polish" --effort 0 --mesh plate1.stl small/plate1.polish.ply -o twice.ply
is '0 1' "$? $(grep -c '^element grid 1$' twice.ply)" 'a polished cage may be polished again'

# --- the grid ---
polished=small/plate1.polish.ply
is "element grid 1 step x y z" "$(awk '$1 == "element" {on = $2 == "grid"; if (on) printf "%s", $0} on && $1 == "property" {printf " %s", $3}' $polished)" 'the element grid'
awk -v n="$(vertices $polished)" '
	$1 == "element" {name[++kinds] = $2; left[kinds] = $3}
	body {while (left[at] == 0) at++; left[at]--; row = $0}
	body && name[at] == "vertex" {for (k = 1; k <= 3; k++) x[3 * v + k] = $k; v++}
	body && name[at] == "grid" {for (i = 1; i <= 3 * n; i++) {k = (i - 1) % 3 + 1; g = (x[i] - $(k + 1)) / $1; off = g - int(g + 0.5); if (off < 0) off = -off; if (off > worst) worst = off}}
	$1 == "end_header" {body = 1; at = 1}
	END {print worst + 0}' $polished >off
at_most "$(cat off)" 1e-3 'all vertices lie on it'
"$BIN/facefix" $polished -o again.ffx 2>said
is '0 ' "$? $(cat said)" 'facefix takes it without a word'
cmp again.ffx small/plate1.ffx
ok $? '... and writes the same stream'
# The unpacked cage is the polished one: the surfaces are as near as place and size are stored.
"$BIN/unpack" --level 3 again.ffx -o again.stl && "$BIN/refine" --level 3 $polished -o direct.stl && "$BIN/deviate" again.stl direct.stl >report
at_most "$(value sym_max_side report)" "$(awk -v step="$(field grid 0 1 $polished)" -v side="$(value a_side report)" 'BEGIN {print 0.5 * step / (side > 0 ? side : 1)}')" '... of the same surface'
"$BIN/facefix" --bits 12 $polished -o bits.ffx 2>said
is '0 ' "$? $(cat said)" '--bits asks for another grid'
! cmp -s bits.ffx again.ffx
ok $? '... and gets it'
moved=$(awk -v x="$(field vertex 2 1 $polished)" -v step="$(field grid 0 1 $polished)" 'BEGIN {printf "%.9g", x + 0.3 * step}')
edit vertex 2 1 "$moved" $polished >moved.ply
"$BIN/facefix" moved.ply -o moved.ffx 2>said
is 0 $? 'a vertex moved by hand is packed'
is 'facefix: warning: moved.ply: vertex 2 is not on the grid: all are rounded anew' "$(cat said)" '... and facefix says that it left the grid'
"$BIN/unpack" --cage moved.ffx | awk -v x="$moved" '/^end_header/ {body = 1; next} body && NF >= 4 && NF < 6 {d = $1 - x; if (d < 0) d = -d; if (best == "" || d < best) best = d} END {print best}' >best
at_most "$(cat best)" "$(awk -v step="$(field grid 0 1 $polished)" 'BEGIN {print 0.2 * step}')" '... and packs it where it was put'
is '' "$("$BIN/facefix" -q moved.ply 2>&1 >/dev/null)" '-q: without a word'
edit grid 0 1 0 $polished >bad.ply
"$BIN/facefix" bad.ply -o bad.ffx 2>said
is '3 facefix: bad.ply: the step of the grid is not positive' "$? $(cat said)" 'a grid without a step is refused'
[ ! -e bad.ffx ]
ok $? '... and nothing is written'

# --- bad input ---
refuses 2 '--mesh is missing: which dense mesh does the cage stand for?' 'no mesh' $assemble
refuses 2 '.*effort.*' 'effort 10' --effort 10 --mesh plate1.stl $assemble
refuses 2 '.*level.*' 'level 0' --level 0 --mesh plate1.stl $assemble
refuses 2 '.*mean.*' 'mean 0' --mean 0 --mesh plate1.stl $assemble
refuses 2 '.*max.*' 'a negative largest distance' --max -1% --mesh plate1.stl $assemble
refuses 4 'nosuch.stl: No such file or directory' 'no such mesh' --mesh nosuch.stl $assemble
refuses 4 'nosuch.ply: No such file or directory' 'no such cage' --mesh plate1.stl nosuch.ply
: >empty
refuses 3 'empty: the file is empty' 'an empty mesh file' --mesh empty $assemble
refuses 3 'empty: the file is empty' 'an empty cage file' --mesh plate1.stl empty
printf 'ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex 0\nproperty double x\nproperty double y\nproperty double z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n' >nofaces.ply
refuses 3 'nofaces.ply: the cage has no faces' 'an empty cage' --mesh plate1.stl nofaces.ply
edit vertex 1 2 nan $assemble >nan.ply
refuses 3 'nan.ply: vertex 1: y is not a finite number' 'a cage with a NaN' --mesh plate1.stl nan.ply
refuses 3 "plate1.stl:.*" 'a mesh for the cage' --mesh plate1.stl plate1.stl
refuses 3 "c.curv.ply: no comment 'cagewright scheme' says which rules the cage is for" 'a dense mesh for the cage' --mesh plate1.stl c.curv.ply
printf 'OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n' >flat.off
refuses 3 'flat.off: .*' 'a mesh without area' --mesh flat.off $assemble
printf 'OFF\n0 0 0\n' >none.off
refuses 3 'none.off: .*' 'a mesh without triangles' --mesh none.off $assemble
sed 's/^comment cagewright assemble 1/comment cagewright assemble 9/' $assemble >newer.ply
refuses 3 'newer.ply: .*9.*' 'a newer schema' --mesh plate1.stl newer.ply
edit face 0 2 99999 $assemble >index.ply
refuses 3 'index.ply: face 0: vertex_indices: 99999 is not within 0 to [0-9]*' 'a vertex that is not there' --mesh plate1.stl index.ply
head -c "$(($(size $assemble) / 2))" $assemble >cut.ply
refuses 3 'cut.ply:.*' 'half a cage' --mesh plate1.stl cut.ply
printf 'ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n4 3 2 1 0\n' >lens.ply
refuses 3 'lens.ply: a vertex inside the cage has two edges that are not both creases' 'vertices of two smooth edges' --mesh plate1.stl lens.ply
printf 'ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 2\n3 0 1 2\n3 0 1 3\n3 0 1 4\n' >fan.ply
refuses 3 'fan.ply: .*' 'three faces at an edge' --mesh plate1.stl fan.ply

# --- bounds that no cage keeps ---
printf 'ply\nformat ascii 1.0\ncomment cagewright scheme quadtri\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n' >wrong.ply
timeout 60 "$BIN/polish" --effort 1 --mesh cylinder.stl wrong.ply -o wrong.polish.ply 2>said
is 0 $? 'a cage of another part is polished as far as it goes'
is 1 "$(grep -c '^polish: warning: wrong.ply: no cage within the bounds was found: mean .*%, largest .*% of the longest side, .*% of the area turned away$' said)" '... and polish says that it misses its bounds'
is '' "$("$BIN/polish" -q --effort 0 --mesh cylinder.stl wrong.ply 2>&1 >/dev/null)" '-q: without a word'
plan
