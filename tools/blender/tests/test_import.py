"""Tests the import: bones lie along the limbs at the joints that the program writes; frame rates; names of every
kind."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest
from conftest import FIXTURES, Written, angle, call, curves, distance, mocap, posed, sampled

REAL = FIXTURES / "real"
FOLDERS = ("real", "made", "skeletons", "arrays", "markers", "dialects", "characters")


def readable() -> list[Path]:
    """Every fixture from which the program writes glTF."""
    table = subprocess.run([os.environ["MOCAP"], "formats", "--json"], check=True, capture_output=True).stdout
    rows = json.loads(table)
    known = {extension for row in rows if row["read"] for extension in row["extensions"]}
    files = [file for folder in FOLDERS for file in sorted((FIXTURES / folder).iterdir())]
    return [file for file in files if file.suffix[1:] in known]


def written(file: Path, folder: Path, *options: str) -> Path | None:
    """The program's output for a file, or None if the program refuses the file."""
    path = folder / "expected.glb"
    words = [os.environ["MOCAP"], "convert", file, "-o", path, "--mesh", "none", "--quiet", *options]
    return path if subprocess.run(words, capture_output=True).returncode == 0 else None


def objects() -> int:
    return sum(len(data) for data in (bpy.data.objects, bpy.data.armatures, bpy.data.actions))


@pytest.mark.parametrize("file", readable(), ids=lambda file: f"{file.parent.name}/{file.name}")
def test_joints_are_where_the_program_writes_them(file: Path, tmp_path: Path) -> None:
    path = written(file, tmp_path, "--skeleton-only", "--keep-constant")
    if path is None:
        with pytest.raises(RuntimeError, match=r"error\[|expected"):
            call("import_motion", filepath=str(file))
        assert objects() == 0
        return
    expected = Written(path)
    if not expected.joints():
        pytest.skip("a file without joints")
    call("import_motion", filepath=str(file))
    armature = bpy.context.object
    scene = bpy.context.scene
    names = [bone.name for bone in armature.data.bones]
    assert len(names) == len(expected.joints())
    size = max(0.01, float(np.ptp([expected.pose(None)[name][:3, 3] for name in expected.joints()], axis=0).max()))
    rate = scene.render.fps / scene.render.fps_base
    frames = round(expected.duration * rate) + 1
    assert expected.duration * rate == pytest.approx(frames - 1, abs=1e-3 + 2e-5 * frames)
    if frames > 1:
        assert list(armature.animation_data.action.frame_range) == [scene.frame_start, scene.frame_start + frames - 1]
    for index in sampled(frames, 5):
        found = posed(armature, scene.frame_start + index)
        nodes = expected.pose(index / max(1, frames - 1) * expected.duration)
        # Blender shortens long names and numbers equal names; the order remains the file's.
        for bone, node in zip(depth_first(armature), expected.joints()):
            off = distance(found[bone], nodes[node])
            assert off <= 1e-4 * max(1.0, size), f"frame {index}, {bone}: {off} m off"


def depth_first(armature: bpy.types.Object) -> list[str]:
    found, todo = [], [bone for bone in reversed(armature.data.bones) if bone.parent is None]
    while todo:
        found.append(todo.pop())
        todo += reversed(found[-1].children)
    return [bone.name for bone in found]


@pytest.mark.parametrize(
    "name", ["real/cmu_12_01_walk.bvh", "real/run.fbx", "skeletons/animics_all_along_z.bvh", "made/arm.usda"]
)
def test_bones_lie_along_the_limbs(name: str) -> None:
    call("import_motion", filepath=str(FIXTURES / name))
    alone = [bone for bone in bpy.context.object.data.bones if len(bone.children) == 1]
    limbs = [bone for bone in alone if (bone.children[0].head_local - bone.head_local).length > 1e-3]
    assert limbs
    for bone in limbs:
        limb = bone.children[0].head_local - bone.head_local
        assert np.degrees((bone.tail_local - bone.head_local).angle(limb)) < 0.5
        assert bone.length == pytest.approx(limb.length, rel=1e-3)


