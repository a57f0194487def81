#!/bin/sh
# pipelines/batch.mk: a collection of parts on one machine and on a cluster; failures, bounds, kills, lost machines.
. "${ROOT:-.}/tests/tools/tap.sh"
: "${work:?}"

# batch ARGUMENTS
batch() {
	make -s -f "$ROOT/pipelines/batch.mk" BIN="$BIN/" "$@" 2> errors
}
# column NUMBER PART: of the table
column() {
	awk -F '\t' -v n="$1" -v part="$2" '$1 == part {print $n; exit}' "$out/batch.tsv"
}
# parts_with STATUS: how many
parts_with() {
	awk -F '\t' -v status="$1" '$10 == status {n++} END {print n + 0}' "$out/batch.tsv"
}
# running TEXT: processes that have it in their command
running() {
	for process in /proc/[0-9]*; do
		case $(tr '\0' ' ' < "$process/cmdline") in *"$1"*) echo "$process" ;; esac
	done 2> /dev/null
}
# cubes FOLDER COUNT: small parts c1.stl, c2.stl ..., no two of them equal
cubes() {
	mkdir "$1"
	n=0
	while [ $n -lt "$2" ]; do
		n=$((n + 1))
		"$PARTS" cube --facets 8 --seed $n --jitter 0.0005 -o "$1/c$n.stl"
	done
}

# The stages without the measuring, which takes most of the time of a small part.
cat > short.mk <<MK
all:
	\$(MAKE) -f "$ROOT/pipelines/patch.mk" BIN="$BIN/" EFFORT=0 IN=\$(IN) OUT=\$(OUT) \$(OUT)/\$(basename \$(IN)).ffx
MK

# --- a folder, a list -----------------------------------------------------------------------------------------------
cubes in 3
gzip -c in/c3.stl > in/Upper.STL.GZ
rm in/c3.stl
cp in/c1.stl 'in/a $b.stl'
cp in/c1.stl in/hülse.Stl
cp in/c1.stl in/c1.STL
cp in/c1.stl "in/line
end.stl"
cp in/c1.stl in/.hidden.stl
echo 'no part' > in/readme.txt
printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n' > in/broken.stl
out=out
batch -j2 IN=in OUT=out > log
is 2 $? 'a folder with bad parts in it'
is 5 "$(parts_with 'done')" '... all good ones are packed'
is 8 "$(awk 'NR > 1' out/batch.tsv | wc -l | tr -d ' ')" '... and every file is in the table'
is 'part triangles bytes ratio mean max watertight seconds MiB status message file' "$(head -n 1 out/batch.tsv | tr '\t' ' ')" '... under these headings'
is 'curv: broken.stl:4: coordinate is not a finite number' "$(column 11 broken)" '... a failure with its message'
is failed "$(column 10 broken)" '... and status'
is 1 "$(grep -c "another part is called c1: $work/in/c1.STL" out/batch.tsv)" '... two of one name'
is 1 "$(grep -c 'control character' out/batch.tsv)" '... a name of two lines'
[ -s out/a__b/a__b.ffx ] && [ -s out/hülse/hülse.ffx ] && [ -s out/Upper/Upper.ffx ]
ok $? '... blanks, signs, other letters, upper case and compression are no obstacle'
is 6 "$(grep -c '^\[[1-6]/6\] ' log)" '... a line for each that was run'
is 1 "$(grep -c '^batch: 8 parts: 5 packed, 3 failed; 60 triangles in [0-9]* bytes' log)" '... and one for all'
is "$(wc -c < out/c1/c1.ffx | tr -d ' ')" "$(column 3 c1)" '... the bytes are those of the file'
is 12 "$(column 2 c1)" '... a cube has twelve triangles'
is "$(awk -v bytes="$(column 3 c1)" 'BEGIN {printf "%.0f", 684 / bytes}')" "$(column 4 c1)" '... which are 684 bytes as binary STL'
at_most "$(column 6 c1)" 1 '... the largest distance is in per cent'
is yes "$(column 7 c1)" '... watertight'
at_most 3 "$(column 9 c1)" '... memory is that of the largest program, some MiB'
is "$work/in/a \$b.stl" "$(column 12 a__b)" '... the file of a part is named'
is 'c1.ffx c1.report log row ' "$(ls -A out/c1 | tr '\n' ' ')" '... what stays of a part'
is 'log row ' "$(ls -A out/broken | tr '\n' ' ')" '... and of a failed one'
is '' "$(ls -A out/.batch)" '... nothing is left over'
is 8 "$(grep -c '^<tr class=' out/batch.html)" '... the page has all of them'
patch IN=in/c2.stl OUT=direct > /dev/null 2>&1
cmp -s direct/c2.ffx out/c2/c2.ffx
ok $? '... the packed part is that of the pipeline alone'

