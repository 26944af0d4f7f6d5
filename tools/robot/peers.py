"""Compares `mocap robot` with mink and hand-made frame tasks on Unitree's G1 and H1 and Booster's T1. Prints a row for
each motion, robot and program, and a table of their means.

    tools/robot/peers [--all] [--rows FILE.jsonl] [--alone] [MOTION...]

`--alone` measures mocap without mink. Prints rows of mocap that exceed a bound of WANTED, with the frame and the
command."""

import argparse
import json
import os
import pathlib
import resource
import shlex
import sys
import tempfile

import mink
import mujoco
import numpy as np

from check import ROOT, SAMPLE, rotate, run, source_joints
from judges import KEYS, T_POSES, Robot
from measure import GOOD as CALLED_GOOD

# Weights of the position and the rotation of a link, by its bone, from GMR's first table for G1. For the other robots,
# GMR has different weights of the rotation of H1's torso and of T1's feet.
PLACES, ROTATION = {"hips": 100.0, "leftFoot": 100.0, "rightFoot": 100.0}, 10.0
ROTATIONS = {("h1", "chest"): 100.0, ("t1", "leftFoot"): 50.0, ("t1", "rightFoot"): 50.0}
# The largest number of steps per frame, the least improvement of a step, and the damping, as in GMR.
STEPS, ENOUGH, DAMPING = 10, 1e-3, 0.5
# From the figure's left, up and forward to X forward, Y left, Z up.
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
# The motions of `--all`: a file below `fixtures`, and the used part in seconds.
ALL = [
    ("real/cmu_12_01_walk.bvh", "0..3"), ("real/motionbuilder_vicon_walk.bvh", "0..3"), ("real/motionbuilder_vicon_walk.bvh", "5..8"),
    ("real/nan_tokens.bvh", "0..3"), ("real/makehuman_zombie_walk.bvh", None), ("real/additive_root_walk.bvh", None), ("real/run.fbx", None),
    ("real/cmu_mixed_rotation_orders.bvh", "0..3"), ("real/cmu_02_01.amc", None), ("real/cmu_salsa_poser_names.bvh", "1..4"),
    ("real/cmu_salsa_poser_names.bvh", "6..9"), ("real/rokoko_dance.bvh", "1..4"), ("real/rokoko_dance.bvh", "6..9"),
    ("real/z_up_dab.bvh", "1..4"), ("real/z_up_dab.bvh", "6..9"), ("real/mocopi_jump_six_channels.bvh", "2..5"),
    ("real/mocopi_jump_six_channels.bvh", "7..10"), ("real/cmu_01_01.bvh", "1..4"), ("real/cmu_01_01.bvh", "8..11"),
    ("real/cmu_01_01.bvh", "15..18"), ("real/hip_knee_ankle_names.bvh", "2..5"), ("real/hip_knee_ankle_names.bvh", "20..23"),
    ("real/kinect_openni.bvh", "5..8"), ("real/kinect_openni.bvh", "20..23"), ("real/perception_neuron_moving_positions.bvh", "0..3"),
    ("skeletons/accad_run_turn.bvh", None), ("skeletons/bvhtoolbox_walk01.bvh", None), ("skeletons/snu_character1_boxes.bvh", "0..3"),
    ("skeletons/vicon_sword_attack.bvh", "0..3"), ("skeletons/rosemotion_robin.bvh", "0..3"),
]  # fmt: skip
# The bounds of a motion: fractions of swing frames and of frames, counts, and metres a second more than in the source.
WANTED = {"scrapes": 0.03, "deep": 0.01, "beyond": 0, "jumps": 0, "more_slide": 0.005}
# The bounds of a motion with the verdict good, with degrees of the limbs.
GOOD = WANTED | {"collide": CALLED_GOOD["collide"], "limbs": CALLED_GOOD["degrees"]}
# A column: its heading, its value in a row, and its digits.
COLUMNS = [
    ("limbs, degrees", "limbs", 1, 1), ("slide, cm/s", "slide", 100, 1), ("scrapes, % of swing", "scrapes", 100, 1),
    ("deeper than 2 cm, %", "deep", 100, 1), ("deepest, cm", "deepest", 100, 1), ("beyond a limit", "beyond", 1, 0),
    ("jumps, %", "jumps", 100, 2), ("self-collision, %", "collide", 100, 1), ("help: force, weights", "force", 1, 3),
    ("help: moment, weight m", "moment", 1, 3), ("poses a second", "speed", 1, 0),
]  # fmt: skip
# For each column, the table has the mean, the maximum or the sum over the motions.
LARGEST, SUMS = {"deepest"}, {"beyond"}


def product(a, b):
    """The product of rotations w x y z."""
    result = np.empty(4)
    mujoco.mju_mulQuat(result, a, b)
    return result


