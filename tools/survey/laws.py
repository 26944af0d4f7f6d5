"""Counts the verdicts of `mocap survey` that change after a harmless change of the clip.

    laws.py MOCAP FOLDER... [--law NAME...] [--list]

FOLDER has the clips of `labels.tsv`, at any depth; each law changes each readable BVH file. If mocap has a step for a
law, or a format such as GLB, mocap makes the change; `plant.py` makes all other changes in the text of the file. The
script prints a table: for each law, how many clips keep their verdict, and how many change between good and bad. Three
kinds are disabled: values that are no numbers and missing frames, because a changed copy of the file lacks them, and
frozen frames, because a law adds them. Files of poses are omitted, because a held pose is no motion.
"""

import argparse
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import plant
from labels import labels

# The seconds of a T-pose before a clip, of a held last frame, and of a frozen frame within the clip.
T_POSE, HELD, FROZEN = 0.5, 1.0, 1.0
# The disabled kinds.
OFF = ["not-finite", "cut-off", "frozen"]
# The rotation about the vertical in degrees, and the displacement of a clip in sizes of its skeleton.
TURN, SHIFT = 37.0, 3.0


def vertical(row):
    return "xyz".index(row["up"][-1])


def size(bvh):
    return sum(np.linalg.norm(offset) for offset in bvh.offsets[1:])


def columns_of_place(bvh):
    columns = {c[0].lower(): bvh.first[0] + i for i, c in enumerate(bvh.channels[0]) if c.lower().endswith("position")}
    if sorted(columns) != ["x", "y", "z"] or len(bvh.channels[0]) < 6 or bvh.parents.count(-1) != 1:
        raise plant.Planted
    return [columns[axis] for axis in "xyz"]


def rotated(bvh, row):
    places = columns_of_place(bvh)
    if np.abs(bvh.offsets[0]).max() > 0:
        raise plant.Planted
    turn = plant.rotation_about(np.eye(3)[vertical(row)], math.radians(TURN))
    _, turns = bvh.world()
    bvh.rows[:, places] = bvh.rows[:, places] @ turn.T
    for frame in range(len(bvh.rows)):
        bvh.set_local(0, frame, turn @ turns[frame, 0])


def shifted(bvh, row):
    for axis, column in enumerate(columns_of_place(bvh)):
        if axis != vertical(row):
            bvh.rows[:, column] += SHIFT * size(bvh) * (1 if axis == 0 else -0.5)


def in_unit(bvh, row):
    """Converts a clip to centimetres, or to metres if it is in centimetres."""
    metres = row["metres_per_unit"]
    plant.scaled(bvh, 0.01 if metres == 0.01 else metres / 0.01)


def held_end(bvh, row):
    frames = max(1, round(HELD / bvh.frame_time))
    bvh.rows = np.concatenate([bvh.rows, np.repeat(bvh.rows[-1:], frames, axis=0)])


def frozen(bvh, row):
    frames, at = max(1, round(FROZEN / bvh.frame_time)), len(bvh.rows) // 2
    bvh.rows = np.insert(bvh.rows, at, np.repeat(bvh.rows[at : at + 1], frames, axis=0), axis=0)


def leading_t_pose(bvh, row):
    """The rest pose at the position of the first frame: a T-pose for most skeletons; the caller omits the others."""
    places = columns_of_place(bvh)
    row = np.zeros(bvh.rows.shape[1])
    for joint in range(1, len(bvh.names)):
        for column, channel in zip(bvh.columns(joint, "position"), "xyz"):
            row[column] = bvh.offsets[joint]["xyz".index(channel)]
    row[places] = bvh.rows[0, places]
    frames = max(1, round(T_POSE / bvh.frame_time))
    bvh.rows = np.concatenate([np.repeat(row[None], frames, axis=0), bvh.rows])