# inodes PART...: they change when the part is done again
inodes() {
	for name; do
		stat -c %i out/$name/row
	done | tr '\n' ' '
}
before=$(inodes c1 c2 broken)
batch IN=in OUT=out > log
is 2 $? 'once more'
is "$before" "$(inodes c1 c2 broken)" '... nothing is done again'
is 8 "$(awk 'NR > 1' out/batch.tsv | wc -l | tr -d ' ')" '... and the table is whole'
touch -d '2001-01-01' in/c2.stl
"$PARTS" cube --facets 8 -o in/broken.stl
batch IN=in OUT=out > log
is 'c2 broken ' "$(sed -n 's/^\[.*\] \([a-z0-9]*\): .*/\1 /p' log | sort -r | tr -d '\n')" 'what changed is done again, older or not'
is 'done' "$(column 10 broken)" '... and mended'
: > in/c2.stl
batch IN=in/c2.stl OUT=out > log
is failed "$(column 10 c2)" 'a part that turns bad'
[ ! -e out/c2/c2.ffx ]
ok $? '... keeps no old result'
is 2 "$(wc -l < out/batch.tsv | tr -d ' ')" '... a part alone can be the source'
before=$(inodes c2)
batch IN=in/c2.stl OUT=out > log
is "$before" "$(inodes c2)" '... and is not tried again'
batch IN=in/c2.stl OUT=out RETRY=1 > log
[ "$before" != "$(inodes c2)" ]
ok $? '... but with RETRY'

printf '# a comment\r\nin/c1.stl\r\n\n  %s/in/a $b.stl\nin/nowhere.stl\n' "$work" > list
batch IN='list in/hülse.Stl in/c1.stl' OUT=out TOL=0.2% LEVEL=2 KEEP='ffx stl' > log
is 2 $? 'a list and parts'
is 'c1 a__b nowhere hülse ' "$(awk 'NR > 1 {print $1}' out/batch.tsv | tr '\n' ' ')" '... in their order, none twice'
is 'no such file' "$(column 11 nowhere)" '... one is missing'
is 3 "$(grep -c '^\[./3\]' log)" '... other options make all stale'
is 'c1.ffx c1.stl log row ' "$(ls -A out/c1 | tr '\n' ' ')" '... what was asked for is kept'
grep -q -e '--mean 0.2%' out/c1/log && grep -q -e '--level 2 ' out/c1/log
ok $? '... the options reach the pipeline'
out=all
batch IN=in/c1.stl OUT=all KEEP=all TOL=0.000001% MAX=0.000001% > log
is '0 missed' "$? $(column 10 c1)" 'a part that misses its bounds is packed'
[ -s all/c1/c1.curv.ply ] && [ -s all/c1/c1.ffx ] && [ -s all/c1/c1.stl ]
ok $? '... all that is made of it is kept on demand'
batch -j2 IN=in/c1.stl OUT=both > log1 &
other=$!
batch -j2 IN=in/c1.stl OUT=both > log2
is 0 $? 'two runs over one folder at a time'
wait $other
is '0 c1.ffx c1.report log row ' "$? $(ls -A both/c1 | tr '\n' ' ')" '... both succeed'
out=out
mkdir foreign foreign/c1
echo mine > foreign/c1/file
batch IN=in/c1.stl OUT=foreign > log
is 1 "$(grep -c 'c1 is there and was not made by a batch' foreign/batch.tsv)" 'a folder of somebody else is left alone'
is file "$(ls foreign/c1)" '... as it was'

for wrong in 'IN=in' 'OUT=out' 'IN=nowhere OUT=out' 'IN=direct OUT=out' 'IN=in OUT=out PIPELINE=nothing' 'IN=in OUT=out PART_SECONDS=soon' 'IN=in OUT=out SHARE=3'; do
	# shellcheck disable=SC2086 # words
	batch $wrong > log
	is "2 1" "$? $(grep -c '^batch: ' errors)" "$wrong: one line says what is wrong"
done

