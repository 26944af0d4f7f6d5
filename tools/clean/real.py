"""Measures `mocap clean` on takes of cameras, sensors and a generator: python real.py MOCAP

`tools/bench/tables cleaned-takes` writes the table of docs/cleaning.md. If input and output are BVH, the script also
measures the jerk of all joints with the kinematics of bvh.py. It must equal the report's jerk within a tenth.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import bvh

ROOT = Path(__file__).parents[2]
FILES = [
    ("real/kinect_openni.bvh", "a depth camera"),
    ("real/nan_tokens.bvh", "a camera; 34 values are NaN"),
    ("real/slimevr_headset_root.bvh", "trackers of a headset, at rest"),
    ("real/z_up_dab.bvh", "a sensor suit"),
    ("real/mocopi_jump_six_channels.bvh", "six sensors"),
    ("real/rokoko_dance.bvh", "a sensor suit"),
    ("arrays/kimodo_soma_01.npz", "a generator, Kimodo"),
]
MEASURES = [("jumps", 1, 0), ("jitter", 1, 0), ("peak_speed", 1, 2), ("skate", 100, 1), ("floor_height", 100, 1)]


def jerk(path, metres):
    """The mean jerk of all joints in m/s3."""
    motion = bvh.read(path)
    motion.turns = np.nan_to_num(motion.turns)
    motion.turns[np.linalg.norm(motion.turns, axis=-1) < 0.5] = [0, 0, 0, 1]
    steps = np.diff(motion.positions(), 3, axis=0) * metres * motion.rate**3
    return np.linalg.norm(steps, axis=-1).mean()


def row(program, folder, name, what):
    source = ROOT / "fixtures" / name
    out, report = folder / f"{source.stem}.bvh", folder / f"{source.stem}.json"
    subprocess.run([program, "clean", source, "-o", out, "--force", "--report", report], check=True, capture_output=True)
    did = json.loads(report.read_text())["changed"]
    before, after = did["before"], did["after"]
    if source.suffix == ".bvh" and "nan" not in name:
        # A file keeps its unit.
        measured = [jerk(path, 1.0) for path in (source, out)]
        ratios = [m / max(b["jitter"], 1e-9) for m, b in zip(measured, (before, after))]
        if before["jitter"] > 1 and abs(ratios[0] / ratios[1] - 1) > 0.1:
            print(f"note: {name}: the jerk measured here is {ratios[0]:.3f} and {ratios[1]:.3f} of what the report says")
    cells = [f"`{source.name}`, {what}"]
    for measure, factor, digits in MEASURES:
        values = [side.get(measure) for side in (before, after)]
        words = ["-" if value is None else f"{factor * value + 0.0:.{digits}f}" for value in values]
        cells.append(" → ".join(words) if words[0] != words[1] else words[0])
    parts = [f"{part['part']}: {part['about']}" for part in did["parts"] if part["outcome"] == "changed"]
    back = [f"{part['part']} undone" for part in did["parts"] if part["outcome"] == "taken-back"]
    cells.append("; ".join(parts + back + did["doubts"]) or "nothing")
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    args = parser.parse_args()
    lines = ["| take | jumps | jitter m/s³ | peak speed m/s | skate cm/s | floor cm | what was done |", "|---|---|---|---|---|---|---|"]
    with tempfile.TemporaryDirectory() as folder:
        lines += [row(str(Path(args.program).resolve()), Path(folder), *file) for file in FILES]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
