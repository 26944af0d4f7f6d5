"""Prints a Markdown table for robots in packages of PyPI, which lack the meshes: every humanoid motion of fixtures/real
on each robot, judged with MuJoCo. `pairs --packages` installs the packages and runs this script. The exit code is 1 if
a joint exceeds a limit of its file, or if a motion with the verdict good exceeds a bound of GOOD.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/packages.py [--only CLIP] [-- OPTION...]"""

import argparse
import importlib.util
import json
import os
import pathlib
import sys
import tempfile

import mujoco
import numpy as np

from check import ROOT, run
from kinds import NEAR, lowest

LOCOMOTION = "mujoco_playground/_src/locomotion"
ROBOTS = {
    "Apollo": (LOCOMOTION, "apollo/xmls/apollo_mjx_feetonly.xml"),
    "Berkeley": (LOCOMOTION, "berkeley_humanoid/xmls/berkeley_humanoid_mjx_feetonly.xml"),
    "OP3": (LOCOMOTION, "op3/xmls/op3_mjx_feetonly.xml"),
    "T1": (LOCOMOTION, "t1/xmls/t1_mjx_feetonly.xml"),
    "Gymnasium": ("gymnasium/envs/mujoco/assets", "humanoid.xml"),
    "dm_control": ("dm_control/suite", "humanoid.xml"),
}
# The bounds of a motion with the verdict good: fractions of frames, and metres a second.
GOOD = {"below": 0.01, "floating": 0.02, "more_slide": 0.005}
# The bounds below and above the floor while the source stands, in metres.
BELOW, FLOATING = 0.01, 0.05
HEADING = [
    "clip", "robot", "limbs, degrees", "beyond limits", "acceleration, rad/s2", "slide, cm/s more", "below the floor, %", "floating, %", "verdict",
]  # fmt: skip


def file_of(folder, path):
    """A file of an installed package, whose folder begins with the package's name."""
    package, _, inner = folder.partition("/")
    return pathlib.Path(importlib.util.find_spec(package).submodule_search_locations[0]) / inner / path


def without_meshes(path):
    """A robot without its meshes, whose files the packages do not bring."""
    spec = mujoco.MjSpec.from_file(str(path))
    for element in [*spec.pairs, *spec.excludes, *[geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_MESH], *spec.meshes]:
        spec.delete(element)
    return spec


def model_of(path):
    return without_meshes(path).compile()


