#!/bin/sh
# Well-known parts, when there is a folder of them: make check DATA=folder. A part that the folder lacks is skipped.
. "${ROOT:-.}/tests/tools/tap.sh"
[ -n "${DATA:-}" ] || skip_all 'DATA is not set: no folder of well-known parts'
[ -d "$DATA" ] || skip_all "$DATA is not a folder"
[ -d "$DATA/meshes" ] && meshes=$DATA/meshes || meshes=$DATA
[ -d "$DATA/nasty" ] && nasty=$DATA/nasty || nasty=$DATA/../nasty

# find_part NAME: its file
find_part() {
	for extension in off.gz stl.gz ply.gz obj.gz off stl ply obj; do
		[ -e "$meshes/$1.$extension" ] && echo "$meshes/$1.$extension" && return
	done
}
# no_bad_file NAME: whatever is in out is whole: PLY that a program reads, streams that check
no_bad_file() {
	for made in "out/$1".*.ply; do
		[ ! -e "$made" ] || "$BIN/render" --size 16x16 "$made" > picture 2> errors || return 1
	done
	[ ! -e "out/$1.ffx" ] || "$BIN/unpack" --check "out/$1.ffx" 2> errors
}

file=$(find_part fandisk)
if [ -n "$file" ]; then
	patch IN="$file" OUT=out FACEFIX=-v > log 2>&1
	ok $? 'fandisk is packed'
	report=out/fandisk.report
	at_most "$(value sym_mean_side $report)" 0.000887 'fandisk: mean error'
	at_most "$(value sym_max_side $report)" 0.01018 'fandisk: largest error'
	is '0 0' "$(value b_open_edges $report) $(value b_nonmanifold_edges $report)" 'fandisk: watertight'
	is 2 "$(awk -F= '$1 == "b_vertices" {v = $2} $1 == "b_triangles" {f = $2} END {print v - f / 2}' $report)" 'fandisk: a sphere in topology'
	at_most "$(wc -c < out/fandisk.ffx)" 380 'fandisk: bytes in all'
	at_most "$(sed -n 's/.*bytes_c=\([0-9.]*\) bytes_g=\([0-9.]*\) bytes_f=\([0-9.]*\).*/\1 \2 \3/p' log | awk '{print $1 + $2 + $3}')" 350 'fandisk: bytes of connectivity, geometry and flags'
	rm -rf out
else
	skip fandisk 'not in the folder'
fi

for name in anchor anchor_dense joint couplingdown handle part pinion pipe spool dragknob block casting upright shape sh1 occt_piston occt_pump_nut \
	occt_engine_block m3_hex_nut round_ring plate_holes torus_cad gmsh_lever; do
	file=$(find_part $name)
	if [ -z "$file" ]; then
		skip "$name" 'not in the folder'
		continue
	fi
	timeout 120 make -f "$ROOT/pipelines/patch.mk" BIN="$BIN/" IN="$file" OUT=out > log 2>&1
	status=$?
	ok $status "$name is packed"
	if [ $status -ne 0 ]; then
		tail -n 2 log | sed 's/^/# /'
	else
		report=out/$name.report
		is '0 0' "$(value b_open_edges "$report") $(value b_nonmanifold_edges "$report")" "$name: watertight"
		at_most "$(value sym_mean_side "$report")" 0.002 "$name: mean error"
	fi
	rm -rf out
done

# Every damaged or strange file: a result, or a documented exit code with one message; no crash, no hang, no bad file.
if [ -d "$nasty" ]; then
	for file in "$nasty"/*; do
		name=$(basename "$file" .gz)
		name=${name%.*}
		case $file in
		*.off.gz | *.stl.gz | *.obj.gz | *.ply.gz) ;;
		*) continue ;;
		esac
		rm -rf out
		mkdir out
		stage=curv
		timeout 60 "$BIN/curv" "$file" -o "out/$name.curv.ply" 2> log
		status=$?
		if [ $status -eq 0 ]; then
			stage=segment
			timeout 60 "$BIN/segment" "out/$name.curv.ply" -o "out/$name.segment.ply" 2> log
			status=$?
		fi
		if [ $status -eq 0 ]; then
			stage=rectify
			timeout 60 "$BIN/rectify" "out/$name.segment.ply" -o "out/$name.rectify.ply" 2> log
			status=$?
		fi
		case $status in
		0) ok 0 "$name: passes the first stages" ;;
		3 | 4) [ "$(grep -vc ' warning: ' log)" -eq 1 ] && grep -q "^$stage: " log && no_bad_file "$name"
			ok $? "$name: refused: $(tail -n 1 log | sed "s#$DATA/##" | cut -c 1-120)" ;;
		*) ok 1 "$name: $stage ends with $status" ;;
		esac
		timeout 60 "$BIN/unpack" "$file" -o out/garbage.ply 2> log
		is '3 absent' "$? $([ -e out/garbage.ply ] && echo present || echo absent)" "$name: is no stream for unpack"
	done
else
	skip 'strange files' 'no folder of them'
fi
plan
