"""Reads the files of `mocap robot --to` by the documentation of each training code, and compares them with MuJoCo's
kinematics of the same motion. It checks keys, shapes, types, orders of rotations, bodies and joints, rates, velocities.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/trainers.py

docs/robots-files.md names the documentation of each format. The exit code is 1 if a file violates it."""

import collections
import json
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
MOTION = pathlib.Path(os.environ.get("MOCAP_MOTION", ROOT / "fixtures/real/cmu_short.bvh"))
ROBOTS = {"g1": ("g1_29dof_rev_1_0.urdf", "g1_29dof_rev_1_0_nomesh.xml"), "h1": ("h1.urdf", "h1_nomesh.xml")}
# The limits for float32 metres, and for metres a second from differences.
NEAR, NEAR_SPEED = 2e-5, 5e-3


def written(urdf, to, folder, *more):
    path = folder / f"{to}.{'csv' if 'csv' in to else 'pkl' if to in ('gmr', 'mimickit', 'twist', 'asap') else 'npz'}"
    done = subprocess.run(
        [os.environ["MOCAP"], "robot", MOTION, "--robot", urdf, "-o", path, "--to", to, *more], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as arrays:
            return dict(arrays)
    if path.suffix == ".pkl":
        return pickle.loads(path.read_bytes())
    return np.loadtxt(path, delimiter=",")


def vector_poses(model, place, vectors):
    """The positions of bodies, posed as in the motion libraries of ASAP and PBHC: with a rotation vector for each
    body."""

    def matrix(quat):
        found = np.empty(9)
        mujoco.mju_quat2Mat(found, quat)
        return found.reshape(3, 3)

    places, turns = [None], [None]
    for body in range(1, model.nbody):
        vector, quat = vectors[body - 1].astype(float), np.empty(4)
        mujoco.mju_axisAngle2Quat(quat, vector / max(np.linalg.norm(vector), 1e-12), np.linalg.norm(vector))
        parent = model.body_parentid[body]
        if parent == 0:
            places.append(place)
            turns.append(matrix(quat))
            continue
        places.append(places[parent] + turns[parent] @ model.body_pos[body])
        turns.append(turns[parent] @ matrix(model.body_quat[body]) @ matrix(quat))
    return np.array(places[1:])


class Model:
    """MuJoCo's kinematics of a robot: bodies and joints in its order, which is depth-first."""

    def __init__(self, mjcf, names):
        self.model = mujoco.MjModel.from_xml_path(str(mjcf))
        self.data = mujoco.MjData(self.model)
        name = lambda kind, index: mujoco.mj_id2name(self.model, kind, index)
        self.bodies = [name(mujoco.mjtObj.mjOBJ_BODY, body) for body in range(1, self.model.nbody)]
        self.joints = [name(mujoco.mjtObj.mjOBJ_JOINT, joint) for joint in range(1, self.model.njnt)]
        assert self.joints == list(names)
        parents = self.model.body_parentid
        children = collections.defaultdict(list)
        for body in range(1, self.model.nbody):
            children[parents[body]].append(body)
        # Breadth-first, the order in which PhysX numbers the links of an articulation.
        queue, self.breadth = collections.deque(children[0]), []
        while queue:
            body = queue.popleft()
            self.breadth.append(body - 1)
            queue.extend(children[body])
        joint_of = {self.model.jnt_bodyid[joint] - 1: joint - 1 for joint in range(1, self.model.njnt)}
        self.breadth_joints = [joint_of[body] for body in self.breadth if body in joint_of]

    def poses(self, qpos):
        positions, rotations = [], []
        for values in qpos:
            self.data.qpos[:] = values
            mujoco.mj_kinematics(self.model, self.data)
            positions.append(self.data.xpos[1:].copy())
            rotations.append(self.data.xquat[1:].copy())
        return np.array(positions), np.array(rotations)

    def velocities(self, qpos, fps):
        """By MuJoCo's own derivative of positions over two frames: joints, and bodies in the axes of the world."""
        dof, linear, angular = [], [], []
        for frame in range(1, len(qpos) - 1):
            velocity = np.empty(self.model.nv)
            mujoco.mj_differentiatePos(self.model, velocity, 2 / fps, qpos[frame - 1], qpos[frame + 1])
            self.data.qpos[:], self.data.qvel[:] = qpos[frame], velocity
            mujoco.mj_forward(self.model, self.data)
            rows = np.empty((self.model.nbody - 1, 6))
            for body in range(1, self.model.nbody):
                mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, body, rows[body - 1], 0)
            dof.append(velocity[6:])
            angular.append(rows[:, :3])
            linear.append(rows[:, 3:])
        return np.array(dof), np.array(linear), np.array(angular)


