"""Compares this package with pybvh: both read the same files and compute the position of every joint in every frame.

Prints a row for each file: the frames, and the shortest processor time of both over several runs, for all threads
together. Then follows the ratio of speeds by processor time and by wall-clock time. The next column is the ratio by
processor time with the SHA-256 of the file, which only this package computes by default. The last column is the largest
difference of positions as a fraction of the figure's height. The exit code is 1 if this difference exceeds 1e-5, or if
the ratio without the hash is below 10.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

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
REPEATS = 40


def ours(path: Path) -> np.ndarray:
    return mocap.read(path, hash=False).to_numpy().positions


def hashed(path: Path) -> np.ndarray:
    return mocap.read(path).to_numpy().positions


def theirs(path: Path) -> np.ndarray:
    return pybvh.read_bvh_file(path, world_up="+y", warn_on_world_up_disagreement=False).node_positions()


class Seconds(NamedTuple):
    processor: float
    clock: float


def seconds(read: Callable[[Path], np.ndarray], path: Path) -> Seconds:
    processor, clock = time.process_time(), time.perf_counter()
    read(path)
    return Seconds(time.process_time() - processor, time.perf_counter() - clock)


def best(path: Path) -> list[Seconds]:
    """The shortest times of all, measured in turns, because other programs only add time."""
    times = [[seconds(read, path) for read in (ours, hashed, theirs)] for _ in range(REPEATS)]
    return [Seconds(*(min(column) for column in zip(*runs))) for runs in zip(*times)]


def main() -> int:
    failed = False
    print(f"{'':30}{'':7}{'ours':>9}{'pybvh':>9}{'times as fast':>27}{'':>9}")
    header = f"{'frames':>7}{'ms':>9}{'ms':>9}{'processor':>11}{'clock':>8}{'hashed':>8}{'apart':>9}"
    print(f"{'file':30}{header}")
    for name in FILES:
        our_positions, their_positions = ours(REAL / name), theirs(REAL / name)
        our_time, hashed_time, their_time = best(REAL / name)
        height = np.ptp(their_positions[0], axis=0).max()
        apart = np.abs(our_positions - their_positions).max() / height
        ratio = their_time.processor / our_time.processor
        failed |= bool(not apart <= 1e-5 or ratio < 10)
        by_clock, with_hash = their_time.clock / our_time.clock, their_time.processor / hashed_time.processor
        times = f"{1e3 * our_time.processor:9.2f}{1e3 * their_time.processor:9.2f}"
        print(f"{name:30}{len(our_positions):7}{times}{ratio:11.1f}{by_clock:8.1f}{with_hash:8.1f}{apart:9.1e}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
