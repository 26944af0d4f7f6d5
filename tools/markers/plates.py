"""Makes C3D files with events, analog channels and force plates, and compares what mocap reads of them with what ezc3d
reads: plates.py MOCAP [--make FILE]. The forces of somebody who stands on the plates are made by a seed."""

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


def channels_of(kind, samples, rng):
    """Raw values of a plate on which somebody stands: forces of the ground, in the axes of the plate, z down."""
    force = np.stack([60 * np.sin(samples / 9), 40 * np.cos(samples / 7), -700 - 80 * np.sin(samples / 5)])
    centre = np.stack([30 * np.cos(samples / 11), 90 * np.sin(samples / 13)])
    force[:, samples < 12] = rng.normal(0, 0.3, (3, 12))  # nobody is there yet
    vertical = 3000 * np.sin(samples / 6)
    moment = np.stack([centre[1] * force[2], -centre[0] * force[2], centre[0] * force[1] - centre[1] * force[0] + vertical])
    if kind == 1:
        return np.concatenate([force, centre, vertical[None]])
    if kind in (2, 4):
        return np.concatenate([force, moment])
    a, b = 120.0, 200.0
    part = force[2] / 4
    z = [part + moment[0] / (4 * b) - moment[1] / (4 * a), part + moment[0] / (4 * b) + moment[1] / (4 * a),
         part - moment[0] / (4 * b) + moment[1] / (4 * a), part - moment[0] / (4 * b) - moment[1] / (4 * a)]
    x12 = force[0] / 2 - moment[2] / (4 * b)
    y14 = force[1] / 2 + moment[2] / (4 * a)
    return np.stack([x12, force[0] - x12, y14, force[1] - y14, *z])


def make(path, kinds, processor="intel", scale=-1.0, seed=7):
    """The raw values of the file; those of channels are less an offset, times a scale."""
    rng = np.random.default_rng(seed)
    samples = np.arange(FRAMES * PER_FRAME, dtype=float)
    points = np.concatenate([rng.normal(0, 300, (FRAMES, 2, 3)), np.zeros((FRAMES, 2, 1))], axis=2)
    blocks = [channels_of(kind, samples, rng) for kind in kinds]
    values = np.concatenate([*blocks, rng.normal(0, 2e-5, (1, len(samples)))])
    units = sum(({1: ["N", "N", "N", "mm", "mm", "Nmm"], 2: ["N"] * 3 + ["Nmm"] * 3, 3: ["N"] * 8, 4: ["V"] * 6}[kind]
                 for kind in kinds), []) + ["V"]
    labels = [f"P{plate + 1}C{channel + 1}" for plate, block in enumerate(blocks) for channel in range(len(block))] + ["EMG"]
    scales = np.abs(values).max(axis=1) / 30000
    offsets = rng.integers(0, 9, len(values))  # ezc3d takes negative ones without their sign
    raw = values / scales[:, None] + offsets[:, None]
    size = max(len(block) for block in blocks)
    channel = np.zeros((size, len(kinds)), dtype=int)
    first = 1
    for plate, block in enumerate(blocks):
        channel[: len(block), plate] = np.arange(first, first + len(block))
        first += len(block)
    corners = np.zeros((3, 4, len(kinds)))
    for plate in range(len(kinds)):
        turn = 0.3 * plate  # seen from above a plate's x goes on, its y to the other side, its z down
        x = np.array([np.cos(turn), np.sin(turn), 0])
        y = np.array([np.sin(turn), -np.cos(turn), 0])
        middle = np.array([200 + 700 * plate, 150, 0])
        for corner, (u, v) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
            corners[:, corner, plate] = middle + 232 * u * x + 254 * v * y
    origin = np.array([[0, 0, 0] if kind == 1 else [120, 200, -30] if kind == 3 else [1.5, -2.5, -38] for kind in kinds])
    matrix = np.eye(6)[:, :, None] * np.ones(len(kinds)) + rng.normal(0, 1e-4, (6, 6, len(kinds)))
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
    for _ in range(2):  # where the data begin follows from the length of what says so
        groups["POINT"]["DATA_START"] = np.array([blocks])
        write(path, points, raw, groups, rate=RATE, per_frame=PER_FRAME, first=FIRST, processor=processor, scale=scale)
        blocks = 2 + pathlib.Path(path).read_bytes()[512 + 2]


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


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap", type=pathlib.Path)
    parser.add_argument("--make", type=pathlib.Path, help="write the file with types 2, 3 and 4, and end")
    arguments = parser.parse_args()
    if arguments.make:
        return make(arguments.make, [2, 3, 4])
    with tempfile.TemporaryDirectory() as folder:
        for kinds in ([2], [3], [4], [2, 3, 4], [4, 2]):
            for processor, scale in (("intel", -1.0), ("intel", 0.1), ("dec", -1.0), ("dec", 0.1)):
                path = pathlib.Path(folder) / "plates.c3d"
                make(path, kinds, processor, scale)
                compare(arguments.mocap, path, kinds)
                # ezc3d does not read SGI's numbers: they are beside Intel's.
                if processor == "intel":
                    own = {name: table(arguments.mocap, name, path) for name in ("analog", "forces")}
                    make(path, kinds, "sgi", scale)
                    for command, columns in own.items():
                        again = table(arguments.mocap, command, path)
                        assert all(np.allclose(values, again[name], rtol=1e-6) for name, values in columns.items()), command


if __name__ == "__main__":
    main()