def bones_of(mocap, motion, folder):
    """Positions and rotations of the bones in metres with +Z up. In the T-pose, every rotation is the identity."""
    for arguments in [
        ("convert", motion, folder / "bones.vrma", "--drop-first-frame", "auto"),
        ("fk", folder / "bones.vrma", "--rot-space", "world", "-o", folder / "bones.npz"),
    ]:
        done, _ = run(mocap, *arguments)
        assert done.returncode == 0, done.stderr
    done, _ = run(mocap, "skeleton", folder / "bones.vrma", "--json")
    joints = {bone: joint["joint"] for bone, joint in json.loads(done.stdout)["humanoid"]["bones"].items()}
    arrays = np.load(folder / "bones.npz")
    names = list(arrays["names"])
    bones = {}
    for bone, joint in joints.items():
        index = names.index(joint)
        xyzw = arrays["rotations"][:, index].astype(float)
        rotation = np.concatenate([xyzw[:, 3:], xyzw[:, :3] @ AXES.T], axis=1)
        bones[bone] = arrays["positions"][:, index].astype(float) @ AXES.T, rotation
    if "chest" not in bones:
        bones["chest"] = bones["spine"]
    return bones


def follow(robot, bones, fps):
    """Positions of the robot in all frames, and seconds of processor time."""
    model = robot.model
    configuration = mink.Configuration(model)
    zero = np.zeros(model.nq)
    zero[3] = 1.0
    configuration.update(zero)
    data = configuration.data
    at = lambda bone: data.xpos[robot.body(robot.links[bone])].copy()
    middle = 0.5 * (at("leftUpperLeg") + at("rightUpperLeg"))
    leg = np.linalg.norm(at("leftLowerLeg") - at("leftUpperLeg")) + np.linalg.norm(at("leftFoot") - at("leftLowerLeg"))
    to_hips = at("hips") - middle
    sole = next(heights for _, heights in robot.soles_at(*robot.poses(zero[None])))
    ankle_height = at("leftFoot")[2] - sole.min()
    t_pose = zero.copy()
    for joint, angle in T_POSES[robot.key].items():
        t_pose[model.jnt_qposadr[model.joint(joint).id]] = angle
    configuration.update(t_pose)
    at_t_pose = {link: data.xquat[robot.body(link)].copy() for link in robot.links.values()}

    upper, lower, foot = (bones[f"left{bone}"][0] for bone in ["UpperLeg", "LowerLeg", "Foot"])
    human_leg = np.mean(np.linalg.norm(upper - lower, axis=1) + np.linalg.norm(lower - foot, axis=1))
    scale = leg / human_leg
    # Raises the person until the lowest ankle is as high as the robot's ankle when it stands on its soles.
    lowest = min(bones[f"{side}Foot"][0][:, 2].min() for side in ["left", "right"])
    raised = np.array([0.0, 0.0, ankle_height - scale * lowest])
    places = {bone: scale * place + raised for bone, (place, _) in bones.items()}
    places["hips"] = 0.5 * (places["leftUpperLeg"] + places["rightUpperLeg"]) + rotate(bones["hips"][1], to_hips)

    tasks = []
    for bone, link in robot.links.items():
        if bone in bones:
            rotation = ROTATIONS.get((robot.key, bone), ROTATION)
            tasks.append((mink.FrameTask(link, "body", PLACES.get(bone, 0.0), rotation, lm_damping=1), link, bone))
    limits = [mink.ConfigurationLimit(model)]
    all_tasks = [task for task, _, _ in tasks]
    configuration.update(zero)
    frames = len(places["hips"])
    qpos = np.empty((frames, model.nq))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    for frame in range(frames):
        for task, link, bone in tasks:
            target = product(bones[bone][1][frame], at_t_pose[link])
            task.set_target(mink.SE3(np.concatenate([target, places[bone][frame]])))
        error = np.inf
        for _ in range(STEPS * (20 if frame == 0 else 1)):
            now = np.linalg.norm(np.concatenate([task.compute_error(configuration) for task in all_tasks]))
            if error - now < ENOUGH:
                break
            error = now
            velocity = mink.solve_ik(configuration, all_tasks, 1 / fps, "daqp", DAMPING, limits=limits)
            configuration.integrate_inplace(velocity, 1 / fps)
        qpos[frame] = configuration.q
    return qpos, resource.getrusage(resource.RUSAGE_SELF).ru_utime - before


def pieces(mocap, motions, folder):
    """The files to retarget, with their names and their arguments for `mocap robot`. Parts of files are written as
    BVH."""
    for number, (path, trim) in enumerate(motions):
        if trim is None:
            yield path, path.stem, [path]
            continue
        part = folder / f"{number}.bvh"
        done, _ = run(mocap, "convert", path, part, "--drop-first-frame", "auto", "--trim", trim)
        assert done.returncode == 0, done.stderr
        yield part, f"{path.stem} {trim} s", [path, "--trim", trim]


