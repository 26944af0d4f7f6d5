"""Measures time and memory of `mocap survey` over different clips of ten seconds.

    scale.py MOCAP [--clips N] [--links N] [--keep FOLDER]

Each clip mixes two parts of a take, joint by joint, at its own pace, with 300 frames at 30 a second. --links adds
file-system links to these clips up to that number. Prints the wall time, the processor time and the largest memory for
a quarter of the clips, for all clips, and for all links.
"""

import argparse
import os
import pathlib
import random
import resource
import subprocess
import tempfile
import time

import numpy as np

from plant import Bvh

TAKE = pathlib.Path(__file__).resolve().parents[2] / "fixtures/real/cmu_01_01.bvh"
FRAMES, RATE = 300, 30


def mixed(rng, bvh):
    """The rows of a clip: two parts of the take at different paces, mixed joint by joint."""

    def part():
        step = rng.uniform(0.6, 1.4) / bvh.frame_time / RATE
        start = rng.uniform(1, len(bvh.rows) - FRAMES * step - 2) if FRAMES * step < len(bvh.rows) - 4 else 1.0
        at = (start + np.arange(FRAMES) * step) % (len(bvh.rows) - 2) + 1
        return bvh.rows[at.astype(int)]

    first, second = part(), part()
    weights = np.zeros(first.shape[1])
    for joint in range(1, len(bvh.names)):
        weights[bvh.columns(joint, "rotation")] = rng.uniform(0, 0.5)
    return (1 - weights) * first + weights * second


def make(folder, count):
    bvh, rng = Bvh(TAKE.read_text()), random.Random(1)
    folder.mkdir(parents=True, exist_ok=True)
    form = " ".join(["%.3f"] * bvh.rows.shape[1]) + "\n"
    head = f"{bvh.head}MOTION\nFrames: {FRAMES}\nFrame Time: {1 / RATE:.7f}\n"
    for number in range(count):
        path = folder / f"{number % 100:02}" / f"{number:06}.bvh"
        path.parent.mkdir(exist_ok=True)
        if not path.exists():
            rows = mixed(rng, bvh)
            path.write_text(head + (form * FRAMES) % tuple(rows.ravel().tolist()))


def measured(mocap, folders, out):
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    words = [mocap, "survey", *folders, "-o", out, "-q"]
    done = subprocess.Popen(words)
    _, status, usage = os.wait4(done.pid, 0)
    wall, after = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    rows = sum(1 for _ in open(out))
    print(f"{rows:7} clips: {wall:7.1f} s, {processor:7.1f} s of processors, {usage.ru_maxrss / 1024:6.0f} MB, exit {status >> 8}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("--clips", type=int, default=10_000)
    parser.add_argument("--links", type=int, default=0)
    parser.add_argument("--keep", type=pathlib.Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.keep or pathlib.Path(temporary)
        make(folder / "clips", args.clips)
        parts = sorted((folder / "clips").iterdir())
        out = folder / "rows.jsonl"
        measured(args.mocap, parts[: len(parts) // 4], out)
        measured(args.mocap, parts, out)
        if args.links:
            for copy in range(args.links // args.clips):
                (folder / "links").mkdir(exist_ok=True)
                link = folder / "links" / f"{copy}"
                link.exists() or link.symlink_to((folder / "clips").resolve())
            measured(args.mocap, [folder / "links"], out)


if __name__ == "__main__":
    main()
