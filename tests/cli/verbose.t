#!/bin/sh
# What -v of every stage tells a person of a part whose faces, curves, loops and handles are known.
. "${ROOT:-.}/tests/tools/tap.sh"

# says PATTERN TOOL ARGUMENTS: TOOL -v says a line that matches, and without -v nothing on standard error
says() {
	pattern=$1 tool=$2
	shift 2
	"$BIN/$tool" -v "$@" 2> said
	grep -q "^$tool: .*$pattern" said
	tap_found=$?
	ok $tap_found "$tool -v says: $pattern"
	[ $tap_found -eq 0 ] || sed 's/^/# /' said
	"$BIN/$tool" "$@" 2> said
	is '' "$(cat said)" "$tool says nothing without it"
}

# A block with a through hole: 6 planes and a cylinder, genus 1; each plane has a loop of its own, those with the hole and
# the bore two. The edges: 12 straight ones and 2 circles.
"$PARTS" block1 --facets 32 -o p.stl
says 'genus=1' mend p.stl -o p.mend.ply
says 'border loops 0, genus 1, volume' curv p.stl -o p.curv.ply
says 'sharpest bend: 90 degrees at ' curv p.stl -o p.curv.ply
says '6 plane, ' segment p.curv.ply -o p.segment.ply
says 'curves between them: 14 sharp, 0 smooth, 0 border, with 8 nodes' segment p.curv.ply -o p.segment.ply
says 'border loops: 10 in all, most of them 2 of patch [0-9]*; 0 closed patches, 0 with handles (0)' segment p.curv.ply -o p.segment.ply
says 'worst patch: [0-9]*, a [a-z]*, with a vertex [0-9.e-]* off it at ' segment p.curv.ply -o p.segment.ply
says 'patches: 6 plane, 1 cylinder, 0 cone' rectify p.segment.ply -o p.rectify.ply
says 'curves between them: 14 sharp' rectify p.segment.ply -o p.rectify.ply
says '14 curves (2 closed' fitcurves p.rectify.ply -o p.fitcurves.ply
says 'largest error' fitcurves p.rectify.ply -o p.fitcurves.ply
says 'patch 0 kind [0-5]: mean .* worst at ' fitpatch --mesh p.rectify.ply p.fitcurves.ply -o p.fitpatch.ply
says 'euler 0' assemble p.fitpatch.ply -o p.assemble.ply
says '[0-9]* vertices, [0-9]* faces before; [0-9]* vertices, [0-9]* faces after' polish --effort 0 --mesh p.stl p.assemble.ply -o p.polish.ply
says 'bytes=[0-9]* mean_side=0.* max_side=0' polish --effort 0 --mesh p.stl p.assemble.ply -o p.polish.ply
says 'holes=0 components=1 handles=1' facefix p.polish.ply -o p.ffx
says 'vertices=[0-9]* faces=' unpack p.ffx -o p.out.stl
says 'cage: [0-9]* vertices, 0 explicit corners' refine p.assemble.ply -o p.refine.ply
says 'farthest from the other one on p.out.stl: .* at ' deviate p.stl p.out.stl -o p.report
says 'largest distance .* at .*, on p' render --colour deviation --against p.stl p.out.stl -o p.png
plan
