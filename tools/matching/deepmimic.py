"""Converts motions of DeepMimic (Peng and others, 2018) from the package pybullet to BVH.

A frame has its duration, the position of the root, and local rotations: quaternions with w first, or the angle of a
hinge about +Z. The skeleton is the package's humanoid, which is four times as large. A cyclic motion repeats for three
seconds; each repetition starts at the last position and direction of the root.
"""

import json
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

SIZE = 4  # the humanoid of the package is four times as large as its motions
SECONDS = 3.0
# In the order of a frame, with the numbers of each.
ORDER = [("root", 4), ("chest", 4), ("neck", 4)]
ORDER += [(f"{side}_{joint}", width) for side in ("right", "left")
          for joint, width in (("hip", 4), ("knee", 1), ("ankle", 4), ("shoulder", 4), ("elbow", 1))]
# Metres: the top of the head's sphere, and the front of the foot's box.
ENDS = {"neck": (0, 0.28, 0), "right_ankle": (0.13, -0.045, 0), "left_ankle": (0.13, -0.045, 0)}


def skeleton(urdf):
    """Name -> (parent, offset), parents first."""
    joints = {}
    for joint in urdf.iter("joint"):
        child, parent = joint.find("child").get("link"), joint.find("parent").get("link")
        offset = np.array([float(number) for number in joint.find("origin").get("xyz").split()]) / SIZE
        joints[child] = (parent, offset)
    joints["root"] = (None, np.zeros(3))
    return joints


def matrices(q):
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    rows += [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    rows += [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    return np.stack(rows, -1).reshape(*q.shape[:-1], 3, 3)


def zxy(m):
    """The angles in degrees about Z, X and Y whose product is m."""
    x = np.arcsin(np.clip(m[..., 2, 1], -1, 1))
    z, y = np.arctan2(-m[..., 0, 1], m[..., 1, 1]), np.arctan2(-m[..., 2, 0], m[..., 2, 2])
    return np.degrees(np.stack([z, x, y], -1))


def about_y(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def heading(m):
    return np.arctan2(-m[2, 0], m[0, 0])


def motion(text):
    """The seconds of a frame, the positions of the root, and the rotations by joint."""
    data = json.loads(text)
    frames = np.array(data["Frames"])
    step, places, rotations, at = frames[0, 0], frames[:, 1:4], {}, 4
    for joint, width in ORDER:
        values = frames[:, at : at + width]
        at += width
        if width == 1:
            values = np.concatenate([np.cos(values / 2), 0 * values, 0 * values, np.sin(values / 2)], -1)
        rotations[joint] = matrices(values)
    times = int(np.ceil(SECONDS / (step * (len(frames) - 1)))) if data.get("Loop") == "wrap" else 1
    place, turn, all_places, roots = np.zeros(3), heading(rotations["root"][0]), [], []
    for _ in range(times):
        back = places[0] * [1, 0, 1]
        m = about_y(turn - heading(rotations["root"][0]))
        all_places.append((places[: len(frames) - (times > 1)] - back) @ m.T + place)
        roots.append(m @ rotations["root"][: len(frames) - (times > 1)])
        place = (m @ (places[-1] - back) + place) * [1, 0, 1]
        turn = heading(m @ rotations["root"][-1])
    count = len(frames) - (times > 1)
    rotations = {joint: np.concatenate([values[:count]] * times) for joint, values in rotations.items()}
    rotations["root"] = np.concatenate(roots)
    return step, np.concatenate(all_places), rotations


def bvh(joints, step, places, rotations):
    lines, order = [], []

    def write(name, depth):
        pad = "\t" * depth
        lines.append(f"{pad}{'ROOT' if not depth else 'JOINT'} {name}\n{pad}{{")
        lines.append("\tOFFSET ".join([pad, " ".join(f"{value:.6f}" for value in joints[name][1])]))
        position = "6 Xposition Yposition Zposition" if not depth else "3"
        lines.append(f"{pad}\tCHANNELS {position} Zrotation Xrotation Yrotation")
        order.append(name)
        below = [child for child, (parent, _) in joints.items() if parent == name]
        for child in below:
            write(child, depth + 1)
        if not below:
            end = " ".join(map(str, ENDS.get(name, (0, -0.08, 0))))
            lines.append(f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET {end}\n{pad}\t}}")
        lines.append(f"{pad}}}")

    write("root", 0)
    still = np.broadcast_to(np.eye(3), (len(places), 3, 3))
    rows = np.concatenate([places, *(zxy(rotations.get(name, still)) for name in order)], -1)
    lines += ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {step:.6f}"]
    lines += [" ".join(f"{value:.5f}" for value in row) for row in rows]
    return "HIERARCHY\n" + "\n".join(lines) + "\n"


def write(wheel, folder):
    """Writes the motions of the package."""
    # The file ends with a byte of 0.
    joints = skeleton(xml.fromstring(wheel.read("pybullet_data/humanoid/humanoid.urdf").split(b"\0")[0]))
    for name in wheel.namelist():
        path = Path(name)
        if "data/motions/" in name and path.suffix == ".txt" and "laikago" not in path.stem:
            (folder / f"{path.stem.removeprefix('humanoid3d_')}.bvh").write_text(bvh(joints, *motion(wheel.read(name))))
