#!/bin/sh
# render from the outside: streams, pictures, exit codes, messages.
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
	rm -f out.png
	got=$("$BIN/render" "$@" -o out.png 2>&1)
	is "$code: render: $message" "$?: $got" "refuses: $message"
	[ ! -e out.png ]
	ok $? "... and writes nothing"
}
size() { # size PICTURE: width x height from the header of a PNG, or nothing
	od -A n -t u1 -N 24 "$1" | tr -s ' \n' '  ' |
		awk '$1 == 137 && $2 == 80 && $3 == 78 && $4 == 71 { print $19 * 256 + $20 "x" $23 * 256 + $24 }'
}

printf '%s\n' OFF '8 6 0' '0 0 0' '1 0 0' '0 1 0' '1 1 0' '0 0 1' '1 0 1' '0 1 1' '1 1 1' \
	'4 0 2 3 1' '4 4 5 7 6' '4 0 1 5 4' '4 2 6 7 3' '4 0 4 6 2' '4 1 3 7 5' >cube.off
"$BIN/render" cube.off -o a.png
is '0: 800x600' "$?: $(size a.png)" 'a cube, 800 by 600'
"$BIN/render" <cube.off >b.png
cmp -s a.png b.png
ok $? 'stdin, stdout, same bytes again'
"$BIN/render" --size 64x48 --view 0,0 cube.off -o c.png
is '64x48' "$(size c.png)" '--size'
"$BIN/render" --size 64x48 --view 90,0 cube.off -o d.png
cmp -s c.png d.png
ok $? 'a cube looks the same from its sides'
"$BIN/render" --size 64x48 --view 30,0 cube.off | cmp -s c.png -
is 1 $? '... but not from its edge'
for option in '--zoom 3' '--centre 1,1,1' '--view 0,90'; do
	# shellcheck disable=SC2086
	"$BIN/render" $option cube.off | cmp -s a.png -
	is 1 $? "$option changes the picture"
done
printf '%s\n' OFF '6 2 0' '0 0 0' '1 0 0' '2 0 0' '0 1 0' '1 1 0' '2 1 0' '4 0 1 4 3' '4 1 2 5 4' >flat.off
"$BIN/render" --view -90,90 flat.off -o flat.png
"$BIN/render" --edges --view -90,90 flat.off | cmp -s flat.png -
is 1 $? '--edges shows edges that do not bend'
sed '7,10s/ 1$/ 1.2/' cube.off >taller.off
"$BIN/render" --colour deviation --against taller.off cube.off -o e.png
is '0: 800x600' "$?: $(size e.png)" '--colour deviation'
OMP_NUM_THREADS=1 "$BIN/render" --colour deviation --against taller.off cube.off | cmp -s e.png -
ok $? '... the same with one thread'
"$BIN/render" --colour deviation --against taller.off --range 1% cube.off | cmp -s e.png -
is 1 $? '--range changes its scale'

# The side at x = 0 bulges by 0.3 in its middle: seen from there, as large as the worst place deserves.
printf '%s\n' OFF '9 9 0' '0 0 0' '1 0 0' '0 1 0' '1 1 0' '0 0 1' '1 0 1' '0 1 1' '1 1 1' '-0.3 0.5 0.5' \
	'4 0 2 3 1' '4 4 5 7 6' '4 0 1 5 4' '4 2 6 7 3' '4 1 3 7 5' '3 0 4 8' '3 4 6 8' '3 6 2 8' '3 2 0 8' >bulge.off
"$BIN/render" -v --view worst --colour deviation --against cube.off bulge.off -o f.png 2>message
is '0: 800x600' "$?: $(size f.png)" '--view worst'
is 'render: largest distance 0.3 (30 % of the longest side) at -0.3 0.5 0.5, on bulge.off' "$(head -n 1 message)" '-v says where the worst place is'
is 'from azimuth 180, elevation 0, zoom 4' "$(sed -n 's/.*\(from azimuth\) -*\(180, elevation\) -*0\(.*\)/\1 \2 0\3/p' message)" '... and it is seen from there'
"$BIN/render" --view 180,0 --centre -0.3,0.5,0.5 --zoom 4 --colour deviation --against cube.off bulge.off | cmp -s f.png -
ok $? '... as if asked for in numbers'
"$BIN/render" -v --view worst --zoom 2 --colour deviation --against bulge.off cube.off -o g.png 2>message
is 'render: largest distance 0.3 (23.08 % of the longest side) at -0.3 0.5 0.5, on bulge.off' "$(head -n 1 message)" 'what is missing counts as well'

refuses 2 '--view worst needs --colour deviation' --view worst cube.off
refuses 2 '--colour deviation needs --against' --colour deviation cube.off
refuses 2 "--colour: 'blue' is not shaded, patch, curvature or deviation" --colour blue cube.off
refuses 2 "--view: 'top' is not azimuth,elevation within +-360 and +-90 degrees" --view top cube.off
refuses 2 "--size: '8x8' is not widthxheight in pixels, each 16 to 4096" --size 8x8 cube.off
refuses 2 "--centre: '1,2' is not x,y,z in model units" --centre 1,2 cube.off
refuses 3 'cube.off: a plain mesh has no patches to colour by' --colour patch cube.off
refuses 3 'cube.off: a plain mesh has no curvatures to colour by' --colour curvature cube.off
: >empty.stl
refuses 3 'empty.stl: the file is empty' empty.stl
refuses 4 'none.ply: No such file or directory' none.ply
printf '\372\061damaged' >part.ffx
"$BIN/render" part.ffx -o out.png 2>message
is 3 $? 'a damaged packed cage is exit 3'
[ ! -e out.png ] && grep -q '^render: part.ffx: ' message
ok $? '... with a message, without a picture'
if [ -w /dev/full ]; then
	"$BIN/render" cube.off -o /dev/full 2>message
	is 4 $? 'a full device is exit 4'
fi
echo "1..$n"
