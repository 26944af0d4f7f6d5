"""Computes MMD's pose of a model at a frame independently, with matrices in NumPy, left-handed as in MMD.

This script does not solve legs in loops: a knee that only turns about X and a hip that turns freely have a closed form,
by the law of cosines. That law leaves the roll of the leg about the line from hip to goal open. Like MMD in its first
rotation of the hip, this script takes the smallest rotation of the hip that brings the foot to the goal.
"""

import numpy as np

RATE = 30
UNIT = 0.08


def matrix(q):
    x, y, z, w = np.asarray(q, float) / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def rotation(axis, angle):
    axis = np.asarray(axis, float)
    axis = axis / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def vector(turn):
    """Axis times angle of a matrix."""
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    if angle < 1e-9:
        return np.zeros(3)
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return axis / np.linalg.norm(axis) * angle


def eased(curve, time):
    """The root of a cubic."""
    ax, ay, bx, by = np.asarray(curve, float) / 127
    roots = np.roots([3 * ax - 3 * bx + 1, 3 * bx - 6 * ax, 3 * ax, -time])
    s = min((root.real for root in roots if abs(root.imag) < 1e-6 and -1e-6 <= root.real <= 1 + 1e-6), default=time)
    return 3 * (1 - s) ** 2 * s * ay + 3 * (1 - s) * s * s * by + s ** 3


def own(keys, frame):
    """The translation and the rotation from the keys of a bone."""
    frames = sorted(keys)
    if frame <= frames[0]:
        at = keys[frames[0]]
        return np.array(at[0]), matrix(at[1])
    if frame >= frames[-1]:
        at = keys[frames[-1]]
        return np.array(at[0]), matrix(at[1])
    after = next(other for other in frames if other > frame)
    before = frames[frames.index(after) - 1]
    time = (frame - before) / (after - before)
    (p, q, _), (p2, q2, curves) = keys[before], keys[after]
    parts = [eased(curve, time) for curve in curves]
    turn = matrix(q2) @ matrix(q).T
    return (
        np.array(p) + (np.array(p2) - np.array(p)) * parts[:3],
        rotation(vector(turn) + 1e-12, np.linalg.norm(vector(turn)) * parts[3]) @ matrix(q),
    )


class Pose:
    def __init__(self, bones):
        self.bones = bones
        self.at = {bone["name"]: bone for bone in bones}
        self.order = sorted(bones, key=lambda bone: (bool(bone.get("flags", 0) & 0x1000), bone.get("layer", 0)))

    def world(self, name):
        bone = self.at[name]
        parent = bone.get("parent")
        place, turn = (np.zeros(3), np.eye(3)) if parent is None else self.world(parent)
        origin = np.zeros(3) if parent is None else np.array(self.at[parent]["at"], float)
        move, own_turn = self.local[name]
        return place + turn @ (np.array(bone["at"], float) - origin + move), turn @ own_turn

    def pose(self, tracks, frame, is_on):
        self.local = {
            bone["name"]: own(tracks[bone["name"]], frame) if bone["name"] in tracks else (np.zeros(3), np.eye(3))
            for bone in self.bones
        }
        for bone in self.bones:
            if bone.get("flags", 0) & 0x0400:
                move, turn = self.local[bone["name"]]
                by = vector(turn)
                angle = np.copysign(np.linalg.norm(by), by @ np.array(bone["axis"]))
                self.local[bone["name"]] = (move, rotation(bone["axis"], angle))
        for bone in self.order:
            name = bone["name"]
            move, turn = self.local[name]
            if "turns" in bone:
                source, ratio = bone["turns"]
                by = vector(self.local[source][1])
                turn = turn @ rotation(by + 1e-12, np.linalg.norm(by) * ratio)
            if "moves" in bone:
                source, ratio = bone["moves"]
                move = move + self.local[source][0] * ratio
            self.local[name] = (move, turn)
            if "ik" in bone and is_on(name):
                self.bring(bone)

    def bring(self, bone):
        target, _, _, links = bone["ik"]
        goal = self.world(bone["name"])[0]
        if len(links) == 2:
            self.bend(links[0][0], links[1][0], target, goal)
            return
        (link, _), = links
        self.aim(link, target, goal)

    def aim(self, link, target, goal):
        """The smallest rotation of a link that points the target to the goal."""
        place = self.world(link)[0]
        a, b = self.world(target)[0] - place, goal - place
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        axis = np.cross(a, b)
        if np.linalg.norm(axis) < 1e-9:
            return
        parent = self.world(self.at[link]["parent"])[1]
        by = rotation(parent.T @ axis, np.arctan2(np.linalg.norm(axis), a @ b))
        self.local[link] = (self.local[link][0], by @ self.local[link][1])

    def bend(self, knee, hip, target, goal):
        """Bends the knee until the foot is as far from the hip as the goal; then rotates the hip towards the goal."""
        distance = np.linalg.norm(goal - self.world(hip)[0])
        move = self.local[knee][0]

        def reach(angle):
            self.local[knee] = (move, rotation((1, 0, 0), angle))
            return np.linalg.norm(self.world(target)[0] - self.world(hip)[0])

        low, high = np.radians(-179.0), np.radians(-0.5)
        if reach(high) > distance:
            for _ in range(60):
                middle = (low + high) / 2
                low, high = (middle, high) if reach(middle) < distance else (low, middle)
        reach(high)
        self.aim(hip, target, goal)
