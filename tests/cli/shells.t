#!/bin/sh
# What the pipeline must keep of a part: its shells and voids, its handles, its borders. What is no surface is split, and said.
. "${ROOT:-.}/tests/tools/tap.sh"

# look FILE: topology.txt has a line for each component, genus and border loops, sorted; volume is that of all, signed
look() {
	"$BIN/curv" -v --prep-only -o look.ply "$1" 2> look.log || return 1
	sed -n 's/.* border loops \([0-9]*\), genus \(-*[0-9]*\), volume .*/genus \2, loops \1/p' look.log | sort | tr '\n' ';' > topology.txt
	volume=$(sed -n 's/.*, volume \(.*\)/\1/p' look.log | awk '{v += $1} END {printf "%.9g", v}')
}
# join A B X Y Z FLIP > OFF: two OFF files in one, the second shifted, and inside out when FLIP is 1
join() {
	awk -v x="$3" -v y="$4" -v z="$5" -v flip="$6" '
		FNR == 1 {file++; next}
		FNR == 2 {points[file] = $1; faces[file] = $2; next}
		FNR <= 2 + points[file] {point[++n] = file == 1 ? $0 : $1 + x " " $2 + y " " $3 + z; next}
		FNR <= 2 + points[file] + faces[file] {o = file == 1 ? 0 : points[1]; face[++m] = file == 2 && flip ? "3 " $2 + o " " $4 + o " " $3 + o : "3 " $2 + o " " $3 + o " " $4 + o}
		END {print "OFF\n" n, m, 0; for (i = 1; i <= n; i++) print point[i]; for (i = 1; i <= m; i++) print face[i]}' "$1" "$2"
}
# keeps FILE DESCRIPTION TOPOLOGY: FILE through the pipeline keeps it, and the volume within one per cent
keeps() {
	name=$(basename "$1") && name=${name%.*}
	look "$1"
	is "$3" "$(cat topology.txt)" "$2: is what it should be"
	before=$volume
	patch IN="$1" OUT=out > log 2>&1
	ok $? "$2: is packed" || sed 's/^/# /' log
	look "out/$name.stl"
	is "$3" "$(cat topology.txt)" "... shells, handles and borders are kept"
	at_most "$(awk -v a="$before" -v b="$volume" 'BEGIN {d = (b - a) / a; print d < 0 ? -d : d}')" 0.01 '... and the volume within one per cent'
}
# borders FILE NAME: the borders of FILE and those of its packed copy are as near as the bound of the surface, and border curves
borders() {
	"$BIN/deviate" --sharp 180 "$1" "out/$2.stl" > border.txt
	at_most "$(value ab_sharp_max_side border.txt)" 0.01 '... its border is found again'
	at_most "$(value ba_sharp_max_side border.txt)" 0.01 '... and there is no other one'
	# kind 2 is border, the third column; the length is that of the control polygon, somewhat more than the border's
	awk '/^element/ {name[++n] = $2; count[n] = $3} /^end_header/ {line = 1; next}
		line {i = 1; for (l = line++; l > count[i]; i++) l -= count[i]; if (name[i] == "curve" && $3 == 2 && $2 == -1) length_of_all += $6}
		END {print length_of_all + 0}' "out/$2.fitcurves.ply" > length
	awk -v a="$(cat length)" -v b="$(value a_sharp_length border.txt)" 'BEGIN {exit !(a > 0.97 * b && a < 1.2 * b)}'
	ok $? '... as curves of the network'
}

# Two shells, one with a handle, apart from each other.
"$PARTS" block1 --facets 24 -o block.off
"$PARTS" cube --nasty --scale 3 -o cube.off
join block.off cube.off 200 0 0 0 > two.off
keeps two.off 'two shells' 'genus 0, loops 0;genus 1, loops 0;'

# A void: a ball of air of radius 12 in a cube of side 30. Its volume counts against that of the cube.
"$PARTS" icosphere --size 800 --scale 0.4 -o ball.off
join cube.off ball.off 15 15 15 1 > void.off
keeps void.off 'a cube with a void' 'genus 0, loops 0;genus 0, loops 0;'
at_most "$volume" 20500 '... which is no second solid'

# Handles: as many as the plate has holes.
"$PARTS" plate12 --facets 20 -o holes.stl
look holes.stl
patch IN=holes.stl OUT=out > log 2>&1
ok $? 'a plate with twelve holes is packed'
look out/holes.stl
is 'genus 12, loops 0;' "$(cat topology.txt)" '... and has twelve holes'
is '' "$(grep non-manifold look.log)" '... of sound surfaces'

# Borders: a half pipe, a bent sheet, and a box without its lid, whose border has corners.
for name in strip saddle; do
	"$PARTS" $name --facets 24 -o $name.stl
	patch IN=$name.stl OUT=out > log 2>&1
	ok $? "$name, an open part, is packed"
	look out/$name.stl
	is 'genus 0, loops 1;' "$(cat topology.txt)" '... stays open, with one border'
	borders $name.stl $name
done
awk 'NR == 2 {$2 -= 2} NR > 2 && NF == 4 && ++face <= 2 {next} {print}' cube.off > box.off
patch IN=box.off OUT=out > log 2>&1
ok $? 'a box without its lid is packed'
look out/box.stl
is 'genus 0, loops 1;' "$(cat topology.txt)" '... stays open'
borders box.off box

# Not a surface: cubes that touch along an edge are two; three sheets along one line; a one-sided band is cut once.
"$PARTS" touching --nasty -o touching.stl
patch IN=touching.stl OUT=out > log 2>&1
ok $? 'two cubes that share an edge are packed'
is 'curv: warning: touching.stl: 1 non-manifold edge cut' "$(grep '^curv' log)" '... as two, which is said'
look out/touching.stl
is 'genus 0, loops 0;genus 0, loops 0;' "$(cat topology.txt)" '... and come back as two'
printf '%s\n' OFF '8 6 0' '0 0 0' '9 0 0' '9 9 0' '0 9 0' '0 -9 3' '9 -9 3' '0 1 9' '9 1 9' \
	'3 0 1 2' '3 0 2 3' '3 0 4 5' '3 0 5 1' '3 0 1 7' '3 0 7 6' > fan.off
patch IN=fan.off OUT=out > log 2>&1
ok $? 'three sheets along one line are packed'
is 'curv: warning: fan.off: 1 non-manifold edge cut' "$(grep 'non-manifold' log)" '... split along it, which is said'
"$BIN/deviate" fan.off out/fan.stl > fan.txt
at_most "$(value sym_max_side fan.txt)" 0.01 '... and all three are there'
"$PARTS" moebius --nasty -o moebius.stl
patch IN=moebius.stl OUT=out > log 2>&1
ok $? 'a band with one side is packed'
is 'curv: warning: moebius.stl: 1 edge of a one-sided surface cut' "$(grep 'one-sided' log)" '... cut across, which is said'
"$BIN/deviate" moebius.stl out/moebius.stl > moebius.txt
at_most "$(value sym_max_side moebius.txt)" 0.01 '... and all of it is there'
plan
