"""A second opinion on the measures and selections of `mocap survey`: jerk, noise and farthest points, with NumPy and
SciPy."""

import base64
import json
import subprocess

import numpy as np
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from plant import Bvh


def jerk(bvh, metres):
    """The root mean square of the third derivative of all joints' positions."""
    places, _ = bvh.world()
    third = np.diff(places * metres, n=3, axis=0) / bvh.frame_time**3
    return float(np.sqrt((third**2).sum(axis=2).mean()))


def noise(bvh, metres):
    """The largest noise of a joint's rotations, in millimetres at the farthest joint below it. docs/survey-columns.md
    defines it."""
    tips = end_sites(bvh)
    rest = np.zeros((len(bvh.names), 3))
    for joint, parent in enumerate(bvh.parents):
        if parent >= 0:
            rest[joint] = rest[parent] + bvh.offsets[joint]
    most = 0.0
    for joint in range(len(bvh.names)):
        columns = bvh.columns(joint, "rotation")
        if len(columns) != 3:
            continue
        order = "".join(c[0].upper() for c in bvh.channels[joint] if c.lower().endswith("rotation"))
        turns = Rotation.from_euler(order, bvh.rows[:, columns], degrees=True)
        steps = (turns[:-1].inv() * turns[1:]).as_rotvec()
        curve = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
        if len(curve) <= 16 or not curve.any():
            continue
        below = [other for other in range(len(bvh.names)) if joint in lineage(bvh, other)]
        points = [rest[other] for other in below] + [rest[other] + tip for other in below for tip in tips[other]]
        reach = max(np.linalg.norm(point - rest[joint]) for point in points) * metres
        most = max(most, white(curve, 1 / bvh.frame_time) * reach)
    return 1000 * most


def white(curve, rate):
    """The possible white noise of a curve: the least of its 2nd to 7th differences, in the calm spans of half a
    second."""
    span = int(np.clip(round(0.5 * rate), 16, len(curve)))
    spans = max(1, 2 * len(curve) // span - 1)
    of_white, found, differences = 1.0, [], curve
    for order in range(1, 8):
        differences = np.diff(differences, axis=0)
        of_white *= 2 * order * (2 * order - 1) / order**2
        if order == 1:
            continue
        levels = []
        for index in range(spans):
            start = min(index * span // 2, max(0, len(differences) - span))
            sizes = np.abs(differences[start : start + span]).ravel()
            levels.append(lower(sizes, 0.5) / 0.6745 / np.sqrt(of_white))
        found.append(levels)
    found = np.array(found)
    calm = [lower(levels, 0.3) for levels in found]
    return lower(found.min(axis=0), 0.3) if calm[-1] >= 0.85 * calm[-2] else 0.0


def lower(values, fraction):
    return float(np.sort(values)[int(fraction * (len(values) - 1))])


def lineage(bvh, joint):
    while joint >= 0:
        yield joint
        joint = bvh.parents[joint]


def end_sites(bvh):
    """The offsets of the end sites of each joint."""
    tips, joint, stack, is_tip = {index: [] for index in range(len(bvh.names))}, -1, [], False
    for line in bvh.head.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] in ("ROOT", "JOINT"):
            joint, is_tip = joint + 1, False
        elif words[0] == "End":
            is_tip = True
        elif words[0] == "{":
            stack.append(joint if not is_tip else None)
        elif words[0] == "}":
            stack.pop()
            is_tip = False
        elif words[0] == "OFFSET" and is_tip:
            owner = next(index for index in reversed(stack) if index is not None)
            tips[owner].append(np.array([float(v) for v in words[1:4]]))
    return tips


def compare(rows, clips):
    """The largest relative differences of jerk and noise. `clips` has BVH texts and metres per unit, by name."""
    worst = {"jerk": 0.0, "noise": 0.0}
    for name, (text, metres) in clips.items():
        bvh = Bvh(text)
        for kind, expected in (("jerk", jerk(bvh, metres)), ("noise", noise(bvh, metres))):
            found = rows[name][kind]
            worst[kind] = max(worst[kind], abs(found - expected) / max(abs(expected), 1e-9))
    return worst


def choice(mocap, record, count):
    """The largest distance of a clip to its nearest chosen clip, divided by the best value of all farthest-point
    samplings."""
    rows = [json.loads(line) for line in record.read_text().splitlines()]
    points, files = [], []
    for row in rows:
        numbers = np.frombuffer(base64.b64decode(row["fingerprint"][1:]), np.int8).reshape(-1, 34) / 127
        if len(numbers):
            points.append(np.concatenate([numbers.mean(axis=0), numbers.std(axis=0)]))
            files.append(row["file"])
    points = np.array(points)
    points = (points - points.mean(axis=0)) / np.where(points.std(axis=0) > 1e-4, points.std(axis=0), np.inf)
    distances = cdist(points, points)
    best = min(sampled(distances, first, count) for first in range(len(points)))
    run = [mocap, "survey", record, "--select", str(count), "--by", "diversity", "-q"]
    listed = subprocess.run(run, capture_output=True, text=True, check=True).stdout.split("\n")
    chosen = [files.index(file) for file in listed if file]
    assert len(chosen) == count, (len(chosen), count)
    return distances[:, chosen].min(axis=1).max() / best


def sampled(distances, first, count):
    nearest = distances[first].copy()
    for _ in range(count - 1):
        nearest = np.minimum(nearest, distances[nearest.argmax()])
    return nearest.max()
