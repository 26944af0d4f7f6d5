"""Computes the scores of `mocap score` in NumPy from the URDF and the arrays, for a walk of the G1 and a copy that
sways and sinks. Prints both values of each score. The exit code is 1 if they differ by more than 1e-6, or for a jerk by
this fraction of it."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBOT = ROOT / "fixtures/robots/g1_29dof_rev_1_0.urdf"
WALK = ROOT / "fixtures/real/cmu_12_01_walk.bvh"
MOCAP = os.environ.get("MOCAP", ROOT / "target/release/mocap")
HANDS = ["left_wrist_yaw_link", "right_wrist_yaw_link"]
ROUNDING = 1e-4  # radians


def run(*words):
    return subprocess.run([MOCAP, *words], check=True, capture_output=True, text=True).stdout


def about(axis, angle):
    """Rodrigues' rotation."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def vector(element, name, default):
    text = element.get(name) if element is not None else None
    return np.array([float(word) for word in (text or default).split()])


def joints():
    """The joints of the file, in its order, parents first."""
    for joint in xml.parse(ROBOT).getroot().findall("joint"):
        origin, limit = joint.find("origin"), joint.find("limit")
        roll, pitch, yaw = vector(origin, "rpy", "0 0 0")
        turn = about(np.array([0, 0, 1]), yaw) @ about(np.array([0, 1, 0]), pitch) @ about(np.array([1, 0, 0]), roll)
        yield {
            "name": joint.get("name"),
            "ends": (joint.find("parent").get("link"), joint.find("child").get("link")),
            "moves": joint.get("type") == "revolute",
            "origin": (turn, vector(origin, "xyz", "0 0 0")),
            "axis": vector(joint.find("axis"), "xyz", "1 0 0"),
            "limits": [float(limit.get(key)) for key in ("lower", "upper")] if limit is not None else None,
        }


def places(motion, frame, tree):
    """The positions of the base and of every link with a joint."""
    x, y, z, w = motion["root_rot"][frame]
    angle = 2 * np.arctan2(np.linalg.norm([x, y, z]), w)
    root = about(np.array([x, y, z]), angle) if angle else np.eye(3)
    world = {"pelvis": (root, motion["root_pos"][frame])}
    found = [world["pelvis"][1]]
    positions = dict(zip(motion["dof_names"], motion["dof_pos"][frame]))
    for joint in tree:
        (parent, child), (turn, offset) = joint["ends"], joint["origin"]
        above, place = world[parent]
        turn, place = above @ turn, place + above @ offset
        if joint["moves"]:
            turn = turn @ about(joint["axis"], positions[joint["name"]])
            found.append(place)
        world[child] = (turn, place)
    return found


def main():
    tree = list(joints())
    links = ["pelvis", *(joint["ends"][1] for joint in tree if joint["moves"])]
    with tempfile.TemporaryDirectory() as folder:
        reference, other = f"{folder}/walk.npz", f"{folder}/other.npz"
        run("robot", WALK, "--robot", ROBOT, "-o", reference, "--fps", "30")
        was = {name: array.astype(float) if array.dtype.kind == "f" else array for name, array in np.load(reference).items()}
        time = np.arange(len(was["root_pos"])) / was["fps"]
        sway = np.stack([0.03 * np.sin(3 * time), 0.02 + 0 * time, -0.02 - 0.01 * np.sin(time)], axis=1)
        phase = 2 * time[:, None] + np.arange(was["dof_pos"].shape[1])
        moved = {"root_pos": was["root_pos"] + sway, "dof_pos": was["dof_pos"] + 0.1 * np.sin(phase)}
        now = {**was, **moved}
        np.savez(other, **now)
        said = run("score", reference, other, "--body", ROBOT, "--robot", ROBOT, "--json")
    scores = json.loads(said)["scores"]
    frames = range(len(time))
    apart = np.array([places(now, frame, tree) for frame in frames]) - np.array([places(was, frame, tree) for frame in frames])
    local = apart - apart[:, :1]
    hands = [links.index(name) for name in HANDS]
    lower, upper = np.array([joint["limits"] for joint in tree if joint["moves"]]).T
    beyond = np.maximum(lower - now["dof_pos"], now["dof_pos"] - upper)
    jerk = np.abs(np.diff(now["dof_pos"], 3, axis=0)).mean() * now["fps"] ** 3
    restated = {
        "bodies": len(links),
        "mpbpe_global": np.linalg.norm(apart, axis=2).mean(),
        "mpbpe_local": np.linalg.norm(local, axis=2).mean(),
        "palm_error": np.linalg.norm(local[:, hands], axis=2).mean(),
        "limit_violation": (beyond > ROUNDING).mean(),
        "at_limit": (beyond > -ROUNDING).mean(),
        "joint_jerk": jerk,
    }
    for name, value in restated.items():
        print(f"{name:16} {scores[name]:.9f} restated {value:.9f}")
    sys.exit(int(any(abs(scores[name] - value) > 1e-6 * max(1, value) for name, value in restated.items())))


main()