BY_TEXT = {
    "rotation": rotated,
    "shift": shifted,
    "unit": in_unit,
    "leading T-pose": leading_t_pose,
    "held last frame": held_end,
    "frozen frames": frozen,
}
BY_MOCAP = {
    "mirror": ["edit", "--step", "mirror", "--to", "bvh"],
    "reversal": ["edit", "--step", "reverse", "--to", "bvh"],
    "GLB": ["convert", "--to", "glb"],
    "FBX": ["convert", "--to", "fbx"],
    "120 to 30 fps": ["convert", "--fps", "30", "--to", "bvh"],
}


def survey(mocap, folder, out):
    off = [option for kind in OFF for option in ("--threshold", f"{kind}=inf")]
    run = subprocess.run([mocap, "survey", folder, "-o", out, "-q", *off], capture_output=True, text=True)
    if run.returncode not in (0, 3):
        sys.exit(run.stderr)
    rows = map(json.loads, out.read_text().splitlines())
    return {pathlib.Path(row["file"]).stem: row for row in rows if row["verdict"] != "unreadable"}


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("mocap")
    arguments.add_argument("folders", nargs="+")
    arguments.add_argument("--law", action="append", help="only this one")
    arguments.add_argument("--list", action="store_true", help="name the clips whose verdict changes")
    options = arguments.parse_args()
    known = labels("all")
    with tempfile.TemporaryDirectory() as temporary:
        root = pathlib.Path(temporary)
        own = root / "own"
        own.mkdir()
        for folder in options.folders:
            for path in pathlib.Path(folder).rglob("*.bvh"):
                data = path.read_bytes()
                digest = hashlib.sha256(data).hexdigest()[:16]
                if known.pop(digest, None):
                    (own / f"{digest}.bvh").write_bytes(data)
        before = survey(options.mocap, own, root / "own.jsonl")
        before = {stem: row for stem, row in before.items() if "pose-file" not in row["properties"]}
        print("| law | clips | same verdict | good to bad, or bad to good |\n|---|---|---|---|")
        for law in options.law or sorted([*BY_TEXT, *BY_MOCAP], key=str.lower):
            changed = root / "changed"
            changed.mkdir()
            if law in BY_MOCAP:
                names = [stem for stem, row in before.items() if law != "120 to 30 fps" or (row["rate"] or 0) > 100]
                files = [own / f"{stem}.bvh" for stem in names]
                command, *rest = BY_MOCAP[law]
                subprocess.run([options.mocap, command, *files, "-o", f"{changed}/", *rest, "-q"], capture_output=True)
            else:
                for stem, row in before.items():
                    if law == "leading T-pose" and row["rest_pose"] != "t-pose":
                        continue
                    try:
                        bvh = plant.Bvh((own / f"{stem}.bvh").read_text(errors="replace"))
                        BY_TEXT[law](bvh, row)
                    except (plant.Planted, ValueError, IndexError, TypeError):
                        continue
                    (changed / f"{stem}.bvh").write_text(bvh.text())
            (root / "changed.jsonl").unlink(missing_ok=True)
            after = survey(options.mocap, changed, root / "changed.jsonl")
            pairs = [(before[stem], row) for stem, row in after.items() if stem in before]
            same = sum(one["verdict"] == other["verdict"] for one, other in pairs)
            far = sum({one["verdict"], other["verdict"]} == {"good", "bad"} for one, other in pairs)
            print(f"| {law} | {len(pairs)} | {100 * same / max(1, len(pairs)):.1f} % | {far} |")
            if options.list:
                for one, other in pairs:
                    if one["verdict"] != other["verdict"]:
                        said = [f"{row['verdict']} ({row['reasons']})" for row in (one, other)]
                        print("   ", pathlib.Path(one["file"]).stem, " -> ".join(said), file=sys.stderr)
            for path in sorted(changed.rglob("*"), reverse=True):
                path.rmdir() if path.is_dir() else path.unlink()
            changed.rmdir()


if __name__ == "__main__":
    main()
