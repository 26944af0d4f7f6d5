#!/usr/bin/env python3
"""Poses another author's figure with the arrays that the program writes, and compares it with the source file.

    posed_by_another.py PROGRAM [--least=N] MOTION ...

`mannequin-x` of PyPI poses SMPL-X's joints in NumPy, and shares nothing with this program. The two rest poses differ.
So each joint is compared by its rotation in the world since the first frame, which does not depend on the rest pose.
The difference has two parts: the change of the limb's direction, and the roll about the limb. The limits are 0.5 and 2
degrees. With --least, files without a humanoid are omitted, and at least N files must be compared.
"""
import json, re, subprocess, sys, tempfile
import numpy as np
from mannequin import Mannequin

# The number of the joint in SMPL-X, the number of the next joint, and the humanoid bone of the next joint.
LIMBS = {"leftUpperLeg": (1, 4, "leftLowerLeg"), "rightUpperLeg": (2, 5, "rightLowerLeg"),
         "leftLowerLeg": (4, 7, "leftFoot"), "rightLowerLeg": (5, 8, "rightFoot"),
         "leftUpperArm": (16, 18, "leftLowerArm"), "rightUpperArm": (17, 19, "rightLowerArm"),
         "leftLowerArm": (18, 20, "leftHand"), "rightLowerArm": (19, 21, "rightHand")}


def run(*words):
    return subprocess.run(words, capture_output=True, text=True)


def angle(a, b):
    """The angle between two vectors in degrees."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, -1)))


def compare(program, file, model, folder):
    """The largest angles of directions and of rolls, the number of frames, and the number of limbs that move by
    positions. None for a file without a humanoid."""
    own, posed = f"{folder}/own.npz", f"{folder}/smplx.npz"
    written = run(program, "fk", file, "-o", posed, "--to", "smplx", "--quiet", "--force")
    found = run(program, "skeleton", file, "--json")
    if written.returncode or found.returncode:
        return None
    skeleton = json.loads(found.stdout)
    bones = {bone: row["joint"] for bone, row in skeleton["humanoid"]["bones"].items()}
    if skeleton["sides"]["value"] == "opposite":
        # The file's left side is the right side here.
        other = {"left": "right", "right": "left"}
        bones = {re.sub("^(left|right)", lambda side: other[side[0]], bone): joint for bone, joint in bones.items()}
    run(program, "fk", file, "-o", own, "--rot", "matrix", "--rot-space", "world", "--out-up", "y", "--quiet", "--force")
    source, arrays = np.load(own), np.load(posed)
    names = [str(name) for name in source["names"]]
    pose = model.rest_pose()
    count = len(arrays["body_pose"])
    transforms = []
    for frame in range(count):
        pose["body_pose"] = arrays["body_pose"][frame].reshape(21, 3)
        pose["pelvis_rotation"] = arrays["global_orient"][frame]
        transforms.append(model.joint_transforms(pose)[:22, :3, :])
    transforms = np.array(transforms, float)
    direction = roll = 0.0
    moving = 0
    for bone, (joint, child, below) in LIMBS.items():
        if bone not in bones or below not in bones:
            continue
        theirs = source["rotations"][:, names.index(bones[bone])].astype(float)
        # A file may move the next joint by its position. The joint's rotation then differs from the limb's.
        there = source["positions"][:, names.index(bones[below])] - source["positions"][:, names.index(bones[bone])]
        there = np.einsum("tji,tj->ti", theirs, there.astype(float))
        if angle(there, np.broadcast_to(there[0], there.shape)).max() > 0.1:
            moving += 1
            continue
        theirs = theirs @ theirs[0].T
        ours = transforms[:, joint, :, :3] @ transforms[0, joint, :, :3].T
        limb = transforms[0, child, :, 3] - transforms[0, joint, :, 3]
        limb /= np.linalg.norm(limb)
        direction = max(direction, angle(ours @ limb, theirs @ limb).max())
        across = np.cross(limb, [0.3, 0.5, 0.8])
        across /= np.linalg.norm(across)
        # The rest of the difference in the frame of the limb: the roll about it.
        left = np.einsum("tji,tjk->tik", ours, theirs) @ across
        left -= (left @ limb)[:, None] * limb
        roll = max(roll, angle(left, np.broadcast_to(across, left.shape)).max())
    return direction, roll, count, moving


program, files = sys.argv[1], [word for word in sys.argv[2:] if not word.startswith("--")]
least = max((int(word[8:]) for word in sys.argv if word.startswith("--least=")), default=len(files))
model = Mannequin("wooden", flat_hand_mean=True)
compared = bad = 0
with tempfile.TemporaryDirectory() as folder:
    for file in files:
        found = compare(program, file, model, folder)
        if found is None:
            print(file, "left out")
            continue
        direction, roll, count, moving = found
        print(f"{file} {count} frames: directions {direction:.3f}, roll {roll:.3f} degrees" +
              (f"; {moving} limbs move by positions" if moving else ""))
        compared += 1
        bad += direction > 0.5 or roll > 2
print(f"mannequin: {compared} clips, {bad} beyond 0.5 degrees of direction or 2 of roll")
sys.exit(bad > 0 or compared < least)
