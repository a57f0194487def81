#!/bin/sh
# What every tool owes its user: help, version, streams, exit codes, whole output or none.
. "${ROOT:-.}/tests/tools/tap.sh"

part filleted --nasty
"$BIN/curv" filleted.stl -o in.segment && "$BIN/segment" in.segment -o in.rectify && "$BIN/rectify" in.rectify -o in.fitcurves &&
	"$BIN/fitcurves" in.fitcurves -o in.fitpatch && "$BIN/fitpatch" --mesh in.fitcurves in.fitpatch -o in.assemble &&
	"$BIN/assemble" in.assemble -o in.polish && "$BIN/polish" --effort 1 --mesh filleted.stl in.polish -o in.facefix && "$BIN/facefix" in.facefix -o in.unpack
ok $? 'the stages run one after the other'
cp filleted.stl in.curv
cp filleted.stl in.mend
cp filleted.stl in.deviate
cp in.facefix in.refine
cp in.facefix in.render
printf 'old\n' > old

# with TOOL: its options and operands before FILE that this input needs
with() {
	case $1 in
	fitpatch) echo '--mesh in.fitcurves' ;;
	polish) echo '--effort 0 --mesh filleted.stl' ;;
	deviate) echo 'filleted.stl' ;;
	esac
}

# The lines of the SYNOPSIS as mandoc shows them, blanks squeezed.
synopsis() {
	mandoc -T ascii -O width=200 "$1" | sed "s/.$(printf '\b')//g" | sed -n '/^SYNOPSIS/,/^[A-Z]/p' | grep -v '^[A-Z]' | tr -s ' \t\n' ' ' | sed 's/^ //; s/ $//'
}
# The usage lines of --help: to the first line that is not continued by eight blanks or more.
usage() {
	"$BIN/$1" --help | awk 'NR == 1 {sub(/^usage: /, ""); print; next} /^        / {print; next} {exit}' | tr -s ' \t\n' ' ' | sed 's/^ //; s/ $//'
}

