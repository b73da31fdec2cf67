#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# bench_efficiency.sh BUILD [CASE...]: what a second rank is worth: 2 ranks of 1 thread against 1
# process on 1 processor, and against 1 process with 2 threads on 2 processors, with each launcher
# that is there. Ways in turns, medians of RUNS (5) turns.
# CASE: picture   antialias of polygons:4000,50, 512x512, 4 x 4 samples
#       pictures  50 of them, as frames
#       slice     4096x4096 through the sphere of 512^3 voxels
#       slices    300 of 512x512 of it, as frames
#       mean      accumulate of 300 frames, 512x512
#       effect    antialias of 300 frames of polygons:4000,50, 512x512
#       resample  512x512 to 4096x4096
# Prints for each, in seconds: end to end 1 x 1, 1 x 2 (processes x threads) and 2 x 1; start-up of
# the launcher and MPI, which is what the same work of 16x16 pixels takes longer under it than
# alone; and 1x1 / (2 2x1), the efficiency, of the whole and without start-up, and 1x2 / 2x1; whether
# outputs are the same bytes.
# Environment: RUNS; LAUNCHERS (openmpi mpich); CPUS, two processors (0,1); OPTIONS, of weft on ranks,
# as "--schedule static". Exit code: 0, 1 (a command failed, or bytes differ), 2 (usage).
set -u
[ $# -ge 1 ] && [ -x "$1/weft" ] || { sed -n 's/^# //p' "$0" | sed -n 2p >&2; exit 2; }
weft=$(realpath "$1")/weft
shift
[ $# -gt 0 ] || set -- picture pictures slice slices mean effect resample
runs=${RUNS:-5} cpus=${CPUS:-0,1} options=${OPTIONS:-}
tmp=$(mktemp -d "${TMPDIR:-/var/tmp}/weft_ranks.XXXXXX")
trap 'rm -rf "$tmp"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
failed=0

# ---- what is done ---------------------------------------------------------------------------------

make_inputs() { # CASE
    case $1 in
    slice | slices) [ -f "$tmp/s.vdb" ] || "$weft" make sphere --size 512 -q -o "$tmp/s.vdb" ;;
    resample) "$weft" antialias none -q --scene polygons:4000,50 -o "$tmp/large.exr" &&
        "$weft" antialias none -q --scene polygons:4000,50 --size 16x16 -o "$tmp/small.exr" ;;
    mean)
        mkdir -p "$tmp/large" "$tmp/small"
        for size in large:512x512 small:16x16; do
            "$weft" antialias none -q --scene polygons:400,50 --size "${size#*:}" --frames 30 \
                -o "$tmp/${size%:*}/f0%02d.exr"
            for ((i = 30; i < 300; i++)); do
                ln -f "$(printf "$tmp/${size%:*}/f%03d.exr" $((i % 30)))" \
                    "$(printf "$tmp/${size%:*}/f%03d.exr" $i)"
            done
        done ;;
    esac
}

# Sets `work`: the words of a verb. SIZE: large or small.
set_work() { # CASE SIZE
    local side=512 wide=4096 frames=50 many=300
    [ "$2" = large ] || side=16 wide=16 frames=2 many=2
    case $1 in
    picture) work=(antialias supersample --scene polygons:4000,50 --samples 16 --size "${side}x$side") ;;
    pictures) work=(antialias supersample --scene polygons:4000,50 --samples 16 --size "${side}x$side"
        --frames $frames) ;;
    slice) work=(slice "$tmp/s.vdb" --size "${wide}x$wide") ;;
    slices) work=(slice "$tmp/s.vdb" --size "${side}x$side" --space index --axis z --at 100..400
        --frames "0-$((many - 1))") ;;
    mean) work=(accumulate) && mapfile -t -O 1 work < <(ls "$tmp/$2"/f*.exr | head -n $many) ;;
    effect) work=(effect antialias --scene polygons:4000,50 --frames $many --size "${side}x$side") ;;
    resample) work=(resample "$tmp/$2.exr" --size "${wide}x$wide") ;;
    *) echo "no case '$1'" >&2; exit 2 ;;
    esac
}

output_of() { # CASE WAY
    mkdir -p "$tmp/out.$2"
    case $1 in
    pictures | slices) echo "$tmp/out.$2/%03d.exr" ;;
    *) echo "$tmp/out.$2/whole.exr" ;;
    esac
}

# ---- ways -----------------------------------------------------------------------------------------

run_way() { # WAY WORDS...
    local way=$1
    shift
    case $way in
    1x1) taskset -c "${cpus%,*}" "$weft" "$@" ;;
    1x2) taskset -c "$cpus" "$weft" "$@" ;;
    openmpi) taskset -c "$cpus" mpirun.openmpi -q --oversubscribe --bind-to none -n 2 "$weft" "$@" $options ;;
    mpich) taskset -c "$cpus" mpirun.mpich -n 2 "$weft" "$@" $options ;;
    esac
}

once() { # CASE SIZE WAY
    local start end
    set_work "$1" "$2"
    start=$(date +%s.%N)
    run_way "$3" "${work[@]}" -q -o "$(output_of "$1" "$3")" >"$tmp/log" 2>&1 || {
        echo "$1, $2, $3: exit code $?: $(head -c 300 "$tmp/log")"
        failed=1
        return 1
    }
    end=$(date +%s.%N)
    echo "$start $end" | awk '{ print $2 - $1 }' >>"$tmp/time.$1.$2.$3"
}

median() { sort -g "$1" | awk '{ v[NR] = $1 } END { print (v[int((NR + 1) / 2)] + v[int((NR + 2) / 2)]) / 2 }'; }

measure() { # CASE
    local way size ok=1
    make_inputs "$1" || return
    for ((run = 0; run < runs; run++)); do
        for way in 1x1 1x2 $launchers; do
            for size in small large; do once "$1" $size $way || ok=0; done
        done
    done
    [ $ok = 1 ] || return
    for way in $launchers; do
        local same="same bytes"
        diff -r "$tmp/out.1x1" "$tmp/out.$way" >/dev/null || { same="OTHER BYTES"; failed=1; }
        echo "$1 $way $(median "$tmp/time.$1.large.1x1") $(median "$tmp/time.$1.large.1x2")" \
            "$(median "$tmp/time.$1.large.$way") $(median "$tmp/time.$1.small.1x2")" \
            "$(median "$tmp/time.$1.small.$way") $same" | awk '{
            start = $7 - $6
            printf "%-9s %-8s %8.3f %8.3f %8.3f %8.3f   %5.2f %5.2f   %5.2f  %s %s\n", $1, $2, $3, $4, $5,
                start, $3 / (2 * $5), $3 / (2 * ($5 - start)), $4 / $5, $8, $9 }'
    done
    rm -rf "$tmp"/out.*
}

launchers=
for name in ${LAUNCHERS:-openmpi mpich}; do
    command -v "mpirun.$name" >/dev/null && launchers="$launchers $name" ||
        echo "mpirun.$name is not here: left out"
done
printf '%-9s %-8s %8s %8s %8s %8s   %5s %5s   %5s\n' "" "" "1 x 1" "1 x 2" "2 x 1" start-up all less "2 thr."
for name; do measure "$name"; done
exit $failed