def test_the_scene_takes_the_rate_or_keeps_it(tmp_path: Path) -> None:
    file = REAL / "cmu_12_01_walk.bvh"
    render = bpy.context.scene.render
    call("import_motion", filepath=str(file))
    assert (render.fps, render.fps_base) == (120, 1)
    render.fps, render.fps_base = 24, 1.001
    call("import_motion", filepath=str(file), rate="KEEP")
    assert render.fps == 24
    mocap("convert", file, "-o", tmp_path / "slow.glb", "--mesh", "none", "--fps", 24 / 1.001)
    expected = Written(tmp_path / "slow.glb")
    first, last = bpy.context.object.animation_data.action.frame_range
    assert last - first == pytest.approx(expected.duration * 24 / 1.001, abs=1e-3)
    for index in sampled(round(last - first) + 1):
        found = posed(bpy.context.object, first + index)
        nodes = expected.pose(index / (24 / 1.001))
        assert max(distance(found[bone], nodes[bone]) for bone in found) < 1e-4


def test_a_rate_that_is_no_whole_number_is_a_quotient(tmp_path: Path) -> None:
    text = (REAL / "cmu_short.bvh").read_text()
    (tmp_path / "ntsc.bvh").write_text(re.sub(r"Frame Time:.*", "Frame Time: 0.0333667", text))
    call("import_motion", filepath=str(tmp_path / "ntsc.bvh"))
    render = bpy.context.scene.render
    assert render.fps / render.fps_base == pytest.approx(1 / 0.0333667, rel=1e-6)


def test_the_unit_of_the_scene_is_kept() -> None:
    file = str(REAL / "cmu_short.bvh")
    call("import_motion", filepath=file)
    metres = posed(bpy.context.object, 20)
    bpy.context.scene.unit_settings.scale_length = 0.01
    call("import_motion", filepath=file)
    for name, matrix in posed(bpy.context.object, 20).items():
        assert np.abs(matrix[:3, 3] - 100 * metres[name][:3, 3]).max() < 0.01


def test_unit_and_up_axis_can_be_stated() -> None:
    file = str(REAL / "cmu_short.bvh")
    call("import_motion", filepath=file)
    guessed = posed(bpy.context.object, 1)
    call("import_motion", filepath=file, unit="0.1", up="z")
    stated = posed(bpy.context.object, 1)
    # CMU's unit is 0.0254 / 0.45 m, with +Y up. This case states +Z up, so the file's (x, y, z) do not change.
    for name in ("LeftFoot", "Head"):
        x, y, z = guessed[name][:3, 3] * 0.45 / 0.0254 * 0.1
        assert stated[name][:3, 3] == pytest.approx([x, z, -y], abs=1e-4)


def test_every_clip_of_a_file_is_an_action(tmp_path: Path) -> None:
    motions = [REAL / "cmu_short.bvh", REAL / "z_up_dab.bvh"]
    mocap("retarget", *motions, FIXTURES / "characters/human_game_engine.glb", "-o", tmp_path / "two.glb")
    call("import_motion", filepath=str(tmp_path / "two.glb"))
    assert sorted(action.name for action in bpy.data.actions) == ["cmu_short", "z_up_dab"]
    assert all(action.users for action in bpy.data.actions)
    assert bpy.context.object.animation_data.action.name == "cmu_short"


def test_actions_have_a_slot_and_a_layer() -> None:
    call("import_motion", filepath=str(REAL / "cmu_short.bvh"))
    armature = bpy.context.object
    if bpy.app.version >= (4, 4):
        action = armature.animation_data.action
        assert [slot.identifier for slot in action.slots] == [f"OB{armature.name}"]
        assert armature.animation_data.action_slot == action.slots[0]
        assert len(action.layers) == 1 and len(action.layers[0].strips) == 1
    assert all(curve.group is not None and curve.group.name in armature.pose.bones for curve in curves(armature))
    assert {point.interpolation for curve in curves(armature) for point in curve.keyframe_points} == {"LINEAR"}


