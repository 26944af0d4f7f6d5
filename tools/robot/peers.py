"""`mocap robot` beside mink with frame tasks made by hand, on Unitree's G1. A row of a table for each motion and program."""

import json
import os
import pathlib
import resource
import sys
import tempfile

import mink
import mujoco
import numpy as np

from check import ROOT, SAMPLE, Judge, rotate, run, source_joints

# A link, the bone that it follows, and the weights of its place and its rotation: those of GMR's first table for G1.
TASKS = [
    ("pelvis", "hips", 100, 10),
    ("torso_link", "chest", 0, 10),
    *[
        (f"{side}_{link}", f"{side}{bone}", place, 10)
        for side in ["left", "right"]
        for link, bone, place in [
            ("hip_yaw_link", "UpperLeg", 0),
            ("knee_link", "LowerLeg", 0),
            ("ankle_roll_link", "Foot", 100),
            ("shoulder_yaw_link", "UpperArm", 0),
            ("elbow_link", "LowerArm", 0),
            ("wrist_yaw_link", "Hand", 0),
        ]
    ],
]
# Arms sideways and straight.
T_POSE = {
    "left_shoulder_roll_joint": np.pi / 2,
    "right_shoulder_roll_joint": -np.pi / 2,
    "left_elbow_joint": np.pi / 2,
    "right_elbow_joint": np.pi / 2,
}
# Steps of a frame at most, the least that one must improve, and the damping, as in GMR.
STEPS, ENOUGH, DAMPING = 10, 1e-3, 0.5
# Left, up and forward of the figure to X forward, Y left, Z up.
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def product(a, b):
    """The product of rotations w x y z."""
    result = np.empty(4)
    mujoco.mju_mulQuat(result, a, b)
    return result


def bones_of(mocap, motion, folder):
    """Places and rotations of the bones in metres, +Z up, with every rotation the identity in the T-pose."""
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


def follow(model, bones, fps):
    """Positions of the robot in all frames, and seconds of processor time."""
    configuration = mink.Configuration(model)
    zero = np.zeros(model.nq)
    zero[3] = 1.0
    configuration.update(zero)
    data = configuration.data
    body = lambda name: mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    hips = 0.5 * (data.xpos[body("left_hip_yaw_link")] + data.xpos[body("right_hip_yaw_link")])
    ankle = data.xpos[body("left_ankle_roll_link")].copy()
    leg = np.linalg.norm(data.xpos[body("left_knee_link")] - data.xpos[body("left_hip_yaw_link")])
    leg += np.linalg.norm(ankle - data.xpos[body("left_knee_link")])
    to_pelvis = data.xpos[body("pelvis")] - hips
    t_pose = zero.copy()
    for joint, angle in T_POSE.items():
        t_pose[model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)]] = angle
    configuration.update(t_pose)
    at_t_pose = {link: data.xquat[body(link)].copy() for link, *_ in TASKS}

    upper, lower, foot = (bones[f"left{bone}"][0] for bone in ["UpperLeg", "LowerLeg", "Foot"])
    human_leg = np.mean(np.linalg.norm(upper - lower, axis=1) + np.linalg.norm(lower - foot, axis=1))
    scale = leg / human_leg
    # The lowest ankle stands as high as that of the robot on its soles, which are 35 mm below.
    lowest = min(bones[f"{side}Foot"][0][:, 2].min() for side in ["left", "right"])
    raised = np.array([0.0, 0.0, 0.035 - scale * lowest])
    places = {bone: scale * place + raised for bone, (place, _) in bones.items()}
    middle = 0.5 * (places["leftUpperLeg"] + places["rightUpperLeg"])
    places["hips"] = middle + rotate(bones["hips"][1], to_pelvis)

    tasks = [(mink.FrameTask(link, "body", place, rotation, lm_damping=1), link, bone) for link, bone, place, rotation in TASKS]
    tasks = [task for task in tasks if task[2] in bones]
    limits = [mink.ConfigurationLimit(model)]
    all_tasks = [task for task, _, _ in tasks]
    configuration.update(zero)
    frames = len(middle)
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


def row(judge, name, motion, qpos, seconds, contacts, fps, source):
    places, rotations = judge.poses(qpos)
    below, _, slide = judge.feet(places, rotations, contacts, fps)
    angles = judge.limbs(rotations, source)
    low, high = judge.model.jnt_range[1:].T
    # The MJCF states its limits in five digits or six.
    beyond = int(((qpos[:, 7:] < low - 1e-5) | (qpos[:, 7:] > high + 1e-5)).sum())
    slide = "-" if slide is None else f"{100 * slide:.1f}"
    cells = [motion, name, f"{np.mean(list(angles.values())):.1f}", beyond, slide, f"{100 * below:.1f}"]
    print("|", " | ".join(map(str, [*cells, f"{len(qpos) / seconds:,.0f}"])), "|", flush=True)


def main():
    mocap = os.environ["MOCAP"]
    motions = [pathlib.Path(path) for path in sys.argv[1:]] or [ROOT / "fixtures/real" / name for name in SAMPLE]
    judge = Judge(mocap, "g1")
    print("| motion | | limbs, degrees | beyond a limit | slide, cm/s | below the floor, % | poses a second |")
    print("|---|---|---|---|---|---|---|")
    for motion in motions:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            done, seconds = run(mocap, "robot", motion, "--robot", judge.urdf, "-o", folder / "a.npz", "--passes", "1")
            assert done.returncode == 0, done.stderr
            written = np.load(folder / "a.npz")
            root = np.concatenate([written["root_pos"], written["root_rot"][:, [3, 0, 1, 2]]], axis=1)
            ours = np.concatenate([root, written["dof_pos"]], axis=1)
            source = source_joints(mocap, motion, folder)
            fps, contacts = float(written["fps"]), written["contacts"]
            bones = bones_of(mocap, motion, folder)
            theirs, their_seconds = follow(judge.model, bones, fps)
        row(judge, "mocap", motion.stem, ours, seconds, contacts, fps, source)
        row(judge, "mink", motion.stem, theirs, their_seconds, contacts, fps, source)


if __name__ == "__main__":
    main()
