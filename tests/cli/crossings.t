#!/bin/sh
# crossings of the bench on shapes whose answer is plain. Only where `make bench` has built it, which needs libcgal-dev.
. "${ROOT:-.}/tests/tools/tap.sh"
crossings=${PARTS%/*}/crossings
[ -x "$crossings" ] || skip_all 'not built: needs libcgal-dev, and make bench'

# off NAME VERTICES FACES: "x y z," and "i j k," lists
off() {
	printf '%s' "$2" | tr ',' '\n' > vertices
	printf '%s' "$3" | tr ',' '\n' | sed 's/^/3 /' > faces
	{
		echo OFF
		echo "$(grep -c . vertices) $(grep -c . faces) 0"
		cat vertices faces
	} > "$1.off"
}
# pairs PART OTHER: pairs of part, of other, and those of other that are new
pairs() {
	"$crossings" "$1.off" "$2.off" > out && echo "$(value a_pairs out) $(value b_pairs out) $(value b_new_pairs out)"
}

tetrahedron='0 0 0,1 0 0,0 1 0,0 0 1,'
sides='0 2 1,0 1 3,0 3 2,1 2 3,'
more='4 6 5,4 5 7,4 7 6,5 6 7,'
off single "$tetrahedron" "$sides"
is '0 0 0' "$(pairs single single)" 'neighbours that share corners and edges do not cross'
off apart "$tetrahedron 2 0 0,3 0 0,2 1 0,2 0 1," "$sides$more"
is '0 0 0' "$(pairs single apart)" 'two tetrahedra apart'
# The second one sticks through the slanted side of the first with its three upright sides.
off through "$tetrahedron .1 .1 .1,1.1 .1 .1,.1 1.1 .1,.1 .1 1.1," "$sides$more"
is '0 3 3' "$(pairs single through)" 'two tetrahedra through each other: three sides cross one'
is 0 "$(value b_in_plane out)" '... none in one plane'
is '3 3 0' "$(pairs through through)" 'nothing is new where the part crosses itself in the same place'
off touching "$tetrahedron .3 .3 0,1.3 .3 -1,.3 1.3 -1,.3 .3 -1," "$sides$more"
"$crossings" single.off touching.off > out
[ "$(value b_pairs out)" -gt 0 ]
ok $? 'a corner that touches a side inside counts'

plane='0 0 0,1 0 0,0 1 0,'
off flat "$plane" '0 1 2,'
off unfolded "$plane .3 -.5 0," '0 1 2,1 0 3,'
is '0 0 0' "$(pairs flat unfolded)" 'two triangles side by side in one plane'
off folded "$plane .3 .5 0," '0 1 2,1 0 3,'
is '0 1 1' "$(pairs flat folded)" 'one folded flat onto the other'
is 1 "$(value b_share out)" '... with all their area'
off ajar "$plane .3 .5 .001," '0 1 2,1 0 3,'
is 1 "$(value b_in_plane out)" '... in one plane'
is '0 0 0' "$(pairs flat ajar)" 'nearly folded'
off pierced "$plane .5 .5 1,.2 .2 -1," '0 1 2,0 3 4,'
is '0 1 1' "$(pairs flat pierced)" 'a shared corner, and one through the other'
off beside "$plane -.5 .5 1,-.2 .2 -1," '0 1 2,0 3 4,'
is '0 0 0' "$(pairs flat beside)" 'a shared corner alone'

"$crossings" single.off missing.off > out 2> err
is 4 $? 'a missing file'
is 'crossings: missing.off: No such file or directory' "$(cat err)" '... is named'
plan