def same_rotation(a, b):
    return np.abs((a * b).sum(axis=-1)).min() > 1 - 1e-6


def check(key, folder, problems):
    urdf, mjcf = (ROOT / "fixtures/robots" / name for name in ROBOTS[key])

    def holds(name, condition):
        if not condition:
            problems.append(f"{key}: {name}")

    def truth(rate):
        arrays = written(urdf, "qpos", folder, *(["--fps", str(rate)] if rate else []))
        return Model(mjcf, arrays["dof_names"]), arrays["qpos"]

    model, qpos = truth(None)
    xyzw = qpos[:, [4, 5, 6, 3]]
    for to in ["gmr", "twist"]:
        made = written(urdf, to, folder)
        holds(f"{to} keys", {"fps", "root_pos", "root_rot", "dof_pos", "local_body_pos", "link_body_list"} <= set(made))
        holds(f"{to} fps", made["fps"] == 120 and isinstance(made["fps"], int))
        holds(f"{to} values", np.array_equal(made["root_pos"], qpos[:, :3]) and np.array_equal(made["root_rot"], xyzw))
        holds(f"{to} joints", np.array_equal(made["dof_pos"], qpos[:, 7:]))
        if to == "gmr":
            holds("gmr bodies", made["local_body_pos"] is None and made["link_body_list"] is None)
    at_origin = qpos.copy()
    at_origin[:, :7] = [0, 0, 0, 1, 0, 0, 0]
    holds("twist links", made["link_body_list"] == model.bodies)
    holds("twist places", np.abs(made["local_body_pos"] - model.poses(at_origin)[0]).max() < NEAR)
    holds("twist type", made["local_body_pos"].dtype == np.float32)
    made = written(urdf, "mimickit", folder)
    holds("mimickit keys", made["loop_mode"] == 0 and made["fps"] == 120)
    rows = made["frames"]
    holds("mimickit shape", rows.shape == (len(qpos), 6 + model.model.njnt - 1))
    for frame in range(0, len(rows), 37):
        quat, vector = np.empty(4), rows[frame, 3:6]
        mujoco.mju_axisAngle2Quat(quat, vector / max(np.linalg.norm(vector), 1e-12), np.linalg.norm(vector))
        holds("mimickit rotation", abs(quat @ qpos[frame, 3:7]) > 1 - 1e-9)
    holds("mimickit rows", np.array_equal(rows[:, :3], qpos[:, :3]) and np.array_equal(rows[:, 6:], qpos[:, 7:]))
    (name, made), = written(urdf, "asap", folder).items()
    holds("asap name", name == pathlib.Path(MOTION).stem and made["fps"] == 120)
    holds("asap joints", np.abs(made["dof"] - qpos[:, 7:]).max() < 1e-6)
    holds("asap rotation", np.abs(made["root_rot"] - qpos[:, [4, 5, 6, 3]]).max() < 1e-6)
    holds("asap feet", made["contact_mask"].shape == (len(qpos), 2))
    vectors = made["pose_aa"]
    holds("asap shape", vectors.shape == (len(qpos), len(model.bodies) + 3, 3) and vectors.dtype == np.float32)
    for frame in range(0, len(qpos), 37):
        places = vector_poses(model.model, made["root_trans_offset"][frame], vectors[frame])
        holds("asap places", np.abs(places - model.poses(qpos[frame : frame + 1])[0][0]).max() < NEAR)
    made = written(urdf, "protomotions", folder)
    holds("protomotions base", np.abs(made["base_frame_pos"] - qpos[:, :3]).max() < NEAR)
    holds("protomotions rotation", np.abs(made["base_frame_wxyz"] - qpos[:, 3:7]).max() < 1e-6)
    holds("protomotions joints", np.abs(made["joint_angles"] - qpos[:, 7:]).max() < 1e-6)
    model, qpos = truth(30)
    made = written(urdf, "unitree-csv", folder)
    holds("unitree-csv", np.abs(made - np.hstack([qpos[:, :3], qpos[:, [4, 5, 6, 3]], qpos[:, 7:]])).max() < 2e-6)
    model, qpos = truth(50)
    made = written(urdf, "mjlab", folder)
    trained(made, "mjlab", model, qpos, 50, holds)
    made = written(urdf, "beyondmimic", folder)
    for keys, order in [(["joint_pos", "joint_vel"], model.breadth_joints), (list(made), model.breadth)]:
        for name in keys:
            if name.startswith("joint" if order is model.breadth_joints else "body") and made[name].ndim > 1:
                made[name] = made[name][:, np.argsort(order)]
    trained(made, "beyondmimic", model, qpos, 50, holds)
    model, qpos = truth(None)
    made = written(urdf, "isaaclab", folder)
    holds("isaaclab fps", made["fps"].shape == () and made["fps"].dtype == np.int64 and made["fps"] == 120)
    bodies, joints = np.array(model.bodies)[model.breadth], np.array(model.joints)[model.breadth_joints]
    holds("isaaclab names", list(made["body_names"]) == list(bodies) and list(made["dof_names"]) == list(joints))
    back = {
        "fps": np.array([120]),
        "joint_pos": made["dof_positions"][:, np.argsort(model.breadth_joints)],
        "joint_vel": made["dof_velocities"][:, np.argsort(model.breadth_joints)],
        "body_pos_w": made["body_positions"][:, np.argsort(model.breadth)],
        "body_quat_w": made["body_rotations"][:, np.argsort(model.breadth)],
        "body_lin_vel_w": made["body_linear_velocities"][:, np.argsort(model.breadth)],
        "body_ang_vel_w": made["body_angular_velocities"][:, np.argsort(model.breadth)],
        "metadata": made["metadata"],
    }
    trained(back, "isaaclab", model, qpos, 120, holds)