# --- shares ---------------------------------------------------------------------------------------------------------
cubes eight 8
out=shares
batch PIPELINE=short.mk IN=eight OUT=shares SHARE=0/2 > log
is '0 4' "$? $(ls -d shares/c* | wc -l | tr -d ' ')" 'a share of two'
[ ! -e shares/batch.tsv ]
ok $? '... makes no table'
batch PIPELINE=short.mk IN=eight OUT=shares table > log
is '2 4 4' "$? $(parts_with 'done') $(parts_with missing)" '... the table of what is there'
batch PIPELINE=short.mk IN=eight OUT=shares SHARE=1/2 > log
batch PIPELINE=short.mk IN=eight OUT=shares table > log
is '0 8' "$? $(parts_with 'done')" '... both shares are everything'

# --- bounds ---------------------------------------------------------------------------------------------------------
# Pipelines that misbehave; a command that names made/ is shown as the stage.
printf 'all:\n\tmkdir -p $(OUT)\n\ttrap "" TERM; sleep 97531 & sleep 97531 # $(OUT)/x\n' > slow.mk
printf 'all:\n\tmkdir -p $(OUT)\n\thead -c 300000000 /dev/zero | tail -n 1 > $(OUT)/c1.ffx\n' > large.mk
printf 'all:\n\tmkdir -p $(OUT)\n\tkill -9 $$$$ # $(OUT)/x\n' > killed.mk
printf 'all:\n\techo $(IN) is fine\n' > idle.mk
out=bounds
batch IN=in/c1.stl OUT=bounds PIPELINE=slow.mk PART_SECONDS=1 > log
is '2 failed' "$? $(column 10 c1)" 'a part that takes too long'
is 'more than 1 seconds, in sleep' "$(column 11 c1 | sed 's/trap/sleep/')" '... is told so'
is '' "$(running 'sleep 97531')" '... and nothing of it is left running'
batch IN=in/c1.stl OUT=bounds PIPELINE=large.mk PART_MIB=200 > log
is '2 failed tail: memory exhausted' "$? $(column 10 c1) $(column 11 c1)" 'a part that takes too much memory'
[ ! -e bounds/c1/c1.ffx ]
ok $? '... leaves no file'
batch IN=in/c1.stl OUT=bounds PIPELINE=killed.mk > log
is '2 failed kill: Killed' "$? $(column 10 c1) $(column 11 c1)" 'a stage that crashes'
batch IN=in/c1.stl OUT=bounds PIPELINE=idle.mk > log
is '2 the pipeline made no packed file' "$? $(column 11 c1)" 'a pipeline that makes nothing'

# --- killed ---------------------------------------------------------------------------------------------------------
# whole FOLDER: a result is the whole result
whole() {
	for row in "$1"/*/row; do
		[ -e "$row" ] || continue
		name=$(basename "$(dirname "$row")")
		cmp -s "$1/$name/$name.ffx" "shares/$name/$name.ffx" && [ "$(wc -l < "$row")" -eq 2 ] && [ -s "$1/$name/log" ] || return 1
	done
	[ "$(ls -d "$1"/c* 2> /dev/null | wc -l)" -eq "$(ls "$1"/c*/row 2> /dev/null | wc -l)" ]
}
for how in 'KILL 0.3' 'TERM 0.6' 'KILL 0.9' 'INT 0.5'; do
	rm -rf killed
	# timeout signals make alone, except for the INT of a terminal, which all get
	set --
	[ "${how%% *}" = INT ] || set -- --foreground
	(exec timeout "$@" -s $how make -s -j2 -f "$ROOT/pipelines/batch.mk" BIN="$BIN/" PIPELINE=short.mk IN=eight OUT=killed) > log 2>&1
	whole killed
	ok $? "killed by ${how%% *} after ${how##* } seconds: a part is there as a whole or not"
	left=50
	while [ $left -gt 0 ] && [ -n "$(running "$work/killed")" ]; do
		sleep 0.1
		left=$((left - 1))
	done
	is '' "$(running "$work/killed")" '... nothing goes on'
	whole killed
	ok $? '... nor becomes half a part'
done
settled=$(ls killed/c*/row 2> /dev/null | wc -l)
batch -j2 PIPELINE=short.mk IN=eight OUT=killed > log
is 0 $? 'the next run goes on'
is "$((8 - settled))" "$(grep -c '^\[' log)" '... with what is missing'
out=killed
is '8 0' "$(parts_with 'done') $(ls -A killed/.batch | wc -l | tr -d ' ')" '... to the end'
whole killed
ok $? '... as if nothing had been'

