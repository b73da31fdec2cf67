# SPDX-License-Identifier: BSD-3-Clause
"""SciPy's map_coordinates of order 3 as a peer: peer_scipy.py samples|coefficients|spline.

samples: prefilter=False on the samples, the plain cubic B-spline. coefficients: the same on the
spline's coefficients, made beforehand by spline_filter; the result interpolates. spline: what
prefilter=True does, spline_filter (one thread) and then the same, all of it timed.

map_coordinates uses one thread and releases the interpreter's lock, so rows are split here; the
coordinates it wants are made beforehand. Mirrored at the faces, which the spline is exact for.
"""
import sys
import threading

import peer

try:
    import numpy as np
    import scipy
    from scipy import ndimage
except ImportError as error:
    peer.skip(f"not installed ({error})")

mode = sys.argv[1]
job = peer.load()
x, y = np.arange(job.width), np.arange(job.height)
position = [job.origin[a] + x[None, :] * job.du[a] + y[:, None] * job.dv[a] for a in (2, 1, 0)]
position = np.stack(position)
result = np.zeros((job.height, job.width), np.float32)
rows = np.linspace(0, job.height, job.threads + 1).astype(int)


def coefficients():
    return ndimage.spline_filter(job.box, order=3, mode="mirror")  # of doubles


def interpolate(source, first, last):
    ndimage.map_coordinates(source, position[:, first:last], result[first:last], order=3,
                            mode="mirror", prefilter=False)


def run():
    source = coefficients() if mode == "spline" else given
    threads = [threading.Thread(target=interpolate, args=(source, first, last))
               for first, last in zip(rows[:-1], rows[1:])]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


given = coefficients() if mode == "coefficients" else job.box
if mode == "coefficients":
    job.box = None
peer.serve(f"SciPy {scipy.__version__}", run, lambda: result)