for tool in assemble curv deviate facefix fitcurves fitpatch mend polish rectify refine render segment unpack; do
	input=in.$tool
	before=$(with $tool)
	# what it writes is told by the extension for some
	x=ply
	[ $tool = render ] && x=png
	# shellcheck disable=SC2086 # options are words
	run() { "$BIN/$tool" $before "$@"; }

	"$BIN/$tool" --help > help 2> errors
	ok $? "$tool: --help succeeds"
	is '' "$(cat errors)" "$tool: --help is silent on standard error"
	is "usage: $tool" "$(head -n 1 help | cut -c 1-$((7 + ${#tool})))" "$tool: --help shows its usage"
	page=$ROOT/man/man1/$tool.1
	if [ -e "$page" ]; then
		is "$(synopsis "$page")" "$(usage $tool)" "$tool: --help equals the SYNOPSIS of its page"
	else
		ok 1 "$tool: has a page"
	fi
	"$BIN/$tool" --version > version 2> errors
	ok $? "$tool: --version succeeds"
	is "$tool (cagewright)" "$(cut -d ' ' -f 1,2 version)" "$tool: --version names it"

	"$BIN/$tool" --no-such-option "$input" > out 2> errors < /dev/null
	is 2 $? "$tool: unknown option is wrong usage"
	is 1 "$(grep -c "^$tool: .*no-such-option" errors)" "$tool: ... and is named"
	is 1 "$(wc -l < errors | tr -d ' ')" "$tool: ... in one line"
	[ ! -s out ]
	ok $? "$tool: ... and writes nothing"

	run missing.file > out 2> errors < /dev/null
	is 4 $? "$tool: missing file"
	is 1 "$(grep -c "^$tool: missing.file: No such file or directory" errors)" "$tool: ... is named"
	[ ! -s out ]
	ok $? "$tool: ... and nothing is written"

	: > empty
	cp old kept.$x
	run empty -o kept.$x > out 2> errors < /dev/null
	is 3 $? "$tool: empty file is wrong input"
	said='the file is empty'
	[ $tool = unpack ] && said='not an FFX stream'
	is "$tool: empty: $said" "$(cat errors)" "$tool: ... and is named"
	cmp -s old kept.$x
	ok $? "$tool: ... and the old output stays"
	if [ $tool != deviate ]; then
		run < /dev/null > out 2> errors
		is 3 $? "$tool: empty standard input"
		is 1 "$(grep -c "^$tool: <stdin>" errors)" "$tool: ... is called <stdin>"
		run < "$input" > from-stdin 2> errors
		ok $? "$tool: reads standard input"
		run - < "$input" > from-dash 2> errors
		cmp -s from-stdin from-dash
		ok $? "$tool: - is standard input"
		run "$input" > from-file 2> errors
		cmp -s from-stdin from-file
		ok $? "$tool: a file gives the same"
		run "$input" -o from-option.$x > out 2> errors
		cmp -s from-file from-option.$x
		ok $? "$tool: -o gives the same"
		[ ! -s out ]
		ok $? "$tool: ... and leaves standard output alone"
		is '' "$(run -q "$input" 2>&1 > /dev/null)" "$tool: -q is silent"
	fi
	run "$input" -o again1.$x 2> errors
	run "$input" -o again2.$x 2> errors
	cmp -s again1.$x again2.$x
	ok $? "$tool: a second run gives the same bytes"
	OMP_NUM_THREADS=1 run "$input" -o one.$x 2> errors
	OMP_NUM_THREADS=2 run "$input" -o two.$x 2> errors
	cmp -s one.$x two.$x
	ok $? "$tool: one thread or two give the same bytes"
	LC_ALL=de_DE.UTF-8 run "$input" -o german.$x 2> errors
	cmp -s german.$x again1.$x
	ok $? "$tool: the locale does not matter"

	run "$input" > /dev/full 2> errors
	is 4 $? "$tool: a full disk"
	is 1 "$(grep -c "^$tool: .*No space left on device" errors)" "$tool: ... is named"
	run "$input" -o no/such/folder/out.$x 2> errors
	is 4 $? "$tool: no folder for the output"
	is 1 "$(grep -c "^$tool: no/such/folder/out" errors)" "$tool: ... is named"
	[ ! -e no ]
	ok $? "$tool: ... and it makes none"

	mkdir -p folder.$x
	run folder.$x > out 2> errors < /dev/null
	is 4 $? "$tool: a folder as input"
	is "$tool: folder.$x: Is a directory" "$(cat errors)" "$tool: ... is named"
	run "$input" -o folder.$x > out 2> errors
	is 4 $? "$tool: a folder as output"
	is "$tool: folder.$x: Is a directory" "$(cat errors)" "$tool: ... is named"

	# A stage that is killed while it waits for its input leaves the old file.
	cp old kept.$x
	rm -f fifo
	mkfifo fifo
	# The tool itself in the background, not a shell that waits for it: the shell would die and the tool go on.
	# shellcheck disable=SC2086 # options are words
	"$BIN/$tool" $before fifo -o kept.$x 2> killed &
	pid=$!
	exec 3<> fifo
	sleep 0.2
	kill -TERM $pid
	wait $pid
	is 143 $? "$tool: ends by SIGTERM"
	exec 3>&-
	cmp -s old kept.$x
	ok $? "$tool: ... and the old output stays"
	is '' "$(find . -name ".kept*")" "$tool: ... and nothing is left over"
done

# The marks that stages leave.
is 7 "$(grep -c '^comment cagewright [a-z]* [0-9]' in.facefix)" 'each stage says in its file what it did'
is '' "$(grep -al "$work" in.* | head -n 1)" 'no file names a folder of this machine'
"$BIN/curv" --no-provenance filleted.stl | grep -q '^comment cagewright curv'
is 1 $? '--no-provenance leaves that out'
"$BIN/curv" --binary filleted.stl -o binary.ply
"$BIN/segment" binary.ply > from-binary 2> errors
ok $? '--binary is read by the next stage'
"$BIN/curv" filleted.stl | head -n 1 > first 2> errors
is ply "$(cat first)" 'a closed pipe ends a stage quietly'
gzip -k filleted.stl
"$BIN/curv" filleted.stl.gz | cmp -s - in.segment
ok $? 'compressed input gives the same'
plan