def trained(made, to, model, qpos, fps, holds):
    positions, rotations = model.poses(qpos)
    dof, linear, angular = model.velocities(qpos, fps)
    holds(f"{to} fps", made["fps"].shape == (1,) and made["fps"][0] == fps)
    holds(f"{to} types", all(made[name].dtype == np.float32 for name in made if name.startswith(("joint_p", "joint_v", "body_p"))))
    holds(f"{to} joints", np.abs(made["joint_pos"] - qpos[:, 7:]).max() < 1e-6)
    holds(f"{to} joint velocities", np.abs(made["joint_vel"][1:-1] - dof).max() < NEAR_SPEED)
    holds(f"{to} bodies", made["body_pos_w"].shape == positions.shape and np.abs(made["body_pos_w"] - positions).max() < NEAR)
    holds(f"{to} rotations", same_rotation(made["body_quat_w"], rotations))
    differences = (positions[2:] - positions[:-2]) * fps / 2
    holds(f"{to} velocities", np.abs(made["body_lin_vel_w"][1:-1] - differences).max() < NEAR_SPEED)
    # Compares with the velocity in the middle of the two frames; the difference depends on the curvature of the motion.
    off = lambda values, expected: np.abs(values[1:-1] - expected).mean() / np.abs(expected).mean()
    holds(f"{to} velocities in the world", off(made["body_lin_vel_w"], linear) < 0.05)
    holds(f"{to} angular velocities", off(made["body_ang_vel_w"], angular) < 0.05)
    metadata = json.loads(str(made["metadata"]))
    holds(f"{to} metadata", {"mocap", "robot", "motion", "origin"} <= set(metadata))


def main():
    problems = []
    for key in ROBOTS:
        with tempfile.TemporaryDirectory() as folder:
            check(key, pathlib.Path(folder), problems)
    for problem in sorted(set(problems)):
        print("FAIL", problem)
    if not problems:
        print("gmr, twist, mimickit, asap, protomotions, unitree-csv, mjlab, beyondmimic and isaaclab: as documented, on", ", ".join(ROBOTS))
    sys.exit(bool(problems))


if __name__ == "__main__":
    main()
