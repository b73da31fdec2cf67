#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# bench_accumulate_peers.sh BUILD [FRAMES [PIXELS [RUNS [TURN...]]]]: the average of the same frames by
# weft accumulate (of BUILD) and by what Debian's packages imagemagick, ffmpeg, libvips-tools and
# openimageio-tools bring, in turns. Default: 300 frames of 1024^2, 3 runs. Frames are noise that
# oiiotool makes: 30 different ones, the other names are links to them; RGBA half EXR as zip packs
# it, and the same as RGB PNG of 8 bits. What is not installed is left out.
# Prints for each, from files to a file: the median of seconds, and of processor time the mean; peak memory in MB, the largest sum
# of PSS (shared pages count once) of all its processes, looked at every 50 ms, so a little low; and
# the largest and the mean error against the exact mean (of PNG files: of their codes / 255), in
# units of 1/255.
#   ImageMagick  -evaluate-sequence mean, 16-bit integers, result as PNG of 16 bits
#   FFmpeg       tmix on 16-bit planes, at most 1,024 frames, result as PNG of 16 bits
#   vips         sum, and linear by 1/N, result as TIFF of floats
#   oiiotool     --add of one frame after the other, --divc, result as EXR of floats
# TURN: only these (weft magick ffmpeg vips oiio). Exit code: 0, 1 (weft failed), 2 (usage).
set -u
[ $# -ge 1 ] && [ -x "$1/weft" ] || { sed -n 's/^# //p' "$0" | sed -n 2,4p >&2; exit 2; }
build=$(realpath "$1") frames=${2:-300} pixels=${3:-1024} runs=${4:-3}
[ $# -le 4 ] && turns="weft magick ffmpeg vips oiio" || turns=${*:5}
different=30
export WEFT_LIBEXEC=$build
tmp=$(mktemp -d "${TMPDIR:-/var/tmp}/weft_peers.XXXXXX")
trap 'rm -rf "$tmp"' EXIT
cd "$tmp" || exit 1
# Debian's limits, of 256 MB of memory and 1 GB of disk, are not what is measured.
mkdir policy
cat >policy/policy.xml <<END
<policymap>
  <policy domain="resource" name="memory" value="1TiB"/>
  <policy domain="resource" name="map" value="1TiB"/>
  <policy domain="resource" name="area" value="1TP"/>
</policymap>
END
export MAGICK_CONFIGURE_PATH=$tmp/policy
magick=$(command -v convert-im6.q16 || command -v magick || true)

make_frames() {
    local i
    for ((i = 0; i < frames; i++)); do
        local name
        name=$(printf 'f%04d' "$i")
        if [ "$i" -lt "$different" ]; then
            oiiotool --pattern constant:color=0.3,0.4,0.5,1 "${pixels}x$pixels" 4 \
                --noise:type=uniform:min=-0.25:max=0.25:mono=0:seed="$i" --ch R,G,B,A=1 \
                -d half --compression zip -o "$name.exr" || exit 1
            oiiotool "$name.exr" --ch R,G,B -d uint8 --attrib oiio:ColorSpace sRGB -o "$name.png" || exit 1
        else
            ln "$(printf 'f%04d' $((i % different))).exr" "$name.exr"
            ln "$(printf 'f%04d' $((i % different))).png" "$name.png"
        fi
    done
}

# ---- one run --------------------------------------------------------------------------------------

# Runs a command in a session of its own; sets seconds, cpu (seconds) and peak (MB).
watch() {
    local start now pid sum
    peak=0
    start=$(date +%s.%N)
    setsid bash -c '"$@"; code=$?; times >cpu; exit $code' - "$@" >log 2>&1 &
    pid=$!
    while kill -0 "$pid" 2>/dev/null; do
        sum=$(cat $(pgrep -s "$pid" | sed 's|.*|/proc/&/smaps_rollup|') 2>/dev/null |
            awk '/^Pss:/ { s += $2 } END { print int(s / 1000) }')
        [ "${sum:-0}" -gt "$peak" ] && peak=$sum
        sleep 0.05
    done
    wait "$pid"
    code=$?
    now=$(date +%s.%N)
    seconds=$(echo "$now $start" | awk '{ print $1 - $2 }')
    cpu=$(sed -n 2p cpu | awk -F'[ms ]+' '{ print 60 * ($1 + $3) + $2 + $4 }')
    return $code
}

# Commands of a peer: KIND is exr or png; the result is out.exr at the end, untimed where converted.
run_weft() {
    local how=
    [ "$1" = exr ] || how="--transfer linear"
    watch "$build/weft" accumulate $(eval echo f*."$1") --type float $how -o out.exr
}
run_magick() {
    watch "$magick" -limit memory 1TiB -limit map 1TiB -limit area 1TP f*."$1" -evaluate-sequence mean \
        -depth 16 out.png && oiiotool out.png -d float -o out.exr
}
run_ffmpeg() {
    watch ffmpeg -v error -y -i "f%04d.$1" -vf "format=gbrap16,tmix=frames=$frames,select=eq(n\,$((frames - 1)))" \
        -fps_mode passthrough -frames:v 1 -pix_fmt rgba64be out.png &&
        oiiotool out.png -d float -o out.exr
}
# Its alpha is from 0 to 255, of EXR files too.
run_vips() {
    local one code
    one=$(awk "BEGIN { printf \"%.17g\", 1 / $frames }")
    code=$(awk "BEGIN { printf \"%.17g\", 1 / ($frames * 255) }")
    [ "$1" = exr ] && code="$one $one $one $code"
    watch sh -c "vips sum '$(echo f*."$1")' sum.v && vips linear sum.v out.tif '$code' 0" &&
        oiiotool out.tif -d float -o out.exr
}
run_oiio() {
    local list=() i
    for i in f*."$1"; do
        list+=("$i")
        [ ${#list[@]} -gt 1 ] && list+=(--add)
    done
    watch oiiotool "${list[@]}" --divc "$frames" -d float -o out.exr
}

there() {
    case $1 in
    weft) true ;;
    magick) [ -n "$magick" ] ;;
    oiio) command -v oiiotool >/dev/null ;;
    *) command -v "$1" >/dev/null ;;
    esac
}

