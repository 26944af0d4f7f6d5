"""Measures motions on robots in MuJoCo: the measures of `check.py`, jumps without a cause in the source, the
acceleration of joints, and velocities beyond the limits. Prints a row per clip, and the
worst values at the end.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/measure.py [--json FILE] [--against FILE] [--table] [-- OPTION...]

`--table` prints the rows as a Markdown table, with the time that the robot stands when track.py plays the motion.
Options after `--` go to `mocap robot`. `--against` names the JSON of another program, and adds the ratio of
accelerations and the difference of angles. A position beyond a limit is a failure. So is a motion with the verdict good
that exceeds a bound of GOOD."""

import argparse
import json
import os
import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from check import ROBOTS, ROOT, Judge, run, source_joints
from track import track, world

# A joint jumps if it moves farther than this in WINDOW seconds without a cause: a joint of the source's limb or trunk
# that turns by half of this angle.
JUMP, WINDOW = 0.5, 1 / 30
# The bounds of a motion with the verdict good.
GOOD = {"jumps": 0.0, "below": 0.01, "beyond_velocity": 0, "more_skate": 0.005, "collide": 0.03, "degrees": 8.0}
LIMBS = {
    "left arm": ["leftShoulder", "leftUpperArm", "leftLowerArm", "leftHand"],
    "right arm": ["rightShoulder", "rightUpperArm", "rightLowerArm", "rightHand"],
    "left leg": ["leftUpperLeg", "leftLowerLeg", "leftFoot"],
    "right leg": ["rightUpperLeg", "rightLowerLeg", "rightFoot"],
}
TRUNK = ["hips", "spine", "chest", "upperChest", "neck", "head"]


def limb_of(joint):
    side = "left" if joint.startswith("left") else "right" if joint.startswith("right") else None
    if side is None:
        return None
    return f"{side} {'leg' if any(word in joint for word in ('hip', 'knee', 'ankle')) else 'arm'}"


def source_rotations(folder, mocap, window):
    """The largest rotation of any joint in each limb of the source within a window of frames, in radians."""
    arrays = np.load(folder / "source.npz")
    names = list(arrays["names"])
    rotations = arrays["rotations"].astype(float)
    done, _ = run(mocap, "skeleton", folder / "source.glb", "--json")
    bones = json.loads(done.stdout)["humanoid"]["bones"]
    turned = {}
    for bone, joint in bones.items():
        if names.count(joint["joint"]) != 1:
            continue
        q = rotations[:, names.index(joint["joint"])]
        dot = np.abs((q[window:] * q[:-window]).sum(axis=1))
        turned[bone] = 2 * np.arccos(np.clip(dot, 0, 1))
    largest = lambda bones: np.max([turned[bone] for bone in bones if bone in turned] or [np.zeros(len(rotations) - window)], axis=0)
    trunk = largest(TRUNK)
    # Some devices swap the sides, so a limb of either side explains a jump.
    arms = largest(LIMBS["left arm"] + LIMBS["right arm"])
    legs = largest(LIMBS["left leg"] + LIMBS["right leg"])
    # A rotation of the whole body also turns the hips.
    return {"arm": np.maximum(arms, trunk), "leg": np.maximum(legs, trunk), None: trunk}


def jumps(written, turns, window):
    """The fraction of frames in which a joint jumps without a cause, and these joints."""
    positions, names = written["dof_pos"], [str(name) for name in written["dof_names"]]
    moved = np.abs(positions[window:] - positions[:-window])
    found = np.zeros(len(moved), bool)
    who = {}
    for index, name in enumerate(names):
        limb = limb_of(name)
        explained = turns[limb.split()[1] if limb else None]
        count = min(len(explained), len(moved))
        jumped = (moved[:count, index] > JUMP) & (explained[:count] < 0.5 * moved[:count, index])
        found[:count] |= jumped
        if jumped.any():
            who[name] = int(jumped.sum())
    return float(found.mean()) if len(found) else 0.0, who


def velocity_limits(urdf):
    limits = {}
    for joint in ET.parse(urdf).getroot().findall("joint"):
        limit = joint.find("limit")
        if limit is not None and limit.get("velocity"):
            limits[joint.get("name")] = float(limit.get("velocity"))
    return limits


