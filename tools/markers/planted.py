"""Places markers of CMU's set on the skeleton of a motion and adds errors from a seed. Then compares the skeleton of
`mocap solve` with the original, which is the exact truth. tools/clean/bvh.py has the kinematics.
"""

import argparse
import pathlib
import sys
import tempfile

import numpy as np
from scipy.spatial.transform import Rotation

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "clean"))
import bvh  # noqa: E402
from judge import angle, solve  # noqa: E402

NOISE = 0.001  # m, of each coordinate
GAPS = 0.10
GHOSTS = 0.01
SWAPS = 2 / 60  # a second
CENTRES = 0.005  # m
ANGLES = 1.5  # degrees
METRES = 0.056444  # in a unit of CMU's BVH files

# A marker: the joint that moves it, the joint beside it, and its offset from the latter in metres. The axes of the
# offset are those of a T-pose: left (outwards for the limbs), up, forward. Names are those of CMU's conversion to BVH.
MIDDLE = {
    "C7": ("Spine1", "Neck", (0.0, 0.02, -0.06)),
    "T10": ("Spine1", "Spine1", (0.0, 0.0, -0.10)),
    "CLAV": ("Spine1", "Neck", (0.0, -0.06, 0.07)),
    "STRN": ("Spine1", "Spine1", (0.0, 0.0, 0.12)),
}
SIDED = {
    "FWT": ("Hips", "UpLeg", (0.03, 0.09, 0.09)),
    "BWT": ("Hips", "UpLeg", (-0.04, 0.09, -0.11)),
    "THI": ("UpLeg", "UpLeg", (0.08, -0.22, 0.02)),
    "KNE": ("UpLeg", "Leg", (0.06, 0.0, 0.0)),
    "SHN": ("Leg", "Leg", (0.05, -0.2, 0.03)),
    "ANK": ("Leg", "Foot", (0.045, 0.0, 0.0)),
    "HEE": ("Foot", "Foot", (0.0, -0.05, -0.06)),
    "TOE": ("Foot", "ToeBase", (-0.02, 0.02, 0.0)),
    "MT5": ("Foot", "ToeBase", (0.04, 0.01, -0.02)),
    "SHO": ("Shoulder", "Arm", (0.0, 0.06, 0.0)),
    "UPA": ("Arm", "Arm", (0.15, 0.05, 0.0)),
    "ELB": ("Arm", "ForeArm", (0.0, 0.042, 0.0)),
    "FRM": ("ForeArm", "ForeArm", (0.12, 0.0, 0.04)),
    "WRA": ("ForeArm", "Hand", (0.0, 0.0, 0.035)),
    "WRB": ("ForeArm", "Hand", (0.0, 0.0, -0.035)),
    "FIN": ("Hand", "Hand", (0.08, 0.02, 0.0)),
    "FHD": ("Head", "Head", (0.07, 0.12, 0.08)),
    "BHD": ("Head", "Head", (0.06, 0.12, -0.08)),
}




def planted(motion, random):
    """Label -> (frames, 3) in metres, and the positions of the joints, which are the truth."""
    frames, joints = motion.turns.shape[:2]
    rest = np.zeros((joints, 3))
    world = [None] * joints
    for joint, parent in enumerate(motion.parents):
        local = Rotation.from_quat(motion.turns[:, joint])
        world[joint] = local if parent < 0 else world[parent] * local
        rest[joint] = motion.offsets[joint] + (rest[parent] if parent >= 0 else 0)
    places = motion.positions() * METRES
    index = {name: joint for joint, name in enumerate(motion.names)}
    markers = {}

    def plant(label, moved, beside, offset):
        joint = index[moved]
        # Real markers are never exactly at their specified positions.
        local = (rest[index[beside]] - rest[joint]) * METRES + np.array(offset) + random.normal(0, 0.005, 3)
        markers[label] = places[:, joint] + world[joint].apply(local)

    for label, (moved, beside, offset) in MIDDLE.items():
        plant(label, moved, beside, offset)
    for label, (moved, beside, offset) in SIDED.items():
        for side, sign in (("Left", 1), ("Right", -1)):
            joints = (name if name in ("Hips", "Head") else side + name for name in (moved, beside))
            plant(side[0] + label, *joints, (sign * offset[0], *offset[1:]))
    return markers, {name: places[:, joint] for name, joint in index.items()}


