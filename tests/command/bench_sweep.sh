#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# bench_sweep.sh WEFT [FRAMES [PIXELS [VOLUME.vdb]]]: a sweep of slices in one process against a
# process for each slice, across an axis and oblique, through a volume and the sphere of 2048^3 (made
# beside it, 200 MB). Prints seconds per slice, the share of each stage, and the largest peak of
# memory. In one process writing overlaps the rest: shares are of the stages' sum.
set -eu
weft=$1 frames=${2:-100} pixels=${3:-1024}
volume=${4:-$(dirname "$0")/../../../shared/data/mri.vdb}
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
last=$((frames - 1))

# The figures of one or more JSON reports: of each, the last of a name is the sum.
figures() { # NAME WAY WALL
    awk -v name="$1" -v way="$2" -v wall="$3" -v frames="$frames" '
        function take() { for (key in now) sum[key] += now[key]; delete now }
        FNR == 1 { take() }
        /"(open|plan|context|read|layout|upload|passes|readback|write)": [0-9.e-]+,?$/ {
            gsub(/[",:]/, ""); now[$1] = $2 }
        /"process_peak"/ { gsub(/,/, ""); if ($2 > peak) peak = $2 }
        END { take(); for (key in sum) all += sum[key]
              printf "%-14s %-13s %8.4f s", name, way, wall / frames
              count = split("open plan context read layout upload passes readback write", keys, " ")
              for (i = 1; i <= count; i++) printf " %s %.0f %%", keys[i], 100 * sum[keys[i]] / all
              printf ", peak %.0f MB\n", peak / 1e6 }' "$tmp"/*.json
    rm -f "$tmp"/*.json "$tmp"/*.exr
}

now() { date +%s.%N; }
since() { echo "$(now) $1" | awk '{ print $1 - $2 }'; }

# The plane of frame f is at `lowest` + f * `step` along z, in voxels: across it, or oblique.
sweep() { # NAME VOLUME WIDTH HEIGHT TILT LOWEST STEP
    name=$1 file=$2
    plane="--space index --size ${pixels}x$pixels --u $3,0,$5 --v 0,$4,0"
    start=$(now)
    "$weft" slice "$file" $plane --origin "0,0,$6" --step "0,0,$7" --frames "0-$last" \
        -o "$tmp/a%04d.exr" --json >"$tmp/all.json"
    figures "$name" "one process" "$(since "$start")"
    start=$(now)
    f=0
    while [ $f -lt "$frames" ]; do
        z=$(echo "$6 $7 $f" | awk '{ printf "%.9g", $1 + $3 * $2 }')
        "$weft" slice "$file" $plane --origin "0,0,$z" -o "$tmp/a$f.exr" --json >"$tmp/$f.json"
        f=$((f + 1))
    done
    figures "$name" "$frames processes" "$(since "$start")"
}

if [ -f "$volume" ]; then
    sweep "axis" "$volume" 200 250 0 10 "$(echo "$frames" | awk '{ print 190 / $1 }')"
    sweep "oblique" "$volume" 200 250 40 5 "$(echo "$frames" | awk '{ print 160 / $1 }')"
else
    echo "$volume is not here: left out"
fi
"$weft" make sphere --size 2048 --voxel 0.01 -o "$tmp/sphere.vdb" -q
sweep "sphere" "$tmp/sphere.vdb" 2048 2048 0 300 "$(echo "$frames" | awk '{ print 1400 / $1 }')"
sweep "sphere oblique" "$tmp/sphere.vdb" 2048 2048 300 300 "$(echo "$frames" | awk '{ print 1200 / $1 }')"
