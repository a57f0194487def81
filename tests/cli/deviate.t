#!/bin/sh
# deviate from the outside: streams, bounds, exit codes, messages.
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
	got=$("$BIN/deviate" "$@" 2>&1 >out.data)
	is "$code: $message" "$?: $got" "refuses: $message"
	[ ! -s out.data ]
	ok $? "... and writes nothing"
}
plate() { # plate Z: a square of side 2
	printf '%s\n' OFF '4 1 0' "0 0 $1" "2 0 $1" "2 2 $1" "0 2 $1" '4 0 1 2 3'
}
value() { # value KEY FILE
	sed -n "s/^$1=//p" "$2"
}

plate 0 >low.off
plate 0.25 >high.off
"$BIN/deviate" low.off high.off >out
ok $? 'measures two files'
is 0.25 "$(value sym_max_abs out)" 'plates 0.25 apart'
is 0.125 "$(value sym_max_side out)" '... an eighth of the longest side'
is 4 "$(value a_area out)" 'area'
is 2 "$(value bbox_side out)" 'longest side'
is 4 "$(value a_open_edges out)" 'a plate has four open edges'
is '' "$(value bounds out)" 'no bounds, no verdict'
plate 0.25 | "$BIN/deviate" low.off - >stdin.out
cmp -s out stdin.out
ok $? 'reads stdin'
gzip -c high.off >high.off.gz
"$BIN/deviate" low.off high.off.gz -o file.out && cmp -s out file.out
ok $? 'reads gzip, writes to a file'
OMP_NUM_THREADS=1 "$BIN/deviate" low.off high.off >one.out
cmp -s out one.out
ok $? 'same bytes with one thread'
is 1000 "$("$BIN/deviate" --samples 1000 low.off high.off | sed -n 's/^samples=//p')" '--samples'

"$BIN/deviate" --mean 0.25001 --max 12.51% low.off high.off >out
is "0 kept" "$? $(value bounds out)" 'bounds kept'
"$BIN/deviate" --mean 0.24999 low.off high.off >out
is "1 exceeded" "$? $(value bounds out)" 'mean exceeded'
"$BIN/deviate" --max 12.49% low.off high.off >out
is "1 exceeded" "$? $(value bounds out)" 'maximum exceeded'

printf '%s\n' OFF '4 1 0' '0 0 0' >cut.off
refuses 3 'deviate: cut.off:2: 4 vertices are promised, more than the file can hold' low.off cut.off
: >empty.off
refuses 3 'deviate: empty.off: the file is empty' empty.off low.off
printf '%s\n' OFF '3 1 0' '0 0 0' '1 0 0' '2 0 0' '3 0 1 2' >line.off
refuses 3 'deviate: line.off: a surface without area' low.off line.off
refuses 4 'deviate: none.off: No such file or directory' none.off low.off
"$BIN/deviate" low.off 2>/dev/null
is 2 $? 'one file is wrong usage'
"$BIN/deviate" --samples 3 low.off high.off 2>/dev/null
is 2 $? 'too few samples are wrong usage'
"$BIN/deviate" low.off high.off >/dev/full 2>err
is 4 $? 'a full disk is exit 4'
"$BIN/deviate" --help | head -1 | grep -q '^usage: deviate '
ok $? '--help'
echo "1..$n"
