"""Judges whether `mocap retarget` keeps hands on the objects that they touch. See README.md."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import glb
import plant

HERE = pathlib.Path(__file__).resolve().parent
FIXTURES = HERE / "../../fixtures/characters"
# The hips, head, left upper arm, hand, thigh, shin and foot of the files, mapped by hand; the right joints follow from
# the names.
CHARACTERS = {
    "human_default.glb": ["root", "head", "upperarm01.L", "wrist.L", "upperleg01.L", "lowerleg01.L", "foot.L"],
    "human_game_engine.glb": ["pelvis", "head", "upperarm_l", "hand_l", "thigh_l", "calf_l", "foot_l"],
    "human_vrm0.vrm": ["腰", "頭", "左腕", "左手首", "左足", "左ひざ", "左足首"],
    "arnaud.fbx": ["Pelvis", "Head", "LeftArm", "Lefthand", "LeftUpLeg", "LeftLeg", "LeftFoot"],
    "human_apose.glb": ["root", "head", "upperarm01.L", "wrist.L", "upperleg01.L", "lowerleg01.L", "foot.L"],
    "human_vrm1.vrm": ["root", "head", "upperarm01.L", "wrist.L", "upperleg01.L", "lowerleg01.L", "foot.L"],
    "human_cmu.glb": ["Hips", "Head", "LeftArm", "LeftHand", "LeftUpLeg", "LeftLeg", "LeftFoot"],
    "q_male.fbx": ["Body", "Head", "UpperArm.L", "Palm.L", "UpperLeg.L", "LowerLeg.L", "Foot.L"],
    "q_knight.fbx": ["Body", "Head", "UpperArm.L", "Palm.L", "UpperLeg.L", "LowerLeg.L", "Foot.L"],
    "q_human2017.fbx": ["Hips", "Head", "LeftArm", "LeftHand", "LeftUpLeg", "LeftLeg", "LeftFoot"],
}
# The seconds in which hands touch, after a tenth of a second to come to rest.
TOUCHES = (1.35, 3.1)
LOOKS = 8
# The limits: the error in metres between wrists, of a hand on a knee relative to the source, of a hand in the head, and
# the ratio of jerks.
APART, KNEE, INSIDE, JERK = 0.06, 0.05, 0.005, 1.2


def right(name):
    for left, other in (("Lefthand", "RightHand"), ("Left", "Right"), ("左", "右"), (".L", ".R"), ("_l", "_r")):
        if left in name:
            return name.replace(left, other)
    return name


class Take:
    """A motion on a character."""

    def __init__(self, path, names):
        self.file = glb.Glb(path)
        keys = ["hips", "head", "arm", "hand", "thigh", "knee", "foot"]
        self.joint = {}
        for key, name in zip(keys, names):
            self.joint[key, 0], self.joint[key, 1] = self.file.index[name], self.file.index[right(name)]

    def at(self, world, key, side=0):
        return world[self.joint[key, side]][:3, 3]

    def leg(self):
        world = self.file.world(None)
        hip, knee, foot = (self.at(world, key) for key in ("thigh", "knee", "foot"))
        return np.linalg.norm(hip - knee) + np.linalg.norm(knee - foot)

    def jerks(self):
        """The root mean square of the jerk of each wrist, in m/s^3."""
        times = np.arange(0, self.file.end, 1 / plant.RATE)
        found = []
        for side in (0, 1):
            hand = self.joint["hand", side]
            track = np.array([self.file.world(time, [hand])[hand][:3, 3] for time in times])
            found.append(np.sqrt((np.diff(track, 3, axis=0) ** 2).sum(1).mean()) * plant.RATE**3)
        return np.array(found)

    def depth(self, world):
        """The depth of a hand's deepest vertex in the head, measured from the head's nearest vertex along its
        normal."""
        head = self.joint["head", 0]
        points, faces = self.file.skin(world, lambda joint: self.file.below(joint, head))
        normals = np.zeros_like(points)
        across = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
        for corner in range(3):
            np.add.at(normals, faces[:, corner], across)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        # Flips the normals of a head that is drawn inside out.
        normals *= np.sign((normals * (points - points.mean(0))).sum()) or 1
        low, high = points.min(0), points.max(0)
        deepest = 0.0
        for side in (0, 1):
            hand = self.joint["hand", side]
            vertices, _ = self.file.skin(world, lambda joint: self.file.below(joint, hand))
            for vertex in vertices[((vertices > low) & (vertices < high)).all(1)]:
                near = np.argmin(((points - vertex) ** 2).sum(1))
                deepest = max(deepest, (points[near] - vertex) @ normals[near])
        return deepest


def judge(motion, take, free, source):
    """The measured values, and whether they are within the limits."""
    times = np.linspace(*TOUCHES, LOOKS)
    worlds = [take.file.world(time) for time in times]
    jerks, was = take.jerks(), free.jerks()
    ratio = (jerks / np.maximum(was, 1e-3)).max()
    text, right_ = f"jerk {ratio:.2f}", ratio <= JERK
    scale = take.leg() / 0.83
    figures = [source[int(round(time * plant.RATE))] for time in times]
    if motion == "prayer":
        left = [take.at(world, "arm") - take.at(world, "arm", 1) for world in worlds]
        apart = [(take.at(world, "hand") - take.at(world, "hand", 1)) @ plant.unit(l) for world, l in zip(worlds, left)]
        text += f", wrists {100 * min(apart):.1f} to {100 * max(apart):.1f} cm apart"
        right_ &= min(apart) >= 0 and max(apart) <= APART * max(scale, 1)
    if motion == "head":
        depth = max(take.depth(world) for world in worlds)
        height = min(take.at(world, "hand", 1)[1] - take.at(world, "head")[1] for world in worlds)
        text += f", hand {100 * depth:.1f} cm in the head, wrist {100 * height:.1f} cm above its joint"
        right_ &= depth <= INSIDE * max(scale, 1)
    if motion == "knees":
        worst = 0.0
        for world, figure in zip(worlds, figures):
            for side, name in enumerate(("Left", "Right")):
                wanted = scale * np.linalg.norm(figure.at(f"{name}Hand") - figure.at(f"{name}Leg"))
                worst = max(worst, abs(np.linalg.norm(take.at(world, "hand", side) - take.at(world, "knee", side)) - wanted))
        text += f", {100 * worst:.1f} cm from where the source has them"
        right_ &= worst <= KNEE * max(scale, 1)
    return text, right_


def main():
    mocap, folder, only = sys.argv[1], pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else FIXTURES), sys.argv[3:]
    passed = failed = 0
    with tempfile.TemporaryDirectory() as place:
        for motion in ("prayer", "head", "knees", "hips"):
            source = list(plant.MOTIONS[motion]())
            path = pathlib.Path(place) / f"{motion}.bvh"
            path.write_text(plant.bvh(source))
            for name, joints in CHARACTERS.items():
                if not (folder / name).exists() or (only and motion not in only and name not in only):
                    continue
                takes = []
                for hands in ("keep", "free"):
                    out = path.with_name(f"{motion}_{hands}" + (".vrm" if name.endswith("vrm") else ".glb"))
                    command = [mocap, "retarget", path, folder / name, "-o", out, "--hands", hands]
                    subprocess.run(command + ["--force"], check=True, capture_output=True)
                    takes.append(Take(out, joints))
                text, is_right = judge(motion, *takes, source)
                before, _ = judge(motion, takes[1], takes[1], source)
                passed, failed = passed + is_right, failed + (not is_right)
                print(f"{'ok    ' if is_right else 'FAILED'} {motion:7} {name:22} {text}; free: {before}", flush=True)
    print(f"{passed} passed, {failed} failed")
    sys.exit(failed > 0)


main()
