"""Reading a file and placing every joint in every frame: this package beside pybvh, in one run, on the same files.

Prints a row for each file: frames, the best of several times for both, how many times as fast, and how far apart the
positions are as a share of the figure's height. The times are those of the processor, all threads together, which
other programs on the machine change least. Exits with 1 where that is above 1e-5 or the speed below 10 times.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pybvh

import mocap

REAL = Path(__file__).parents[2] / "fixtures" / "real"
# Files whose roots replace their OFFSETs, as pybvh always does, and whose other joints have no position channels.
FILES = [
    "cmu_01_01.bvh",
    "cmu_12_01_walk.bvh",
    "cmu_mixed_rotation_orders.bvh",
    "motionbuilder_vicon_walk.bvh",
    "rokoko_dance.bvh",
]
REPEATS = 20


def ours(path: Path) -> np.ndarray:
    return mocap.read(path).to_numpy().positions


def theirs(path: Path) -> np.ndarray:
    return pybvh.read_bvh_file(path, world_up="+y", warn_on_world_up_disagreement=False).node_positions()


def seconds(read: Callable[[Path], np.ndarray], path: Path) -> float:
    start = time.process_time()
    read(path)
    return time.process_time() - start


def best(path: Path) -> tuple[float, float]:
    """The shortest times of both, in turns, for caches that another program has emptied only ever add to them."""
    times = [(seconds(ours, path), seconds(theirs, path)) for _ in range(REPEATS)]
    our_times, their_times = zip(*times)
    return min(our_times), min(their_times)


def main() -> int:
    failed = False
    print(f"{'file':34}{'frames':>7}{'ours ms':>10}{'pybvh ms':>10}{'times':>8}{'apart':>10}")
    for name in FILES:
        our_positions, their_positions = ours(REAL / name), theirs(REAL / name)
        our_time, their_time = best(REAL / name)
        height = np.ptp(their_positions[0], axis=0).max()
        apart = np.abs(our_positions - their_positions).max() / height
        ratio = their_time / our_time
        failed |= bool(not apart <= 1e-5 or ratio < 10)
        columns = f"{len(our_positions):7}{1e3 * our_time:10.2f}{1e3 * their_time:10.2f}{ratio:8.1f}{apart:10.1e}"
        print(f"{name:34}{columns}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
