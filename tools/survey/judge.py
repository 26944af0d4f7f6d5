"""Judges `mocap survey` by artificial defects at known places in clean clips, and by artificial twins
(near-duplicates).

    judge.py MOCAP [--defects N] [--twins N] [--seed S] [--keep FOLDER]

Prints for each kind: recall above its stated smallest amount, and the distance of the found frames from the planted
frames. Also prints false alarms on the clean clips, and recall and precision of twins.
"""

import argparse
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

import numpy as np

import opinions
from plant import HAS_PLACE, KINDS, OVERLAPS, TWINS, Body, Bvh, Planted

FIXTURES = pathlib.Path(__file__).resolve().parents[2] / "fixtures"
# Clips that a person checked: people on a flat floor, with their feet on it, and without any of the planted defects.
# For each: the metres per unit of the file, and the used frames.
CLEAN = {
    "real/cmu_12_01_walk.bvh": (0.0564444, 1, 524),
    "real/motionbuilder_vicon_walk.bvh": (0.0254, 0, None),
    # After frame 2,000, the standing right foot slides by 6.4 cm.
    "real/cmu_01_01.bvh": (0.0564444, 1, 2000),
    "skeletons/bvhtoolbox_walk01.bvh": (0.01, 0, None),
    "skeletons/accad_run_turn.bvh": (0.01, 0, None),
    "skeletons/vicon_sword_attack.bvh": (0.01, 0, None),
}
# Clips from which twins are made; they need not be clean.
BASES = [
    "real/cmu_12_01_walk.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/cmu_01_01.bvh",
    "real/cmu_salsa_poser_names.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/rokoko_dance.bvh",
    "real/z_up_dab.bvh",
    "real/slimevr_headset_root.bvh",
    "skeletons/bvhtoolbox_walk01.bvh",
    "skeletons/accad_run_turn.bvh",
    "skeletons/animics_all_along_z.bvh",
]
# The targets: recall of each kind, false alarms on clean clips, frames of a place, recall and precision of twins.
RECALL, FALSE_ALARMS, PLACE, TWIN_RECALL, TWIN_PRECISION = 0.95, 0.02, 2, 0.98, 0.99
# The largest difference from a second opinion, and the largest ratio of the distance to a chosen clip to NumPy's
# distance.
OPINION, CHOICE = 0.01, 1.05
# The length of a cut of a clean clip, in seconds.
CUTS = (2.5, 6.0)


def survey(mocap, folder, *options):
    out = folder.with_suffix(".jsonl")
    run = subprocess.run([mocap, "survey", folder, "-o", out, "-q", *options], capture_output=True, text=True)
    if run.returncode not in (0, 3):
        sys.exit(run.stderr)
    rows = [json.loads(line) for line in out.read_text().splitlines()]
    return {pathlib.Path(row["file"]).name: row for row in rows}


def cut(rng, bvh, first, last, seconds, low=None):
    """A part of a clip with a random start; with `low`, a part that begins and ends with a foot on the floor."""
    clip = bvh.copy()
    rows = bvh.rows[first:last]
    frames = min(len(rows), round(seconds / bvh.frame_time))
    for _ in range(50):
        start = rng.randrange(len(rows) - frames + 1)
        clip.rows = rows[start : start + frames].copy()
        if low is None or max(low[first + start], low[first + start + frames - 1]) < 0.06:
            return clip
    return clip


def lowest_toes(bvh, metres):
    """The height of the lower toe in each frame above its usual height, in metres."""
    body = Body(bvh, metres)
    heights = body.places[:, body.toes(), 1].min(axis=1)
    return heights - np.percentile(heights, 10)


