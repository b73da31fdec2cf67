# SPDX-License-Identifier: BSD-3-Clause
"""What the Python programs that run a peer share: peer.h, where the protocol is written down."""
import sys
import time


def skip(reason):
    print("skip", reason, flush=True)
    sys.exit(77)


def load():
    """The job as an object, its box [z][y][x] of float32."""
    import numpy as np

    class Job:
        pass

    job, words = Job(), sys.stdin.readline().split()
    fd, sx, sy, sz, job.width, job.height, job.threads = map(int, words[1:8])
    numbers = np.array([float(word) for word in words[8:17]])
    job.origin, job.du, job.dv = numbers[0:3], numbers[3:6], numbers[6:9]
    with open(f"/proc/self/fd/{fd}", "rb") as file:
        job.box = np.fromfile(file, np.float32, sx * sy * sz).reshape(sz, sy, sx)
    return job


def serve(version, run, pixels):
    """run() is timed; pixels() gives the last run's as float32 [y][x]."""
    print("ready", version, flush=True)
    for line in sys.stdin:
        if line == "run\n":
            start = time.perf_counter()
            run()
            print(f"{time.perf_counter() - start:.9f}", flush=True)
        elif line == "pixels\n":
            sys.stdout.buffer.write(pixels().astype("float32").tobytes())
            sys.stdout.flush()
