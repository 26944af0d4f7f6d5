"""Checks the layout and the values of database.bin and features.bin: the controller of Holden's demonstration must read
them, and compute the same features. See README.md.

    holden.py FOLDER LEFT,RIGHT

FOLDER has both files and joints.npz, the output of `mocap fk` for the first clip; LEFT and RIGHT are the joints of the
feet.
"""

import sys
from pathlib import Path

import numpy as np

folder = Path(sys.argv[1])
WEIGHTS = [(3, 0.75), (3, 0.75), (3, 1), (3, 1), (3, 1), (6, 1), (6, 1.5)]
failed = False


def held(what, value, most):
    global failed
    failed |= not value <= most
    print(f"{'ok  ' if value <= most else 'FAIL'} {what}: {value:.3g} ({most:.3g})")


class File:
    """A file that is read exactly from its start to its end."""

    def __init__(self, path):
        self.bytes, self.at = path.read_bytes(), 0

    def take(self, kind, *shape):
        count = int(np.prod(shape))
        values = np.frombuffer(self.bytes, kind, count, self.at)
        self.at += values.nbytes
        return values.reshape(shape)

    def table(self, kind, width):
        rows, columns = self.take("<u4", 2)
        return self.take(kind, rows, columns, width) if width > 1 else self.take(kind, rows, columns)

    def row(self, kind):
        return self.take(kind, int(self.take("<u4", 1)[0]))

    def end(self):
        assert self.at == len(self.bytes), f"{len(self.bytes) - self.at} bytes are left"


def times(a, b):
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([aw * bw - (av * bv).sum(-1, keepdims=True), aw * bv + bw * av + np.cross(av, bv)], -1)


def inverse(q):
    return q * [1, -1, -1, -1]


def turned(q, v):
    return v + 2 * np.cross(q[..., 1:], np.cross(q[..., 1:], v) + q[..., :1] * v)


database = File(folder / "database.bin")
positions, velocities = database.table("<f4", 3).astype(float), database.table("<f4", 3).astype(float)
rotations, spins = database.table("<f4", 4).astype(float), database.table("<f4", 3).astype(float)
parents, starts, stops = database.row("<i4"), database.row("<i4"), database.row("<i4")
contacts = database.table("u1", 1)
database.end()
frames, bones = positions.shape[:2]
assert velocities.shape == spins.shape == positions.shape and rotations.shape == (frames, bones, 4)
assert contacts.shape == (frames, 2) and set(np.unique(contacts)) <= {0, 1}
assert parents[0] == -1 and all(0 <= parents[bone] < bone for bone in range(1, bones))
assert starts[0] == 0 and stops[-1] == frames and all(starts[1:] == stops[:-1]) and all(starts < stops)
held("length of quaternions less 1", np.abs(np.linalg.norm(rotations, axis=-1) - 1).max(), 1e-5)
held("height of the root", np.abs(positions[:, 0, 1]).max(), 0)
held("the root turns about the vertical", np.abs(rotations[:, 0, [1, 3]]).max(), 1e-6)
inner = np.ones(frames, bool)
inner[starts] = inner[stops - 1] = False
assert contacts.any() and not contacts.all()
before = np.roll(rotations, 1, 0)
follows = np.ones(frames, bool)
follows[starts] = False
held("signs of quaternions that jump", float((rotations * before).sum(-1)[follows].min() < 0), 0)

# Forward kinematics, with velocities as differences in the world.
world, at = np.empty_like(positions), np.empty_like(rotations)
for bone in range(bones):
    above = parents[bone]
    if above < 0:
        world[:, bone], at[:, bone] = positions[:, bone], rotations[:, bone]
    else:
        world[:, bone] = world[:, above] + turned(at[:, above], positions[:, bone])
        at[:, bone] = times(at[:, above], rotations[:, bone])
speed, spin = np.empty_like(positions), np.empty_like(positions)
for bone in range(bones):
    above = parents[bone]
    if above < 0:
        speed[:, bone], spin[:, bone] = velocities[:, bone], spins[:, bone]
    else:
        arm = turned(at[:, above], positions[:, bone])
        speed[:, bone] = speed[:, above] + turned(at[:, above], velocities[:, bone]) + np.cross(spin[:, above], arm)
        spin[:, bone] = spin[:, above] + turned(at[:, above], spins[:, bone])
differences = 30 * (np.roll(world, -1, 0) - np.roll(world, 1, 0))
off = np.linalg.norm(speed - differences, axis=-1)[inner]
held("velocities of the bones, m/s in the 99th percentile", np.percentile(off, 99), 0.02)

# The joints of `mocap fk` on the character. There, the root of the file is no joint.
joints = np.load(folder / "joints.npz")
found = world[starts[0] : stops[0], 1:]
is_joint = ~joints["end_sites"]
expected = joints["positions"][:, is_joint]
count = min(len(found), len(expected))
held("frames beside mocap fk", abs(len(found) - len(expected)), 1)
# `mocap retarget` knows the floor of a body's own motion. A character without motion stands at its rest height.
shift = (found[:count] - expected[:count]).mean((0, 1))
held("shift over the ground beside mocap fk, m", np.abs(shift[[0, 2]]).max(), 1e-3)
held("joints beside mocap fk, m", np.abs(found[:count] - expected[:count] - shift).max(), 1e-3)

# The features, as the database of the demonstration computes them.
names = [str(name) for name in joints["names"][is_joint]]
feet = [1 + names.index(foot) for foot in sys.argv[2].split(",")]
back = inverse(rotations[:, 0])
raw = [turned(back, world[:, foot] - positions[:, 0]) for foot in feet]
raw += [turned(back, speed[:, foot]) for foot in [*feet, 1]]
ends = np.concatenate([np.full(stop - start, stop - 1) for start, stop in zip(starts, stops)])
ahead = [np.minimum(np.arange(frames) + after, ends) for after in (20, 40, 60)]
raw.append(np.concatenate([turned(back, positions[then, 0] - positions[:, 0])[:, [0, 2]] for then in ahead], -1))
looks = turned(rotations[:, 0], np.broadcast_to([0.0, 0.0, 1.0], (frames, 3)))
raw.append(np.concatenate([turned(back, looks[then])[:, [0, 2]] for then in ahead], -1))
raw = np.concatenate(raw, -1)
mean, scale, column = raw.mean(0), np.empty(27), 0
for width, weight in WEIGHTS:
    scale[column : column + width] = raw[:, column : column + width].std(0).mean() / weight
    column += width

file = File(folder / "features.bin")
features, offset, divided = file.table("<f4", 1), file.row("<f4"), file.row("<f4")
file.end()
assert features.shape == (frames, 27) and offset.shape == divided.shape == (27,)
held("features", np.abs(features - (raw - mean) / scale).max(), 1e-3)
held("what was taken off", np.abs(offset - mean).max(), 1e-4)
held("what was divided by", np.abs(divided / scale - 1).max(), 1e-3)
sys.exit(failed)
