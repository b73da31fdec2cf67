#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# sh tools/figures.sh [--build DIR] [--out DIR] [--data DIR] [--list] [NAME...]: makes the pictures of
# docs/ again, all of them or those named, with the programs in --build (default build/release), into
# --out (default docs). --data is a folder of volumes and meshes that are not in the repository; figures
# that need some of it are left out, with a line, where it is not there. Needs gnuplot, and python3 for
# the page of kernels; pngquant, where it is installed, makes files smaller. Names that stand for
# several: drawn (those that are the same on every machine, up to its OpenGL) and measured (charts of
# times: on an idle machine). Exit code: 0, 1 (a figure failed), 2 (usage).
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build/release out=$root/docs data=

# NAME KIND FILES; the commands of each stand in figure_NAME below.
figures='
kernels-side-by-side drawn    kernels-side-by-side.png
kernel-page          drawn    kernels.md kernels-*.png
coordinates          drawn    coordinates.svg
slice                drawn    slice.png
slices-up            drawn    slices-up.png
resample             drawn    resample.png
lattice              drawn    lattice.png
derivatives          drawn    derivatives.png
quantities           drawn    quantities.png
accumulate           drawn    accumulate.png
pictures             drawn    pictures.png
table                drawn    table.png
orders               drawn    orders.png
effects              drawn    effect_fade.png effect_motion_blur.png effect_antialias.png effect_dof.png effect_soft_shadow.png effect_radiosity.png
effect-convergence   drawn    effect_convergence.png
accumulation-cube    drawn    accumulation-cube.png
antialias-coincident drawn    antialias-none.png antialias-weights.png antialias-stencil.png
antialias-crops      drawn    antialias-crops.png
chart                measured chart.png chart-truth.png
accumulation-chart   measured accumulation-chart.png
antialias-chart      measured antialias-chart.png
ranks-load           measured ranks-load.png
'

weft() { "$build/weft" "$@"; }
# Pictures side by side. Dithering would be taken for noise where colours are the subject.
panels() {
    panels_whole "$@"
    squeeze "$1"
}
panels_whole() { sh "$root/tools/figures/panels.sh" "$@"; }
# 256 colours are enough for most pictures.
squeeze() {
    ! command -v pngquant >/dev/null || pngquant --skip-if-larger --quality 70-97 --force --output "$1" "$1" || [ $? -ge 98 ]
}

figure_kernels_side_by_side() {
    "$root/tests/peers/figures/figure_kernels.sh" "$build" "$out/kernels-side-by-side.png" >/dev/null
    squeeze "$out/kernels-side-by-side.png"
}

figure_kernel_page() {
    python3 "$root/tools/figures/kernel_page.py" "$build/weft" "$out"
    for picture in "$out"/kernels-*.png; do
        [ "$picture" = "$out/kernels-side-by-side.png" ] || squeeze "$picture"
    done
}

figure_coordinates() {
    sh "$root/tools/figures/coordinates.sh" "$out/coordinates.svg"
}

# Across an axis and obliquely.
figure_slice() {
    weft make marschner-lobb -o ml.vdb --size 128 -q
    set -- --space index --size 288x288 --colour-map viridis -q
    weft slice ml.vdb "$@" --origin 10,10,63.5 --u 108,0,0 --v 0,108,0 --preview z.png
    weft slice ml.vdb "$@" --origin 63.5,10,10 --u 0,108,0 --v 0,0,108 --preview x.png
    weft slice ml.vdb "$@" --origin 12,10,46 --u 102,0,36 --v 0,108,0 --preview oblique.png
    panels "$out/slice.png" 3 '--axis z=z.png' '--axis x=x.png' '--origin --u --v=oblique.png'
}

# A letter from its side and from above, whose world has z up.
figure_slices_up() {
    python3 "$root/tools/figures/letter.py" letter.raw
    weft convert letter.raw letter.vdb --raw 28x28x28:uint8 --background 0 -q
    set -- letter.vdb --size 220x0 --colour-map cividis --range 0,255 -q
    weft slice "$@" --axis x --preview plain.png
    weft slice "$@" --axis x --up z --preview up.png
    weft slice "$@" --axis x --up z --flip x --preview flip.png
    weft slice "$@" --axis z --at 92% --up y --preview across.png
    panels "$out/slices-up.png" 4 '--axis x=plain.png' '--axis x --up z=up.png' \
        '--axis x --up z --flip x=flip.png' '--axis z --up y=across.png'
}

# A picture of 48 x 48 pixels, 4 times as large.
figure_resample() {
    weft effect antialias --scene polygons:40,90 --seed 5 --size 48x48 --frames 64 -o small.exr --preview small.png -q
    set --
    for kernel in nearest linear mitchell catmull-rom lanczos:3; do
        file=large-${kernel%:*}.png
        weft resample small.png -o "$file" --size x4 --kernel "$kernel" -q
        set -- "$@" "$kernel=$file"
    done
    panels "$out/resample.png" 5 "$@"
}

