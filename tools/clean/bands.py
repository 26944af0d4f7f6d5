"""Judges `mocap clean` on noise that is correlated, at many rates, interpolated, and with spikes of the root.

python bands.py MOCAP FOLDERS.. [--count 12] [--seeds 1,2] [--cases NAME,..]

The peer is a Butterworth filter of 6 Hz, order 2, forwards and backwards, on quaternions and the root. It does not
adapt to a clip.
"""

import argparse
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import bvh
import judge
import plant

CUT_OFF = 6.0  # of the peer, in Hz
# The correlation time of the noise in ms, the frame rate of the take, and the number of frames interpolated per frame.
CASES = {f"{rate} Hz, {time} ms": (time, rate, 1) for time in (0, 15, 30, 60, 120, 250) for rate in (24, 30, 60, 120)}
CASES |= {f"30 Hz x{times}, {time} ms": (time, 30, times) for times in (2, 4) for time in (0, 60)}
CASES |= {"60 Hz x2, 0 ms": (0, 60, 2), "30 Hz, spikes": (0, 30, 1), "60 Hz, spikes": (0, 60, 1), "60 Hz, clean": (None, 60, 1)}


def one(task):
    program, folder, name, index, source, truth, seed = task
    time, own, times = CASES[name]
    random = np.random.default_rng([seed, index, own, time or 0])
    rate = truth.rate
    motion = truth.take(np.arange(0, len(truth.root), times))
    motion.rate = rate / times
    if time is not None:
        plant.add_noise(motion, random, time / 1000)
    if name.endswith("spikes"):
        plant.add_root_spikes(motion, random)
    if times > 1:
        motion = plant.interpolated(motion, times)
        truth = truth.take(np.arange(len(motion.root)))
    stem = folder / f"{name.replace(' ', '_').replace(',', '')}_{index}_{seed}"
    noisy, out = stem.with_suffix(".bvh"), stem.parent / (stem.name + "_out.bvh")
    bvh.write(noisy, motion)
    run = subprocess.run([program, "clean", noisy, "-o", out, "--force"], capture_output=True, text=True)
    if run.returncode != 0:
        raise SystemExit(f"{noisy}: {run.stderr}")
    cleaned = bvh.read(out)
    order = [cleaned.names.index(joint) for joint in motion.names]
    cleaned.turns, cleaned.parents, cleaned.offsets = cleaned.turns[:, order], motion.parents, motion.offsets
    frames = min(len(cleaned.root), len(truth.root))
    true = truth.positions()[:frames]
    feet = [truth.names.index(joint) for joint in source["ankles"] + source["balls"]]
    row = {}
    for who, places in (
        ("input", motion.positions()),
        ("filter", judge.butterworth(motion, CUT_OFF).positions()),
        ("clean", cleaned.positions()),
    ):
        places = places[:frames]
        row[who] = [
            judge.acceleration_error(places, true, rate) / 100,
            judge.peaks(places, true, rate),
            judge.skate(places, true, feet, rate),
            10 * np.linalg.norm(places - true, axis=-1).mean(),
            10 * np.linalg.norm(places - true, axis=-1).max(),
        ]
    return name, index, row


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--count", type=int, default=12)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--cases", default="")
    parser.add_argument("--keep")
    args = parser.parse_args()
    folder = Path(args.keep or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    wanted = [name for name in CASES if not args.cases or any(part in name for part in args.cases.split(";"))]
    tasks = []
    for seed in map(int, args.seeds.split(",")):
        rates = {CASES[name][1] * CASES[name][2] for name in wanted}
        found = {rate: list(plant.clips(args.folders, args.count, seed, rates=(rate,))) for rate in rates}
        for name in wanted:
            rate = CASES[name][1] * CASES[name][2]
            for index, (source, truth, _) in enumerate(found[rate]):
                tasks.append((os.path.abspath(args.program), folder, name, index, source, truth.copy(), seed))
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(one, tasks))
    print(f"{'case':<18}{'input':>8}{'filter':>8}{'clean':>8}{'/filter':>8}{'/input':>8}{'most':>7}{'peaks':>7}{'fpeaks':>7}{'skate':>13}{'mm':>13}{'most mm':>9}")
    for name in wanted:
        rows = [row for case, _, row in results if case == name]
        before, peer, after = (np.array([row[who] for row in rows]) for who in ("input", "filter", "clean"))
        mean = [part[:, 0].mean() for part in (before, peer, after)]
        print(
            f"{name:<18}" + "".join(f"{value:8.2f}" for value in mean)
            + f"{mean[2] / mean[1]:8.2f}{mean[2] / max(mean[0], 1e-9):8.2f}{(after[:, 0] / before[:, 0].clip(1e-9)).max():7.2f}"
            + f"{after[:, 1].mean():7.3f}{peer[:, 1].mean():7.3f}"
            + f"{np.nanmean(before[:, 2]):7.1f}{np.nanmean(after[:, 2]):6.1f}{before[:, 3].mean():7.1f}{after[:, 3].mean():6.1f}{after[:, 4].max():9.1f}"
        )


if __name__ == "__main__":
    main()
