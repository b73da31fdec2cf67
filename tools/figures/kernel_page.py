#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""kernel_page.py WEFT DOCS: writes DOCS/kernels.md and its pictures, DOCS/kernels-*.png, from what
`WEFT kernel --list --json` and `WEFT kernel NAME --json` tell, with gnuplot. The words are here, the
facts are weft's. tests/command/test_command_kernel.c compares them."""

import json
import math
import os
import subprocess
import sys
import tempfile

# Title, file, kernels that are drawn, what they are good for; kernels are told to families below.
FAMILIES = [
    ("Nearest and linear", "simple", ["nearest", "linear"], """
One or two samples for each axis: the fastest, and the worst with everything that is smooth. `nearest` is right for labels
and other values that have no mean, and to see the samples themselves. `area` is `nearest` that a smaller image stretches:
each new pixel is the mean of what it covers. `linear` never overshoots; its slope jumps at every sample, which shading
shows as facets. `bspline0` and `bspline1` are other names of `nearest` and `linear`."""),
    ("Cubics of Mitchell and Netravali", "cubics", ["catmull-rom", "mitchell", "notch"], """
Four samples for each axis, by two numbers B and C: `cubic:B,C`; `cardinal:C` has B = 0. `catmull-rom`, the default, passes
through the samples and overshoots a little beside edges. `mitchell` blurs a little and rings less: a good choice for
photographs. `notch` removes the pattern of the sample grid at the price of a strong blur. Other programs' "bicubic" is
`catmull-rom` (a = -0.5) or `cardinal:0.75` (a = -0.75), and `cubic:1,0` is `bspline`."""),
    ("B-splines that blur", "bsplines", ["bspline2", "bspline", "bspline5", "bspline7"], """
The smoothest curves for their width, never below the smallest sample or above the largest. They do not pass through the
samples: take them for noisy data, for smooth surfaces from coarse samples, or for coefficients that another program has
already prefiltered. A higher degree blurs more. `bspline` is `bspline3`; `omoms` is its cousin with the smallest error
for four samples once it is prefiltered."""),
    ("B-splines that interpolate", "bsplines-i", ["bspline2i", "bspline3i", "bspline5i", "bspline7i"], """
The same curves on coefficients instead of samples (Unser's prefilter), which weft computes from the voxels around whatever
is read. The result passes through the samples. Their error falls fastest when samples are dense: take `bspline3i` where
accuracy counts and the data is smooth, and for gradients and curvatures. They ring beside sharp edges, and a missing
sample (NaN) takes its neighbours with it. The picture has the whole of prefilter and kernel. `bsplinei` is `bspline3i`."""),
    ("Lagrange and Keys", "lagrange", ["lagrange3", "lagrange5", "keys6"], """
Interpolation without a prefilter. `lagrange3` and `lagrange5` are exact for polynomials of degree 3 and 5, but their slope
jumps at the samples, as that of `linear` does: good for values, not for shading. `keys6` has six samples, order 4 and a
smooth slope: the most accurate of those that need no prefilter and have a gradient without jumps."""),
    ("Windowed sincs", "sincs", ["lanczos", "hann-sinc", "blackman-sinc", "kaiser-sinc"], """
The ideal filter sin(pi x) / (pi x), cut off by a window at a radius that you choose (`lanczos:2`, `kaiser-sinc:4,8`). They
keep more detail than cubics and ring more beside edges. Their weights do not quite add up to one: `weft slice` and `weft
resample` divide by the sum, elsewhere say `NAME+unit`. `lanczos:3` is the usual choice for photographs; `rect-sinc` is
there to show why windows are needed."""),
    ("Gaussian", "gaussian", ["gaussian", "gaussian:3,0.8"], """
A blur of your own width (`gaussian:RADIUS,SIGMA`), for smoothing on purpose: scale spaces, denoising, derivatives of noisy
data. It does not pass through the samples and its weights do not add up to one (`+unit`)."""),
]


