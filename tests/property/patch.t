#!/bin/sh
# What must not matter to the pipeline: where a part is, how large, in which order its facets come, which way round they are.
. "${ROOT:-.}/tests/tools/tap.sh"

# euler FILE: vertices - faces / 2 of a closed triangle mesh measured by deviate
euler() {
	awk -F= '$1 == "b_vertices" {v = $2} $1 == "b_triangles" {f = $2} END {print v - f / 2}' "$1"
}
# packed NAME: NAME.stl through the pipeline, measured against itself
packed() {
	patch IN="$1.stl" OUT=out > "$1.log" 2>&1 || {
		sed 's/^/# /' "$1.log" | tail -n 3
		return 1
	}
}

for name in filleted plate1 bracket; do
	case $name in
	filleted) options=--nasty genus=0 ;;
	plate1) options='--facets 32' genus=1 ;;
	bracket) options='--facets 32' genus=2 ;;
	esac
	# shellcheck disable=SC2086 # options are words
	"$PARTS" $name $options -o $name.stl
	packed $name
	ok $? "$name is packed"
	mean=$(value sym_mean_side out/$name.report)
	largest=$(value sym_max_side out/$name.report)
	bytes=$(wc -c < out/$name.ffx)
	is $((2 - 2 * genus)) "$(euler out/$name.report)" "$name: Euler characteristic"

	for change in '--rotate --seed 1' '--scale 1000' '--scale 0.001' '--shuffle --seed 2' '--flip --seed 3' '--rotate --shuffle --flip --seed 4'; do
		changed=$name$(printf %s "$change" | tr -d ' ')
		# shellcheck disable=SC2086
		"$PARTS" $name $options $change -o "$changed.stl"
		packed "$changed"
		ok $? "$name $change: is packed"
		report=out/$changed.report
		[ -e "$report" ] || continue
		is $((2 - 2 * genus)) "$(euler "$report")" "$name $change: Euler characteristic"
		is '0 0' "$(value b_open_edges "$report") $(value b_nonmanifold_edges "$report")" "$name $change: watertight"
		is 0 "$(value b_volume "$report" | grep -c '^-')" "$name $change: outside is outside"
		# Rounding to the grid of the stream, which lies along the axes, may move the surface by 0.03 % in the mean, and ties are
		# broken by index, so that figures move a little; a lost patch or curve would move them much more.
		at_most "$(value sym_mean_side "$report")" "$(awk -v m="$mean" 'BEGIN {print 1.5 * m + 3e-4}')" "$name $change: mean error as before"
		at_most "$(value sym_max_side "$report")" "$(awk -v m="$largest" 'BEGIN {print 1.5 * m + 1.5e-3}')" "$name $change: largest error as before"
		at_most "$(wc -c < "out/$changed.ffx")" "$(awk -v b="$bytes" 'BEGIN {print 1.4 * b + 12}')" "$name $change: about as small as before"
	done
done
plan
