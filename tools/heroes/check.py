"""Judges the files of `check`."""

import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from document import Document

ROOT = Path(__file__).resolve().parents[2]
MOCAP = os.environ["MOCAP"]
BLENDER = os.environ.get("BLENDER_PYTHON")
# The largest distance in metres between a bone in Blender and the node of the GLB file, whose position this script
# computes.
ALLOWED = 1e-5
# The armature of this character is scaled by 0.01, which increases the error of Blender's glTF importer. The FBX files
# of the same clips are within the other limit.
SCALED = {("human_game_engine.glb", "import_scene.gltf"): 2e-5}
# The limit of a distant joint as a fraction of its distance, because Blender computes in single precision.
SINGLE = 4e-6
SAMPLE = 3
# Motions by the system that made them. Each file of MOTIONS counts as its own system.
SYSTEMS = {
    "AMASS": ["arrays/amass_smpl.npz", "arrays/amass_smplh.npz", "arrays/amass_smplx_deflated.npz"],
    "ACCAD": ["skeletons/accad_run_turn.bvh"],
    "Animics": ["skeletons/animics_all_along_z.bvh"],
    "Biovision": ["real/biovision_example1.bvh"],
    "Blender": ["skeletons/blender_rigify_names.bvh"],
    "BVH toolbox": ["skeletons/bvhtoolbox_walk01.bvh", "real/hip_knee_ankle_names.bvh"],
    "CMU": ["real/cmu_01_01.amc", "real/cmu_01_01.bvh", "real/cmu_02_01.amc", "real/cmu_12_01_walk.bvh", "real/cmu_short.bvh"],
    "CMU, other rotation orders": ["real/cmu_mixed_rotation_orders.bvh"],
    "FBX of ProAnimationBank": ["real/run.fbx"],
    "Kimodo": ["arrays/kimodo_soma_01.npz"],
    "Kinect": ["real/kinect_openni.bvh"],
    "MakeHuman": ["real/makehuman_zombie_walk.bvh", "real/makehuman_fly_one_frame.bvh"],
    "mocopi": ["real/mocopi_jump_six_channels.bvh"],
    "MotionBuilder": ["real/motionbuilder_vicon_walk.bvh"],
    "Perception Neuron": ["real/perception_neuron_moving_positions.bvh"],
    "Poser": ["real/cmu_salsa_poser_names.bvh"],
    "Rokoko": ["real/rokoko_dance.bvh", "skeletons/rosemotion_robin.bvh"],
    "SNU": ["skeletons/snu_character1_boxes.bvh"],
    "SlimeVR": ["real/slimevr_headset_root.bvh"],
    "Vicon": ["skeletons/vicon_sword_attack.bvh"],
    "Xsens": ["skeletons/xsens_names_tpose.bvh"],
    "Z up": ["real/z_up_dab.bvh"],
    "others": ["real/nan_tokens.bvh", "real/additive_root_pose.bvh", "real/additive_root_walk.bvh"],
}
HEROES = ["human_default.glb", "human_game_engine.glb", "human_vrm0.vrm"]


def files_of(variable, suffixes):
    folder = os.environ.get(variable)
    found = sorted(Path(folder).iterdir()) if folder else []
    return [path for path in found if path.suffix in suffixes]


def run(*args):
    return subprocess.run([str(arg) for arg in args], capture_output=True, text=True)


