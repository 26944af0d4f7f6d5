"""Poses motions of MMD without mocap, and compares the poses with mocap's. See README.md.

usage: python judge.py MOCAP [MODULES]      MODULES: the folder with node_modules of babylon-mmd
       python judge.py --expected MODULES   the table of src/formats/tests/it/mmd.rs
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from mmd_bone_tools import pmx, vmd

import dancer
import files
import statement

HERE = Path(__file__).resolve().parent
FIXTURES = HERE.parents[1] / "fixtures"
MIRROR = np.diag([1.0, 1.0, -1.0])
ALLOWED = 1.0  # degrees, of limbs
ALLOWED_ARMS = 0.01  # of bones without IK, which have a closed form
ALLOWED_FOOT = 5.0  # mm, from the foot's position by the law of cosines, for a leg of two bones
LEGS = ("足", "ひざ", "つま先")


def tracks_of(motion, model):
    """The keys of each bone of the model, read by mmd-bone-tools; names have at most 15 bytes."""
    whole = {bone.name.encode("cp932")[:15].decode("cp932", "ignore"): bone.name for bone in model.bones}
    tracks = {}
    for key in motion.bones:
        # Each row of the table begins with a complete curve.
        curves = [[key.interpolation[16 * curve + 4 * part] for part in range(4)] for curve in range(4)]
        if key.name in whole:
            tracks.setdefault(whole[key.name], {})[key.frame] = (key.position, key.rotation, curves)
    return tracks


def bones_of(model):
    """The bones of a model in the form of `dancer`, read by mmd-bone-tools."""
    name = lambda index: None if index < 0 else model.bones[index].name
    bones = []
    for bone in model.bones:
        own = {"name": bone.name, "at": list(bone.position), "parent": name(bone.parent), "layer": bone.layer, "flags": bone.flags}
        if bone.inherit_parent >= 0:
            own["turns" if bone.flags & 0x0100 else "moves"] = (name(bone.inherit_parent), bone.inherit_weight)
        if bone.fixed_axis is not None:
            own["axis"] = list(bone.fixed_axis)
        if bone.is_ik:
            links = [(name(link.bone), link.limits) for link in bone.ik_links]
            own["ik"] = (name(bone.ik_target), bone.ik_loops, bone.ik_limit, links)
        bones.append(own)
    return bones


def states_of(motion, frame):
    states = {}
    for change in motion.ik or []:
        if change.frame <= frame:
            states.update({state.name: state.enabled for state in change.states})
    return states


def quaternion(turn):
    by = statement.vector(turn)
    angle = np.linalg.norm(by)
    axis = by / angle if angle > 1e-12 else by
    return [*map(float, axis * np.sin(angle / 2)), float(np.cos(angle / 2))]


def by_babylon(modules, bones, tracks, motion, frames, folder):
    """Matrices of babylon-mmd: frame, bone, 4, 4; rows are axes."""
    still = (np.zeros(3), np.eye(3))
    posed = []
    for frame in range(frames):
        own = [statement.own(tracks[bone["name"]], frame) if bone["name"] in tracks else still for bone in bones]
        off = [name for name, on in states_of(motion, frame).items() if not on]
        posed.append({"own": [[[*map(float, move)], quaternion(turn)] for move, turn in own], "off": off})
    given, made = folder / "given.json", folder / "made.json"
    given.write_text(json.dumps({"bones": bones, "frames": posed}))
    subprocess.run(["node", HERE / "babylon.mjs", modules, given, made], check=True)
    return np.array(json.loads(made.read_text())).reshape(frames, len(bones), 4, 4)


def by_statement(bones, tracks, motion, frames):
    pose = statement.Pose(bones)
    for frame in range(frames):
        states = states_of(motion, frame)
        pose.pose(tracks, frame, lambda name: states.get(name, True))
        yield {bone["name"]: pose.world(bone["name"]) for bone in bones}


def by_mocap(mocap, motion, model, folder, frames):
    """Positions in units and rotations of every node, from the matrices that `mocap fk` writes."""
    out = folder / "ours.npz"
    subprocess.run([mocap, "fk", motion, "--skeleton", model, "--rot-space", "world", "-o", out, "--force"], check=True, capture_output=True)
    arrays = np.load(out)
    names = [str(name) for name in arrays["names"]]
    positions, rotations = arrays["positions"], arrays["rotations"]
    assert len(positions) == frames, (len(positions), frames)
    return names, positions, rotations


def degrees(ours, theirs):
    """The angle between rotations, computed from the chord, because the arc cosine loses digits at small angles."""
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(ours - theirs) / np.sqrt(8), 0, 1)))


def compare(mocap, motion_file, model_file, modules, folder):
    motion, model = vmd.load_vmd(motion_file), pmx.load_pmx(model_file)
    bones, tracks = bones_of(model), tracks_of(motion, model)
    frames = 1 + max(key.frame for key in motion.bones)
    names, positions, rotations = by_mocap(mocap, motion_file, model_file, folder, frames)
    place = {name: index for index, name in enumerate(names)}
    worst = {"arms": 0.0, "feet": 0.0, "babylon": 0.0}
    for frame, theirs in enumerate(by_statement(bones, tracks, motion, frames)):
        for name, (at, turn) in theirs.items():
            is_leg = any(part in name for part in LEGS)
            ours = positions[frame, place[name]], statement.matrix(rotations[frame, place[name]])
            if not is_leg:
                worst["arms"] = max(worst["arms"], degrees(ours[1], MIRROR @ turn @ MIRROR))
            if name.endswith("足首") and frame < 50:
                worst["feet"] = max(worst["feet"], 1000 * statement.UNIT * np.linalg.norm(ours[0] - MIRROR @ at))
    if modules:
        made = by_babylon(modules, bones, tracks, motion, frames, folder)
        for frame in range(frames):
            for index, bone in enumerate(bones):
                ours = statement.matrix(rotations[frame, place[bone["name"]]])
                turn = made[frame, index, :3, :3].T
                worst["babylon"] = max(worst["babylon"], degrees(ours, MIRROR @ turn @ MIRROR))
    name = Path(motion_file).name
    print(f"mmd: {name}: {len(bones)} bones, {frames} frames: {worst['arms']:.4f} degrees off the statement, feet "
          f"{worst['feet']:.2f} mm" + (f", {worst['babylon']:.4f} degrees off babylon-mmd" if modules else "; babylon-mmd left out"))
    assert worst["arms"] < ALLOWED_ARMS and worst["feet"] < ALLOWED_FOOT and worst["babylon"] < ALLOWED, worst


def written(mocap, modules, folder):
    """Checks that a walk on the model, written and read by mmd-bone-tools, has the poses of its GLB file."""
    walk, model = FIXTURES / "real" / "cmu_12_01_walk.bvh", FIXTURES / "made" / "dancer.pmx"
    out = folder / "walk.vmd"
    subprocess.run([mocap, "retarget", walk, model, "-o", out], check=True, capture_output=True)
    motion = vmd.load_vmd(out)
    assert motion.model_name == "踊り子" and not motion.trailing, motion.model_name
    assert motion.ik and not any(state.enabled for state in motion.ik[0].states), motion.ik
    compare(mocap, out, model, modules, folder)


def hostile(mocap, folder):
    """Checks that the program ends with 0 or 1 within seconds for changed files."""
    rng = np.random.default_rng(1)
    seeds = {name: (FIXTURES / "made" / name).read_bytes() for name in ("dancer.vmd", "dancer.pmx")}
    codes = {}
    for index in range(200):
        name = ("dancer.vmd", "dancer.pmx")[index % 2]
        data = bytearray(seeds[name])
        for _ in range(rng.integers(1, 6)):
            at = int(rng.integers(len(data)))
            data[at : at + 4] = rng.bytes(4) if rng.random() < 0.7 else b"\xff\xff\xff\x7f"
        (folder / name).write_bytes(data)
        other = ("dancer.pmx", "dancer.vmd")[index % 2]
        (folder / other).write_bytes(seeds[other])
        done = subprocess.run([mocap, "info", folder / "dancer.vmd", "--skeleton", folder / "dancer.pmx"],
                              capture_output=True, text=True, timeout=60)
        assert done.returncode in (0, 1) and "panicked" not in done.stderr, (index, done.returncode, done.stderr)
        codes[done.returncode] = codes.get(done.returncode, 0) + 1
    print(f"mmd: 200 changed files: {codes.get(0, 0)} read, {codes.get(1, 0)} refused")


def expected(modules, folder):
    motion, model = vmd.load_vmd(FIXTURES / "made" / "dancer.vmd"), pmx.load_pmx(FIXTURES / "made" / "dancer.pmx")
    bones, tracks = bones_of(model), tracks_of(motion, model)
    made = by_babylon(modules, bones, tracks, motion, 60, folder)
    names = [bone["name"] for bone in bones]
    for frame in (0, 12, 20, 33, 45, 55):
        for name in ("頭", "左目", "左手首", "右手首", "左ひざ", "左足首", "右ひざ", "右つま先", "左ひざD", "髪", "長い名前の骨の先"):
            at = MIRROR @ made[frame, names.index(name), 3, :3]
            print(f'    ({frame}, "{name}", [{", ".join(f"{value:.4f}" for value in at)}]),')


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        temporary = Path(name)
        if sys.argv[1] == "--expected":
            expected(sys.argv[2], temporary)
            sys.exit()
        program, modules = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None
        dancer.write(temporary)
        for file in ("dancer.pmx", "dancer.vmd"):
            assert (temporary / file).read_bytes() == (FIXTURES / "made" / file).read_bytes(), f"{file} is not what dancer.py writes"
        compare(program, FIXTURES / "made" / "dancer.vmd", FIXTURES / "made" / "dancer.pmx", modules, temporary)
        # Checks other sizes of indices, UTF-8, and a model without a mesh.
        for size, utf8, mesh in ((2, True, True), (4, False, False)):
            files.pmx(temporary / "other.pmx", "踊り子", dancer.bones(), dancer.MORPHS, size, utf8, mesh)
            compare(program, FIXTURES / "made" / "dancer.vmd", temporary / "other.pmx", modules, temporary)
        written(program, modules, temporary)
        hostile(program, temporary)
