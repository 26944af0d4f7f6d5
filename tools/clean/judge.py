"""Judges `mocap clean` by comparison with the motions before artificial defects. See README.md."""

import argparse
import json
import os
import subprocess
import tempfile
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.signal import butter, filtfilt
from scipy.spatial.transform import Rotation

import bvh
import plant

warnings.simplefilter("ignore")
SETS = {
    "clean": [],
    "noise": ["noise"],
    "flips": ["flips", "noise"],
    "floor": ["floor", "noise"],
    "time": ["time", "noise"],
    "depth": ["depth", "noise"],
    "all": ["noise", "flips", "floor", "time"],
    "hands": ["noise"],
    "rate": ["noise"],
}
HANDS = 6  # source clips in which the hands meet
# How the set `rate` spoils a clip, in turn: each fifth frame is repeated; or the file states half of the true rate,
# twice the true rate, or the true rate.
RATES = ["repeated", "half", "twice", "true"]
MEET = 25.0  # hands meet or hold one object if their wrists are nearer than this, in cm
# The limits of the mean of every sample: the targets that are reached, else values a little above the README's table.
HELD = {
    "noise: acceleration error / spoiled": 0.35,
    "noise: joint error / spoiled": 0.6,
    "clean: largest change mm": 1.0,
    "time: frames too many or few": 0.2,
    "noise: skate cm/s": 3.5,
    "all: feet in contact off level cm": 0.8,
    "rate: true rates changed": 0.0,
}
# Feet at least this far apart, in cm, show a slope. The height of a foot varies by 1 cm between steps: at this
# distance, 2 degrees for one step, and less than 1 degree for several.
WIDE = 30.0
CUT_OFFS = np.geomspace(0.7, 14, 24)  # of the Butterworth filters, in Hz


def accelerations(places, rate):
    return np.diff(places, 2, axis=0) * rate**2


def acceleration_error(places, truth, rate):
    return np.linalg.norm(accelerations(places, rate) - accelerations(truth, rate), axis=-1).mean()


def butterworth(motion, cut_off):
    """The usual filter: second order, forwards and backwards, on quaternions and on the root."""
    b, a = butter(2, cut_off / (motion.rate / 2))
    turns = motion.turns.copy()
    for frame in range(1, len(turns)):
        opposite = (turns[frame] * turns[frame - 1]).sum(-1) < 0
        turns[frame, opposite] *= -1
    filtered = motion.copy()
    turns = filtfilt(b, a, turns, axis=0)
    filtered.turns = turns / np.linalg.norm(turns, axis=-1, keepdims=True)
    filtered.root = filtfilt(b, a, motion.root, axis=0)
    return filtered


def peer(motion, truth, rate):
    """The Butterworth filter with the cut-off that comes nearest to the truth of this clip."""
    best = None
    for cut_off in CUT_OFFS[CUT_OFFS < 0.45 * rate]:
        places = butterworth(motion, cut_off).positions()
        error = acceleration_error(places, truth, rate)
        if best is None or error < best[0]:
            best = error, places, cut_off
    return best


def peaks(places, truth, rate):
    """The speed at the fastest hundredth of the true motion's moments, as a fraction of the true speed."""
    speeds = [np.linalg.norm(p[2:] - p[:-2], axis=-1) * rate / 2 for p in (truth, places)]
    fastest = speeds[0] >= np.percentile(speeds[0], 99)
    return speeds[1][fastest].mean() / speeds[0][fastest].mean()


def over_ground(places, feet, rate):
    return np.linalg.norm(np.diff(places[:, feet][..., [0, 2]], axis=0), axis=-1) * rate


def standing(truth, feet, rate):
    """Where the true motion stands on a point of its feet: the frames after the first, and the points."""
    heights = truth[1:, feet, 1]
    return (over_ground(truth, feet, rate) < 8) & (heights < np.percentile(heights, 5, axis=0) + 3)


def off_level(places, truth, feet, rate):
    """The distance in cm of the balls of the feet from their mean height while the true motion stands on them."""
    stands = standing(truth, feet, rate)
    heights = [places[1:, feet[k], 1][stands[:, k]] for k in (2, 3)]
    off = np.concatenate([abs(own - own.mean()) for own in heights if len(own)] or [[]])
    return off.mean() if len(off) else np.nan


def skate(places, truth, feet, rate):
    """The mean speed over the ground, in cm/s, of the slower of ankle and ball while the true motion stands on them."""
    stands, speeds = standing(truth, feet, rate), over_ground(places, feet, rate)
    slide = []
    for side in (0, 1):
        both = [side, side + 2]
        at = stands[:, both].any(axis=1)
        slide.append(np.where(stands[:, both], speeds[:, both], np.inf).min(axis=1)[at])
    slide = np.concatenate(slide)
    return slide.mean() if len(slide) else np.nan


