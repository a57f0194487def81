#!/bin/sh
# The EXAMPLES of the manual pages do what they say, and every tool and pipeline has its page.
. "${ROOT:-.}/tests/tools/tap.sh"
PATH=$BIN:$PATH
# What counts here is that the commands run: where an example does not say how long polish shall search, it does not.
EFFORT=0
export PATH EFFORT

mkdir parts
for name in flange bracket shaft elbow pin ring gear; do
	# few facets: what counts here is that the commands run
	"$PARTS" $name --facets 24 -o parts/$name.stl || exit 1
done

# commands PAGE: the lines "$ command" of its EXAMPLES, with the escapes of mdoc undone
commands() {
	sed -n '/^\.Sh EXAMPLES/,/^\.Sh [^E]/p' "$1" |
		sed -n "s/^\\\$ //p" | sed "s/\\\\e/\\\\/g; s/\\\\-/-/g; s/\\\\(aq/'/g; s/\\\\&//g"
}

for page in "$ROOT"/man/man1/*.1 "$ROOT"/man/man7/*.7; do
	name=$(basename "$page")
	mkdir "$name.d"
	cp parts/*.stl "$name.d"
	commands "$page" > "$name.sh"
	lines=$(wc -l < "$name.sh" | tr -d ' ')
	case $name in
	*.1)
		[ "$lines" -gt 0 ]
		ok $? "$name: has examples"
		;;
	esac
	[ "$lines" -gt 0 ] || continue
	mkdir -p "$name.d/pipelines"
	cp "$ROOT"/pipelines/* "$name.d/pipelines"
	(cd "$name.d" && BIN="$BIN/" sh -e ../"$name.sh") > "$name.out" 2>&1 < /dev/null
	status=$?
	ok $status "$name: its $lines examples run"
	[ $status -eq 0 ] || sed 's/^/# /' "$name.out" | tail -n 20
	is '' "$(find "$name.d" -name '.*.??????')" "$name: nothing is left over"
done

for tool in "$BIN"/*; do
	tool=$(basename "$tool")
	[ -e "$ROOT/man/man1/$tool.1" ]
	ok $? "$tool has a page"
done

# Names that the pages refer to exist, or belong to other packages.
for xref in $(sed -n 's/^\.Xr \([a-z0-9-]*\) \([157]\).*/\1.\2/p' "$ROOT"/man/man?/* | sort -u); do
	case $xref in
	make.1 | gzip.1 | sh.1 | awk.1 | man.1) continue ;;
	esac
	[ -e "$ROOT/man/man${xref##*.}/$xref" ]
	ok $? "$xref exists"
done

# The complete example at the head of each format's page is a file of that format.
# example PAGE: its first block that begins with the line "ply"
example() {
	awk '/^\.Bd/ {inside = 1; next} inside && first == "" {first = $0; keep = $0 == "ply"} /^\.Ed/ {if (keep) exit; inside = 0; first = ""; next}
	inside && keep {gsub(/\\e/, "\\"); gsub(/\\-/, "-"); print}' "$1"
}
example "$ROOT/man/man5/cagewright-cage.5" > cage.ply
"$BIN/refine" cage.ply -o cage.obj
ok $? 'the example of cagewright-cage(5) is a cage'
example "$ROOT/man/man5/cagewright-dense.5" > dense.ply
"$BIN/render" dense.ply -o dense.png
ok $? 'the example of cagewright-dense(5) is a dense mesh'
example "$ROOT/man/man5/cagewright-network.5" > network.ply
"$BIN/render" network.ply -o network.png
ok $? 'the example of cagewright-network(5) is a network'
plan