class Pair:
    """A motion on a character, in both formats."""

    def __init__(self, motion, hero, folder):
        self.motion, self.hero = motion, hero
        name = f"{motion.stem}_{motion.suffix[1:]}_on_{hero.stem}"
        self.own, self.fbx = folder / f"{name}{hero.suffix}", folder / f"{name}.fbx"
        self.failures, self.worst = [], {}

    def make(self):
        """Whether both files were made. A motion that is refused for all characters is no failure."""
        for output in [self.own, self.fbx]:
            made = run(MOCAP, "retarget", "--quiet", "--force", self.motion, self.hero, "-o", output)
            if made.returncode:
                self.failures.append(f"{output.suffix}: {made.stderr.strip().splitlines()[:2]}")
                return False
        return True

    def judge_document(self):
        before, after = Document(self.hero).hashes(), Document(self.own).hashes()
        lost = [part for part, value in before.items() if after.get(part) != value]
        self.parts = len(before)
        if lost:
            self.failures.append(f"the file of the character lost or changed {', '.join(lost)}")

    def requests(self):
        document = Document(self.own)
        end = document.end()
        times = max((document.values(sampler["input"]) for sampler in document.json["animations"][-1]["samplers"]), key=len)
        self.seconds = sorted({times[place][0] for place in (0, len(times) // 2, len(times) - 1)} | {end})
        self.truth = document.places(self.seconds)
        # The importer of glTF accepts no other suffix.
        glb = self.own.with_suffix(".in_blender.glb")
        shutil.copyfile(self.own, glb)
        of = [(glb, "import_scene.gltf"), (self.fbx, "wm.fbx_import"), (self.fbx, "import_scene.fbx")]
        return [{"file": str(file), "seconds": self.seconds, "importer": importer} for file, importer in of]

    def judge_blender(self, importer, found):
        if "refusal" in found:
            self.failures.append(f"blender's {importer}: {found['refusal']}")
            return
        skin = Document(self.own).json
        joints = {skin["nodes"][joint]["name"] for each in skin["skins"] for joint in each["joints"]}
        short = {name.encode()[:63].decode(errors="ignore"): name for name in joints}
        compared, worst = set(), 0.0
        farthest = max(math.hypot(*place) for truth in self.truth for place in truth.values())
        for truth, places in zip(self.truth, found["places"]):
            for bone, place in zip(found["bones"], places):
                if bone in short:
                    compared.add(short[bone])
                    worst = max(worst, math.dist(place, truth[short[bone]]))
        self.worst[importer] = worst
        if compared != joints:
            self.failures.append(f"blender's {importer}: no {sorted(joints - compared)[:3]}")
        allowed = SCALED.get((self.hero.name, importer), ALLOWED)
        if worst > max(allowed, SINGLE * farthest):
            self.failures.append(f"blender's {importer}: {1000 * worst:.4f} mm off")


def validate(pairs):
    for start in range(0, len(pairs), 20):
        part = pairs[start : start + 20]
        ran = run("node", Path(__file__).with_name("validate.js"), *[pair.own for pair in part])
        if ran.returncode:
            sys.exit(f"the validator: {ran.stderr}")
        for pair, line in zip(part, ran.stdout.splitlines()):
            found = json.loads(line)
            if found["errors"]:
                pair.failures.append(f"the validator: {found['messages'][:2]}")


def in_blender(pairs):
    for start in range(0, len(pairs), 20):
        asked = [(pair, request) for pair in pairs[start : start + 20] for request in pair.requests()]
        requests = json.dumps([request for _, request in asked])
        script = ROOT / "tools/fbx/blender.py"
        ran = subprocess.run([BLENDER, script], input=requests, capture_output=True, text=True)
        if ran.returncode:
            sys.exit(f"Blender: {ran.stderr}")
        for (pair, request), found in zip(asked, json.loads(ran.stdout.splitlines()[-1])):
            pair.judge_blender(request["importer"], found)
        print(f"{min(start + 20, len(pairs))} of {len(pairs)} pairs in Blender", file=sys.stderr, flush=True)


def main(arguments):
    keep = None
    if "--keep" in arguments:
        keep = Path(arguments[arguments.index("--keep") + 1])
        keep.mkdir(parents=True, exist_ok=True)
    folder = keep or Path(tempfile.mkdtemp())
    motions = [ROOT / "fixtures" / file for files in SYSTEMS.values() for file in files]
    motions += files_of("MOTIONS", {".bvh", ".fbx", ".amc"})
    heroes = {path.name: path for path in [*(ROOT / "fixtures/characters" / name for name in HEROES), *files_of("HEROES", {".glb", ".vrm"})]}
    pairs = [Pair(motion, hero, folder) for hero in heroes.values() for motion in motions]
    names = [argument for argument in arguments if not argument.startswith("--") and argument != str(keep)]
    if names:
        pairs = [pair for pair in pairs if any(name in pair.own.name for name in names)]
    elif "--all" not in arguments:
        commit = run("git", "-C", ROOT, "rev-parse", "HEAD").stdout.strip()
        pairs = random.Random(os.environ.get("MOCAP_SEED", commit)).sample(pairs, SAMPLE)
    made = [pair for pair in pairs if pair.make()]
    for pair in made:
        pair.judge_document()
    validate(made)
    if BLENDER:
        in_blender(made)
    else:
        print("left out: Blender, because BLENDER_PYTHON names no Python")
    failed = [pair for pair in pairs if pair.failures]
    for pair in failed:
        print(f"FAILED {pair.motion.name} on {pair.hero.name}")
        for failure in pair.failures:
            print(f"    {failure}")
    for name in sorted({pair.hero.name for pair in made}):
        of_hero = [pair for pair in made if pair.hero.name == name]
        worst = {who: max(pair.worst.get(who, 0) for pair in of_hero) for who in of_hero[0].worst}
        said = ", ".join(f"{who} {1000 * metres:.4f} mm" for who, metres in worst.items())
        print(f"{name}: {len(of_hero)} motions, {of_hero[0].parts} parts as before; farthest in Blender's {said}")
    if not keep:
        shutil.rmtree(folder)
    print(f"{len(pairs) - len(failed)} passed, {len(failed)} failed")
    return 1 if failed or not pairs else 0


sys.exit(main(sys.argv[1:]))