# ---- turns ----------------------------------------------------------------------------------------

command -v oiiotool >/dev/null || { echo "oiiotool, which makes the frames, is not here" >&2; exit 2; }
make_frames
failed=0
for kind in exr png; do
    cat f*."$kind" >/dev/null # warm
    rm -f times.*
    for ((run = 0; run < runs; run++)); do
        for peer in $turns; do
            there "$peer" || { [ "$run" -gt 0 ] || echo "$kind $peer: not installed"; continue; }
            [ -f "times.$peer.failed" ] && continue
            rm -f out.*
            if "run_$peer" "$kind"; then
                echo "$seconds $cpu $peak" >>"times.$peer"
                [ "$run" -gt 0 ] || mv out.exr "result.$peer.exr"
            else
                echo "$kind $peer: failed: $(head -c 300 log)"
                : >"times.$peer.failed"
                [ "$peer" = weft ] && failed=1
            fi
        done
    done
    printf '%s, %d frames of %dx%d, %d runs\n%-8s %8s %8s %8s %12s %12s\n' "$kind" "$frames" "$pixels" \
        "$pixels" "$runs" "" seconds cpu "peak MB" "max error" "mean error"
    for peer in $turns; do
        [ -f "times.$peer" ] && [ -f "result.$peer.exr" ] || continue
        errors=$("$build/mean_error" "result.$peer.exr" -- f*."$kind" | awk '{ print 255 * $2, 255 * $3 }')
        sort -g "times.$peer" | awk -v peer="$peer" -v errors="$errors" '
            { s[NR] = $1; c += $2; if ($3 > m) m = $3 }
            END { split(errors, e, " "); printf "%-8s %8.2f %8.2f %8d %12.3g %12.3g\n", peer,
                  (s[int((NR + 1) / 2)] + s[int((NR + 2) / 2)]) / 2, c / NR, m, e[1], e[2] }'
    done
    rm -f result.*
done
exit $failed
