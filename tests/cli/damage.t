#!/bin/sh
# Damaged files through the programs: exit 3 with one line, or a warning and a good result; never a crash, never half a file.
. "${ROOT:-.}/tests/tools/tap.sh"

# refused PROGRAM FILE [OPTIONS]: exit 3, one line that begins with the program and names the file, nothing written
refused() {
	program=$1 file=$2
	shift 2
	printf 'old\n' > out.ply
	timeout 60 "$BIN/$program" "$@" "$file" -o out.ply > stdout 2> errors
	status=$?
	last=$(tail -n 1 errors | cut -c 1-200)
	[ $status -eq 3 ] && [ "$(cat out.ply)" = old ] && [ ! -s stdout ] && case $last in "$program: "*"$(basename "$file")"*) ;; *) false ;; esac
	refused=$?
	ok $refused "$program refuses ${file#"$ROOT"/tests/formats/}"
	[ $refused -eq 0 ] || echo "# exit $status, $last"
}

for file in "$ROOT"/tests/formats/ffx/failed/*; do
	refused unpack "$file" --cage
done
for kind in off obj stl om ply; do
	[ -d "$ROOT/tests/formats/$kind/failed" ] || continue
	for file in "$ROOT/tests/formats/$kind/failed"/*; do
		[ "$kind" = ply ] && file=$file
		refused curv "$file"
	done
done
for file in "$ROOT"/tests/formats/dense/failed/*; do
	refused segment "$file"
done
for file in "$ROOT"/tests/formats/cage/failed/*; do
	refused refine "$file"
done
for file in "$ROOT"/tests/formats/ffx/passed/*; do
	timeout 60 "$BIN/unpack" --level 1 "$file" -o good.ply 2> errors
	ok $? "unpack accepts ${file#"$ROOT"/tests/formats/}"
done

# Any cut of a stream is noticed, and any changed byte.
"$PARTS" filleted --nasty -o part.stl
"$BIN/curv" part.stl | "$BIN/segment" | "$BIN/rectify" -o r.ply
"$BIN/fitcurves" r.ply -o c.ply
"$BIN/fitpatch" --mesh r.ply c.ply | "$BIN/assemble" | "$BIN/facefix" -o whole.ffx
size=$(wc -c < whole.ffx | tr -d ' ')
wrong=0
n=0
while [ "$n" -lt "$size" ]; do
	head -c "$n" whole.ffx > cut.ffx
	"$BIN/unpack" --cage cut.ffx -o cut.ply 2> errors
	[ $? -eq 3 ] && [ ! -e cut.ply ] || wrong=$((wrong + 1))
	{
		head -c "$n" whole.ffx
		printf '\245'
		tail -c +$((n + 2)) whole.ffx
	} > changed.ffx
	if ! cmp -s changed.ffx whole.ffx; then
		"$BIN/unpack" --cage changed.ffx -o changed.ply 2> errors
		[ $? -eq 3 ] && [ ! -e changed.ply ] || wrong=$((wrong + 1))
	fi
	n=$((n + 1))
done
is 0 $wrong "unpack refuses every cut and every changed byte of a stream of $size"
plan