# Voxels as they lie on lattices, looked up by nearest. The last is turned about the middle.
figure_lattice() {
    weft make marschner-lobb -o source.vdb --size 24 -q
    weft lattice source.vdb --scale 4 --kernel bspline3i -o fine.vdb -q
    weft lattice source.vdb --scale 4 --kernel bspline3i -o turned.vdb -q \
        --matrix 0.866025,-0.5,0,7.290713,0.5,0.866025,0,-4.209288,0,0,1,0
    for volume in source fine turned; do
        weft slice $volume.vdb --kernel nearest --origin -0.5,-0.5,11.5 --u 24,0,0 --v 0,24,0 \
            --size 288x288 --range 0.15,0.7 --colour-map viridis --preview $volume.png -q
    done
    panels "$out/lattice.png" 3 '24^3 voxels=source.png' '--scale 4=fine.png' '--scale 4 --matrix=turned.png'
}

figure_derivatives() {
    weft make marschner-lobb -o ml.vdb --size 64 -q
    set -- --space index --origin 6,6,31.5 --u 52,0,0 --v 0,52,0 --size 192x192 --kernel bspline3i
    weft slice ml.vdb "$@" --preview value.png -q
    weft slice ml.vdb "$@" --quantity normal --preview normal.png -q
    weft slice ml.vdb "$@" --quantity laplacian --colour-map cool-warm --preview laplacian.png -q
    panels_whole "$out/derivatives.png" 3 'value=value.png' 'normal=normal.png' 'laplacian=laplacian.png'
}

# As they come: --annotate has its own titles.
figure_pictures() {
    weft make marschner-lobb -o marschner-lobb.vdb --size 40 -q
    set -- marschner-lobb.vdb --origin 3,3,19.5 --u 33,0,0 --v 0,33,0 --size 300x300 -q
    weft slice "$@" --annotate --colour-map viridis --preview left.png
    weft slice "$@" --verify --profile unorm8 --kernel bspline --error-image right.png >/dev/null
    panels "$out/pictures.png" 2 'weft slice --annotate=left.png' '--verify --error-image, 8-bit passes=right.png'
}

figure_quantities() {
    needs mri.vdb || return 0
    set -- "$data/mri.vdb" --axis x --up z --size 280x280 -q
    weft slice "$@" --preview value.png
    weft slice "$@" --quantity normal --preview normal.png
    weft slice "$@" --quantity mean-curvature --range -0.5,0.5 --colour-map cool-warm --preview curvature.png
    weft slice "$@" --slab 40 --combine max --preview slab.png
    panels_whole "$out/quantities.png" 4 'value=value.png' 'normal=normal.png' 'mean-curvature=curvature.png' \
        '--slab 40 --combine max=slab.png'
}

# Depth of field by more and more frames.
figure_accumulate() {
    set --
    for frames in 1 4 16 64; do
        weft effect dof+antialias --frames $frames --size 224x224 --preview frames-$frames.png -q
        set -- "$@" "--frames $frames=frames-$frames.png"
    done
    panels "$out/accumulate.png" 4 "$@"
}

figure_table() {
    weft table --dims 2 --plot "$out/table.png" -o table.txt -q
}

# Passes on 8 bits in two orders. The errors are sums of the slices with the weights 8 and -8, and 1 for
# a slice that is 1 everywhere: 1 + 8 (slice - exact).
figure_orders() {
    weft make marschner-lobb -o ml.vdb --size 40 -q
    weft make constant -o one.vdb --size 40 -q
    set -- --space index --origin 4,4,19.5 --u 31,0,0 --v 0,31,0 --size 176x176 -q
    weft slice ml.vdb "$@" -o exact.exr --range 0,0.65 --preview exact.png
    weft slice one.vdb "$@" -o one.exr
    printf '8\n-8\n1\n' >weights
    for order in planned natural; do
        weft slice ml.vdb "$@" --profile unorm8,taps=1 --order $order -o $order.exr --range 0,0.65 \
            --preview $order.png
        weft accumulate $order.exr exact.exr one.exr --weights weights --range 0.4,1.6 \
            --colour-map cool-warm -o error.exr --preview error-$order.png -q
    done
    panels_whole "$out/orders.png" 5 'exact|single precision=exact.png' 'planned order|8 bits=planned.png' \
        'its error|full colour: 0.075=error-planned.png' 'order of the taps|8 bits=natural.png' \
        'its error|full colour: 0.075=error-natural.png'
}

# ---- effects and anti-aliasing -------------------------------------------------------------------

