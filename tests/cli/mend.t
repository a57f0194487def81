#!/bin/sh
# mend from the outside: streams, formats, exit codes, messages.
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
	rm -f out.*
	got=$("$BIN/mend" "$@" -o out.ply 2>&1)
	is "$code: $message" "$?: $got" "refuses: $message"
	[ "$(ls out.* 2>/dev/null)" = "" ]
	ok $? "... and writes nothing"
}

# A unit cube of quads; the last face runs the wrong way, and a vertex is unused.
cat >cube.off <<'END'
OFF
9 6 0
0 0 0
1 0 0
0 1 0
1 1 0
0 0 1
1 0 1
0 1 1
1 1 1
5 5 5
4 0 2 3 1
4 4 5 7 6
4 0 1 5 4
4 2 6 7 3
4 0 4 6 2
4 1 5 7 3
END
want='mend: warning: cube.off: 2 faces turned over
mend: warning: cube.off: 1 unused vertex removed'

got=$("$BIN/mend" cube.off -o cube.ply 2>&1)
is "0: $want" "$?: $got" 'says each repair once'
got=$("$BIN/mend" -q cube.off -o cube.stl 2>&1)
is '0: ' "$?: $got" 'is quiet with -q'
is 684 "$(wc -c <cube.stl | tr -d ' ')" 'writes 12 facets as binary STL'
is 'element vertex 8' "$(sed -n 3p cube.ply)" 'writes 8 vertices'

"$BIN/mend" -q <cube.off >stdin.ply
cmp -s stdin.ply cube.ply
ok $? 'reads standard input, writes PLY to standard output'
gzip -c cube.off >cube.off.gz
"$BIN/mend" -q cube.off.gz | cmp -s - cube.ply
ok $? 'reads gzip'
"$BIN/mend" cube.ply 2>&1 | cmp -s - cube.ply
ok $? 'leaves a clean mesh as it is, silently'

for kind in obj off stl stla ply; do
	"$BIN/mend" -q cube.off -o a.$kind && mv a.$kind "a.${kind%a}" 2>/dev/null
	"$BIN/mend" --report report "a.${kind%a}" -o again.off 2>&1 | sed 's/^/# /'
	is 'component.0.vertices=8
component.0.edges=18
component.0.faces=12
component.0.euler=2
component.0.borders=0
component.0.genus=0
component.0.volume=1' "$(grep '^component\.' report)" "$kind comes back as a cube"
done

is 'faces_turned_over 0' "$("$BIN/mend" cube.ply --report r -o x.off 2>&1; sed -n 's/^face_turned_over=/faces_turned_over /p' r)" 'reports zeros'
"$BIN/mend" --check cube.stl
is 0 $? 'an STL file needs no repair for being one'
"$BIN/mend" -q --check cube.off >check.out
is 1 $? '--check says no'
[ ! -s check.out ]
ok $? '... and writes nothing'

# One corner of one facet is off by a thousandth.
"$BIN/mend" -q cube.off -o crack.stla
awk '/vertex 1 1 1/ && !done { print "vertex 1 1 1.001"; done = 1; next } { print }' crack.stla >crack.stl
"$BIN/mend" --weld 0.2% --report r crack.stl -o x.off 2>/dev/null
is 'component.0.borders=0' "$(grep component.0.borders r)" '--weld closes a crack'
"$BIN/mend" --exact --report r crack.stl -o x.off 2>/dev/null
is 'component.0.borders=1' "$(grep component.0.borders r)" '--exact leaves it'

printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n' >nan.off
refuses 3 'mend: nan.off:5: coordinate is not a finite number' nan.off
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n' >flat.off
refuses 3 'mend: flat.off: no face has an area' flat.off
: >empty.stl
refuses 3 'mend: empty.stl: the file is empty' empty.stl
head -c 300 cube.stl >cut.stl
refuses 3 'mend: cut.stl: byte 80: the header promises 12 facets, the file has room for 4 and a part' cut.stl
refuses 4 'mend: missing.stl: No such file or directory' missing.stl
refuses 2 'mend: --exact and --weld exclude each other' --exact --weld 1 cube.off
got=$("$BIN/mend" cube.off -o cube.step 2>&1)
is "2: mend: no writer for '.step' files (ply, obj, off, stl, stla)" "$?: $got" 'refuses an unknown extension'
printf 'OFF\n3 1 0\n0 0 0\n1e39 0 0\n0 1e39 0\n3 0 1 2\n' >huge.off
rm -f huge.stl
got=$("$BIN/mend" huge.off -o huge.stl 2>&1)
is '3: mend: vertex 1: coordinate 1e+39 is too large for STL' "$?: $got" 'refuses what STL cannot hold'
[ ! -e huge.stl ]
ok $? '... and leaves no file'
"$BIN/mend" -q cube.off -o /dev/full 2>/dev/null
is 4 $? 'a full disk is exit 4'
echo "1..$n"