def rows_of(robot, mocap, motion, name, words, alone, folder):
    """A row for each program, with the measures of a motion on the robot."""
    done, seconds = run(mocap, "robot", motion, "--robot", robot.urdf, "-o", folder / "a.npz", "--json")
    if done.returncode:
        print(f"{robot.key} {name}: {done.stderr.strip()[:200]}", file=sys.stderr)
        return
    report, written = json.loads(done.stdout), np.load(folder / "a.npz")
    fps, contacts = float(written["fps"]), written["contacts"]
    if len(contacts) < 12:
        return
    order = [list(written["dof_names"]).index(joint) for joint in robot.joints]
    qpos = np.concatenate([written["root_pos"], written["root_rot"][:, [3, 0, 1, 2]], written["dof_pos"][:, order]], axis=1)
    source = source_joints(mocap, motion, folder)
    made = [("mocap", qpos, seconds)]
    if not alone:
        # mocap omits a rest pose before the motion, so mink's motion omits the same frame.
        theirs, their_seconds = follow(robot, bones_of(mocap, motion, folder), fps)
        made.append(("mink", theirs[len(theirs) - len(qpos) :], their_seconds))
    for program, qpos, seconds in made:
        row = {"clip": name, "program": program, **robot.row(qpos, contacts, fps, source, folder), "speed": len(qpos) / max(seconds, 1e-9)}
        row["scrapes"] = row["scraping"] / row["swing"] if row["swing"] else None
        source_slide = report["source_skate"]
        row["more_slide"] = None if None in (row["slide"], source_slide) else row["slide"] - source_slide
        if program == "mocap":
            row |= {key: report[key] for key in ["verdict", "source_skate"]}
            row["command"] = shlex.join(map(str, ["mocap", "robot", *words, "--robot", robot.urdf, "-o", "a.npz"]))
        yield row


def number(value, factor, digits):
    return "-" if value is None else f"{factor * value:,.{digits}f}"


def table(rows, programs):
    """A row for each robot and program: the mean, maximum or sum over its motions."""
    print("| robot | |", " | ".join(heading for heading, *_ in COLUMNS), "|")
    print("|---" * (len(COLUMNS) + 2) + "|")
    for key in dict.fromkeys(row["robot"] for row in rows):
        for program in programs:
            cells = []
            for _, name, factor, digits in COLUMNS:
                values = [row[name] for row in rows if (row["robot"], row["program"]) == (key, program) and row[name] is not None]
                together = max if name in LARGEST else sum if name in SUMS else np.mean
                cells.append(number(together(values) if values else None, factor, digits))
            first = f"| {key.upper()} |" if program == programs[0] else "| |"
            print(first, " | ".join([program, *cells]), "|")


def violations(rows):
    """Prints the rows of mocap beyond a bound, and the number of them with the verdict good."""
    ours = [row for row in rows if row["program"] == "mocap"]
    beyond = lambda row, bounds: {name: row[name] for name, bound in bounds.items() if (row[name] or 0) > bound}
    for row in ours:
        found = beyond(row, WANTED)
        if found:
            frames = {
                "scrapes": row["scraping_frames"][:8], "deep": (row["deepest_frame"], row["deepest_link"]),
                "beyond": row["beyond_frames"], "jumps": row["jumped"],
            }  # fmt: skip
            what = ", ".join(f"{name} {value:.4g} {frames.get(name, '')}" for name, value in found.items())
            print(f"{row['robot']} {row['clip']} ({row['verdict']}): {what}; {row['command']}")
    good = [row for row in ours if row["verdict"] == "good"]
    wrong = [row for row in good if beyond(row, GOOD)]
    print(f"{len(ours)} motions on robots, {len(good)} good, of which {len(wrong)} beyond a bound")
    for row in wrong:
        print(f"called good: {row['robot']} {row['clip']}: {beyond(row, GOOD)}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--all", action="store_true", help="thirty motions of fixtures instead of three")
    parser.add_argument("--alone", action="store_true", help="measure mocap without mink")
    parser.add_argument("--rows", type=pathlib.Path, help="write every row to this file, as lines of JSON")
    parser.add_argument("--robot", choices=KEYS, action="append", help="only this robot")
    parser.add_argument("motions", nargs="*", type=pathlib.Path)
    args = parser.parse_args()
    mocap, rows = os.environ["MOCAP"], []
    motions = [(path, None) for path in args.motions] or [(ROOT / "fixtures/real" / name, None) for name in SAMPLE]
    if args.all:
        motions = [(ROOT / "fixtures" / path, trim) for path, trim in ALL]
    programs = ["mocap"] if args.alone else ["mocap", "mink"]
    robots = [Robot(mocap, key) for key in args.robot or KEYS]
    with tempfile.TemporaryDirectory() as parts:
        for motion, name, words in pieces(mocap, motions, pathlib.Path(parts)):
            for robot in robots:
                with tempfile.TemporaryDirectory() as folder:
                    for row in rows_of(robot, mocap, motion, name, words, args.alone, pathlib.Path(folder)):
                        rows.append(row)
                        cells = (number(row[column], factor, digits) for _, column, factor, digits in COLUMNS)
                        print(row["robot"], name, row["program"], *cells, row.get("verdict", ""), sep=", ", file=sys.stderr, flush=True)
                        if args.rows:
                            args.rows.open("a").write(json.dumps(row) + "\n")
    table(rows, programs)
    violations(rows)


if __name__ == "__main__":
    main()