figure_effects() {
    weft effect fade --fade 0.5 --size 256x256 --preview "$out/effect_fade.png" -q
    weft effect motion-blur+antialias --size 256x256 --preview "$out/effect_motion_blur.png" -q
    weft effect antialias --scene polygons:150,600 --size 192x192 --frames 66 --preview "$out/effect_antialias.png" -q
    weft effect dof+antialias --size 256x256 --preview "$out/effect_dof.png" -q
    weft effect soft-shadow+antialias --frames 64 --size 256x256 --preview "$out/effect_soft_shadow.png" -q
    weft effect radiosity+antialias --frames 1024 --size 256x256 --preview "$out/effect_radiosity.png" -q
}

figure_effect_convergence() {
    "$root/tests/peers/figures/figure_effect.sh" "$build" "$out/effect_convergence.png" >/dev/null
}

figure_accumulation_cube() {
    "$root/tests/peers/figures/figure_accumulate.sh" "$build" "$out/accumulation-cube.png" >/dev/null
}

# Two quadrilaterals in one plane.
figure_antialias_coincident() {
    cat >double.obj <<'END'
v -1 -0.7 0 0.9 0.25 0.1
v 0.6 -1 0 0.9 0.25 0.1
v 0.4 0.6 0 0.9 0.25 0.1
v -0.8 0.5 0 0.9 0.25 0.1
v -0.5 -0.4 0 0.1 0.35 0.8
v 1 -0.6 0 0.1 0.35 0.8
v 0.9 0.9 0 0.1 0.35 0.8
v -0.4 1 0 0.1 0.35 0.8
f 1 2 3 4
f 5 6 7 8
END
    set -- acaa --scene double.obj --eye 0,0,3.4 --target 0,0,0 --size 112x112 -q
    weft antialias "$@" --coincident none --allow-weight --preview "$out/antialias-none.png" \
        --weight-map "$out/antialias-weights.png"
    weft antialias "$@" --preview "$out/antialias-stencil.png"
}

# Spot: Keenan Crane, CC0.
figure_antialias_crops() {
    needs mesh/spot.obj || return 0
    command -v povray >/dev/null || { left_out "no povray to stand beside"; return 0; }
    "$root/tests/peers/antialias/figure_antialias.sh" "$build" "$out/antialias-crops.png" \
        --scene "$data/mesh/spot.obj" --size 512x512 --crop 296,66,32x32 >/dev/null
}

# ---- measured ------------------------------------------------------------------------------------

figure_chart() {
    "$build/bench_peers" marschner-lobb:128 --csv all.csv >/dev/null
    grep -v '^weft,' all.csv >peers.csv # those of weft the chart measures itself
    weft chart marschner-lobb --size 1024x1024 --points peers.csv --png "$out/chart.png" -q
}

figure_accumulation_chart() {
    weft chart --accumulate --png "$out/accumulation-chart.png" -q
}

figure_antialias_chart() {
    weft chart --antialias --png "$out/antialias-chart.png" -q
}

# Too few parts for four ranks.
figure_ranks_load() {
    command -v mpirun >/dev/null || { left_out "no mpirun"; return 0; }
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
        mpirun -n 4 "$build/weft" antialias supersample --samples 64 --scene polygons:4000,50 \
        --schedule static --granularity 2 -o ranks.exr --load-chart "$out/ranks-load.png" -q
}

# ---- the command ---------------------------------------------------------------------------------

left_out() { echo "figures.sh: $name is left out: $1" >&2; }
needs() {
    [ -n "$data" ] && [ -e "$data/$1" ] && return
    left_out "it needs --data with $1"
    return 1
}
usage() {
    sed -n '3,10s/^# //p' "$0" >&2
    exit 2
}
folder() { (cd "$1" 2>/dev/null && pwd) || { echo "figures.sh: no folder $1" >&2; exit 2; }; }

list() { printf '%s' "$figures" | awk 'NF'; }
wanted=
while [ $# -gt 0 ]; do
    case $1 in
    --build | --out | --data)
        [ $# -ge 2 ] || usage
        value=$(folder "$2")
        case $1 in --build) build=$value ;; --out) out=$value ;; *) data=$value ;; esac
        shift
        ;;
    --list)
        list
        exit 0
        ;;
    drawn | measured) wanted="$wanted $(list | awk -v kind="$1" '$2 == kind { print $1 }')" ;;
    -*) usage ;;
    *)
        list | awk '{ print $1 }' | grep -qx -e "$1" ||
            { echo "figures.sh: no figure $1; --list names them" >&2; exit 2; }
        wanted="$wanted $1"
        ;;
    esac
    shift
done
[ -n "$wanted" ] || wanted=$(list | awk '{ print $1 }')
[ -x "$build/weft" ] || { echo "figures.sh: no $build/weft: build first, or say --build DIR" >&2; exit 2; }

tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
failed=0
for name in $wanted; do
    echo "== $name"
    mkdir "$tmp/$name"
    # In a shell of its own, which ends at the first command that fails.
    (cd "$tmp/$name" && set -e && "figure_$(echo "$name" | tr - _)") &
    wait $! || { echo "figures.sh: $name failed" >&2; failed=1; }
    rm -rf "${tmp:?}/$name"
done
exit $failed
