"""Measures how many frames a second `mocap clean` cleans on one core: python speed.py MOCAP FOLDERS..

The time is the processor time of `mocap clean` minus the time of `mocap convert`, which reads and writes the same
files; each is the least of five runs. The input is the whole first motion of sources.json: clean, with noise, and with
noise, flips, a floor and errors of time. Both write glTF, because the writer of BVH needs more time for the digits of
smoothed angles.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import bvh
import plant

KINDS = {"clean": [], "noise": ["noise"], "all": ["noise", "flips", "floor", "time"]}
RATE = 120.0
RUNS = 5


def seconds(arguments):
    """The processor time of a command, in all its threads."""
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"failed: {arguments}")
    return usage.ru_utime + usage.ru_stime


def main():
    program, folders = str(Path(sys.argv[1]).resolve()), sys.argv[2:]
    source = next(plant.sources(folders))
    clean = plant.load(source, RATE)
    with tempfile.TemporaryDirectory() as folder:
        for kind, what in KINDS.items():
            motion, _, _ = plant.spoil(clean, source, np.random.default_rng(1), what)
            take, out = Path(folder) / f"{kind}.bvh", Path(folder) / f"{kind}_out.glb"
            bvh.write(take, motion)
            least = [min(seconds([program, word, take, "-o", out, "--force"]) for _ in range(RUNS)) for word in ("clean", "convert")]
            frames, joints = motion.turns.shape[:2]
            print(f"{kind:<8}{frames} frames, {joints} joints: {frames / max(least[0] - least[1], 1e-3):8.0f} frames a second")


if __name__ == "__main__":
    main()