def spoiled(markers, rate, random):
    """Adds noise, gaps in runs, reflections, and pairs of markers with exchanged labels. Returns the list of these
    pairs."""
    labels = list(markers)
    track = np.stack([markers[label] for label in labels], 1)
    frames = len(track)
    track = track + random.normal(0, NOISE, track.shape)
    for _ in range(int(GAPS * frames * len(labels) / 30)):
        begin = random.integers(0, frames)
        track[begin : begin + random.integers(10, 50), random.integers(0, len(labels))] = np.nan
    ghosts = random.random(track.shape[:2]) < GHOSTS
    track[ghosts] += random.normal(0, 0.3, (ghosts.sum(), 3))
    swaps = []
    for _ in range(max(2, round(SWAPS * frames / rate))):
        a, b = random.choice(len(labels), 2, replace=False)
        begin = int(random.integers(0, frames - 30))
        last = begin + int(random.integers(10, 30))
        track[begin:last, [a, b]] = track[begin:last, [b, a]]
        swaps.append(({labels[a], labels[b]}, begin, last - 1))
    return labels, track, swaps


def trc(path, labels, track, rate):
    with open(path, "w") as file:
        file.write("PathFileType\t4\t(X/Y/Z)\tplanted.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n")
        file.write(f"{rate}\t{len(track)}\t{len(labels)}\tm\nFrame#\tTime\t" + "\t\t\t".join(labels) + "\n\n")
        for frame, row in enumerate(track):
            cells = ["" if np.isnan(value) else f"{value:.6f}" for value in row.ravel()]
            file.write(f"{frame + 1}\t{frame / rate:.6f}\t" + "\t".join(cells) + "\n")


JOINTS = {
    "UpperLeg": "UpLeg",
    "LowerLeg": "Leg",
    "Foot": "Foot",
    "UpperArm": "Arm",
    "LowerArm": "ForeArm",
    "Hand": "Hand",
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("motion")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hold", action="store_true")
    given = parser.parse_args()
    random = np.random.default_rng(given.seed)
    motion = bvh.read(given.motion)
    motion = motion.take(slice(1, None))  # the first frame is a T-pose
    markers, truth = planted(motion, random)
    labels, track, swaps = spoiled(markers, motion.rate, random)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "planted.trc"
        trc(path, labels, track, motion.rate)
        found, said = solve(given.mocap, path)
    places = dict(zip(found.names, found.positions().transpose(1, 0, 2)))
    errors = {}
    for ours, theirs in JOINTS.items():
        for side in ("left", "right"):
            off = places[side + ours] - truth[side.capitalize() + theirs]
            errors[side + ours] = np.linalg.norm(off, axis=1)
            print(f"{side + ours:24} {np.median(errors[side + ours]) * 1000:7.1f} mm median")
    centres = np.median(np.concatenate(list(errors.values())))
    angles = []
    for joints in (("UpperLeg", "LowerLeg", "Foot"), ("UpperArm", "LowerArm", "Hand")):
        for side in ("left", "right"):
            mine = angle(*(places[side + joint] for joint in joints))
            true = angle(*(truth[side.capitalize() + JOINTS[joint]] for joint in joints))
            angles.append(np.sqrt(np.mean((mine - true) ** 2)))
            print(f"{side} {joints[1]:19} {angles[-1]:7.2f} degrees RMS")
    named = 0
    lines = said.split("\n")
    for pair, first, last in swaps:
        hit = [
            line
            for place, line in enumerate(lines)
            if "swapped-markers" in line
            and any(label in line + " ".join(lines[place : place + 3]) for label in pair)
            and (words := line.split("frames ")[1].split())
            and int(words[0]) <= last
            and int(words[2].rstrip(":;")) >= first
        ]
        named += bool(hit)
    false = said.count("swapped-markers")
    print(f"centres {centres * 1000:.1f} mm median, wanted {CENTRES * 1000:.0f}")
    print(f"angles {max(angles):.2f} degrees RMS at most, wanted {ANGLES}")
    print(f"swaps named {named} of {len(swaps)}; {false} warnings of swaps")
    if given.hold and not (named == len(swaps) and centres <= CENTRES and max(angles) <= ANGLES):
        sys.exit("a swap was not named, or a value is worse than wanted")


if __name__ == "__main__":
    main()