def hands(places, truth, names, sides):
    """The error in cm of one hand's position relative to the other where they meet, and their distance as a fraction of
    the true distance."""
    wrists = [next((i for i, name in enumerate(names) if name in (side + "Hand", side + "Wrist")), None) for side in sides]
    if None in wrists:
        return np.nan, np.nan
    apart = [p[:, wrists[0]] - p[:, wrists[1]] for p in (places, truth)]
    near = np.linalg.norm(apart[1], axis=-1) < MEET
    if near.sum() < 5:
        return np.nan, np.nan
    off = np.linalg.norm(apart[0] - apart[1], axis=-1)[near].mean()
    return off, np.linalg.norm(apart[0], axis=-1)[near].mean() / np.linalg.norm(apart[1], axis=-1)[near].mean()


def tilt(places, truth):
    """The angle in degrees between the up axes of two motions after alignment, and the difference of their heights in
    cm."""
    a, b = (p.reshape(-1, 3) - p.reshape(-1, 3).mean(axis=0) for p in (places, truth))
    turn, _ = Rotation.align_vectors(b, a)
    up = turn.apply([0, 1, 0])
    return np.degrees(np.arccos(np.clip(up[1], -1, 1)))


def spread(truth, source):
    """The spread of the feet on the ground in cm, as the standard deviation in the narrowest direction of the points
    where the true motion stands. A slope shows only over this spread."""
    places = truth.positions()
    feet = [truth.names.index(name) for name in source["ankles"]]
    speeds = np.linalg.norm(np.diff(places[:, feet], axis=0), axis=-1) * truth.rate
    low = places[1:, feet, 1] < np.percentile(places[:, feet, 1], 5, axis=0) + 3
    stands = places[1:, feet][low & (speeds < 20)][:, [0, 2]]
    return np.sqrt(np.linalg.eigvalsh(np.cov(stands.T))[0]) if len(stands) > 2 else 0.0


def measures(motion, truth, source, wrong, shown):
    """The remaining defects. Lengths are in cm."""
    frames = min(len(motion.root), len(truth.root))
    places, true = motion.positions()[:frames], truth.positions()[:frames]
    feet = [truth.names.index(name) for name in source["ankles"] + source["balls"]]
    relative = Rotation.from_quat(motion.turns[:frames].reshape(-1, 4)).inv() * Rotation.from_quat(
        truth.turns[:frames].reshape(-1, 4)
    )
    off = np.degrees(relative.magnitude()).reshape(frames, -1)
    stands = true[:, feet, 1] < np.percentile(true[:, feet, 1], 5, axis=0) + 2
    heights = (places - true)[:, feet, 1][stands]
    meet = hands(places, true, truth.names, source.get("sides", plant.SIDES))
    return {
        "hands": meet[0],
        "hands apart": meet[1],
        "own skate": skate(true, true, feet, truth.rate),
        "level": off_level(places, true, feet, truth.rate),
        "own level": off_level(true, true, feet, truth.rate),
        "root": np.linalg.norm((places - true)[:, 0], axis=-1).mean(),
        "joint": np.linalg.norm(places - true, axis=-1).mean(),
        "largest": np.linalg.norm(places - true, axis=-1).max(),
        "acceleration": acceleration_error(places, true, truth.rate),
        "peaks": peaks(places, true, truth.rate),
        "skate": skate(places, true, feet, truth.rate),
        "tilt": tilt(places, true),
        "height": abs(heights.mean()),
        "flipped": float((off[wrong[:frames]] < 20).mean()) if wrong.any() else np.nan,
        "frames": abs(len(motion.root) - len(truth.root)),
    }