def family(name):
    """The index of the family that a kernel of the catalogue belongs to."""
    if name in ("nearest", "area", "linear", "bspline0", "bspline1"):
        return 0
    if name in ("cubic", "cardinal", "catmull-rom", "mitchell", "notch"):
        return 1
    if name.startswith(("bspline", "omoms")):
        return 3 if name.endswith("i") else 2
    if name in ("lagrange3", "lagrange5", "keys6"):
        return 4
    if name.endswith("sinc") or name == "lanczos":
        return 5
    if name == "gaussian":
        return 6
    sys.exit(f"kernel_page.py: {name} belongs to no family: add it")


def ask(weft, *arguments):
    return json.loads(subprocess.run([weft, "kernel", *arguments, "--json"], check=True,
                                     capture_output=True).stdout)


# ---- pictures ------------------------------------------------------------------------------------


def draw(weft, names, path):
    """All pictures have the same axes, so that they can be compared."""
    with tempfile.TemporaryDirectory() as folder:
        kernels, spectra = [], []
        for index, name in enumerate(names):
            facts = ask(weft, name) # of prefiltered kernels: both together
            curve, spectrum = facts["curve"], facts["spectrum"]
            file = os.path.join(folder, str(index))
            with open(file, "w", encoding="ascii") as out:
                out.writelines(f"{a} {b}\n" for a, b in zip(curve["x"], curve["value"]))
                out.write("\n\n")
                out.writelines(f"{a} {20 * math.log10(max(b, 1e-9))}\n" for a, b in
                               zip(spectrum["frequency"], spectrum["magnitude"]))
            style = f"with lines lw 2 lc {index + 1}"
            kernels.append(f"'{file}' index 0 {style} notitle")
            spectra.append(f"'{file}' index 1 {style} title '{name}'")
        script = f"""
set terminal pngcairo size 860,250 font 'sans,10' noenhanced
set output '{folder}/out.png'
set linetype 1 lc rgb '#0060a8'; set linetype 2 lc rgb '#d95f02'
set linetype 3 lc rgb '#1b9e77'; set linetype 4 lc rgb '#7b3294'
set multiplot
set grid lc rgb '#e4e4e4'; set border lc rgb '#606060'
set bmargin at screen 0.20; set tmargin at screen 0.95
set lmargin at screen 0.06; set rmargin at screen 0.43
set xrange [-4:4]; set yrange [-0.3:1.15]
set xlabel 'x, in sample distances' offset 0,0.6; set xtics 1; set ytics 0.5
plot 0 lc rgb '#909090' notitle, {', '.join(kernels)}
set lmargin at screen 0.52; set rmargin at screen 0.83
set xrange [0:2.5]; set yrange [-80:10]
set xlabel 'f, in cycles per sample distance; grey: Nyquist' offset 0,0.6; set xtics 0.5; set ytics 20
set ylabel 'response, dB' offset 1
set arrow from 0.5,-80 to 0.5,10 nohead lc rgb '#b0b0b0' lw 2
set key outside right top Left reverse samplen 1.5
plot {', '.join(spectra)}
unset multiplot
"""
        subprocess.run(["gnuplot"], input=script, check=True, text=True)
        with open(f"{folder}/out.png", "rb") as picture, open(path, "wb") as out:
            out.write(picture.read())


# ---- the page ------------------------------------------------------------------------------------


def row(facts, names):
    name = facts["kernel"].split(":")[0]
    prefilter = "no"
    if facts["prefiltered"]:
        prefilter = "has it"
    elif facts["needs_prefilter"]:
        prefilter = f"yes: `{name}i`" if name + "i" in names else "yes; weft has none"
    through = "yes" if facts["interpolating"] else "yes, prefiltered" if facts["prefiltered"] else "no: blurs"
    above = facts["overshoot"]["above"]
    return (f"| `{facts['kernel']}` | {facts['taps']} | {facts['support']:g} | {facts['order']['order']} "
            f"| {through} | {prefilter} | {'yes' if facts['unit_sum'] else 'no'} "
            f"| {'0' if above < 5e-4 else f'{above:.3f}'} |")


