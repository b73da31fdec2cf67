# SPDX-License-Identifier: BSD-3-Clause
"""Dense volumes on another lattice: weft lattice in turns with SciPy's zoom, VTK and Teem.

  /usr/bin/python3 -B bench_lattice.py WEFT [VOLUME] [--factor 2] [--side 97] [--runs 3]
                                       [--threads N]

A cube of SIDE voxels (odd, so that both ends of it stay voxels at 2 and 0.5) from the middle of
VOLUME, or a generated one where there is none: a sphere's distance, of which no brick is constant.
All programs read it as NRRD; the others write NRRD, weft a VDB file.

Columns: wall and processor seconds, medians of the runs, from voxels in memory to voxels in memory
(weft: what --json calls "pass", and "read", too, where a prefilter is part of it; its processor
seconds are not told there, so that weft with one thread stands beside weft with all) and of the
whole program from file to file. Last, the largest difference between the peer's voxels and those of
weft with the same kernel, 12 of the source's from the faces (which are extended differently), as a
share of the range of the source's values.

Equal lattices: weft keeps voxel (0, 0, 0) in its place and puts voxel j at j / FACTOR of the
source. That is "node" centring for Teem (-c node, by default it is "cell"), BorderOff of
vtkImageResize, and grid_mode=False of zoom, with int((size - 1) * FACTOR) + 1 voxels.
SciPy and VTK do not filter when they minify: weft's kernels are not stretched in turn there, and at
0.5 every second voxel is what comes out. Teem stretches kernels as weft does.
"""
import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

try:
    import numpy as np
    import peer_lattice as nrrd
except ImportError as error:
    print("skip: not installed", error)
    sys.exit(77)

PEER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "peer_lattice.py")
INNER = 12  # voxels of the source; the cubic spline's prefilter has forgotten the face by then