def measured(judge, mocap, motion, folder, options, simulated=None):
    done, seconds = run(mocap, "robot", motion, "--robot", judge.urdf, "-o", folder / "a.npz", "--json", *options)
    if done.returncode:
        return None
    report = json.loads(done.stdout)
    written = np.load(folder / "a.npz")
    positions, fps = written["dof_pos"], float(written["fps"])
    if len(positions) < 12:
        return None
    root = np.concatenate([written["root_pos"], written["root_rot"][:, [3, 0, 1, 2]]], axis=1)
    places, rotations = judge.poses(np.concatenate([root, positions], axis=1))
    below, deepest, skate = judge.feet(places, rotations, written["contacts"], fps)
    angles = judge.limbs(rotations, source_joints(mocap, motion, folder))
    window = max(1, round(fps * WINDOW))
    share, who = jumps(written, source_rotations(folder, mocap, window), window)
    limits = velocity_limits(judge.urdf)
    speed = np.abs(np.diff(positions, axis=0)) * fps
    names = [str(name) for name in written["dof_names"]]
    fast = sum(int((speed[:, i] > limits[name] * (1 + 1e-6)).sum()) for i, name in enumerate(names) if name in limits)
    acceleration = np.abs(np.diff(positions, 2, axis=0)) * fps**2
    stands = None
    if simulated is not None:
        stands, *_ = track(simulated, written["dof_names"], np.concatenate([root, positions], axis=1), fps)
    row = {
        "robot": judge.key,
        "stands": stands,
        "clip": motion.name,
        "frames": len(positions),
        "fps": fps,
        "degrees": float(np.mean(list(angles.values()))) if angles else None,
        "jumps": share,
        "who": who,
        "acceleration_99": float(np.percentile(acceleration, 99)),
        "beyond_position": judge.limits(written),
        "beyond_velocity": fast,
        "below": below,
        "deepest": deepest,
        "skate": skate,
        "source_skate": report["source_skate"],
        "more_skate": None if None in (skate, report["source_skate"]) else skate - report["source_skate"],
        "own_degrees": report["mean_degrees"],
        "collide": judge.shapes.share(written["dof_names"], positions) if judge.shapes else None,
        "own_collide": report["fraction_in_self_collision"],
        "verdict": report["verdict"],
        "poses_a_second": len(positions) / max(seconds, 1e-9),
    }
    return row


HEADING = [
    "clip", "robot", "seconds", "limbs, degrees", "jumps, %", "beyond limits", "acceleration, rad/s2", "slide, cm/s more",
    "below the floor, %", "collide, %", "stands, s", "verdict",
]  # fmt: skip


def cells(row):
    """A row of the table."""
    more = row["more_skate"]
    collide = row["collide"] if row["collide"] is not None else row["own_collide"]
    return [
        f"`{row['clip'].rsplit('.', 1)[0]}`", row["robot"].upper(), f"{(row['frames'] - 1) / row['fps']:.1f}",
        "-" if row["degrees"] is None else f"{row['degrees']:.1f}", f"{100 * row['jumps']:.1f}",
        row["beyond_position"] + row["beyond_velocity"], f"{row['acceleration_99']:.0f}", "-" if more is None else f"{100 * more:.1f}",
        f"{100 * row['below']:.1f}", f"{100 * collide:.1f}", "-" if row["stands"] is None else f"{row['stands']:.1f}", row["verdict"],
    ]  # fmt: skip


