"""Forward kinematics of a plain BVH file in double precision, directly from its text.

The tests compare the package with this script. The two share no code: this script reads lines and uses 3x3 matrices,
without quaternions.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Joint:
    name: str
    parent: int
    offset: np.ndarray = field(default_factory=lambda: np.zeros(3))
    channels: list[str] = field(default_factory=list)


def read(path: Path) -> tuple[list[Joint], np.ndarray]:
    """The joints and end sites in the order of the file, and the rows of the motion."""
    lines = [line.strip() for line in path.read_text(encoding="latin-1").splitlines() if line.strip()]
    motion = lines.index("MOTION")
    joints: list[Joint] = []
    above: list[int] = []
    for line in lines[:motion]:
        keyword, *words = line.split()
        if keyword in ("ROOT", "JOINT", "End"):
            parent = above[-1] if above else -1
            name = f"EndSite_{joints[parent].name}" if keyword == "End" else " ".join(words)
            above.append(len(joints))
            joints.append(Joint(name, parent))
        elif keyword == "OFFSET":
            joints[above[-1]].offset = np.array(words, dtype=float)
        elif keyword == "CHANNELS":
            joints[above[-1]].channels = words[1:]
        elif keyword == "}":
            above.pop()
    frames = int(lines[motion + 1].split(":")[1])
    rows = np.array([line.split() for line in lines[motion + 3 : motion + 3 + frames]], dtype=float)
    # A NaN repeats the last value of its column; in the first row it becomes 0.
    for frame, row in enumerate(rows):
        lost = ~np.isfinite(row)
        row[lost] = rows[frame - 1][lost] if frame else 0.0
    return joints, rows


def turn(axis: int, degrees: np.ndarray) -> np.ndarray:
    """Rotations about an axis: frames x 3 x 3."""
    sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    matrices = np.tile(np.eye(3), (len(degrees), 1, 1))
    after, last = (axis + 1) % 3, (axis + 2) % 3
    matrices[:, after, after] = matrices[:, last, last] = cos
    matrices[:, last, after] = sin
    matrices[:, after, last] = -sin
    return matrices


def positions(path: Path, root_adds: bool = False) -> np.ndarray:
    """World positions, frames x joints x 3. A position channel replaces the OFFSET, or, for some roots, is added to
    it."""
    joints, rows = read(path)
    places = np.zeros((len(rows), len(joints), 3))
    turns = np.zeros((len(rows), len(joints), 3, 3))
    columns = iter(rows.T)
    for index, joint in enumerate(joints):
        local = np.tile(joint.offset, (len(rows), 1))
        own = np.tile(np.eye(3), (len(rows), 1, 1))
        for channel in joint.channels:
            axis, values = "XYZ".index(channel[0]), next(columns)
            if channel.endswith("rotation"):
                own = own @ turn(axis, values)
            else:
                local[:, axis] = values + (joint.offset[axis] if root_adds and joint.parent < 0 else 0.0)
        if joint.parent < 0:
            places[:, index], turns[:, index] = local, own
        else:
            above = turns[:, joint.parent]
            places[:, index] = places[:, joint.parent] + np.einsum("fij,fj->fi", above, local)
            turns[:, index] = above @ own
    return places


def height(places: np.ndarray) -> float:
    """The longest side of the box around the first frame."""
    return float(np.ptp(places[0], axis=0).max())
