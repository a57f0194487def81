#!/bin/sh
# refine from the outside: streams, formats, exit codes, messages.
BIN=$(cd "${BIN:-bin}" && pwd)
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT && cd "$work" || exit 1
n=0
ok() { # ok STATUS DESCRIPTION
	n=$((n + 1))
	if [ "$1" -eq 0 ]; then echo "ok $n - $2"; else echo "not ok $n - $2"; fi
}
is() { # is EXPECTED ACTUAL DESCRIPTION
	[ "$1" = "$2" ]
	ok $? "$3"
	[ "$1" = "$2" ] || printf '# wanted: %s\n# got: %s\n' "$1" "$2"
}
refuses() { # refuses EXIT MESSAGE ARGUMENTS...
	code=$1 message=$2
	shift 2
	got=$("$BIN/refine" "$@" 2>&1 >out.data)
	is "$code: $message" "$?: $got" "refuses: $message"
	[ ! -s out.data ]
	ok $? "... and writes nothing"
}

header() {
	printf '%s\n' ply 'format ascii 1.0' 'comment cagewright scheme quadtri' 'comment by hand' "element vertex $1" \
		'property double x' 'property double y' 'property double z' "element face $2" \
		'property list uchar int vertex_indices' 'property int patch' 'element edge 1' 'property int vertex1' \
		'property int vertex2' 'property uchar sharp' end_header
}
{
	header 6 2
	printf '%s\n' '0 0 0' '1 0 0' '1 1 0' '0 1 0' '1 0 1' '1 1 1' '4 0 1 2 3 5' '4 1 4 5 2 7' '1 2 1'
} >fold.ply

"$BIN/refine" fold.ply >default.ply
ok $? 'reads a file, writes to stdout'
"$BIN/refine" --level 4 <fold.ply >stdin.ply
ok $? 'reads stdin'
cmp -s default.ply stdin.ply
ok $? 'level 4 is the default'
is 2 "$(grep -c '^element vertex 561$\|^element face 512$' default.ply)" 'sizes of level 4'
is 'comment by hand' "$(grep hand default.ply)" 'comments pass'
is 'comment cagewright refine 1 level=4' "$(grep 'cagewright refine' default.ply)" 'says what was done'
"$BIN/refine" --no-provenance fold.ply | grep -q 'cagewright refine'
is 1 $? '--no-provenance leaves that out'
is '256 256' "$(grep -c '^4 .* 5$' default.ply) $(grep -c '^4 .* 7$' default.ply)" 'faces keep their patch'
"$BIN/refine" --no-provenance -l 2 fold.ply >two.ply
"$BIN/refine" --no-provenance -l 1 fold.ply | "$BIN/refine" --no-provenance -l 1 >one_one.ply
cmp -s two.ply one_one.ply
ok $? 'two steps are twice one step'
"$BIN/refine" --limit fold.ply | grep -q 'cagewright scheme'
is 1 $? 'limit points are not called a cage'
for e in ply obj off stl stla; do
	"$BIN/refine" fold.ply -o "out.$e" && [ -s "out.$e" ]
	ok $? "writes $e"
done
is 51284 "$(wc -c <out.stl | tr -d ' ')" 'STL: two triangles a quad, 84 + 50 bytes each'
"$BIN/refine" --binary fold.ply | head -2 | tail -1 | grep -q binary_little_endian
ok $? '--binary'

refuses 2 "refine: no writer for '.xyz' files (ply, obj, off, stl, stla)" fold.ply -o part.xyz
refuses 2 "refine: cannot write compressed files: 'part.stl.gz'" fold.ply -o part.stl.gz
refuses 2 "refine: unknown scheme 'bicubic' (quadtri, loop, catmullclark)" --scheme bicubic fold.ply
refuses 3 'refine: fold.ply: face 0 has 4 vertices: Loop subdivision needs triangles' --scheme loop fold.ply
sed 's/^4 1 4 5 2/4 1 2 5 4/' fold.ply >turned.ply
refuses 3 'refine: turned.ply: faces 0 and 1 run along edge 1-2 in the same direction: orientations differ' turned.ply
{
	header 7 2
	printf '%s\n' '0 0 0' '1 0 0' '1 1 0' '0 1 0' '1 0 1' '1 1 1' '9 9 9' '4 0 1 2 3 5' '4 1 4 5 2 7' '1 2 1'
} >loose.ply
refuses 3 'refine: loose.ply: vertex 6 has no face' loose.ply
sed '/scheme/d' fold.ply >nameless.ply
refuses 3 "refine: nameless.ply: no comment 'cagewright scheme' says which rules the cage is for" nameless.ply
"$BIN/refine" --scheme catmullclark nameless.ply | grep -q 'cagewright scheme catmullclark'
ok $? '--scheme stands in for the comment'
if [ -w /dev/full ]; then
	"$BIN/refine" fold.ply -o /dev/full 2>message
	is 4 $? 'a full device is exit 4'
fi
echo "1..$n"