def source(options, path):
    """Writes the cube, as NRRD."""
    side = options.side
    if options.volume and os.path.exists(options.volume):
        subprocess.run([options.weft, "convert", "-q", options.volume, path, "--type", "float"],
                       check=True)
        box = nrrd.read(path)[0]
        start = [max(0, (size - side) // 2) for size in box.shape]
        box = box[tuple(slice(s, s + side) for s in start)].copy()
        name = os.path.basename(options.volume)
    else:
        axis = np.arange(side, dtype=np.float32) - (side - 1) / 2
        z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
        box = (0.4 * side - np.sqrt(x * x + y * y + z * z)).astype(np.float32)
        name = "sphere"
    os.path.exists(path) and os.remove(path)
    nrrd.write(path, box)
    print(f"{name}, {' x '.join(map(str, box.shape[::-1]))} voxels, factor {options.factor:g}, "
          f"medians of {options.runs} runs in turns")


def measured(command, env=None):
    """Its standard output, wall and processor seconds of it and its children; None if it skips."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, stdout=subprocess.PIPE, env=env)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode == 77:
        return None
    if done.returncode:
        sys.exit(f"failed: {' '.join(command)}")
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.stdout.decode(), wall, used


class Weft:
    def __init__(self, options, kernel, threads, stretched, tmp):
        self.name = f"weft {kernel}" + ("" if stretched else ", not stretched")
        self.threads = threads
        self.out = f"{tmp}/{kernel}{stretched}.vdb"
        self.prefiltered, self.times, self.difference = kernel == "bspline3i", [], ""
        self.weft = options.weft
        self.command = [options.weft, "lattice", f"{tmp}/in.nrrd", "--scale", f"{options.factor:g}",
                        "--kernel", kernel, "--antialias", "on" if stretched else "off", "--json",
                        "-q", "-o", self.out]

    def run(self):
        text, wall, used = measured(self.command, dict(os.environ, WEFT_THREADS=str(self.threads)))
        seconds = json.loads(text)["grids"][0]["seconds"]
        inner = seconds["pass"] + (seconds["read"] if self.prefiltered else 0.0)
        self.times.append((inner, np.nan, wall, used))

    def voxels(self):
        subprocess.run([self.weft, "convert", "-q", self.out, self.out + ".nrrd"], check=True)
        return nrrd.read(self.out + ".nrrd")


class Peer:
    def __init__(self, options, library, name, threads, equal, tmp):
        self.name, self.threads, self.equal = name, threads, equal
        self.out, self.times, self.difference = f"{tmp}/{library}.nrrd", [], ""
        self.command = [sys.executable, "-B", PEER, library, f"{tmp}/in.nrrd", self.out,
                        f"{options.factor:g}", str(threads)]
        # Teem's own program is what is measured from file to file, where it is installed.
        unu = library == "teem" and (shutil.which("teem-unu") or shutil.which("unu"))
        count = str(nrrd.count(options.side, options.factor))
        self.whole = unu and [unu, "resample", "-i", f"{tmp}/in.nrrd", "-s", count, count, count,
                              "-c", "node", "-co", "-k", "cubic:0,0.5", "-b", "bleed",
                              "-o", self.out]

    def run(self):
        result = measured(self.command)
        if not result:
            self.times = None
            return
        text, wall, used = result
        inner, inner_used, self.version = text.split(None, 2)
        if self.whole:
            _, wall, used = measured(self.whole)
        self.times.append((float(inner), float(inner_used), wall, used))

    def compare(self, given, factor):
        made = nrrd.read(self.out)[0]
        box, spacing, origin = self.equal.voxels()
        start = np.rint(-origin / spacing).astype(int)[::-1]  # where the source's first voxel is
        box = box[tuple(slice(s, s + n) for s, n in zip(start, made.shape))]
        edge = int(np.ceil(INNER * factor))
        inner = (slice(edge, -edge),) * 3
        off = np.abs(made[inner].astype(float) - box[inner]).max() / np.ptp(given)
        self.difference = f"{off:.1e}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("weft")
    parser.add_argument("volume", nargs="?")
    for name, default in (("factor", 2.0), ("side", 97), ("runs", 3), ("threads", os.cpu_count())):
        parser.add_argument("--" + name, type=type(default), default=default)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as tmp:
        source(options, f"{tmp}/in.nrrd")
        up, all_threads = options.factor >= 1, options.threads

        def weft(kernel, threads, stretched=True):
            return Weft(options, kernel, threads, stretched, tmp)
        rom, spline = weft("catmull-rom", all_threads), weft("bspline3i", all_threads, up)
        plain = rom if up else weft("catmull-rom", all_threads, False)
        rows = [rom, Peer(options, "teem", "Teem, Catmull-Rom", 1, rom, tmp),
                weft("catmull-rom", 1)]
        rows += [plain] if not up else []
        rows += [Peer(options, "vtk", "VTK, Catmull-Rom", all_threads, plain, tmp), spline,
                 Peer(options, "scipy", "SciPy, cubic spline", 1, spline, tmp),
                 weft("bspline3i", 1, up)]
        for _ in range(options.runs):
            for row in rows:
                if row.times is not None:
                    row.run()
        given = nrrd.read(f"{tmp}/in.nrrd")[0]
        print(f"{'':34}{'threads':>8}{'in memory':>11}{'cores':>8}{'file to file':>14}{'cores':>8}"
              f"{'difference':>12}")
        for row in rows:
            if row.times is None:
                print(f"{row.name:34}not installed")
                continue
            if isinstance(row, Peer):
                row.compare(given, options.factor)
            inner, used, wall, cores = (statistics.median(column) for column in zip(*row.times))
            used = "" if np.isnan(used) else f"{used:.3f}"
            print(f"{row.name:34}{row.threads:8}{inner:11.3f}{used:>8}{wall:14.3f}{cores:8.3f}"
                  f"{row.difference:>12}")
        versions = [row.version.strip() for row in rows if isinstance(row, Peer) and row.times]
        print("Versions: " + ", ".join(versions))


if __name__ == "__main__":
    main()
