"""Judges `mocap solve` on CMU's take 01_01. It compares the solution of the C3D file's markers with the joints of the
AMC file, which CMU's system solved from the same markers. The C3D reader and the kinematics of ASF and BVH are in this
folder and use no code of mocap.

Prints results. With --hold, the exit code is 1 if a result is worse than the limits in README.md.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "clean"))
import acclaim  # noqa: E402
import bvh  # noqa: E402
import c3d  # noqa: E402

# A joint of mocap, and the bone of CMU's skeleton that ends at this joint. CMU's forearm is two bones, of which the
# second ends at the wrist.
ENDS = {
    "UpperLeg": "hipjoint",
    "LowerLeg": "femur",
    "Foot": "tibia",
    "UpperArm": "clavicle",
    "LowerArm": "humerus",
    "Hand": "wrist",
}
MARKERS = 15.0  # mm, RMS
CENTRES = 0.030  # m, median
ANGLES = 6.0  # degrees, RMS
FLIP = 90.0  # degrees between two frames at 120 Hz


def angle(a, b, c):
    """The angle in degrees between the two bones that meet at b; 0 if they are straight."""
    first, second = b - a, c - b
    cosine = (first * second).sum(-1) / np.linalg.norm(first, axis=-1) / np.linalg.norm(second, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def turned(turns):
    """The largest angle of each joint between two frames, in degrees."""
    cosine = np.abs((turns[1:] * turns[:-1]).sum(-1))
    return np.degrees(2 * np.arccos(np.clip(cosine, -1, 1))).max(0)


def solve(mocap, source, more=()):
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder) / "out.bvh"
        command = [mocap, "solve", str(source), "-o", str(output), "--out-unit", "m", *more]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        return bvh.read(output), done.stderr


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("c3d")
    parser.add_argument("asf")
    parser.add_argument("amc")
    parser.add_argument("--hold", action="store_true")
    given = parser.parse_args()
    motion, said = solve(given.mocap, given.c3d)
    print(said.strip())
    places = dict(zip(motion.names, motion.positions().transpose(1, 0, 2)))
    truth = {name: place / 1000 for name, place in acclaim.ends(given.asf, given.amc).items()}
    frames = min(len(truth["root"]), len(motion.root))
    truth = {name: place[:frames] for name, place in truth.items()}
    places = {name: place[:frames] for name, place in places.items()}
    # (x, y, z) of C3D is (x, z, -y) in mocap and (y, z, x) in CMU's skeleton.
    places = {name: np.stack([-p[:, 2], p[:, 1], p[:, 0]], 1) for name, p in places.items()}
    bad = []

    def hold(what, value, limit, unit, is_held=True):
        print(f"{what:32} {value:8.2f} {unit}, wanted {limit:.0f}")
        if value > limit and is_held:
            bad.append(f"{what}: {value:.2f} {unit}, allowed {limit:.2f}")

    errors = []
    for ours, theirs in ENDS.items():
        for side in ("left", "right"):
            off = np.linalg.norm(places[side + ours] - truth[side[0] + theirs], axis=1)
            errors.append(off)
            mean = (places[side + ours] - truth[side[0] + theirs]).mean(0) * 1000
            print(f"{side + ours:32} {np.median(off) * 1000:8.1f} mm median, {mean.round()} mean")
    hold("joint centres, median", np.median(np.concatenate(errors)) * 1000, CENTRES * 1000, "mm", is_held=False)
    hold("markers, RMS, as mocap says", float(said.split("residual ")[1].split(" mm")[0]), MARKERS, "mm")
    for name, ours, theirs in (
        ("Knee", ("UpperLeg", "LowerLeg", "Foot"), ("hipjoint", "femur", "tibia")),
        ("Elbow", ("UpperArm", "LowerArm", "Hand"), ("clavicle", "humerus", "wrist")),
    ):
        for side in ("left", "right"):
            mine = angle(*(places[side + joint] for joint in ours))
            other = angle(*(truth[side[0] + bone] for bone in theirs))
            hold(f"{side}{name}, RMS", np.sqrt(np.mean((mine - other) ** 2)), ANGLES, "degrees")
            print(f"{'':32} {(mine - other).mean():8.2f} degrees mean, {(mine - other).std():.2f} about it")
    steps = turned(motion.turns)
    worst = int(np.argmax(steps))
    hold(f"fastest: {motion.names[worst]}", steps[worst], FLIP, "degrees in a frame")
    if given.hold and bad:
        sys.exit("\n".join(bad))


if __name__ == "__main__":
    main()
