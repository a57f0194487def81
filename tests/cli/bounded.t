#!/bin/sh
# bounded: bounds of time and memory, statuses, and that nothing stays behind.
. "${ROOT:-.}/tests/tools/tap.sh"
: "${work:?}"
bounded() {
	"$BIN/bounded" "$@" 2> errors
}
# gone PID: within a few seconds (a zombie is gone)
gone() {
	left=50
	while [ $left -gt 0 ] && grep -q '^State:[[:space:]]*[^ZX[:space:]]' "/proc/$1/status" 2> /dev/null; do
		sleep 0.1
		left=$((left - 1))
	done
	[ $left -gt 0 ]
}

bounded --help > help
ok $? '--help succeeds'
is "$(mandoc -T ascii -O width=200 "$ROOT/man/man1/bounded.1" | sed "s/.$(printf '\b')//g" | sed -n '/^SYNOPSIS/,/^[A-Z]/p' | grep -v '^[A-Z]' | tr -s ' \t\n' ' ' | sed 's/^ //; s/ $//')" \
	"$(sed 's/^usage: //' help | tr -s ' \t\n' ' ' | sed 's/^ //; s/ $//')" '... and equals the SYNOPSIS of its page'
for wrong in '' '--seconds' '--seconds -1 -- true' '--mib many -- true' '--no-such-option -- true' 'true' '--'; do
	# shellcheck disable=SC2086 # words
	bounded $wrong
	is '2 1' "$? $(grep -c '^bounded: ' errors)" "'$wrong' is wrong usage, in one line"
done

bounded -- sh -c 'exit 7'
is 7 $? 'the status of the command'
bounded -- sh -c 'kill -9 $$'
is 137 $? '... and of one that a signal ended'
bounded -- ./nothing
is '127 1' "$? $(grep -c 'bounded: ./nothing: No such file' errors)" 'no such command'
echo > text
bounded -- ./text
is 126 $? 'a file that is no command'
is '-x a  b' "$(bounded --seconds 9 -- printf '%s %s' -x 'a  b')" 'the words of the command are its own'
is through "$(echo through | bounded -- cat)" 'streams are those of the command'

bounded --log log --name one -- true
bounded --log log -- sh -c 'head -c 30000000 /dev/zero | tail -n 1 > /dev/null; exit 3'
is 3 $? 'a log'
is 'one 0 sh 3' "$(awk -F '\t' '{printf "%s%s %s", sep, $1, $4; sep = " "}' log)" '... has a line for each run'
is 4 "$(awk -F '\t' 'END {print NF}' log)" '... of four fields'
at_most 29000 "$(awk -F '\t' '$1 == "sh" {print $3}' log)" '... the memory is that of the largest process below, at least'
at_most "$(awk -F '\t' '$1 == "sh" {print $3}' log)" 60000 '... and not much more'

bounded --mib 100 -- sh -c 'head -c 300000000 /dev/zero | tail -n 1 > /dev/null'
is '1 1' "$? $(grep -c 'memory exhausted' errors)" 'the bound of memory holds for what the command starts'
# shellcheck disable=SC3045 # dash and bash have it
(ulimit -v 50000 && bounded --mib 100000 -- sh -c 'ulimit -v') > limit
is 50000 "$(cat limit)" '... and never raises a lower one'

start=$(date +%s)
bounded --seconds 0.5 --log late -- sh -c 'trap "" TERM; echo $$ > stubborn; sleep 60 & echo $! > child; while :; do sleep 1; done'
is '124 1' "$? $(grep -c 'stopped after 0.5 seconds' errors)" 'the bound of time'
at_most $(($(date +%s) - start)) 8 '... holds for a command that does not want to end'
is 124 "$(cut -f 4 late)" '... and is in the log'
gone "$(cat stubborn)" && gone "$(cat child)"
ok $? '... nothing stays behind'
bounded -- sh -c 'sleep 60 & echo $! > child'
gone "$(cat child)"
ok $? 'what the command leaves behind ends with it'

rm child
for signal in 'HUP 1' 'INT 2' 'TERM 15'; do
	# a shell without job control lets its background children ignore SIGINT: perl undoes that
	perl -e '$SIG{INT} = "DEFAULT"; exec @ARGV' "$BIN/bounded" -- sh -c 'echo $$ > child; sleep 60' &
	pid=$!
	until [ -s child ]; do sleep 0.1; done
	kill -s ${signal% *} $pid
	wait $pid
	is $((128 + ${signal#* })) $? "${signal% *} ends it by that signal"
	gone "$(cat child)"
	ok $? '... with its command'
	rm child
done

# Its parent is killed: with --tied it ends, without it goes on.
for tied in --tied ''; do
	# shellcheck disable=SC2086 # a word or none
	sh -c '"$@" & wait' sh "$BIN/bounded" --seconds 60 $tied -- sh -c 'echo $$ > child; sleep 60' &
	pid=$!
	until [ -s child ]; do sleep 0.1; done
	sleep 0.2
	kill -9 $pid
	wait $pid 2> /dev/null
	if [ -n "$tied" ]; then
		gone "$(cat child)"
		ok $? '--tied: ends with the process that started it'
	else
		sleep 0.5
		kill -0 "$(cat child)"
		ok $? '... and without it goes on'
		kill "$(cat child)"
	fi
	rm child
done
plan