# --- launched -------------------------------------------------------------------------------------------------------
out=launched
cat > launcher <<'SH'
#!/bin/sh
# a launcher that fails at first
echo "$*" >> launches
[ "$(wc -l < launches)" -gt "$1" ] || { echo 'launcher: machine lost' >&2; exit 1; }
shift
exec "$@"
SH
batch IN=in/c1.stl OUT=launched LAUNCH='sh "launcher" 9' LAUNCHES=1 > log
is '2 lost could not be run, 1 times: launcher: machine lost' "$? $(column 10 c1) $(column 11 c1)" 'a launcher that fails'
[ ! -e launched/c1 ]
ok $? '... settles nothing'
batch IN=in/c1.stl OUT=launched LAUNCH="sh '$work/launcher' 2" LAUNCHES=2 > log
is '0 3' "$? $(wc -l < launches | tr -d ' ')" '... is tried again'
: > launches
batch IN=in/broken.stl OUT=launched LAUNCH='sh launcher 0' PIPELINE=idle.mk > log
is '2 1' "$? $(wc -l < launches | tr -d ' ')" '... but not for a part that fails'

# --- a cluster ------------------------------------------------------------------------------------------------------
# Slurm as it is on Debian, on the loopback: a controller and two nodes, with keys, ports and folders of
# their own. bounded ends them with this test, whatever ends that.
PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd srun; do
	if ! command -v $program > /dev/null; then
		skip 'forty parts on two nodes' "no $program: apt-get install munge slurmctld slurmd slurm-client"
		plan
	fi
done
slurm=$work/slurm
mkdir -p "$slurm/state" "$slurm/n1" "$slurm/n2"
port=$((17000 + $$ % 3500 * 4))
while grep -qi "$(printf ':%04X \|:%04X \|:%04X ' $port $((port + 1)) $((port + 2)))" /proc/net/tcp; do
	port=$((port + 3))
done
host=$(uname -n)
host=${host%%.*}
user=$(id -un)
head -c 128 /dev/urandom > "$slurm/key"
chmod 400 "$slurm/key"
cat > "$slurm/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthInfo=socket=$slurm/socket
SlurmctldPort=$port
SlurmctldPidFile=$slurm/slurmctld.pid
StateSaveLocation=$slurm/state
SlurmdPidFile=$slurm/%n/pid
SlurmdSpoolDir=$slurm/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdTimeout=5
KillWait=2
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=0
SlurmdParameters=config_overrides
NodeName=n[1-2] NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1))-$((port + 2)) CPUs=2
PartitionName=all Nodes=ALL Default=YES
CONF
export SLURM_CONF="$slurm/slurm.conf"
# service NAME COMMAND...
service() {
	service=$1
	shift
	"$BIN/bounded" -q --tied --seconds 300 -- "$@" > "$slurm/$service.log" 2>&1 &
	services="$services $!"
}
services=
end_services() {
	# shellcheck disable=SC2086 # words
	[ -z "$services" ] || kill $services 2> /dev/null
	wait
	rm -rf "$work"
}
trap end_services EXIT
service munged munged --foreground --force --key-file="$slurm/key" --socket="$slurm/socket" --pid-file="$slurm/munged.pid" \
	--log-file="$slurm/munged.log" --seed-file="$slurm/seed"
left=50
while [ $left -gt 0 ] && [ ! -S "$slurm/socket" ]; do
	sleep 0.1
	left=$((left - 1))
done
service slurmctld slurmctld -D
service n1 slurmd -D -N n1
service n2 slurmd -D -N n2
deadline=$(($(date +%s) + 20))
while [ "$(date +%s)" -lt $deadline ] && [ "$(timeout 3 sinfo -h -N -o %t 2> /dev/null | grep -c '^idle$')" -ne 2 ]; do
	sleep 0.1
done
nodes=$(timeout 20 srun -N2 sh -c 'echo $SLURMD_NODENAME' 2> "$slurm/srun.log" < /dev/null | sort | tr '\n' ' ')
if [ "$nodes" != 'n1 n2 ' ]; then
	skip 'forty parts on two nodes' "Slurm does not run here: $(tail -q -n 1 "$slurm"/*.log | tr '\n' ' ')"
	plan
fi

