"""Makes C3D files with events, analog channels and force plates, and compares mocap with ezc3d. For plates that ezc3d
does not read (types 5 to 7), it compares mocap with the original forces: plates.py MOCAP [--make FILE [--types 5,6,7]].
A seed gives the forces of a person on the plates."""

import argparse
import json
import pathlib
import subprocess
import tempfile

import ezc3d
import numpy as np

from c3d_write import write

FRAMES, RATE, PER_FRAME = 20, 100.0, 4
FIRST = 11  # the number of the first frame
EVENTS = [("Foot Strike", "Left", 0.14), ("Foot Off", "Right", 0.17), ("Foot Strike", "Right", 0.25)]


HALF = np.array([120.0, 200.0])  # half the distances between the sensors at the corners
MATRIX = {4: (6, 6), 5: (6, 8), 6: (12, 12), 7: (8, 8)}
CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6, 5: 8, 6: 12, 7: 8}


def origin_of(kind):
    return [0, 0, 0] if kind == 1 else [*HALF, -30] if kind in (3, 6, 7) else [1.5, -2.5, -38]


def wrench(samples, rng):
    """Force, centre and free moment of the ground, in the axes of the plate, z down."""
    force = np.stack([60 * np.sin(samples / 9), 40 * np.cos(samples / 7), -700 - 80 * np.sin(samples / 5)])
    centre = np.stack([30 * np.cos(samples / 11), 90 * np.sin(samples / 13)])
    force[:, samples < 12] = rng.normal(0, 0.3, (3, 12))  # nobody is on the plate yet
    return force, centre, 3000 * np.sin(samples / 6)


def channels_of(kind, force, centre, vertical, matrix):
    """Raw values of a plate on which a person stands."""
    moment = np.stack([centre[1] * force[2], -centre[0] * force[2], centre[0] * force[1] - centre[1] * force[0] + vertical])
    if kind == 1:
        return np.concatenate([force, centre, vertical[None]])
    if kind in (2, 4):
        return np.concatenate([force, moment])
    if kind == 5:  # the matrix gives force and moment about the origin of the sensors
        about = moment - np.cross(force.T, origin_of(5)).T
        return np.linalg.pinv(matrix) @ np.concatenate([force, about])
    a, b = HALF
    if kind in (6, 7):  # sensors are below the surface
        moment = moment - np.cross(force.T, [0, 0, origin_of(kind)[2]]).T
    part = force[2] / 4
    z = [part + moment[0] / (4 * b) - moment[1] / (4 * a), part + moment[0] / (4 * b) + moment[1] / (4 * a),
         part - moment[0] / (4 * b) + moment[1] / (4 * a), part - moment[0] / (4 * b) - moment[1] / (4 * a)]
    x12 = force[0] / 2 - moment[2] / (4 * b)
    y14 = force[1] / 2 + moment[2] / (4 * a)
    x34, y23 = force[0] - x12, force[1] - y14
    if kind == 6:
        shares = [(x12 * 0.4, y14 * 0.7), (x12 * 0.6, y23 * 0.2), (x34 * 0.5, y23 * 0.8), (x34 * 0.5, y14 * 0.3)]
        return np.linalg.inv(matrix) @ np.stack([row for (x, y), up in zip(shares, z) for row in (x, y, up)])
    values = np.stack([x12, x34, y14, y23, *z])
    return values if kind == 3 else np.linalg.inv(matrix) @ values


def matrices(kinds, rng):
    """An array with room for the largest matrix; smaller matrices fill its corner."""
    rows, columns = np.max([MATRIX.get(kind, (6, 6)) for kind in kinds], axis=0)
    matrix = rng.normal(0, 1, (rows, columns, len(kinds)))
    for plate, kind in enumerate(kinds):
        own = MATRIX.get(kind, (6, 6))
        crosstalk = (1e-4 if kind < 5 else 0.05) * matrix[: own[0], : own[1], plate]
        matrix[:, :, plate] = 0
        matrix[: own[0], : own[1], plate] = np.eye(*own) + crosstalk
    return matrix


