"""Judges the files of `check`."""

import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import zipfile
from array import array
from ast import literal_eval
from pathlib import Path

from assimp import assimp, run

ROOT = Path(__file__).resolve().parents[2]
MOCAP = os.environ["MOCAP"]
BLENDER = os.environ.get("BLENDER_PYTHON")
# In metres. Assimp prints six digits, and sums them along chains.
ALLOWED = 5e-5
SAMPLE = 10
TIMES = 8
# Fixtures with a joint so far away that single precision limits its position; the allowed error is a fraction of the
# distance.
SINGLE = 4e-6
# Blender stores a bone as the positions of its head and its tail in single precision. So a short bone far from the
# origin turns a little, and with it the path of a root along the bone.
BLENDER_ALLOWED = {"run.fbx": 2e-4}
# Characters keep their files. In these, Blender takes the root for the armature, and does not know the type of some
# properties.
KEPT = {"arnaud.fbx": "Hips"}
# The importer built in since Blender 4.5, and the one in Python before it.
IMPORTERS = ["wm.fbx_import", "import_scene.fbx"]
# Blender's importer of glTF puts a bone of this file at another position, with `--bone-axis` and without.
OTHERWISE_IN_GLTF = {"animation_with_skeleton.fbx"}
# Joints without names; the file has arbitrary names for them.
UNNAMED = {"unnamed_joints_between_meshes.gltf"}
# Morph targets without a skeleton, which Rust tests judge.
FACES = {"face_alone.gltf"}
# The largest angle in degrees between a bone of a file with `--bone-axis y` and the line to its child, in Blender.
OFF_CHILD = 5


def read_npz(path):
    """The arrays of a NumPy archive: names, positions and times."""
    found = {}
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            length = int.from_bytes(data[8:10], "little")
            header = literal_eval(data[10 : 10 + length].decode("latin-1"))
            found[name.removesuffix(".npy")] = (header["descr"], header["shape"], data[10 + length :])
    return found


def numbers(entry):
    descr, shape, data = entry
    values = array({"<f4": "f", "<f8": "d"}[descr])
    values.frombytes(data[: values.itemsize * math.prod(shape)])
    return values, shape


def texts(entry):
    descr, shape, data = entry
    size = 4 * int(descr.removeprefix("<U"))
    parts = [data[size * index : size * (index + 1)] for index in range(shape[0])]
    return [part.decode("utf-32-le").rstrip("\0") for part in parts]


def unique(names):
    """The names in the file, which are made unique."""
    taken, last, made = set(), {}, []
    for name in names:
        name = "".join("_" if ord(c) < 32 or 127 <= ord(c) < 160 else c for c in name)
        wanted = name
        while name in taken:
            last[wanted] = last.get(wanted, 1) + 1
            name = f"{wanted}_{last[wanted]}"
        taken.add(name)
        made.append(name)
    return made


