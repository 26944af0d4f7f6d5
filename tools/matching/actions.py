"""Checks that the first five results of `mocap find` include the action of a take that is retargeted to another
skeleton. See README.md.

    actions.py MOCAP FIXTURES FOLDER [WHEEL]

The script writes takes, takes on other skeletons and the database to FOLDER. WHEEL is the package pybullet, whose
motions are used too.
"""

import json
import subprocess
import sys
import zipfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from math import comb
from pathlib import Path

import deepmimic
import numpy as np

mocap, fixtures, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
# The actions as the authors of the files name them. In CMU's list, 01_01 is forward jumps, 02_01 and 12_01 are walk, 60
# and 61 are salsa.
ACTIONS = {
    "walk": "real/cmu_12_01_walk.bvh real/cmu_02_01.amc real/additive_root_walk.bvh real/makehuman_zombie_walk.bvh "
    "real/motionbuilder_vicon_walk.bvh skeletons/bvhtoolbox_walk01.bvh walk 0walk_forward turn_left0 turn_left1 "
    "turn_right0 turn_right1",
    "run": "real/run.fbx skeletons/accad_run_turn.bvh run",
    "jump": "real/cmu_01_01.bvh real/mocopi_jump_six_channels.bvh skeletons/snu_character1_boxes.bvh jump",
    "dance": "real/rokoko_dance.bvh real/cmu_salsa_poser_names.bvh dance_a dance_b",
    # Actions with a single take, and other actions; they are in the database as possible wrong results.
    "punch": "punch",
    "kick": "kick spinkick",
    "other": "real/cmu_mixed_rotation_orders.bvh real/z_up_dab.bvh real/kinect_openni.bvh "
    "real/hip_knee_ankle_names.bvh real/perception_neuron_moving_positions.bvh real/slimevr_headset_root.bvh "
    "skeletons/vicon_sword_attack.bvh skeletons/rosemotion_robin.bvh "
    "backflip cartwheel crawl getup_facedown getup_faceup roll spin",
}
JUDGED = ["walk", "run", "jump", "dance"]
# Takes of one walk in several directions: none of them counts as a result for another.
ONE = [{"walk", "0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1"}]
SKELETONS = ["characters/human_game_engine.glb", "characters/human_vrm0.vrm", "real/biovision_example1.bvh"]
SECONDS, FIRST = 1.0, 5
WANTED = 0.8


def run(*arguments):
    return subprocess.run([mocap, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


@cache
def liveliest(path):
    """The second in which the joints move most, by the positions of `mocap fk` relative to their mean."""
    npz = folder / f"{path.stem}.npz"
    run("fk", path, "--fps", 20, "--out-unit", "m", "-q", "--force", "-o", npz)
    positions = np.load(npz)["positions"].astype(float)
    npz.unlink()
    about = positions - positions.mean(1, keepdims=True)
    moved = np.linalg.norm(np.diff(about, axis=0), axis=-1).mean(-1)
    count = int(SECONDS * 20)
    if len(moved) <= count:
        return path
    first = int(np.convolve(moved, np.ones(count), "valid").argmax())
    return f"{path}@{first / 20}s..{first / 20 + SECONDS}s"


def take_of(name):
    return fixtures / name if "/" in name else folder / "takes" / f"{name}.bvh"


def asked(query):
    name, skeleton = query
    path = folder / f"{Path(name).stem}.{SKELETONS.index(skeleton)}.bvh"
    if not path.exists():
        run("retarget", take_of(name), "--to-skeleton", fixtures / skeleton, "-q", "-o", path)
    # The take itself and takes of the same walk do not count as results; no result counts twice.
    found = run("find", folder / "all.mdb", "--like", liveliest(path), "-n", 99, "--json")
    found = json.loads(found)
    own = next((takes for takes in ONE if name in takes), {name})
    return [action[row["file"]] for row in found if row["file"] not in {str(take_of(take)) for take in own}]


(folder / "takes").mkdir(parents=True)
if len(sys.argv) > 4:
    deepmimic.write(zipfile.ZipFile(sys.argv[4]), folder / "takes")
ACTIONS = {of: [name for name in names.split() if take_of(name).exists()] for of, names in ACTIONS.items()}
action = {str(take_of(name)): of for of, names in ACTIONS.items() for name in names}
run("index", *action, "-q", "-o", folder / "all.mdb")
hits, chances = defaultdict(list), {}
for of in JUDGED:
    queries = [(name, skeleton) for name in ACTIONS[of] for skeleton in SKELETONS]
    with ThreadPoolExecutor(2) as pool:
        for (name, _), found in zip(queries, pool.map(asked, queries)):
            right = found.count(of)
            if right:
                hits[of].append(of in found[:FIRST])
                chances.setdefault(of, []).append(1 - comb(len(found) - right, FIRST) / comb(len(found), FIRST))
right, count = sum(map(sum, hits.values())), sum(map(len, hits.values()))
each = ", ".join(f"{of} {sum(found)}/{len(found)} ({np.mean(chances[of]):.2f})" for of, found in hits.items())
chance = sum(map(sum, chances.values())) / count
print(f"the action among the first {FIRST}: {right}/{count}, {right / count:.2f}; by chance {chance:.2f}")
print(f"  {each}")
sys.exit(right < WANTED * count)