def line(row, before):
    skate, source = row["skate"], row["source_skate"]
    more = f"{100 * (skate - source):+6.2f}" if skate is not None and source is not None else "     -"
    text = (
        f"{row['robot']:3} {row['clip'][:34]:34} {row['degrees'] or 0:6.2f} deg, jumps {100 * row['jumps']:5.2f} %, "
        f"a99 {row['acceleration_99']:7.0f}, over {row['beyond_position']}/{row['beyond_velocity']}, slide {more} cm/s, "
        f"below {100 * row['below']:4.1f} %, collide {100 * (row['collide'] if row['collide'] is not None else row['own_collide']):4.1f} %, "
        f"{row['verdict']}, {row['poses_a_second']:.0f}/s"
    )
    if before:
        ratio = row["acceleration_99"] / max(before["acceleration_99"], 1e-9)
        degrees = (row["degrees"] or 0) - (before["degrees"] or 0)
        text += f" | a99 x{ratio:.2f}, {degrees:+.2f} deg, own {row['own_degrees'] - before['own_degrees']:+.2f}"
    return text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--json", type=pathlib.Path, help="write the rows to this file")
    parser.add_argument("--against", type=pathlib.Path, help="rows of another program")
    parser.add_argument("--table", action="store_true", help="print the rows as a table of Markdown")
    parser.add_argument("--only", default="", help="clips whose names have this in them")
    parser.add_argument("options", nargs="*", help="options of mocap robot")
    args = parser.parse_args()
    mocap = os.environ["MOCAP"]
    folders = os.environ.get("MOCAP_MOTIONS", str(ROOT / "fixtures/real")).split(":")
    motions = [path for folder in folders for path in sorted(pathlib.Path(folder).iterdir())]
    motions = [path for path in motions if path.suffix in {".bvh", ".amc", ".fbx"} and args.only in path.name]
    before = {}
    if args.against:
        before = {(row["robot"], row["clip"]): row for row in json.loads(args.against.read_text())}
    rows = []
    if args.table:
        print("|", " | ".join(HEADING), "|")
        print("|---" * len(HEADING) + "|")
    for key in ROBOTS:
        judge = Judge(mocap, key)
        simulated = world(judge.urdf, judge.mjcf) if args.table else None
        for motion in motions:
            with tempfile.TemporaryDirectory() as folder:
                row = measured(judge, mocap, motion, pathlib.Path(folder), args.options, simulated)
            if row:
                rows.append(row)
                text = "| " + " | ".join(map(str, cells(row))) + " |" if args.table else line(row, before.get((key, motion.name)))
                print(text, flush=True)
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    total(rows, before)
    wrong = [(row, name) for row in rows for name in beyond(row)]
    for row, name in wrong:
        print(f"FAIL {row['robot']} {row['clip']}: {name} is {row[name]}, called {row['verdict']}")
    sys.exit(bool(wrong))


def beyond(row):
    """The values of a row beyond their bounds: position limits always, the others if the verdict is good."""
    names = [name for name in ["beyond_position"] if row[name] > 0]
    if row["verdict"] == "good":
        names += [name for name, bound in GOOD.items() if row[name] is not None and row[name] > bound]
    return names


def total(rows, before):
    mean = lambda values: float(np.mean(values)) if len(values) else float("nan")
    slides = [row["skate"] - row["source_skate"] for row in rows if row["skate"] is not None and row["source_skate"] is not None]
    print(
        f"{len(rows)} pairs: {sum(row['jumps'] > 0 for row in rows)} with unexplained jumps ({100 * mean([row['jumps'] for row in rows]):.2f} % of frames), "
        f"beyond limits of position {sum(row['beyond_position'] for row in rows)}, of velocity {sum(row['beyond_velocity'] for row in rows)}, "
        f"angles {mean([row['degrees'] for row in rows if row['degrees'] is not None]):.2f} degrees, "
        f"slide beyond +0.5 cm/s in {sum(slide > 0.005 for slide in slides)}, below the floor in over 1 % of frames in {sum(row['below'] > 0.01 for row in rows)}, "
        f"collide in over 2 % in {sum((row['collide'] if row['collide'] is not None else row['own_collide']) > 0.02 for row in rows)}"
    )
    pairs = [(row, before[row["robot"], row["clip"]]) for row in rows if (row["robot"], row["clip"]) in before]
    if pairs:
        ratios = [row["acceleration_99"] / max(was["acceleration_99"], 1e-9) for row, was in pairs]
        angles = [(row["degrees"] or 0) - (was["degrees"] or 0) for row, was in pairs]
        own = [row["own_degrees"] - was["own_degrees"] for row, was in pairs]
        print(
            f"acceleration: median x{np.median(ratios):.2f}, x{max(ratios):.2f} at most, above x0.25 in {sum(ratio > 0.25 for ratio in ratios)}; "
            f"angles {mean(angles):+.2f} degrees on average, {max(angles):+.2f} at most; own {mean(own):+.2f}, {max(own):+.2f} at most"
        )


if __name__ == "__main__":
    main()
