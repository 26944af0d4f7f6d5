#!/usr/bin/env python3
"""Compares how `mocap solve` rolls the bones of limbs with the rotations of the source file.

    roll.py [--least=PERCENT] [--truth=JSON] [--bones] PROGRAM FOLDER/FILE.bvh ...

With --least, the script fails if fewer than PERCENT of the frames are within 10 degrees.

The positions of the joints that fixtures/skeletons/truth.json maps by hand go to `mocap solve`; this script reads
files, poses them and measures angles with NumPy, without mocap. In the rest poses of files, the axes of a bone have
different rolls. So the median roll over the clip is subtracted for each bone, in the file and in the solution. Only
frames count in which the knee or the elbow is bent by 20 degrees or more. Two more columns show the limits of the
comparison: `hinge` is the fraction of frames in which the axis of the bent limb is within 10 degrees of its median in
the file's bone. Positions contain no more than this axis. `flips` counts flips that only the solved bone
has: rolls by more than 60 degrees between two frames, beyond the shortest turn of the bone's direction.
"""
import json, os, subprocess, sys, tempfile
import numpy as np

BENT, NEAR, FLIP = 20, 10, 60
LIMBS = [(side + upper, side + lower, side + end, side + name) for side in ("left", "right")
         for upper, lower, end, name in (("UpperArm", "LowerArm", "Hand", "UpperArm"), ("UpperLeg", "LowerLeg", "Foot", "UpperLeg"))]


