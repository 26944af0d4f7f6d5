#!/usr/bin/env python3
"""Computes HumanML3D's 263 numbers in NumPy, after the notebook that defines them, and compares the program's numbers.

    humanml3d.py PROGRAM [--least=N] MOTION ...     compares the program's output for motions. With --least, files
                                                    without a humanoid or with too few frames are omitted, and at least
                                                    N files must be compared.
    humanml3d.py --vectors JOINTS.npy VECTORS.npy   compares the published numbers of a clip with this script's

The skeleton keeps the lengths of the input, because the common skeleton of the data set comes from a licensed body.
"""
import subprocess, sys, tempfile
import numpy as np

RAW = np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, -1, 0], [0, 1, 0], [0, -1, 0], [0, -1, 0],
                [0, 1, 0], [0, 0, 1], [0, 0, 1], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]] + [[0, -1, 0]] * 6, float)
CHAINS = [[0, 2, 5, 8, 11], [0, 1, 4, 7, 10], [0, 3, 6, 9, 12, 15], [9, 14, 17, 19, 21], [9, 13, 16, 18, 20]]


def unit(v, otherwise=(0, 0, 1)):
    """Vectors of length 1; vectors of length 0 become `otherwise`."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.where(length > 0, v / np.where(length > 0, length, 1), otherwise)


def arc(a, b):
    """The matrix of the shortest rotation from a to b (Rodrigues)."""
    a, b = np.broadcast_arrays(unit(a), unit(b, a))
    v, c = np.cross(a, b), np.sum(a * b, -1)[..., None, None]
    z = np.zeros(v.shape[:-1])
    k = np.stack([np.stack([z, -v[..., 2], v[..., 1]], -1), np.stack([v[..., 2], z, -v[..., 0]], -1),
                  np.stack([-v[..., 1], v[..., 0], z], -1)], -2)
    return np.eye(3) + k + k @ k / (1 + c)


def smooth(values, deviation=20, reach=80):
    taps = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    taps /= taps.sum()
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(padded[:, axis], taps, "valid") for axis in range(values.shape[1])], -1)


def vectors(p):
    p = p.astype(float).copy()
    p[..., 1] -= p[..., 1].min()
    p -= p[0, 0] * [1, 0, 1]
    first = p[0]
    across = first[2] - first[1] + first[17] - first[16]
    p = p @ arc(np.cross([0, 1, 0], across), np.array([0, 0, 1.0])).T
    across = unit(p[:, 1] - p[:, 2] + p[:, 17] - p[:, 16])
    forward = unit(smooth(np.cross([0, 1, 0], across)))
    root = arc(forward, np.array([0, 0, 1.0]))
    root[0] = np.eye(3)  # as in the data set: see a commented line of the notebook
    # The shortest rotation from a heading to +Z as a quaternion, whose w is not negative. Where the heading passes -Z,
    # the product of two such quaternions has a negative w. The arcsine of its y then gives the supplement of the angle,
    # as in the data set.
    w, y = 1 + forward[:, 2], -forward[:, 0]
    w, y = w / np.hypot(w, y), y / np.hypot(w, y)
    w[0], y[0] = 1, 0
    half = np.arcsin(np.clip(y[1:] * w[:-1] - w[1:] * y[:-1], -1, 1))
    way = np.einsum("tij,tj->ti", root[1:], p[1:, 0] - p[:-1, 0])
    local = p - p[:, :1] * [1, 0, 1]
    ric = np.einsum("tij,tkj->tki", root, local)
    rotations = np.tile(np.eye(3), (len(p), 22, 1, 1))
    for chain in CHAINS:
        above = root
        for parent, child in zip(chain, chain[1:]):
            own = arc(RAW[child], p[:, child] - p[:, parent])
            rotations[:, child] = np.swapaxes(above, 1, 2) @ own
            above = own
    six = np.concatenate([rotations[..., 0], rotations[..., 1]], -1)
    velocity = np.einsum("tij,tkj->tki", root[:-1], p[1:] - p[:-1])
    feet = (np.sum((p[1:] - p[:-1])[:, [7, 10, 8, 11]] ** 2, -1) < 0.002).astype(float)
    n = len(p) - 1
    return np.concatenate([half[:, None], way[:, [0, 2]], p[:-1, 0, 1:2], ric[:-1, 1:].reshape(n, -1),
                           six[:-1, 1:].reshape(n, -1), velocity.reshape(n, -1), feet], 1)


def worst(a, b, what):
    parts = {"heading": (0, 1), "way": (1, 3), "height": (3, 4), "joints": (4, 67), "rotations": (67, 193),
             "velocities": (193, 259), "contacts": (259, 263)}
    found = {name: float(np.abs(a[:, i:j] - b[:, i:j]).max()) for name, (i, j) in parts.items()}
    print(what, " ".join(f"{name} {value:.1e}" for name, value in found.items()))
    return max(value for name, value in found.items())


if sys.argv[1] == "--vectors":
    made, published = vectors(np.load(sys.argv[2])), np.load(sys.argv[3])
    n = len(made)
    # Headings are smoothed over 80 frames, and the published clip had one frame more than its joints.
    worst(made, published[:n], "all frames:")
    sys.exit(worst(made[: n - 81], published[: n - 81], "but the last 80:") > 1e-4)

bad = compared = 0
least = [int(word[8:]) for word in sys.argv[2:] if word.startswith("--least=")]
for file in (word for word in sys.argv[2:] if not word.startswith("--")):
    with tempfile.TemporaryDirectory() as folder:
        # Uses the program's own positions of its skeleton, so that the comparison leaves out the solver.
        for layout, name in (("kimodo", "k.npz"), ("humanml3d", "h.npy")):
            command = [sys.argv[1], "fk", file, "-o", f"{folder}/{name}", "--to", layout, "--quiet"]
            made = subprocess.run(command, capture_output=bool(least), text=True)
            if made.returncode != 0:
                break
        if made.returncode != 0:
            if not least:
                sys.exit(made.returncode)
            print(file, "left out:", made.stderr.strip().split("\n")[0].split("]: ")[-1])
            continue
        body, rows = np.load(f"{folder}/k.npz"), np.load(f"{folder}/h.npy")
        rate = float(body["fps"])
        count = int((len(body["posed_joints"]) - 1) / (rate / 20)) + 1
        frames = np.minimum(np.floor(np.arange(count) * rate / 20 + 0.5).astype(int), len(body["posed_joints"]) - 1)
        bad += worst(vectors(body["posed_joints"][frames]), rows, file) > 1e-4
        compared += 1
print(f"HumanML3D: {compared} clips compared, {bad} beyond 1e-4")
sys.exit(bad > 0 or compared < max(least, default=0))