class Fixture:
    """A converted file, and the positions of its joints."""

    def __init__(self, path, folder, bound):
        self.path, self.folder, self.bound = path, folder, bound
        # The files with frames along the bones, and the importer that reads each.
        self.along = []
        self.output = folder / f"{path.parent.name}_{path.name.replace('.', '_')}.fbx"
        self.failures = []
        self.notes = []

    def prepare(self):
        options = ["--max-error", f"{self.bound}m"] if self.bound else []
        made = run(MOCAP, "convert", "--quiet", self.path, self.output, *options)
        if made.returncode:
            return False
        truth = self.folder / "truth.npz"
        made = run(MOCAP, "fk", self.path, "-o", truth, "--out-unit", "m", "--out-up", "y")
        if made.returncode:
            self.failures.append(f"fk: {made.stderr.strip().splitlines()[-1]}")
            return True
        along = self.output.with_name(f"{self.output.stem}_along")
        for suffix in [".fbx", ".glb"]:
            out = along.with_suffix(suffix)
            made = run(MOCAP, "convert", "--quiet", "--bone-axis", "y", "--skeleton-only", self.path, out, *options)
            if not made.returncode:
                of_gltf = [] if self.path.name in OTHERWISE_IN_GLTF else ["import_scene.gltf"]
                readers = IMPORTERS if suffix == ".fbx" else of_gltf
                self.along += [(out, reader) for reader in readers]
            elif "has different scales along its axes" not in made.stderr:
                self.failures.append(f"--bone-axis y, {suffix}: {made.stderr.strip()}")
        arrays = read_npz(truth)
        self.names = unique(texts(arrays["names"]))
        values, (self.frames, joints, _) = numbers(arrays["positions"])
        step = 3 * joints
        # A file without a motion has no rate.
        self.rate = numbers(arrays["frame_rate"])[0][0] or 30.0
        # Without a frame, the check only counts bones.
        last = self.frames - 1
        chosen = sorted({round(index * last / (TIMES - 1)) for index in range(TIMES if self.frames else 0)})
        self.seconds = [frame / self.rate for frame in chosen]
        self.places = [
            [list(values[step * frame + 3 * joint : step * frame + 3 * joint + 3]) for joint in range(joints)]
            for frame in chosen
        ]
        farthest = max((abs(value) for frame in self.places for place in frame for value in place), default=0)
        self.allowed = max(ALLOWED, SINGLE * farthest)
        return True

    def compare(self, who, frames, seconds_end, allowed, without=None):
        """Positions by name at each time, except of the joint `without`. The largest error is added to the program's
        allowed error."""
        worst = 0.0
        allowed += self.bound
        for ours, theirs in zip(self.places, frames):
            for name, place in zip(self.names, ours):
                if name == without:
                    continue
                if name not in theirs:
                    self.failures.append(f"{who}: no {name}")
                    return
                worst = max(worst, math.dist(place, theirs[name]))
        if worst > allowed:
            self.failures.append(f"{who}: {1000 * worst:.4f} mm off, {1000 * allowed:.4f} allowed")
        self.notes.append(f"{who} {1000 * worst:.4f} mm")
        end = max(self.frames - 1, 0) / self.rate
        if abs(seconds_end - end) > 1e-4 * max(end, 1) and self.moves():
            self.failures.append(f"{who}: ends at {seconds_end:.5f} s, and not at {end:.5f}")

    def moves(self):
        return any(frame != self.places[0] for frame in self.places[1:])

    def judge_ufbx(self):
        made = run(MOCAP, "verify", self.path, self.output, "--max-error", f"{self.allowed + self.bound}m", "--json")
        try:
            found = json.loads(made.stdout)
        except json.JSONDecodeError:
            self.failures.append(f"ufbx: {made.stderr.strip()}")
            return
        self.notes.append(f"ufbx {1000 * found['max_error']:.4f} mm")
        if made.returncode:
            self.failures.append(f"ufbx: {found['max_error']} {found['findings'][:3]}")

    def judge_assimp(self):
        found = assimp(self.output, self.folder, self.seconds, self.rate)
        if "refusal" in found:
            self.failures.append(f"assimp: {found['refusal']}")
            return
        self.compare("assimp", found["places"], found["end"], 4 * self.allowed)

    def judge_blender(self, output, importer, found):
        is_along = output != self.output
        who = f"blender's {importer}{' with --bone-axis y' if is_along else ''}"
        if "refusal" in found:
            self.failures.append(f"{who}: {found['refusal']}")
            return
        root = None if is_along else KEPT.get(self.path.name)
        if found["console"] and not root:
            self.failures.append(f"{who} prints {found['console'][:3]}")
        if is_along:
            angles = [(angle, bone) for bone, angle in found["off_child"].items() if bone in self.names]
            degrees, bone = max(angles, default=(0.0, ""))
            self.notes.append(f"{degrees:.2f} degrees off the child")
            if degrees > OFF_CHILD:
                self.failures.append(f"{who}: {bone} is {degrees:.2f} degrees off the line to its child")
        # The program shortens names to this length.
        names = [name.encode()[:63].decode(errors="ignore") for name in self.names]
        expected = [name for name in names if name != root]
        # The importer of glTF also makes bones from groups above and between joints.
        bones = [name for name in found["bones"] if importer != "import_scene.gltf" or name in names]
        if sorted(bones) != sorted(expected):
            self.failures.append(f"{who}: {len(bones)} bones, and not {len(expected)}")
            return
        frames = [dict(zip(found["bones"], frame)) for frame in found["places"]]
        frames = [{name: frame[short] for name, short in zip(self.names, names) if short != root} for frame in frames]
        self.compare(who, frames, found["end"], BLENDER_ALLOWED.get(self.path.name, self.allowed), root)
        # The importer of glTF does not change the rate.
        if importer != "import_scene.gltf" and self.frames > 1 and abs(found["rate"] / self.rate - 1) > 1e-5:
            self.failures.append(f"{who}: {found['rate']} frames a second, and not {self.rate}")


