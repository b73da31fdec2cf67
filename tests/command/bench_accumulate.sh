#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# bench_accumulate.sh WEFT [FRAMES [PIXELS [RUNS]]]: weft accumulate over many names, links to eight
# files of noise (RGBA half, packed as zip, made by oiiotool), with 32 descriptors at most:
#   alone      seconds, frames a second, and the peak of memory of all processes
#   --resume   likewise, and how often the state was saved, its seconds and bytes
#   killed     by SIGKILL after a quarter, half and three quarters of that, and started again:
#              seconds of all runs together; the bytes must be those of the run alone
# Default: 5,000 frames of 1024^2, one run. Memory is the largest sum of PSS (what processes share
# counts once), looked at every 50 ms. Exit code: 0, 1 (a run failed, other bytes, a process or a
# file that was left), 2 (usage).
set -u
[ $# -ge 1 ] && [ -x "$1" ] || { sed -n 's/^# //p' "$0" | sed -n 2,3p >&2; exit 2; }
weft=$(realpath "$1") frames=${2:-5000} pixels=${3:-1024} runs=${4:-1}
command -v oiiotool >/dev/null || { echo "oiiotool makes the frames: it is missing" >&2; exit 2; }
tmp=$(mktemp -d "${TMPDIR:-/var/tmp}/weft_accumulate.XXXXXX")
trap 'rm -rf "$tmp"' EXIT
cd "$tmp" || exit 1
ulimit -n 32
files=8 last=$((frames - 1)) failed=0

for ((i = 0; i < files; i++)); do
    oiiotool --pattern constant:color=0.3,0.4,0.5,1 "${pixels}x$pixels" 4 \
        --noise:type=uniform:min=-0.25:max=0.25:mono=0:seed="$i" --ch R,G,B,A=1 \
        -d half --compression zip -o "n$i.exr" || exit 1
done
for ((i = 0; i <= last; i++)); do
    ln -s "n$((i % files)).exr" "$(printf 'f%06d.exr' "$i")"
done

fail() { echo "FAILED: $*"; failed=1; }

# Starts weft in a session of its own: `pid`.
start() { # OUTPUT [OPTION...]
    began=$(date +%s.%N)
    setsid "$weft" accumulate f%06d.exr -o "$@" --json >report.json 2>log &
    pid=$!
}
since() { echo "$(date +%s.%N) $1" | awk '{ printf "%.2f", $1 - $2 }'; }

# Waits for it, or kills it after some seconds: `seconds`, and the `peak` in MB so far.
finish() { # [SECONDS]
    local sum when=${1:-}
    while kill -0 "$pid" 2>/dev/null; do
        sum=$(cat $(pgrep -s "$pid" | sed 's|.*|/proc/&/smaps_rollup|') 2>/dev/null |
            awk '/^Pss:/ { s += $2 } END { print int(s / 1000) }')
        [ "${sum:-0}" -gt "$peak" ] && peak=$sum
        if [ -n "$when" ] && awk "BEGIN { exit !($(since "$began") >= $when) }"; then
            kill -9 "$pid"
            break
        fi
        sleep 0.05
    done
    { wait "$pid"; } 2>/dev/null
    code=$?
    seconds=$(since "$began")
}

# Processes of the session that still run; dead ones wait for init.
left() { ps -o stat= -s "$pid" | grep -v -c '^Z'; }

figure() { sed -n "s/^ *\"$1\": \([0-9.e+-]*\),*$/\1/p" report.json | tail -1; }

rate() { awk "BEGIN { printf \"%.1f\", $frames / $1 }"; }

for ((run = 1; run <= runs; run++)); do
    peak=0
    start alone.exr
    finish
    [ "$code" -eq 0 ] || fail "alone: code $code, $(cat log)"
    alone=$seconds
    echo "alone:    $seconds s, $(rate "$seconds") frames/s, peak $peak MB"

    peak=0
    rm -f s.state
    start kept.exr --resume s.state
    finish
    [ "$code" -eq 0 ] || fail "--resume: code $code, $(cat log)"
    cmp alone.exr kept.exr || fail "--resume: other bytes"
    # The state's part of the report: its own seconds are the last ones before the preview.
    sed -n '/"state": {/,/}/p' report.json >state.json && mv state.json report.json
    echo "--resume: $seconds s, $(rate "$seconds") frames/s, peak $peak MB," \
        "saved $(figure saves) times in $(figure total) s, $(figure bytes) bytes," \
        "$(awk "BEGIN { printf \"%+.1f\", 100 * ($seconds / $alone - 1) }") %"

    peak=0
    rm -f s.state kept.exr
    whole=$(date +%s.%N)
    for share in 0.25 0.25 0.25; do
        start kept.exr --resume s.state
        finish "$(awk "BEGIN { print $share * $alone }")"
        [ "$code" -eq 137 ] || fail "it ended with code $code before it was killed, $(cat log)"
        [ "$(left)" -eq 0 ] || sleep 1
        [ "$(left)" -eq 0 ] || fail "processes are left"
        [ ! -e kept.exr ] || fail "an output is there"
    done
    start kept.exr --resume s.state
    finish
    [ "$code" -eq 0 ] || fail "killed: code $code, $(cat log)"
    cmp alone.exr kept.exr || fail "killed: other bytes"
    sed -n '/"state": {/,/}/p' report.json >state.json && mv state.json report.json
    echo "killed three times: $(since "$whole") s in all, peak $peak MB," \
        "the last run went on from frame $(figure resumed)"
    [ -z "$(find . -name '.?*')" ] || fail "files are left: $(find . -name '.?*')"
    rm -f s.state kept.exr
done
exit "$failed"