def defects(mocap, rng, folder, count, sample):
    """Plants defects, and prints a row for each kind. Returns the missed targets."""
    clips = {name: Bvh((FIXTURES / name).read_text()) for name in CLEAN}
    low = {name: lowest_toes(clips[name], CLEAN[name][0]) for name in CLEAN}
    folder.mkdir()
    truth, number = {}, 0
    kinds = list(KINDS)
    # The planted defects of a kind do not depend on the other kinds.
    seed = rng.random()
    own = {kind: random.Random(f"{seed} {kind}") for kind in kinds}
    tries = 0
    while number < count:
        tries += 1
        if tries > 20 * count:
            sys.exit(f"only {number} of {count} defects can be planted")
        kind = kinds[number % len(kinds)]
        chance = own[kind]
        name = chance.choice(list(CLEAN))
        metres, first, last = CLEAN[name]
        clip = cut(chance, clips[name], first, last, chance.uniform(*CUTS), low[name])
        try:
            frames, amount = KINDS[kind](chance, clip, metres)
        except Planted:
            continue
        file = f"{number:05}_{kind}.bvh"
        (folder / file).write_text(clip.text())
        truth[file] = (kind, frames, amount, name)
        number += 1
    clean = 0
    for name in CLEAN:
        metres, first, last = CLEAN[name]
        for _ in range(max(4, count // 40)):
            clip = cut(rng, clips[name], first, last, rng.uniform(*CUTS), low[name])
            (folder / f"clean{clean:04}_{pathlib.Path(name).stem}.bvh").write_text(clip.text())
            clean += 1
    rows = survey(mocap, folder)
    failures = []
    print(f"{'kind':16}{'planted':>8}{'recall':>8}{'place':>8}")
    for kind in kinds:
        planted = {file: t for file, t in truth.items() if t[0] == kind}
        found = sum(is_found(rows[file], *t[:2]) for file, t in planted.items())
        places = [place(rows[file], kind, t[1]) for file, t in planted.items() if is_found(rows[file], *t[:2])]
        near = np.mean([p <= PLACE for p in places]) if kind in HAS_PLACE and places else math.nan
        recall = found / len(planted) if planted else math.nan
        print(f"{kind:16}{len(planted):8}{recall:8.3f}{near:8.3f}")
        # In a sample, the survey may miss one defect of each kind.
        if recall < RECALL and (not sample or found < len(planted) - 1):
            failures.append(f"{kind}: recall {recall:.3f}")
            missed = [f"{file} {t[1:]}" for file, t in planted.items() if not is_found(rows[file], *t[:2])]
            print("    missed:", "; ".join(missed[:4]))
        if near < RECALL and not sample:
            failures.append(f"{kind}: within {PLACE} frames {near:.3f}")
    alarms = {file: row["reasons"] for file, row in rows.items() if file.startswith("clean") and row["verdict"] != "good"}
    fraction = len(alarms) / clean
    print(f"false alarms: {len(alarms)} of {clean} clean clips, {100 * fraction:.1f} %")
    for file, reasons in list(alarms.items())[:8]:
        print("   ", file, reasons)
    if fraction > (0.1 if sample else FALSE_ALARMS):
        failures.append(f"false alarms {fraction:.3f}")
    return failures + second_opinions(mocap, folder, rows, truth)


def second_opinions(mocap, folder, rows, truth):
    """Compares measures and selections with NumPy and SciPy."""
    noisy = [file for file, planted in truth.items() if planted[0] == "noise"][:12]
    clips = {file: ((folder / file).read_text(), CLEAN[truth[file][3]][0]) for file in noisy}
    failures = []
    for kind, off in opinions.compare(rows, clips).items():
        print(f"{kind} beside NumPy and SciPy: {100 * off:.3f} % off at most in {len(clips)} clips")
        if off > OPINION:
            failures.append(f"{kind}: {off:.4f} from the second opinion")
    ratio = opinions.choice(mocap, folder.with_suffix(".jsonl"), max(2, len(rows) // 33))
    print(f"chosen clips: largest distance {ratio:.4f} of that of NumPy's farthest points")
    if ratio > CHOICE:
        failures.append(f"chosen clips: {ratio:.4f} of NumPy's")
    return failures


# A flip of a finger, and a sunk foot while the other foot stands, are separate kinds.
ALSO = {"flip": ["finger-flip"], "under-floor": ["foot-through-floor"]}


def is_found(row, kind, frames):
    kinds = [kind, *ALSO.get(kind, [])]
    found = [d["frames"] for d in row["defects"] if d["kind"] in kinds]
    if kind in HAS_PLACE:
        return any(a <= frames[1] and b >= frames[0] for a, b in found)
    if kind in OVERLAPS:
        covered = set()
        for a, b in found:
            covered.update(range(a, b + 1))
        inside = sum(frame in covered for frame in range(frames[0], frames[1] + 1))
        return inside >= 0.5 * (frames[1] - frames[0] + 1)
    return bool(found)


def place(row, kind, frames):
    found = [d["frames"] for d in row["defects"] if d["kind"] in [kind, *ALSO.get(kind, [])]]
    return min(max(abs(a - frames[0]), abs(b - frames[1])) for a, b in found)


def twins(mocap, rng, folder, count, sample):
    """Plants twins of parts of real clips, and compares the found pairs with the planted pairs."""
    folder.mkdir()
    family, kinds, number = {}, list(TWINS), 0
    bases = []
    for name in BASES:
        text = (FIXTURES / name).read_text()
        bvh = Bvh(text)
        frames = round(4.0 / bvh.frame_time)
        first = 1
        while first + frames <= len(bvh.rows) or first == 1:
            base = bvh.copy()
            base.rows = bvh.rows[first : first + frames].copy()
            first += frames
            file = f"base{len(bases):03}.bvh"
            # A still clip has no twins.
            if np.abs(np.diff(base.rows[:, 3:], axis=0)).max(axis=1).sum() > 100:
                (folder / file).write_text(base.text())
                family[file] = len(bases)
                bases.append(base)
    reasons = {}
    tries = 0
    while number < count:
        tries += 1
        if tries > 20 * count:
            sys.exit(f"only {number} of {count} twins can be planted")
        kind, index = kinds[number % len(kinds)], rng.randrange(len(bases))
        clip = bases[index].copy()
        try:
            TWINS[kind](rng, clip)
        except Planted:
            continue
        file = f"twin{number:05}_{kind}.bvh"
        (folder / file).write_text(clip.text())
        family[file] = index
        reasons[file] = kind
        number += 1
    rows = survey(mocap, folder)
    groups = {}
    for file, row in rows.items():
        if row["twin_group"] is not None:
            groups.setdefault(row["twin_group"], set()).add(file)
    base_of = {index: file for file, index in family.items() if file.startswith("base")}
    failures, found_of, total = [], {}, {}
    for file, kind in reasons.items():
        group = rows[file]["twin_group"]
        total[kind] = total.get(kind, 0) + 1
        is_twin = group is not None and group == rows[base_of[family[file]]]["twin_group"]
        found_of[kind] = found_of.get(kind, 0) + is_twin
    wrong = right = 0
    for file, row in rows.items():
        if row["twin"]:
            kept = pathlib.Path(row["twin_of"]).name
            right += family[kept] == family[file]
            if family[kept] != family[file]:
                wrong += 1
                if wrong <= 5:
                    print("    wrong:", file, "of", kept, row["twin_reason"])
    for kind in kinds:
        print(f"{kind:16}{total.get(kind, 0):8}{found_of.get(kind, 0) / max(1, total.get(kind, 0)):8.3f}")
    recall, precision = sum(found_of.values()) / sum(total.values()), right / max(1, right + wrong)
    print(f"twins of {len(bases)} clips: recall {recall:.4f}, precision {precision:.4f}")
    if recall < (0.9 if sample else TWIN_RECALL):
        failures.append(f"twins: recall {recall:.4f}")
    if precision < TWIN_PRECISION:
        failures.append(f"twins: precision {precision:.4f}")
    return failures


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("--defects", type=int, default=2000)
    parser.add_argument("--twins", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sample", action="store_true", help="one miss of each kind is allowed")
    parser.add_argument("--keep", type=pathlib.Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.keep or pathlib.Path(temporary)
        folder.mkdir(exist_ok=True)
        failures = []
        if args.defects:
            failures += defects(args.mocap, random.Random(args.seed), folder / "defects", args.defects, args.sample)
        if args.twins:
            failures += twins(args.mocap, random.Random(args.seed), folder / "twins", args.twins, args.sample)
    for failure in failures:
        print("not as asked:", failure)
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
