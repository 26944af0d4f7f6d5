"""The smallest limb angles between a dog and a robot that the robot's joints and limits allow.

    tools/robot/.venv/bin/python tools/robot/limb_floor.py dog.xml TAKE.bvh ...

For each of 50 frames, SciPy searches the rotation of the base and the positions of all joints. It has no floor, no feet
in place and no velocities. The search is local, so a nearer pose may exist. It shares no code with mocap.
"""

import sys

import mujoco
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

# The first joint of each segment, and the paw: of the robot, and of the dog.
LEGS = {
    f"{side} {end}": ([f"{joint}_{side[0]}{rest}" for joint, rest in robot], [name.replace("*", side) for name in dog])
    for side in ("Left", "Right")
    for end, robot, dog in (
        (
            "fore",
            (("shoulder", "_extend"), ("elbow", ""), ("wrist", ""), ("finger", "")),
            ("b_*Arm", "b_*ForeArm", "b_*Hand", "b_*Finger"),
        ),
        (
            "hind",
            (("hip", "_extend"), ("knee", ""), ("ankle", ""), ("toe", "")),
            ("b_*LegUpper", "b_*Leg", "b_*Leg1", "b_*Ankle"),
        ),
    )
}
FRAMES = 50
# +Y up to +Z up, with +Z forward to +X.
TO_ROBOT = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)


def directions_of(path):
    """The directions of the segments of each leg, in some frames of a BVH file: (frames, 12, 3)."""
    head, motion = open(path).read().split("MOTION")
    joints, stack, name = [], [], None
    for words in map(str.split, head.splitlines()):
        match words:
            case ["ROOT" | "JOINT", name]:
                pass
            case ["End", "Site"]:
                name = None
            case ["{"]:
                stack.append((name, len(joints)))
                joints.append([name, stack[-2][1] if len(stack) > 1 else None, None, []])
            case ["}"]:
                stack.pop()
            case ["OFFSET", *offset]:
                joints[-1][2] = np.array(offset, float)
            case ["CHANNELS", _, *channels]:
                joints[-1][3] = channels
    rows = np.array([line.split() for line in motion.strip().splitlines()[2:]], float)
    rows = rows[np.linspace(0, len(rows) - 1, FRAMES).round().astype(int)]
    found = []
    for row in rows:
        values, places, at = iter(row), [], {}
        for joint, parent, offset, channels in joints:
            row_of = {channel: next(values) for channel in channels}
            moved = [row_of.get(f"{axis}position", offset[index]) for index, axis in enumerate("XYZ")]
            turns = [(channel[0], angle) for channel, angle in row_of.items() if channel.endswith("rotation")]
            turn = Rotation.identity()
            if turns:
                turn = Rotation.from_euler("".join(axis for axis, _ in turns), [angle for _, angle in turns], True)
            above = places[parent] if parent is not None else (Rotation.identity(), np.zeros(3))
            places.append((above[0] * turn, above[1] + above[0].apply(moved)))
            at[(joint or "").replace("__", "_")] = places[-1][1]
        found.append([at[b] - at[a] for _, dog in LEGS.values() for a, b in zip(dog, dog[1:])])
    found = np.array(found) @ TO_ROBOT.T
    return found / np.linalg.norm(found, axis=2, keepdims=True)


class Robot:
    def __init__(self, path):
        self.model = mujoco.MjModel.from_xml_path(path)
        self.data = mujoco.MjData(self.model)
        joints = [[self.model.joint(joint).id for joint in robot] for robot, _ in LEGS.values()]
        self.segments = np.array([pair for leg in joints for pair in zip(leg, leg[1:])])
        hinge = self.model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
        self.positions = self.model.jnt_qposadr[hinge]
        self.lower, self.upper = self.model.jnt_range[hinge].T
        self.hinges = np.flatnonzero(hinge)
        bodies = self.model.jnt_bodyid
        above = {0: set()}
        for body in range(1, self.model.nbody):
            above[body] = above[self.model.body_parentid[body]] | {body}
        # Whether each hinge moves the anchor of each segment's two ends. A joint does not move its own anchor.
        self.moves = np.array(
            [[[bodies[h] in above[bodies[e]] and h < e for e in pair] for pair in self.segments] for h in self.hinges]
        )

    def vectors(self, x):
        self.data.qpos[self.positions] = x[3:]
        mujoco.mj_kinematics(self.model, self.data)
        at = self.data.xanchor
        return at[self.segments[:, 1]] - at[self.segments[:, 0]]

    def directions(self, x):
        found = self.vectors(x)
        return Rotation.from_rotvec(x[:3]).apply(found / np.linalg.norm(found, axis=1, keepdims=True))

    def slopes(self, x):
        found = self.vectors(x)
        lengths = np.linalg.norm(found, axis=1, keepdims=True)
        found /= lengths
        at, axes = self.data.xanchor[self.hinges], self.data.xaxis[self.hinges]
        ends = self.data.xanchor[self.segments]
        moved = np.cross(axes[:, None, None], ends[None] - at[:, None, None]) * self.moves[..., None]
        moved = (moved[:, :, 1] - moved[:, :, 0]) / lengths
        moved -= (moved * found).sum(2, keepdims=True) * found
        base = Rotation.from_rotvec(x[:3]).as_matrix()
        step = 1e-6 * np.eye(3)
        turned = [(Rotation.from_rotvec(x[:3] + d).apply(found) - found @ base.T) / 1e-6 for d in step]
        return np.concatenate([turned, moved @ base.T]).reshape(len(x), -1).T

    def nearest(self, wanted, start, weights):
        weights = np.repeat(weights, 3)

        # A small weight keeps the joints that no segment shows near 0.
        def apart(x):
            return np.concatenate([weights * (self.directions(x) - wanted).ravel(), 1e-4 * x[3:]])

        def slopes(x):
            rest = np.hstack([np.zeros((len(x) - 3, 3)), 1e-4 * np.eye(len(x) - 3)])
            return np.vstack([weights[:, None] * self.slopes(x), rest])

        low, high = np.r_[np.full(3, -np.inf), self.lower], np.r_[np.full(3, np.inf), self.upper]
        start = np.clip(start, low + 1e-6, high - 1e-6)
        return least_squares(apart, start, slopes, bounds=(low, high), max_nfev=100).x


def main():
    robot = Robot(sys.argv[1])
    for path in sys.argv[2:]:
        wanted = directions_of(path)
        angles, x = [], None
        for frame in wanted:
            zero = np.zeros(3 + len(robot.lower))
            zero[:3] = Rotation.align_vectors(frame, robot.directions(zero))[0].as_rotvec()
            best = None
            for start in (zero, x):
                # Squares with these weights become the mean of the angles.
                weights = np.ones(len(frame))
                for _ in range(6 if start is not None else 0):
                    start = robot.nearest(frame, start, weights)
                    cosines = np.clip((robot.directions(start) * frame).sum(1), -1, 1)
                    found = np.degrees(np.arccos(cosines))
                    weights = 1 / np.sqrt(np.maximum(np.radians(found), 0.01))
                    if best is None or found.mean() < best.mean():
                        x, best = start, found
            angles.append(best)
        angles = np.array(angles)
        parts = angles.mean(0).reshape(4, 3)
        print(f"{path}: mean {angles.mean():.1f}, worst frame {angles.mean(1).max():.1f} degrees")
        for leg, part in zip(LEGS, parts):
            print(f"  {leg:<11}", *(f"{value:5.1f}" for value in part))


if __name__ == "__main__":
    main()