def rotation(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    m = np.zeros((len(degrees), 3, 3))
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    m[:, axis, axis] = 1
    m[:, a, a], m[:, b, b], m[:, a, b], m[:, b, a] = c, c, -s, s
    return m


class Bvh:
    """Joints, parents, and the world positions and rotations of the joints in every frame."""

    def __init__(self, path):
        text = open(path, encoding="utf-8", errors="replace").read()
        head, motion = text.split("MOTION", 1)
        self.names, self.parents, self.offsets, channels, stack, skip = [], [], [], [], [], 0
        lines = [line.strip() for line in head.splitlines() if line.strip()]
        for line in lines:
            words = line.split()
            if words[0] in ("ROOT", "JOINT"):
                self.names.append(" ".join(words[1:]).rstrip("{").strip())
                self.parents.append(stack[-1] if stack else None)
                self.offsets.append(np.zeros(3))
                channels.append([])
                new = len(self.names) - 1
            elif words[0].lower() == "end":
                new = None
            elif words[0] == "{":
                stack.append(new)
            elif words[0] == "}":
                stack.pop()
            elif words[0] == "OFFSET" and stack[-1] is not None:
                self.offsets[stack[-1]] = np.array([float(word) for word in words[1:4]])
            elif words[0] == "CHANNELS":
                channels[stack[-1]] = words[2:2 + int(words[1])]
        lines = motion.split("\n")
        at = next(i for i, line in enumerate(lines) if line.strip().startswith("Frame Time"))
        self.rate = 1 / float(lines[at].split(":")[1])
        width = sum(map(len, channels))
        rows = np.array(" ".join(lines[at + 1:]).split(), float)
        rows = rows[:len(rows) // width * width].reshape(-1, width)
        self.places, self.turns, column = [], [], 0
        for joint, own in enumerate(channels):
            local, place = np.tile(np.eye(3), (len(rows), 1, 1)), np.tile(self.offsets[joint], (len(rows), 1))
            for name in own:
                value, axis = rows[:, column], "XYZ".index(name[0].upper())
                column += 1
                if name[1:].lower() == "position":
                    place[:, axis] = value
                elif name[1:].lower() == "rotation":
                    local = local @ rotation(axis, value)
            above = self.parents[joint]
            if above is not None:
                place = self.places[above] + np.einsum("tij,tj->ti", self.turns[above], place)
                local = self.turns[above] @ local
            self.places.append(place)
            self.turns.append(local)


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)


def about(axis, a, b):
    """The angle in degrees from a to b about the axis."""
    a, b = (unit(v - axis * np.sum(v * axis, -1, keepdims=True)) for v in (a, b))
    return np.degrees(np.arctan2(np.sum(np.cross(a, b) * axis, -1), np.sum(a * b, -1)))


def wrapped(degrees):
    return (degrees + 180) % 360 - 180


def off_median(degrees):
    """How far angles are from their median on the circle."""
    middle = np.degrees(np.angle(np.mean(np.exp(1j * np.radians(degrees)))))
    middle += np.median(wrapped(degrees - middle))
    return np.abs(wrapped(degrees - middle))


def across(turns, direction):
    """A fixed axis of the bone's frame, in the world, perpendicular to the bone's median direction."""
    local = unit(np.median(np.einsum("tji,tj->ti", turns, direction), 0))
    axis = np.cross(local, np.eye(3)[np.argmin(np.abs(local))])
    return np.einsum("tij,j->ti", turns, axis)


def twist(axis, along):
    """The roll of a bone in degrees from each frame to the next, beyond the shortest turn of its direction."""
    before, after = along[:-1], along[1:]
    # Rodrigues' formula for the shortest rotation from one direction to the next.
    turn, cosine = np.cross(before, after), np.sum(before * after, -1, keepdims=True)
    carried = axis[:-1] * cosine + np.cross(turn, axis[:-1]) + turn * np.sum(turn * axis[:-1], -1, keepdims=True) / (1 + cosine)
    return np.abs(about(after, carried, axis[1:]))


def solve(program, file, bones, folder):
    """The solution for the joints' positions, and the rotation of its world."""
    above = {"spine": "hips", "chest": "spine", "upperChest": "chest", "neck": "upperChest", "head": "neck"}
    for side in ("left", "right"):
        for chain in (("upperChest", "Shoulder", "UpperArm", "LowerArm", "Hand"), ("hips", "UpperLeg", "LowerLeg", "Foot", "Toes")):
            chain = [chain[0]] + [side + bone for bone in chain[1:]]
            above.update(zip(chain[1:], chain))
    def parent(bone):
        bone = above[bone]
        return bone if bone in bones else parent(bone)
    order = ["hips"] + [bone for bone in above if bone in bones and bone != "hips"]
    order = sorted(order, key=lambda bone: 0 if bone == "hips" else 1)
    joints = [{"name": bone, "bone": bone, **({} if bone == "hips" else {"parent": parent(bone)})} for bone in order]
    np.savez(f"{folder}/points.npz", positions=np.stack([file.places[bones[bone]] for bone in order], 1), names=np.array(order),
             fps=file.rate)
    json.dump(joints, open(f"{folder}/set.json", "w"))
    command = [program, "solve", f"{folder}/points.npz", "--joint-set", f"{folder}/set.json", "-o", f"{folder}/out.bvh"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    solved = Bvh(f"{folder}/out.bvh")
    os.remove(f"{folder}/out.bvh")
    own = np.concatenate([file.places[bones[bone]] - file.places[bones["hips"]] for bone in order])
    theirs = np.concatenate([solved.places[solved.names.index(bone)] - solved.places[solved.names.index("hips")] for bone in order])
    u, _, v = np.linalg.svd(own.T @ theirs)
    return solved, u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v, theirs


def main():
    arguments = sys.argv[1:]
    show = "--bones" in arguments
    here = os.path.dirname(os.path.abspath(__file__))
    truth = next((a.split("=")[1] for a in arguments if a.startswith("--truth=")), f"{here}/../../fixtures/skeletons/truth.json")
    program, *paths = [argument for argument in arguments if not argument.startswith("--")]
    files = json.load(open(truth))["files"]
    total = {}
    with tempfile.TemporaryDirectory() as folder:
        for path in paths:
            known = next((v for k, v in files.items() if k.split("/")[-1] == os.path.basename(path)), None)
            if not known or not known.get("map"):
                continue
            try:
                file = Bvh(path)
                bones = {bone: file.names.index(name) for bone, name in known["map"].items() if name in file.names}
                bones = {bone: joint for bone, joint in bones.items() if not any(f in bone for f in
                         ("Thumb", "Index", "Middle", "Ring", "Little", "Eye", "jaw"))}
                if len(file.places[0]) < 2 or "hips" not in bones:
                    continue
                solved, world, _ = solve(program, file, bones, folder)
            except (RuntimeError, ValueError, IndexError) as error:
                print(f"{os.path.basename(path):45} {error}")
                continue
            for upper, lower, end, name in LIMBS:
                if not all(bone in bones for bone in (upper, lower, end)):
                    continue
                a, b, c = (file.places[bones[bone]] for bone in (upper, lower, end))
                thigh, shin = unit(b - a), unit(c - b)
                bend = np.degrees(np.arccos(np.clip(np.sum(thigh * shin, -1), -1, 1)))
                bent = (bend >= BENT) & (bend <= 174)
                if bent.sum() < 2:
                    continue
                for bone, along in ((upper, thigh), (lower, shin)):
                    turns = file.turns[bones[bone]]
                    theirs = world @ solved.turns[solved.names.index(bone)]
                    mine = across(turns, along)
                    roll = about(along, mine, across(theirs, along))
                    hinge = about(along, mine, np.cross(thigh, shin))
                    # A solution of 6 degrees of freedom may also have errors of direction; they do not count here.
                    good, known_by_hinge = off_median(roll[bent]) <= NEAR, off_median(hinge[bent]) <= NEAR
                    turned = twist(across(theirs, along), along)
                    flips = int(((turned > FLIP) & (np.abs(wrapped(np.diff(roll))) > FLIP)).sum())
                    row = np.array([bent.sum(), good.sum(), known_by_hinge.sum(), flips])
                    kind = bone.replace("left", "").replace("right", "")
                    total[kind] = total.get(kind, 0) + row
                    total[os.path.basename(path)] = total.get(os.path.basename(path), 0) + row
                    if show:
                        print(f"{os.path.basename(path):45} {bone:16} {row[0]:6} {row[1] / row[0]:7.1%} {row[2] / row[0]:7.1%} {flips:4}")
    print(f"{'':45} {'frames':>8} {'roll':>8} {'hinge':>8} {'flips':>6}")
    for name, row in total.items():
        print(f"{name:45} {row[0]:8} {row[1] / row[0]:8.1%} {row[2] / row[0]:8.1%} {row[3]:6}")
    rows = sum(row for name, row in total.items() if not name.endswith(".bvh"))
    print(f"{'all':45} {rows[0]:8} {rows[1] / rows[0]:8.1%} {rows[2] / rows[0]:8.1%} {rows[3]:6}")
    least = next((float(a.split("=")[1]) for a in arguments if a.startswith("--least=")), 0)
    sys.exit(int(100 * rows[1] / rows[0] < least))


main()