# The pipeline itself, but it notes who starts, and with the file "hold" there the second node gets stuck.
cat > noted.mk <<MK
all:
	echo "\$\$SLURMD_NODENAME \$(IN)" >> "$work/started"
	if test -e "$work/hold" && test "\$\$SLURMD_NODENAME" = n2; then \
		echo \$\$\$\$ > "$work/\$(IN).pid"; mv "$work/\$(IN).pid" "$work/held/\$(IN)"; while test -e "$work/hold"; do sleep 0.1; done; fi
	\$(MAKE) -f "$work/short.mk" IN=\$(IN) OUT=\$(OUT)
	echo "\$\$SLURMD_NODENAME \$(IN)" >> "$work/ended"
MK
mkdir held
cubes forty 40
"$PARTS" cube --facets 8 -o forty/c40.stl
printf 'bad' > forty/c39.stl
out=cluster
"$BIN/bounded" --tied -- make -s -j8 -f "$ROOT/pipelines/batch.mk" BIN="$BIN/" IN=forty OUT=cluster PIPELINE=noted.mk LAUNCH='srun -Q -n1 -N1' > log 2> errors &
batch_pid=$!
left=600
while [ $left -gt 0 ] && [ "$(grep -c '^\[' log)" -lt 16 ]; do
	sleep 0.1
	left=$((left - 1))
done
is 2 "$(cut -d ' ' -f 1 started | sort -u | wc -l | tr -d ' ')" 'both nodes work'
touch hold
while [ $left -gt 0 ] && [ -z "$(ls held)" ]; do
	sleep 0.1
	left=$((left - 1))
done
# The whole machine: the daemon, then the steps that it had and what these run. A step that the daemon had just begun
# gets stuck a moment later: what the node has started and not ended is waited for, until there has been no more of it
# for a second.
kill -9 "$(cat "$slurm/n2/pid")"
still=0
while [ $left -gt 0 ] && [ $still -lt 10 ]; do
	sleep 0.1
	left=$((left - 1))
	still=$((still + 1))
	lost=$(ls held | tr '\n' ' ')
	# The bad part never ends.
	if [ "$lost" != "$(sed -n '/c39/d; s/^n2 //p' started ended | sort | uniq -u | tr '\n' ' ')" ] || [ "$lost" != "${seen:-}" ]; then
		still=0
	fi
	seen=$lost
done
for name in $lost; do
	doomed=
	pid=$(cat "held/$name")
	while [ "$pid" -gt 1 ]; do
		doomed="$pid $doomed"
		case $(cat "/proc/$pid/comm") in slurmstepd*) break ;; esac
		pid=$(sed -n 's/^PPid:[[:space:]]*//p' "/proc/$pid/status")
	done
	# shellcheck disable=SC2086 # words
	kill -9 $doomed 2> /dev/null
done
rm hold
wait $batch_pid
is 2 $? 'forty parts on two nodes, one of which is lost half-way: one part is bad'
is '39 1 0' "$(parts_with 'done') $(parts_with failed) $(parts_with lost)" '... every other one is done'
is '40 40' "$(grep -c '^\[' log) $(sed -n 's/^\[.*\] \(c[0-9]*\): .*/\1/p' log | sort -u | wc -l | tr -d ' ')" '... each is told of once'
is '39 39' "$(wc -l < ended | tr -d ' ') $(sort -u -k 2 ended | wc -l | tr -d ' ')" '... and done once'
is "$lost" "$(cut -d ' ' -f 2 started | sort | uniq -d | tr '\n' ' ')" '... only what the lost node had was started again'
is 0 "$(for name in $lost; do grep "^n2 $name\$" ended; done | wc -l)" '... on the other one'
is '' "$(ls -A cluster/.batch/*/work/* 2> /dev/null)" '... nothing is left over'
is 1 "$(grep ' c39.stl$' started | wc -l | tr -d ' ')" '... the bad part was not tried again'
before=$(wc -l < started)
batch IN=forty OUT=cluster PIPELINE=noted.mk LAUNCH='srun -Q -n1 -N1' > log
is "$before" "$(wc -l < started)" 'the same again starts nothing'

# A job array, a share each.
rm -f started ended
sbatch -Q --array=0-1 -o /dev/null --wrap "make -s -f '$ROOT/pipelines/batch.mk' BIN='$BIN/' PIPELINE=short.mk IN=eight OUT=array SHARE=\$SLURM_ARRAY_TASK_ID/2" < /dev/null
ok $? 'a job array'
left=300
while [ $left -gt 0 ] && [ -n "$(squeue -h)" ]; do
	sleep 0.1
	left=$((left - 1))
done
out=array
batch PIPELINE=short.mk IN=eight OUT=array table > log
is '0 8' "$? $(parts_with 'done')" '... does all parts'
plan