def make(path, kinds, processor="intel", scale=-1.0, seed=7):
    """The raw values of the file. The value of a channel is (raw - offset) x scale. Returns the original forces."""
    rng = np.random.default_rng(seed)
    samples = np.arange(FRAMES * PER_FRAME, dtype=float)
    points = np.concatenate([rng.normal(0, 300, (FRAMES, 2, 3)), np.zeros((FRAMES, 2, 1))], axis=2)
    truth = [wrench(samples, rng) for _ in kinds]
    emg = rng.normal(0, 2e-5, (1, len(samples)))
    offsets = rng.integers(0, 9, sum(CHANNELS[kind] for kind in kinds) + 1)  # ezc3d ignores the sign of negative values
    matrix = matrices(kinds, rng)
    own = [matrix[: MATRIX[kind][0], : MATRIX[kind][1], plate] if kind in MATRIX else None for plate, kind in enumerate(kinds)]
    blocks = [channels_of(kind, *truth[plate], own[plate]) for plate, kind in enumerate(kinds)]
    values = np.concatenate([*blocks, emg])
    units = sum(({1: ["N", "N", "N", "mm", "mm", "Nmm"], 2: ["N"] * 3 + ["Nmm"] * 3, 3: ["N"] * 8}.get(kind, ["V"] * CHANNELS[kind])
                 for kind in kinds), []) + ["V"]
    labels = [f"P{plate + 1}C{channel + 1}" for plate, block in enumerate(blocks) for channel in range(len(block))] + ["EMG"]
    scales = np.abs(values).max(axis=1) / 30000
    raw = values / scales[:, None] + offsets[:, None]
    size = max(len(block) for block in blocks)
    channel = np.zeros((size, len(kinds)), dtype=int)
    first = 1
    for plate, block in enumerate(blocks):
        channel[: len(block), plate] = np.arange(first, first + len(block))
        first += len(block)
    corners = np.zeros((3, 4, len(kinds)))
    for plate in range(len(kinds)):
        turn = 0.3 * plate  # seen from above, a plate's x points ahead, its y to the other side, its z down
        x = np.array([np.cos(turn), np.sin(turn), 0])
        y = np.array([np.sin(turn), -np.cos(turn), 0])
        middle = np.array([200 + 700 * plate, 150, 0])
        for corner, (u, v) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
            corners[:, corner, plate] = middle + 232 * u * x + 254 * v * y
    origin = np.array([origin_of(kind) for kind in kinds])
    groups = {
        "POINT": {"USED": np.array([2]), "SCALE": np.array([scale]), "RATE": np.array([RATE]), "DATA_START": np.array([0]),
                  "FRAMES": np.array([FRAMES]), "LABELS": ["LANK", "RANK"], "DESCRIPTIONS": ["a", "b"], "UNITS": "mm"},
        "ANALOG": {"USED": np.array([len(values)]), "LABELS": labels, "DESCRIPTIONS": labels, "GEN_SCALE": np.array([1.0]),
                   "SCALE": scales, "OFFSET": offsets, "UNITS": units, "RATE": np.array([RATE * PER_FRAME]),
                   "FORMAT": "SIGNED", "BITS": np.array([16])},
        "FORCE_PLATFORM": {"USED": np.array([len(kinds)]), "TYPE": np.array(kinds), "CORNERS": corners,
                           "ORIGIN": origin.T.astype(float), "CHANNEL": channel, "ZERO": np.array([1, 0]), "CAL_MATRIX": matrix},
        "TRIAL": {"ACTUAL_START_FIELD": np.array([FIRST, 0]), "ACTUAL_END_FIELD": np.array([FIRST + FRAMES - 1, 0])},
        "EVENT": {"USED": np.array([len(EVENTS)]), "LABELS": [label for label, _, _ in EVENTS],
                  "CONTEXTS": [context for _, context, _ in EVENTS],
                  "TIMES": np.array([[0.0] * len(EVENTS), [time for *_, time in EVENTS]])},
    }
    blocks = 2
    for _ in range(2):  # the start of the data depends on the length of the section that states it
        groups["POINT"]["DATA_START"] = np.array([blocks])
        write(path, points, raw, groups, rate=RATE, per_frame=PER_FRAME, first=FIRST, processor=processor, scale=scale)
        blocks = 2 + pathlib.Path(path).read_bytes()[512 + 2]
    return truth, corners


def table(mocap, command, path):
    text = subprocess.run([mocap, command, str(path), "-o", "-", "--quiet"], capture_output=True, text=True, check=True).stdout
    lines = text.splitlines()
    names = lines[0].split(",")
    return dict(zip(names, np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]]).T))


def turned(vectors):
    """From +Z up to +Y up."""
    return np.stack([vectors[0], vectors[2], -vectors[1]])