def axes_of(model, geom):
    """The axes of a shape in the frame of its body, as columns."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return turn.reshape(3, 3)


def corners_of(model, geom):
    """Points of a shape, in the frame of its body: the corners of a box, or the ends of an axis."""
    size = model.geom_size[geom]
    half = {mujoco.mjtGeom.mjGEOM_BOX: size, mujoco.mjtGeom.mjGEOM_CAPSULE: [0, 0, size[1]], mujoco.mjtGeom.mjGEOM_CYLINDER: [0, 0, size[1]]}
    half = np.array(half.get(mujoco.mjtGeom(model.geom_type[geom]), [0, 0, 0]))
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).T.reshape(-1, 3)
    return model.geom_pos[geom] + (signs * half) @ axes_of(model, geom).T


def corners(model, body):
    """Points of the shapes of a body, in its frame."""
    return np.concatenate([corners_of(model, geom) for geom in np.flatnonzero(model.geom_bodyid == body)])


class Robot:
    def __init__(self, mocap, name, path):
        self.mocap, self.name, self.path = mocap, name, path
        self.model = model_of(path)
        self.data = mujoco.MjData(self.model)
        names = [self.model.joint(index).name for index in range(self.model.njnt)]
        self.joints = {joint: index for index, joint in enumerate(names)}
        done, _ = run(mocap, "skeleton", path, "--json")
        bones = json.loads(done.stdout)["humanoid"]["bones"]
        self.feet = [self.model.body(bones[foot]["joint"]).id for foot in ("leftFoot", "rightFoot")]
        self.soles = [corners(self.model, foot) for foot in self.feet]

    def row(self, motion, folder, options):
        done, _ = run(self.mocap, "robot", motion, "--robot", self.path, "-o", folder / "a.npz", "--json", "--force", *options)
        if done.returncode:
            return None
        report, written = json.loads(done.stdout), np.load(folder / "a.npz")
        positions, fps, contacts = written["dof_pos"], float(written["fps"]), written["contacts"]
        if len(positions) < 12:
            return None
        model, data, beyond, heights, points = self.model, self.data, 0, [], [[], []]
        joints = [self.joints[str(name)] for name in written["dof_names"]]
        low, high = model.jnt_range[joints].T
        limited = model.jnt_limited[joints].astype(bool)
        beyond = int((((positions < low - NEAR) | (positions > high + NEAR)) & limited).sum())
        for frame, values in enumerate(positions):
            data.qpos[:3], data.qpos[3:7] = written["root_pos"][frame], written["root_rot"][frame][[3, 0, 1, 2]]
            data.qpos[model.jnt_qposadr[joints]] = values
            mujoco.mj_kinematics(model, data)
            heights.append(lowest(model, data))
            for side, foot in enumerate(self.feet):
                points[side].append(data.xpos[foot] + self.soles[side] @ data.xmat[foot].reshape(3, 3).T)
        heights, speeds = np.array(heights), []
        for side in (0, 1):
            steps = np.linalg.norm(np.diff(np.array(points[side])[:, :, :2], axis=0), axis=2) * fps
            speeds.extend(steps.min(axis=1)[contacts[:-1, side] & contacts[1:, side]])
        stands = contacts.any(axis=1)
        source = report["source_skate"]
        return {
            "clip": motion.stem, "robot": self.name, "degrees": report["mean_degrees"], "beyond": beyond,
            "acceleration": float(np.percentile(np.abs(np.diff(positions, 2, axis=0)) * fps**2, 99)),
            "more_slide": float(np.mean(speeds)) - source if speeds and source is not None else None,
            "below": float((heights < -BELOW).mean()),
            "floating": float((heights[stands] > FLOATING).mean()) if stands.any() else None,
            "verdict": report["verdict"],
        }  # fmt: skip


def cells(row):
    part = lambda value: "-" if value is None else f"{100 * value:.1f}"
    return [
        f"`{row['clip']}`", row["robot"], f"{row['degrees']:.1f}", row["beyond"], f"{row['acceleration']:.0f}",
        part(row["more_slide"]), part(row["below"]), part(row["floating"]), row["verdict"],
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="", help="clips whose names have this in them")
    parser.add_argument("options", nargs="*", help="options of mocap robot")
    args = parser.parse_args()
    motions = sorted((ROOT / "fixtures/real").iterdir())
    motions = [path for path in motions if path.suffix in {".bvh", ".amc", ".fbx"} and args.only in path.name]
    print("|", " | ".join(HEADING), "|")
    print("|---" * len(HEADING) + "|")
    rows = []
    for name, (folder, path) in ROBOTS.items():
        robot = Robot(os.environ["MOCAP"], name, file_of(folder, path))
        for motion in motions:
            with tempfile.TemporaryDirectory() as made:
                row = robot.row(motion, pathlib.Path(made), args.options)
            if row:
                rows.append(row)
                print("| " + " | ".join(map(str, cells(row))) + " |", flush=True)
    beyond = lambda row: [name for name, bound in GOOD.items() if row["verdict"] == "good" and (row[name] or 0) > bound]
    wrong = [row for row in rows if row["beyond"] or beyond(row)]
    good = [row for row in rows if row["verdict"] == "good"]
    print(f"{len(rows)} pairs; good {len(good)}, of which beyond a bound {sum(bool(beyond(row)) for row in good)}", file=sys.stderr)
    for row in wrong:
        print(f"FAIL {row['robot']} {row['clip']}: {beyond(row) or 'beyond limits'}: {row}", file=sys.stderr)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
