"""Opens the USD files of mocap with usd-core, and compares joints and skins. See README.md."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel, UsdValidation, Vt

import glb

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
CLIPS = ["cmu_short", "rokoko_dance", "z_up_dab", "mocopi_jump_six_channels"]
CHARACTERS = ["human_default.glb", "human_game_engine.glb", "human_vrm0.vrm", "arnaud.fbx"]
ALLOWED = 1e-5  # metres
ALLOWED_SKIN = 1e-5


def run(*arguments):
    done = subprocess.run([str(argument) for argument in arguments], capture_output=True, text=True)
    return done.returncode, done.stderr


def must(*arguments):
    code, said = run(*arguments)
    assert code == 0, (arguments, said)


def skeleton(stage):
    (found,) = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)]
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate)
    return cache, UsdSkel.Skeleton(found), cache.GetSkelQuery(UsdSkel.Skeleton(found))


def joints(stage, frames):
    """The positions of all joints in the world, by the names of the scene."""
    _, prim, query = skeleton(stage)
    names = list(prim.GetJointNamesAttr().Get())
    found = np.empty((frames, len(names), 3))
    for frame in range(frames):
        matrices = query.ComputeJointSkelTransforms(frame)
        found[frame] = [matrix.ExtractTranslation() for matrix in matrices]
    return names, found


def compliant(path):
    """Every validator of usd-core; usdchecker runs the same validators."""
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    said = [error.GetMessage() for error in context.Validate(Usd.Stage.Open(str(path)))]
    assert not said, (path, said[:5])


def motion(mocap, source, folder):
    """The largest distance of a joint from its position; None for a file that mocap refuses to read."""
    truth = folder / "truth.npz"
    code, said = run(mocap, "fk", source, "-o", truth, "--force", "--out-unit", "m", "--out-up", "y")
    if code == 1:
        print(f"usd: {source.name} is refused: {said.splitlines()[0]}")
        return None
    assert code == 0, said
    truth = np.load(truth)
    names, positions = [str(name) for name in truth["names"]], truth["positions"]
    worst = 0.0
    for extension in ("usda", "usdz"):
        output = folder / f"take.{extension}"
        must(mocap, "convert", source, output, "--force")
        stage = Usd.Stage.Open(str(output))
        assert UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == "Y"
        found_names, found = joints(stage, len(positions))
        assert found_names == names, (found_names[:5], names[:5])
        worst = max(worst, np.abs(np.linalg.norm(found - positions, axis=2)).max(initial=0))
        compliant(output)
    assert worst < ALLOWED, (source, worst)
    # The file from another writer: only the values come from mocap.
    stage.Flatten().Export(str(folder / "theirs.usda"))
    must(mocap, "verify", source, folder / "theirs.usda", "--max-error", "0.1mm")
    return worst


def skinned(stage):
    """The vertices of each mesh at rest, as UsdSkel moves them."""
    cache, _, query = skeleton(stage)
    rest = Vt.Matrix4dArray(query.ComputeSkinningTransforms(Usd.TimeCode.Default()))
    for binding in cache.ComputeSkelBindings(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate):
        for target in binding.GetSkinningTargets():
            prim = UsdGeom.PointBased(target.GetPrim())
            points = prim.GetPointsAttr().Get()
            assert target.ComputeSkinnedPoints(rest, points, Usd.TimeCode.Default())
            weights = np.array(target.ComputeJointInfluences()[1]).reshape(-1, target.GetNumInfluencesPerComponent())
            assert np.abs(weights.sum(axis=1) - 1).max() < 1e-6, prim
            yield np.array(points)


def skin(mocap, character, folder):
    """The largest distance of a rest vertex from its position that NumPy computes from the character's file."""
    hero = folder / "hero.usdz"
    must(mocap, "convert", character, hero, "--force")
    compliant(hero)
    # Only rest pose and skin, because an animation would pose the character.
    stage = Usd.Stage.Open(str(hero))
    for prim in list(stage.Traverse()):
        if prim.IsA(UsdSkel.Animation):
            stage.RemovePrim(prim.GetPath())
    found = np.concatenate(list(skinned(stage)))
    if character.suffix == ".fbx":
        # NumPy does not read FBX, so the skin is compared with the skin of mocap's GLB file of it.
        must(mocap, "convert", character, folder / "hero.glb", "--force")
        character = folder / "hero.glb"
    expected = np.concatenate(list(glb.skinned(character)))
    worst = farthest(found, expected)
    assert len(found) > 1000 and worst < ALLOWED_SKIN, (character, len(found), worst)
    return worst, len(found)


def farthest(found, expected):
    """Finds the nearest of all vertices, because the parts of a character may be split in another order."""
    if found.shape == expected.shape and (worst := np.linalg.norm(found - expected, axis=1).max()) < ALLOWED_SKIN:
        return worst
    worst = 0.0
    for some in np.array_split(found, 1 + len(found) // 500):
        distance = np.linalg.norm(some[:, None] - expected[None], axis=2).min(axis=1)
        worst = max(worst, distance.max())
    return worst


def refuses_binary(mocap, folder):
    stage = Usd.Stage.Open(str(folder / "take.usda"))
    stage.Export(str(folder / "take.usdc"))
    code, said = run(mocap, "info", folder / "take.usdc")
    assert code == 1 and "usdcat" in said, said


def main(mocap, clips):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = [motion(mocap, FIXTURES / "real" / f"{clip}.bvh", folder) for clip in clips]
        found = [worst for worst in found if worst is not None]
        print(f"usd: {len(found)} clips: joints at most {1000 * max(found):.5f} mm off, the compliance checker is silent")
        refuses_binary(mocap, folder)
        for character in CHARACTERS:
            error, count = skin(mocap, FIXTURES / "characters" / character, folder)
            print(f"usd: {character}: {count} vertices at most {1000 * error:.5f} mm off at rest")


everything = sorted(path.stem for path in (FIXTURES / "real").glob("*.bvh"))
main(sys.argv[1], everything if "--all" in sys.argv[2:] else CLIPS)