def test_markers_can_be_solved(tmp_path: Path) -> None:
    file = FIXTURES / "markers/cmu_01_01.c3d"
    mocap("solve", file, "-o", tmp_path / "solved.glb", "--mesh", "none")
    expected = Written(tmp_path / "solved.glb")
    call("import_motion", filepath=str(file), solve=True)
    rate = bpy.context.scene.render.fps
    for index in (0, 300, 599):
        found, nodes = posed(bpy.context.object, 1 + index), expected.pose(index / rate)
        assert len(found) > 15 and max(distance(found[name], nodes[name]) for name in found) < 1e-4


@pytest.mark.parametrize("mode", ["EDIT", "POSE"])
def test_it_imports_from_every_mode(mode: str) -> None:
    call("import_motion", filepath=str(REAL / "cmu_short.bvh"))
    first = bpy.context.object
    bpy.ops.object.mode_set(mode=mode)
    call("import_motion", filepath=str(REAL / "z_up_dab.bvh"))
    assert bpy.context.object != first and bpy.context.object.mode == first.mode == "OBJECT"
    assert bpy.context.selected_objects == [bpy.context.object]


@pytest.mark.parametrize("hidden", ["exclude", "hide_viewport"])
def test_it_imports_beside_a_collection_that_is_not_shown(hidden: str) -> None:
    collection = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(collection)
    layer = bpy.context.view_layer.layer_collection.children["Hidden"]
    bpy.context.view_layer.active_layer_collection = layer
    setattr(layer, hidden, True)
    call("import_motion", filepath=str(REAL / "cmu_short.bvh"))
    assert bpy.context.object.visible_get() and len(bpy.context.object.data.bones) == 31


def test_it_imports_beside_a_linked_collection(tmp_path: Path) -> None:
    collection = bpy.data.collections.new("Linked")
    bpy.context.scene.collection.children.link(collection)
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {collection})
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, into):
        into.collections = ["Linked"]
    bpy.context.scene.collection.children.link(into.collections[0])
    bpy.context.view_layer.active_layer_collection = bpy.context.view_layer.layer_collection.children["Linked"]
    call("import_motion", filepath=str(REAL / "cmu_short.bvh"))
    assert bpy.context.object.visible_get()


HOSTILE = [
    "a b.bvh",
    "'quoted\" [x].bvh",
    "line\nbreak.bvh",
    "tab\tand%s{}.bvh",
    "\u30e2\u30fc\u30b7\u30e7\u30f3\U0001f57a.bvh",
    "-o --force.bvh",
    "n" * 200 + ".bvh",
    ".bvh",
    "no extension",
    "\u202egnp.bvh",
]


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_files_with_hostile_names(name: str, tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_short.bvh", tmp_path / name)
    call("import_motion", directory=f"{tmp_path}/", files=[{"name": name}])
    armature = bpy.context.object
    call("retarget_files", filepath=str(tmp_path / name))
    for action in bpy.data.actions:
        assert action.frame_range[1] > 2
    assert len(armature.data.bones) == 31


@pytest.mark.parametrize(
    "name", ['a"b', "back\\slash", "bracket]", "x" * 100, "\u30dc\u30fc\u30f3" * 20, "%s", "'", "."]
)
def test_joints_with_hostile_names(name: str, tmp_path: Path) -> None:
    lines = [
        "HIERARCHY",
        "ROOT root { OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation",
        f"JOINT {name}",
        "{ OFFSET 0 1 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 1 0 } } }",
        "MOTION",
        "Frames: 2",
        "Frame Time: 0.1",
        "0 0 0 0 0 0 0 0 0",
        "0 0 0 0 0 0 90 0 0",
    ]
    (tmp_path / "motion.bvh").write_text("\n".join(lines), encoding="utf-8")
    call("import_motion", filepath=str(tmp_path / "motion.bvh"), unit="m", up="y")
    armature = bpy.context.object
    child = armature.data.bones[1].name
    assert angle(posed(armature, 1)[child], posed(armature, 2)[child]) == pytest.approx(90, abs=0.01)
