# SPDX-License-Identifier: BSD-3-Clause
"""A volume on another lattice by another library.

peer_lattice.py scipy|vtk|teem IN OUT FACTOR THREADS

IN and OUT are NRRD files of floats, encoding raw. The result's voxel j lies at j / FACTOR of the
source's, the last within it. Prints the seconds and processor seconds of the call, from voxels in
memory to voxels in memory, and the library's version.
"""
import ctypes
import ctypes.util
import os
import re
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "volumes"))
import peer  # noqa: E402

try:
    import numpy as np
except ImportError as error:
    peer.skip(f"not installed ({error})")


def read(path):
    """Voxels [z][y][x], spacing and origin of a NRRD file of floats, encoding raw, axes aligned."""
    with open(path, "rb") as file:
        field = {}
        while line := file.readline().decode().strip():
            name, colon, value = line.partition(": ")
            if colon:
                field[name] = value
        size = [int(word) for word in field["sizes"].split()]
        box = np.fromfile(file, np.float32).reshape(size[::-1])
    numbers = [re.split("[(), ]+", field[name])[1:-1]
               for name in ("space directions", "space origin")]
    return box, float(numbers[0][0]), np.array(numbers[1], float)


def write(path, box, spacing=1.0, origin=(0.0, 0.0, 0.0)):
    axes = " ".join(f"({','.join(repr(spacing * (a == b)) for b in range(3))})" for a in range(3))
    with open(path, "wb") as file:
        file.write(("NRRD0005\ntype: float\ndimension: 3\nspace dimension: 3\n"
                    f"sizes: {' '.join(map(str, box.shape[::-1]))}\nspace directions: {axes}\n"
                    f"space origin: ({','.join(repr(float(o)) for o in origin)})\n"
                    "endian: little\nencoding: raw\n\n").encode())
        box.tofile(file)


def count(size, factor):
    return int((size - 1) * factor) + 1


def scipy(box, factor, threads):
    """zoom of order 3, prefiltered: the cardinal cubic spline. One thread."""
    from scipy import __version__, ndimage
    zoom = [count(size, factor) / size for size in box.shape]
    return f"SciPy {__version__}", lambda: ndimage.zoom(box, zoom, order=3, mode="mirror")


def vtk(box, factor, threads):
    """vtkImageResize, cubic (Catmull-Rom), one axis after another."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkImagingCore import vtkImageInterpolator, vtkImageResize
    vtkSMPTools.Initialize(threads)
    image = vtkImageData()
    image.SetDimensions(box.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(box.ravel()))  # borrows
    cubic, resize = vtkImageInterpolator(), vtkImageResize()
    cubic.SetInterpolationModeToCubic()
    resize.SetInputData(image)
    resize.SetInterpolator(cubic)
    resize.BorderOff()  # first and last voxels stay where they are
    resize.SetResizeMethodToOutputDimensions()
    resize.SetOutputDimensions([count(size, factor) for size in box.shape[::-1]])
    resize.SetNumberOfThreads(threads)

    def run():
        resize.Update()
        return vtk_to_numpy(resize.GetOutput().GetPointData().GetScalars()).reshape(
            [count(size, factor) for size in box.shape])
    return f"VTK {vtkVersion.GetVTKVersion()}", run


def teem(source, result, factor, shape):
    """What unu resample calls, between files that Teem reads and writes. One thread."""
    lib = ctypes.CDLL(ctypes.util.find_library("teem") or "libteem.so.2")
    for name in ("nrrdNew", "nrrdResampleContextNew"):
        getattr(lib, name).restype = ctypes.c_void_p
    pointer, double, uint = ctypes.c_void_p, ctypes.c_double, ctypes.c_uint
    node, bleed = 1, 2  # nrrdCenterNode, nrrdBoundaryBleed
    given, made = pointer(lib.nrrdNew()), pointer(lib.nrrdNew())
    context = pointer(lib.nrrdResampleContextNew())
    kernel = pointer.in_dll(lib, "nrrdKernelBCCubic")
    failed = lib.nrrdLoad(given, source.encode(), None)
    failed |= lib.nrrdResampleInputSet(context, given)
    for axis, size in enumerate(shape[::-1]):
        failed |= lib.nrrdResampleOverrideCenterSet(context, uint(axis), node)
        failed |= lib.nrrdResampleKernelSet(context, uint(axis), kernel, (double * 3)(1, 0, 0.5))
        failed |= lib.nrrdResampleSamplesSet(context, uint(axis),
                                             ctypes.c_size_t(count(size, factor)))
        failed |= lib.nrrdResampleRangeFullSet(context, uint(axis))
    failed |= lib.nrrdResampleBoundarySet(context, bleed)
    failed |= lib.nrrdResampleRenormalizeSet(context, 1)
    version = ctypes.c_char_p.in_dll(lib, "airTeemVersion").value.decode()

    def run():
        if failed or lib.nrrdResampleExecute(context, made):
            lib.biffGet.restype = ctypes.c_char_p
            sys.exit(lib.biffGet(b"nrrd").decode())
    return f"Teem {version}", run, lambda: lib.nrrdSave(result.encode(), made, None)


def main():
    library, source, result, factor, threads = sys.argv[1:]
    box, spacing, origin = read(source)
    save = None
    try:
        if library == "teem":
            version, run, save = teem(source, result, float(factor), box.shape)
        else:
            version, run = {"scipy": scipy, "vtk": vtk}[library](box, float(factor), int(threads))
    except (ImportError, OSError) as error:
        peer.skip(f"not installed ({error})")
    wall, used = time.perf_counter(), time.process_time()
    made = run()
    wall, used = time.perf_counter() - wall, time.process_time() - used
    if save:
        save()
    else:
        write(result, made, spacing / float(factor), origin)
    print(wall, used, version)


if __name__ == "__main__":
    main()
