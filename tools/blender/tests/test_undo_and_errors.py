"""Tests that one undo reverts an operator, and that a failing operator changes nothing and reports mocap's message."""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy
import pytest
import targets
from conftest import FIXTURES, call, curves

REAL = FIXTURES / "real"
BROKEN = sorted(file for file in (FIXTURES / "broken").iterdir() if file.suffix == ".bvh")


def state() -> dict[str, object]:
    """The state of Blender: data-blocks, curves, poses, colours, the rate and the frames of the scene."""
    scene = bpy.context.scene
    found: dict[str, object] = {
        "blocks": sorted(f"{type(one).__name__} {one.name_full} {one.users}" for one in bpy.data.user_map()),
        "scene": [scene.render.fps, scene.render.fps_base, scene.frame_start, scene.frame_end, scene.frame_current],
        "active": bpy.context.view_layer.objects.active and bpy.context.view_layer.objects.active.name,
        "selected": sorted(one.name for one in bpy.context.selected_objects),
    }
    for armature in bpy.data.objects:
        if armature.type != "ARMATURE" or armature.pose is None:
            continue
        bones = [(one.name, *map(tuple, one.matrix_basis), one.color.palette) for one in armature.pose.bones]
        keys = []
        if armature.animation_data and armature.animation_data.action:
            keys = [
                (one.data_path, one.array_index, tuple(tuple(point.co) for point in one.keyframe_points))
                for one in curves(armature)
            ]
        found[armature.name] = (bones, keys)
    return found


def moving() -> bpy.types.Object:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    return bpy.context.object


def still() -> bpy.types.Object:
    return targets.read(FIXTURES / "characters/human_game_engine.glb")


def both() -> bpy.types.Object:
    source, target = moving(), still()
    source.select_set(True)
    return target


OPERATORS = {
    "import_motion": (lambda: None, {"filepath": str(REAL / "z_up_dab.bvh")}),
    "retarget_files": (still, {"filepath": str(REAL / "z_up_dab.bvh"), "rate": "SET"}),
    "retarget_selected": (both, {}),
    "clean": (moving, {}),
    "foot_lock": (moving, {}),
    "loop": (moving, {"into_copy": True}),
}


@pytest.mark.parametrize("name", OPERATORS)
def test_one_undo_takes_it_back_and_redo_does_it_again(name: str) -> None:
    prepare, options = OPERATORS[name]
    prepare()
    bpy.context.scene.frame_set(7)
    bpy.ops.ed.undo_push(message="prepared")
    before = state()
    call(name, **options)
    after = state()
    assert after != before
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    assert state() == after


def fails(name: str, **options: object) -> str:
    """The report of an operator that must fail and change nothing."""
    before = state()
    with pytest.raises(RuntimeError) as raised:
        call(name, **options)
    assert state() == before
    text = str(raised.value)
    assert text.startswith("Error: ") and "Traceback" not in text
    return text


@pytest.mark.parametrize("file", BROKEN, ids=lambda file: file.stem)
@pytest.mark.parametrize("name", ["import_motion", "retarget_files"])
def test_broken_files_fail_with_the_message_of_mocap(file: Path, name: str) -> None:
    options = {"rate": "SET"} if name == "retarget_files" else {}
    if options:
        still()
    (message, *_) = file.with_suffix(".error").read_text().splitlines()
    told = fails(name, filepath=str(file), **options)
    what = re.sub(r"^error(\[[\w-]+\])?: ", "", message)
    assert str(file) in told
    # The program's message begins with the place and the code of the error.
    assert what.split("error[")[-1].split("; ")[0] in told


def test_one_broken_file_of_many_imports_none(tmp_path: Path) -> None:
    for name in ("a.bvh", "c.bvh"):
        (tmp_path / name).write_bytes((REAL / "cmu_short.bvh").read_bytes())
    (tmp_path / "b.bvh").write_text("HIERARCHY\nROOT hip\n")
    told = fails(
        "import_motion", directory=f"{tmp_path}/", files=[{"name": name} for name in ("a.bvh", "b.bvh", "c.bvh")]
    )
    assert "b.bvh" in told


def test_files_that_are_not_there_and_folders(tmp_path: Path) -> None:
    assert "no-such.bvh" in fails("import_motion", filepath=str(tmp_path / "no-such.bvh"))
    fails("import_motion", filepath=str(tmp_path))
    fails("import_motion", filepath="")
    assert "unit" in fails("import_motion", filepath=str(REAL / "cmu_short.bvh"), unit="parsec")


def test_an_armature_that_is_no_humanoid_is_named(tmp_path: Path) -> None:
    bpy.ops.object.armature_add()
    told = fails("retarget_files", filepath=str(REAL / "cmu_short.bvh"))
    assert f"armature {bpy.context.object.name!r}" in told and "target.glb" not in told


def test_an_armature_without_bones_and_with_a_skewed_scale() -> None:
    armature = bpy.data.objects.new("Empty", bpy.data.armatures.new("Empty"))
    bpy.context.collection.objects.link(armature)
    targets.activate(armature)
    bpy.context.view_layer.update()
    assert "has no bones" in fails("retarget_files", filepath=str(REAL / "cmu_short.bvh"))
    still().scale = (1, 2, 1)
    bpy.context.view_layer.update()
    assert "expected one positive number" in fails("retarget_files", filepath=str(REAL / "cmu_short.bvh"))
    bpy.context.object.scale = (-1, 1, 1)
    bpy.context.view_layer.update()
    assert "expected one positive number" in fails("retarget_files", filepath=str(REAL / "cmu_short.bvh"))


def test_a_loop_that_is_not_there_changes_nothing() -> None:
    call("import_motion", filepath=str(FIXTURES / "dialects/two_roots.bvh"))
    fails("loop")


def test_operators_are_off_without_an_armature() -> None:
    for name in ("retarget_files", "retarget_selected", "clean", "foot_lock", "loop"):
        assert not getattr(bpy.ops.mocap, name).poll()
    still()
    assert bpy.ops.mocap.retarget_files.poll() and not bpy.ops.mocap.clean.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.mocap.retarget_files.poll()


def test_the_report_is_kept_with_the_action() -> None:
    armature = still()
    call("retarget_files", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    lines = json.loads(armature.animation_data.action["mocap_report"])
    assert any("mean limb error" in line for line in lines)
    assert sum(line.startswith(("left", "right")) for line in lines) == 8


def test_limbs_are_coloured_by_their_angle() -> None:
    armature = still()
    call("retarget_files", filepath=str(REAL / "cmu_12_01_walk.bvh"), color=False)
    assert {bone.color.palette for bone in armature.pose.bones} == {"DEFAULT"}
    call("retarget_files", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    painted = {
        bone.name: tuple(bone.color.custom.normal) for bone in armature.pose.bones if bone.color.palette == "CUSTOM"
    }
    arms, legs = ("upperarm", "lowerarm"), ("thigh", "calf")
    assert set(painted) == {f"{limb}_{side}" for limb in (*arms, *legs) for side in "lr"}
    # The arms follow the source. The legs differ by up to 2 degrees, because the feet are locked.
    assert all(painted[f"{limb}_{side}"][1] > painted[f"{limb}_{side}"][0] for limb in arms for side in "lr")
    assert any(painted[f"{limb}_{side}"][0] > painted[f"{limb}_{side}"][1] for limb in legs for side in "lr")