def rate(program, folder, index, source, clean, seed):
    """The reported rate of a motion whose file states a wrong rate, or repeats frames."""
    random = np.random.default_rng([seed, index, 7])
    motion, true, kind = clean.copy(), clean.rate, RATES[(index + 2 * (index // 7)) % len(RATES)]
    plant.add_noise(motion, random)
    if kind == "repeated":
        true = plant.repeat(motion, random)
    motion.rate *= {"half": 0.5, "twice": 2.0}.get(kind, 1.0)
    noisy, out = folder / f"rate_{index}.bvh", folder / f"rate_{index}_out.bvh"
    bvh.write(noisy, motion)
    report = out.with_suffix(".json")
    run = subprocess.run([program, "clean", noisy, "-o", out, "--force", "--report", report, "--only", "time"], capture_output=True, text=True)
    if run.returncode != 0:
        raise SystemExit(f"{noisy}: {run.stderr}")
    off = bvh.read(out).rate / true
    doubts = json.loads(report.read_text())["changed"]["doubts"]
    return {"file": source["file"], "rate": clean.rate, "kind": "rate", "index": index, "spoiled": kind, "off": off, "doubts": doubts}


def one(task):
    program, folder, index, source, clean, seed, kind, arguments = task
    if kind == "rate":
        return rate(program, folder, index, source, clean, seed)
    motion, wrong, shown = plant.spoil(clean, source, np.random.default_rng([seed, index]), SETS[kind])
    noisy, out = folder / f"{kind}_{index}.bvh", folder / f"{kind}_{index}_out.bvh"
    bvh.write(noisy, motion)
    motion = bvh.read(noisy)
    run = subprocess.run(
        [program, "clean", noisy, "-o", out, "--force", "--report", out.with_suffix(".json"), *arguments],
        capture_output=True,
        text=True,
    )
    if run.returncode != 0:
        raise SystemExit(f"{noisy}: {run.stderr}")
    cleaned = bvh.read(out)
    order = [cleaned.names.index(name) for name in motion.names]
    cleaned.names, cleaned.turns = motion.names, cleaned.turns[:, order]
    cleaned.parents, cleaned.offsets = motion.parents, clean.offsets
    before = measures(motion, clean, source, wrong, shown)
    after = measures(cleaned, clean, source, wrong, shown)
    result = {"file": source["file"], "rate": clean.rate, "kind": kind, "index": index, "before": before, "after": after,
              "spread": spread(clean, source)}
    if kind == "noise":
        truth = clean.positions()
        error, places, cut_off = peer(motion, truth, clean.rate)
        result["peer"] = {"acceleration": error, "cut_off": cut_off, "peaks": peaks(places, truth, clean.rate),
                          "joint": np.linalg.norm(places - truth, axis=-1).mean()}
    return result


def table(results):
    """The rows of the table: targets and measured values."""
    by = {kind: [r for r in results if r["kind"] == kind] for kind in SETS}

    def ratio(kind, key, of="before"):
        return np.array([r["after"][key] / r[of][key] for r in by[kind]])

    def after(kind, key):
        return np.array([r["after"][key] for r in by[kind]])

    rows = []

    def row(name, values, wanted, is_good):
        values = values[np.isfinite(values)]
        if len(values):
            good = is_good(values).mean()
            rows.append((name, wanted, np.mean(values), np.median(values), np.percentile(values, 90), good, len(values)))

    for kind in ("noise", "all"):
        row(f"{kind}: acceleration error / spoiled", ratio(kind, "acceleration"), "0.35", lambda v: v <= 0.35)
        if kind == "noise":
            row("noise: acceleration error / best Butterworth", ratio(kind, "acceleration", "peer"), "0.8", lambda v: v <= 0.8)
            row("noise: joint error / best Butterworth", ratio(kind, "joint", "peer"), "", lambda v: v <= 1)
        row(f"{kind}: joint error / spoiled", ratio(kind, "joint"), "0.6", lambda v: v <= 0.6)
        row(f"{kind}: peak speed / true", after(kind, "peaks"), "0.95..1.05", lambda v: abs(v - 1) <= 0.05)
    row("noise: peak speed of best Butterworth / true", np.array([r["peer"]["peaks"] for r in by["noise"]]), "", lambda v: abs(v - 1) <= 0.05)
    for kind in ("flips", "all"):
        row(f"{kind}: flipped rotations mended", after(kind, "flipped"), "0.98", lambda v: v >= 0.98)
    row("skate of the truth cm/s", np.array([r["after"]["own skate"] for r in by["noise"]]), "", lambda v: v <= 0.5)
    for kind in ("noise", "floor", "all"):
        row(f"{kind}: skate cm/s", after(kind, "skate"), "0.5", lambda v: v <= 0.5)
    row("all: skate before cm/s", np.array([r["before"]["skate"] for r in by["all"]]), "", lambda v: v <= 0.5)
    row("off level of the truth cm", np.array([r["after"]["own level"] for r in by["noise"]]), "", lambda v: v <= 1)
    for kind in ("noise", "floor", "all"):
        row(f"{kind}: feet in contact off level cm", after(kind, "level"), "1", lambda v: v <= 1)
    row("all: off level before cm", np.array([r["before"]["level"] for r in by["all"]]), "", lambda v: v <= 1)
    for kind in ("floor", "all"):
        row(f"{kind}: slope degrees", after(kind, "tilt"), "0.3", lambda v: v <= 0.3)
        wide = np.array([r["spread"] >= WIDE for r in by[kind]], dtype=bool)
        row(f"{kind}: slope degrees, feet wide apart", after(kind, "tilt")[wide], "0.3", lambda v: v <= 0.3)
        row(f"{kind}: height cm", after(kind, "height"), "1", lambda v: v <= 1)
    for kind in ("time", "all"):
        row(f"{kind}: frames too many or few", after(kind, "frames"), "0", lambda v: v == 0)
    row("time: joint error / spoiled", ratio("time", "joint"), "0.6", lambda v: v <= 0.6)
    row("hands: one off from the other / spoiled", ratio("hands", "hands"), "0.6", lambda v: v <= 0.6)
    row("hands: distance / true", after("hands", "hands apart"), "0.95..1.05", lambda v: abs(v - 1) <= 0.05)
    row("depth: root error / spoiled", ratio("depth", "root"), "0.5", lambda v: v <= 0.5)
    row("depth: joint error / spoiled", ratio("depth", "joint"), "0.6", lambda v: v <= 0.6)
    row("depth: skate cm/s", after("depth", "skate"), "0.5", lambda v: v <= 0.5)
    of_rate = {kind: [r for r in by["rate"] if r["spoiled"] == kind] for kind in RATES}
    right = {kind: np.array([abs(r["off"] - 1) < 0.01 for r in of_rate[kind]], dtype=float) for kind in RATES}
    wrong = [r for kind in ("half", "twice") for r in of_rate[kind]]
    row("rate: repeated frames found", right["repeated"], "1", lambda v: v == 1)
    row("rate: wrong rates corrected", np.concatenate([right["half"], right["twice"]]), "", lambda v: v == 1)
    row("rate: wrong rates corrected or pointed out", np.array([abs(r["off"] - 1) < 0.01 or bool(r["doubts"]) for r in wrong], dtype=float), "1", lambda v: v == 1)
    row("rate: true rates changed", 1 - right["true"], "0", lambda v: v == 0)
    row("rate: true rates pointed out", np.array([bool(r["doubts"]) for r in of_rate["true"]], dtype=float), "0", lambda v: v == 0)
    row("clean: largest change mm", 10 * after("clean", "largest"), "1", lambda v: v <= 1)
    return rows


def markdown(rows):
    """The table of the README."""
    lines = ["| measure | wanted | mean | median | 90 % | reached | clips |", "|---|---|---|---|---|---|---|"]
    for name, wanted, mean, median, most, good, count in rows:
        reached = f"{good:.0%}" if wanted else ""
        lines.append(f"| {name} | {wanted} | {mean:.3f} | {median:.3f} | {most:.3f} | {reached} | {count} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sets", default=",".join(SETS))
    parser.add_argument("--arguments", default="")
    parser.add_argument("--keep")
    parser.add_argument("--json")
    parser.add_argument("--table", action="store_true", help="also print the table of the README")
    parser.add_argument("--hold", action="store_true", help="exit with 1 where a mean is worse than HELD")
    args = parser.parse_args()
    folder = Path(args.keep or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    tasks = [
        (os.path.abspath(args.program), folder, index, source, clean, args.seed, kind, args.arguments.split())
        for index, (source, clean, _) in enumerate(plant.clips(args.folders, args.count, args.seed))
        for kind in args.sets.split(",")
        if kind != "hands"
    ]
    if "hands" in args.sets.split(","):
        for index, (source, clean, _) in enumerate(plant.clips(args.folders, HANDS, args.seed, "hands")):
            tasks.append((os.path.abspath(args.program), folder, index, source, clean, args.seed, "hands", args.arguments.split()))
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(one, tasks))
    if args.json:
        Path(args.json).write_text(json.dumps(results, indent=1))
    print(f"{'measure':<46}{'wanted':>11}{'mean':>9}{'median':>9}{'90 %':>9}{'reached':>9}{'clips':>7}")
    for name, wanted, mean, median, most, good, count in table(results):
        print(f"{name:<46}{wanted:>11}{mean:>9.3f}{median:>9.3f}{most:>9.3f}{good:>9.0%}{count:>7}")
    if args.table:
        print(markdown(table(results)))
    worse = [row[0] for row in table(results) if row[2] > HELD.get(row[0], np.inf)]
    if args.hold and worse:
        raise SystemExit("worse than what is held: " + ", ".join(worse))


if __name__ == "__main__":
    main()
