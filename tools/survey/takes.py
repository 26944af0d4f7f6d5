"""Measures recall and precision of near-duplicates on a folder of takes: each BVH file is a take, and the script adds
variants of it.

    takes.py MOCAP FOLDER [--variants N] [--seconds S] [--seed S] [--keep FOLDER]

A variant is found if `mocap survey` has it in the group of its take. A group that joins files of two takes is wrong.
Takes differ if CMU's numbers differ (`16_02`). Without such numbers, takes differ if the file names differ and neither
name ends with the other, because folders have copies with a word before the name. Precision is the fraction of
near-duplicates whose kept clip is of the same take.
"""

import argparse
import pathlib
import random
import re
import sys
import tempfile

import numpy as np

from judge import survey
from plant import TWINS, Bvh, Planted

# The least content of a variant for recognition: seconds, and degrees of all channels together.
LEAST_SECONDS, LEAST_DEGREES = 2.5, 300
# Longer takes are cut, so that a folder takes minutes; with --seconds, to their middle.
MOST_SECONDS = 20
# The targets.
RECALL, PRECISION = 0.95, 0.99


def take(path):
    """The name of a file's take: CMU's number, else the name of the file."""
    number = re.search(r"(?<!\d)(\d{2,3})_(\d{2})(?!\d)", path.stem)
    return f"CMU {int(number[1])}_{number[2]}" if number else path.stem


def are_one(a, b):
    """Whether two names belong to one take."""
    return a.endswith(b) or b.endswith(a)


def read(path, seconds):
    """The cut take; `None` if the file is no plain BVH file, or is too short or too still for recognition."""
    try:
        bvh = Bvh(path.read_text())
    except (ValueError, IndexError, TypeError, UnicodeDecodeError):
        return None
    if bvh.rows.ndim != 2 or not 0 < bvh.frame_time < 0.2:
        return None
    frames = round((seconds or MOST_SECONDS) / bvh.frame_time)
    first = max(0, len(bvh.rows) - frames) // 2 if seconds else 0
    bvh.rows = bvh.rows[first : first + frames]
    return bvh if is_enough(bvh, min(seconds or LEAST_SECONDS, LEAST_SECONDS)) else None


def is_enough(bvh, seconds):
    """Whether a clip has this number of seconds, and moves enough for recognition."""
    moves = np.abs(np.diff(bvh.rows[:, 3:], axis=0)).max(axis=1, initial=0).sum()
    # A clip that may be shorter may move less.
    least = LEAST_DEGREES * min(1, (seconds or len(bvh.rows) * bvh.frame_time) / LEAST_SECONDS)
    return len(bvh.rows) * bvh.frame_time >= 0.99 * seconds and not moves < least


def plant(rng, paths, count, seconds, folder):
    """Writes takes and variants. Returns the take and the kind of each file, and the file of each take's first clip."""
    bases = [(take(path), bvh) for path in paths if (bvh := read(path, seconds)) is not None]
    if not bases:
        sys.exit("no file of the folder is long enough and moves enough")
    truth = {}
    for index, (name, bvh) in enumerate(bases):
        file = f"{index:04}_take.bvh"
        (folder / file).write_text(bvh.text())
        truth[file] = (name, None, file)
    kinds = list(TWINS)
    for number in range(count):
        kind = kinds[number % len(kinds)]
        for _ in range(50):
            index = rng.randrange(len(bases))
            clip = bases[index][1].copy()
            try:
                TWINS[kind](rng, clip)
            except (Planted, IndexError, KeyError, ValueError):
                continue
            if not is_enough(clip, 0.0):
                continue
            file = f"{index:04}_variant{number:05}_{kind}.bvh"
            (folder / file).write_text(clip.text())
            truth[file] = (bases[index][0], kind, f"{index:04}_take.bvh")
            break
    return truth, len(bases)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--variants", type=int, default=500)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path)
    args = parser.parse_args()
    paths = sorted(args.folder.rglob("*.bvh"))
    with tempfile.TemporaryDirectory() as temporary:
        folder = (args.keep or pathlib.Path(temporary)) / "takes"
        folder.mkdir(parents=True, exist_ok=True)
        truth, takes = plant(random.Random(args.seed), paths, args.variants, args.seconds, folder)
        rows = survey(args.mocap, folder)
    missed, total, right, wrong = {}, {}, 0, 0
    for file, (name, kind, base) in truth.items():
        row = rows[file]
        if kind:
            total[kind] = total.get(kind, 0) + 1
            if row["twin_group"] is None or row["twin_group"] != rows[base]["twin_group"]:
                missed.setdefault(kind, []).append(file)
        if row["twin"]:
            other = truth[pathlib.Path(row["twin_of"]).name]
            if are_one(other[0], name):
                right += 1
                continue
            wrong += 1
            print(f"wrong: {file} {name!r} with {pathlib.Path(row['twin_of']).name} {other[0]!r}, {row['twin_reason']}")
    for kind, count in total.items():
        lost = missed.get(kind, [])
        print(f"{kind:20}{count:6}{1 - len(lost) / count:8.3f}  {' '.join(lost[:3])}")
    planted = sum(total.values())
    recall = 1 - sum(map(len, missed.values())) / max(1, planted)
    precision = right / max(1, right + wrong)
    print(f"{takes} takes, {planted} variants: recall {recall:.4f}, precision {precision:.4f}")
    sys.exit(recall < RECALL or precision < PRECISION)


if __name__ == "__main__":
    main()
