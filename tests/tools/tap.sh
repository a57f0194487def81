# shellcheck shell=sh
# What the scripts under tests/ share: TAP, and a temporary folder of their own that they start in.
#	. "${ROOT:-.}/tests/tools/tap.sh"
# gives $BIN and $PARTS as absolute paths, $ROOT, and the functions below; end with `plan`.
ROOT=$(cd "${ROOT:-.}" && pwd)
BIN=$(cd "${BIN:-bin}" && pwd)
PARTS=${PARTS:-$ROOT/build/parts}
case $PARTS in
/*) ;;
*) PARTS=$(pwd)/$PARTS ;;
esac
unset MAKEFLAGS MFLAGS MAKELEVEL MAKEOVERRIDES GNUMAKEFLAGS
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
cd "$work" || exit 1
tap_count=0
tap_failed=0

# ok STATUS DESCRIPTION
ok() {
	tap_count=$((tap_count + 1))
	if [ "$1" -eq 0 ]; then
		echo "ok $tap_count - $2"
	else
		tap_failed=$((tap_failed + 1))
		echo "not ok $tap_count - $2"
		echo "# not ok $tap_count - $2" >&2
	fi
}
# is WANTED GOT DESCRIPTION
is() {
	if [ "$1" = "$2" ]; then
		ok 0 "$3"
	else
		ok 1 "$3"
		# on standard error, which the summary of many scripts shows too
		printf '%s\n' "$1" | sed "s/^/# $3: wanted: /" >&2
		printf '%s\n' "$2" | sed "s/^/# $3: got: /" >&2
	fi
}
# skip DESCRIPTION REASON
skip() {
	tap_count=$((tap_count + 1))
	echo "ok $tap_count - $1 # SKIP $2"
}
# skip_all REASON: nothing of this script can run
skip_all() {
	echo "1..0 # SKIP $1"
	exit 0
}
# at_most NUMBER BOUND DESCRIPTION: both any decimal numbers
at_most() {
	tap_status=$(awk -v a="$1" -v b="$2" 'BEGIN {print (a "" != "" && a + 0 <= b + 0) ? 0 : 1}')
	ok "$tap_status" "$3"
	[ "$tap_status" -eq 0 ] || echo "# $1 is more than $2"
}
# value KEY FILE: of a key=value file
value() {
	sed -n "s/^$1=//p" "$2"
}
# part NAME [OPTIONS]: the sample part NAME of the project as NAME.stl
part() {
	tap_part=$1
	"$PARTS" "$@" -o "$tap_part.stl"
}
# patch ARGUMENTS: the patch pipeline, without the search that takes most of its time unless an EFFORT is given
patch() {
	make -f "$ROOT/pipelines/patch.mk" BIN="$BIN/" EFFORT=0 "$@"
}
# plan: the last line
plan() {
	echo "1..$tap_count"
	[ "$tap_failed" -eq 0 ]
	exit
}