HEAD = """<!-- Made by tools/figures/kernel_page.py from `weft kernel`: change it there. -->
# The kernels

A reconstruction kernel h tells how much each sample counts for a point at a distance x from it: the value at a point is
the sum of samples times h, in 2D and 3D of products of h along the axes. `--kernel NAME` takes any of these wherever a verb
filters; `weft kernel NAME` prints all that is known of one, `weft kernel NAME --plot k.svg` draws it, and
[kernel.h](../filter/kernels/kernel.h) has them in C. Not sure? Take `catmull-rom` (the default) for volumes and images,
`bspline3i` where accuracy counts, `mitchell` for photographs, `bspline` for noisy data, `nearest` for labels.

![The same samples seen through five kernels](kernels-side-by-side.png)

How to read the tables:

- **taps**: samples along an axis that count at a point; in 3D it is the third power. **support**: how far h reaches.
- **order** N: halve the distance of samples, and the error falls by 2^N where data is smooth. 0: it stops falling.
- **through the samples**: the result has the samples' values at the samples' places; else it blurs, however dense they are.
- **wants a prefilter**: with coefficients in place of samples the order would be higher; `NAMEi` does so.
- **sums to 1**: constant data stays constant; where not, `NAME+unit` divides by the sum.
- **overshoot**: how far the result rises above a step from 0 to 1.

In the pictures the kernel is on the left, and what it does to each frequency on the right: up to the grey line (Nyquist)
0 dB is best, beyond it as little as possible: what stays there shows the sample grid.
"""

TAIL = """
## Your own

`table:FILE` reads samples of a kernel: a half-width and numbers at equal steps, as `support 1  1 0.5 0` (that is
`linear`), with `cubic` for cubic instead of linear interpolation between them, and `whole` where it is not even. In C fill a
`struct weft_kernel_info`: [kernel.h](../filter/kernels/kernel.h); [CONTRIBUTING.md](../CONTRIBUTING.md) shows how to add
one to the catalogue.

`NAME+unit` divides the weights at each position by their sum. `NAME+radial` is h of the distance in place of a product, for
tiles and the reference only. `NAME:p,q` sets parameters, and trailing ones may be left out.
"""


def page(weft, names):
    lines = [HEAD]
    plain = [n for n in names if not n.startswith(("d-", "dd-"))]
    for index, (title, file, _, words) in enumerate(FAMILIES):
        lines += [f"\n## {title}\n{words}\n", f"![Kernels and their frequency responses](kernels-{file}.png)\n",
                  "| kernel | taps | support | order | through the samples | wants a prefilter | sums to 1 | overshoot |",
                  "|---|---:|---:|---:|---|---|---|---:|"]
        lines += [row(ask(weft, n), names) for n in plain if family(n) == index]
    lines.append("""
## Derivatives

`--quantity gradient` and its kin take these by themselves; named as kernels they reconstruct the derivative of the signal
along x in 1D. The number is the order of approximation of that derivative. Kernels without a line have none.

| kernel | first derivative | second derivative |
|---|---|---|""")
    order = {n: ask(weft, n)["order"]["order"] for n in names if n.startswith(("d-", "dd-"))}
    for n in plain:
        if "d-" + n in order:
            second = f"`dd-{n}` ({order['dd-' + n]})" if "dd-" + n in order else ""
            lines.append(f"| `{n}` | `d-{n}` ({order['d-' + n]}) | {second} |")
    lines.append(TAIL)
    return "\n".join(lines).replace("\n\n\n", "\n\n")


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: kernel_page.py WEFT DOCS")
    weft, docs = sys.argv[1:]
    names = [entry["name"] for entry in ask(weft, "--list")["kernels"]]
    for _, file, drawn, _ in FAMILIES:
        draw(weft, drawn, os.path.join(docs, f"kernels-{file}.png"))
    text = page(weft, names)
    with open(os.path.join(docs, "kernels.md"), "w", encoding="utf-8") as out:
        out.write(text.rstrip("\n") + "\n")


main()