def compare(mocap, path, kinds):
    theirs = ezc3d.c3d(str(path), extract_forceplat_data=True)
    names = theirs["parameters"]["ANALOG"]["LABELS"]["value"]
    ours = table(mocap, "analog", path)
    values = theirs["data"]["analogs"][0]
    off = max(np.abs(ours[name] - values[index]).max() / np.abs(values[index]).max() for index, name in enumerate(names))
    print(f"types {kinds}: {len(names)} analog channels of {values.shape[1]} samples: {off:.1e} off, relative")
    assert off < 1e-6 and np.allclose(ours["time"], np.arange(values.shape[1]) / (RATE * PER_FRAME), atol=1e-6)
    forces = table(mocap, "forces", path)
    worst = {"force, N": 0.0, "centre, m": 0.0, "moment, N m": 0.0}
    for plate in range(len(kinds)):
        own = theirs["data"]["platform"][plate]
        loaded = np.abs(own["force"][2]) > 10
        pairs = [("force, N", "ground_force_{}_v", own["force"], loaded | True),
                 ("centre, m", "ground_force_{}_p", own["center_of_pressure"] / 1000, loaded),
                 ("moment, N m", "ground_moment_{}_m", own["Tz"] / 1000, loaded)]
        for what, name, vectors, where in pairs:
            mine = np.stack([forces[name.format(plate + 1) + axis] for axis in "xyz"])
            worst[what] = max(worst[what], np.abs(mine - turned(vectors))[:, where].max())
    print("  largest differences from ezc3d:", ", ".join(f"{what}: {off:.1e}" for what, off in worst.items()))
    assert worst["force, N"] < 1e-3 and max(worst["centre, m"], worst["moment, N m"]) < 1e-6, worst
    info = json.loads(subprocess.run([mocap, "info", "--json", str(path)], capture_output=True, text=True, check=True).stdout)
    events = [(event["label"], event["context"], event["time"]) for event in info["recorded"]["events"]]
    for (label, context, time), (own, side, seconds) in zip(EVENTS, events, strict=True):
        assert (label, context) == (own, side) and abs(time - (FIRST - 1) / RATE - seconds) < 1e-6, (time, seconds)
    assert [plate["plate_type"] for plate in info["recorded"]["plates"]] == kinds


def compare_planted(mocap, path, kinds, truth, corners):
    """Plates that ezc3d does not read."""
    forces = table(mocap, "forces", path)
    worst = {"force, N": 0.0, "centre, m": 0.0, "moment, N m": 0.0}
    for plate, (force, centre, vertical) in enumerate(truth):
        corner = corners[:, :, plate]
        x, y = corner[:, 0] - corner[:, 1], corner[:, 0] - corner[:, 3]
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        axes = np.stack([x, y, np.cross(x, y)], axis=1)
        flat = np.zeros_like(centre[0])
        loaded = np.abs(force[2]) > 10
        pairs = [("force, N", "ground_force_{}_v", axes @ force, loaded | True),
                 ("centre, m", "ground_force_{}_p", (corner.mean(axis=1)[:, None] + axes @ np.stack([*centre, flat])) / 1000, loaded),
                 ("moment, N m", "ground_moment_{}_m", axes @ np.stack([flat, flat, vertical]) / 1000, loaded)]
        for what, name, vectors, where in pairs:
            mine = np.stack([forces[name.format(plate + 1) + axis] for axis in "xyz"])
            worst[what] = max(worst[what], np.abs(mine - turned(vectors))[:, where].max())
    print(f"types {kinds}: largest differences from what was put in:", ", ".join(f"{what}: {off:.1e}" for what, off in worst.items()))
    # The file has raw values of 1e5 in single precision.
    assert worst["force, N"] < 5e-3 and max(worst["centre, m"], worst["moment, N m"]) < 5e-5, worst


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap", type=pathlib.Path)
    parser.add_argument("--make", type=pathlib.Path, help="write a file, and end")
    parser.add_argument("--types", default="2,3,4", help="the plates of that file")
    arguments = parser.parse_args()
    if arguments.make:
        return make(arguments.make, [int(kind) for kind in arguments.types.split(",")])
    with tempfile.TemporaryDirectory() as folder:
        for kinds in ([5], [6], [7], [5, 6, 7], [7, 5]):
            path = pathlib.Path(folder) / "plates.c3d"
            compare_planted(arguments.mocap, path, kinds, *make(path, kinds))
        for kinds in ([2], [3], [4], [2, 3, 4], [4, 2]):
            for processor, scale in (("intel", -1.0), ("intel", 0.1), ("dec", -1.0), ("dec", 0.1)):
                path = pathlib.Path(folder) / "plates.c3d"
                make(path, kinds, processor, scale)
                compare(arguments.mocap, path, kinds)
                # ezc3d does not read SGI's numbers, so they are compared with Intel's.
                if processor == "intel":
                    own = {name: table(arguments.mocap, name, path) for name in ("analog", "forces")}
                    make(path, kinds, "sgi", scale)
                    for command, columns in own.items():
                        again = table(arguments.mocap, command, path)
                        assert all(np.allclose(values, again[name], rtol=1e-6) for name, values in columns.items()), command


if __name__ == "__main__":
    main()