def choose(arguments):
    files = []
    for folder in ["real", "dialects", "skeletons", "made", "characters"]:
        files += sorted((ROOT / "fixtures" / folder).iterdir())
    files = [file for file in files if file.suffix in {".bvh", ".amc", ".c3d", ".fbx", ".glb", ".gltf", ".vrm"} and file.name not in UNNAMED | FACES]
    names = [argument for argument in arguments if not argument.startswith("--")]
    if names:
        return [file for file in files if any(name in str(file) for name in names)]
    if "--all" in arguments:
        return files
    commit = run("git", "-C", ROOT, "rev-parse", "HEAD").stdout.strip()
    return sorted(random.Random(os.environ.get("MOCAP_SEED", commit)).sample(files, SAMPLE))


def main(arguments):
    keep = None
    bound = 0.0
    if "--max-error" in arguments:
        place = arguments.index("--max-error")
        bound = float(arguments[place + 1]) / 1000
        del arguments[place : place + 2]
    if "--keep" in arguments:
        place = arguments.index("--keep")
        keep = Path(arguments[place + 1])
        keep.mkdir(parents=True, exist_ok=True)
        del arguments[place : place + 2]
    folder = keep or Path(tempfile.mkdtemp())
    fixtures = []
    for path in choose(arguments):
        fixture = Fixture(path, folder, bound)
        if fixture.prepare():
            fixtures.append(fixture)
            if not fixture.failures:
                fixture.judge_ufbx()
                fixture.judge_assimp()
        else:
            print(f"left out, because convert refuses it: {path.name}")
    sound = [fixture for fixture in fixtures if hasattr(fixture, "seconds")]
    if BLENDER:
        asked = [
            (fixture, output, importer)
            for fixture in sound
            for output, importer in [*((fixture.output, importer) for importer in IMPORTERS), *fixture.along]
        ]
        requests = [
            {"file": str(output), "seconds": fixture.seconds, "importer": importer} for fixture, output, importer in asked
        ]
        script = Path(__file__).with_name("blender.py")
        ran = subprocess.run([BLENDER, script], input=json.dumps(requests), capture_output=True, text=True)
        if ran.returncode:
            sys.exit(f"Blender: {ran.stderr}")
        for (fixture, output, importer), found in zip(asked, json.loads(ran.stdout.splitlines()[-1])):
            fixture.judge_blender(output, importer, found)
    else:
        print("left out: Blender, because BLENDER_PYTHON names no Python")
    failed = 0
    for fixture in fixtures:
        failed += bool(fixture.failures)
        verdict = "FAILED" if fixture.failures else "ok"
        print(f"{verdict} {fixture.path.relative_to(ROOT)}: {', '.join(fixture.notes)}")
        for failure in fixture.failures:
            print(f"    {failure}")
    if not keep:
        shutil.rmtree(folder)
    print(f"{len(fixtures) - failed} passed, {failed} failed")
    return 1 if failed or not fixtures else 0


sys.exit(main(sys.argv[1:]))
