"""Tests Clean, Foot Lock and Loop: the action becomes the program's output for the file that the extension writes.

That file is compared with Blender's own export. The program does not get the export: a foot lock turns the micrometre
by which the two files differ into 0.2 mm.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
import targets
from conftest import FIXTURES, Written, angle, call, curves, distance, mocap, posed, sampled

REAL = FIXTURES / "real"

STEPS = {"clean": ("clean",), "foot_lock": ("edit", "--step", "foot-lock"), "loop": ("edit", "--step", "loop")}


def noisy(armature: bpy.types.Object) -> None:
    """Spikes in some curves, which *Clean* must remove."""
    for curve in curves(armature)[8:60:7]:
        for at in range(20, len(curve.keyframe_points), 45):
            curve.keyframe_points[at].co.y += 0.5
        curve.update()


def told(armature: bpy.types.Object, folder: Path) -> Path:
    """The file that the extension gives to mocap. It matches the armature in the file of Blender's own exporter."""
    from bl_ext.user_default.mocap import glb, operators, rig

    frames = operators.frames_of(armature.animation_data.action)
    scene, path = bpy.context.scene, folder / "moving.glb"
    tree = rig.tree_of(armature, scene)
    glb.write(path, tree, rig.poses_of(armature, scene, frames), 120, rig.skin_of(armature, scene, tree))
    options = {"export_frame_range": False, "export_optimize_animation_size": False, "export_anim_slide_to_zero": True}
    scene.render.fps = 120
    bpy.ops.export_scene.gltf(filepath=str(folder / "blender.glb"), export_format="GLB", **options)
    ours, theirs = Written(path), Written(folder / "blender.glb")
    assert ours.duration == pytest.approx(theirs.duration, abs=1e-5)
    for index in [None, *sampled(len(frames))]:
        one, other = (written.pose(None if index is None else index / 120) for written in (ours, theirs))
        assert max(distance(one[bone.name], other[bone.name]) for bone in armature.data.bones) < 1e-5
        assert max(angle(one[bone.name], other[bone.name]) for bone in armature.data.bones) < 1e-3
    return path


def compare(armature: bpy.types.Object, written: Written, rate: float) -> None:
    first, last = armature.animation_data.action.frame_range
    assert round(last - first) == round(written.duration * rate)
    for index in sampled(round(last - first) + 1):
        expected, found = written.pose(index / rate), posed(armature, first + index)
        for name, matrix in found.items():
            off, turned = distance(matrix, expected[name]) * 1000, angle(matrix, expected[name])
            assert off <= 0.1 and turned <= 0.1, f"frame {index}, {name}: {off:.3f} mm, {turned:.3f} degrees off"


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("motion", ["cmu_12_01_walk.bvh", "z_up_dab.bvh"])
def test_the_action_is_what_the_program_makes(step: str, motion: str, tmp_path: Path) -> None:
    call("import_motion", filepath=str(REAL / motion))
    armature = bpy.context.object
    bpy.context.scene.render.fps = 120
    noisy(armature)
    command, *words = STEPS[step]
    mocap(command, told(armature, tmp_path), "-o", tmp_path / "out.glb", *words)
    before = posed(armature, 21)
    call(step)
    compare(armature, Written(tmp_path / "out.glb"), 120)
    assert len(bpy.data.actions) == 1
    changed = max(distance(posed(armature, 21)[name], matrix) for name, matrix in before.items())
    assert changed > 0.001, "the step changes the motion"


def test_a_character_with_a_scale_and_a_skin(tmp_path: Path) -> None:
    armature = targets.read(FIXTURES / "characters/human_game_engine.glb")
    call("retarget_files", filepath=str(REAL / "cmu_12_01_walk.bvh"), rate="SET", feet="free")
    mocap("edit", told(armature, tmp_path), "-o", tmp_path / "out.glb", "--step", "foot-lock")
    call("foot_lock")
    compare(armature, Written(tmp_path / "out.glb"), 120)


def test_an_object_that_moves_keeps_its_own_curves(tmp_path: Path) -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    armature = bpy.context.object
    for frame, x in ((1, 0.0), (524, 2.0)):
        armature.location.x = x
        armature.keyframe_insert("location", frame=frame)
    own = [curve for curve in curves(armature) if not curve.data_path.startswith("pose.bones")]
    assert len(own) == 3
    keys = [[tuple(point.co) for point in curve.keyframe_points] for curve in own]
    mocap("edit", told(armature, tmp_path), "-o", tmp_path / "out.glb", "--step", "foot-lock")
    call("foot_lock")
    own = [curve for curve in curves(armature) if not curve.data_path.startswith("pose.bones")]
    assert keys == [[tuple(point.co) for point in curve.keyframe_points] for curve in own]
    written = Written(tmp_path / "out.glb")
    for index in (10, 200, 500):
        expected, found = written.pose(index / 120), posed(armature, 2 + index)
        assert max(distance(found[name], expected[name]) for name in found) < 1e-4


def test_constraints_are_in_the_motion(tmp_path: Path) -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    armature = bpy.context.object
    limit = armature.pose.bones["LeftForeArm"].constraints.new("LIMIT_ROTATION")
    limit.use_limit_x, limit.min_x, limit.max_x, limit.owner_space = True, 0, 0.1, "LOCAL"
    mocap("edit", told(armature, tmp_path), "-o", tmp_path / "out.glb", "--step", "foot-lock")
    call("foot_lock")
    compare(armature, Written(tmp_path / "out.glb"), 120)


def test_the_original_can_be_kept() -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    armature = bpy.context.object
    original = armature.animation_data.action
    keys = sum(len(curve.keyframe_points) for curve in curves(armature))
    call("loop", into_copy=True, in_place=True)
    action = armature.animation_data.action
    assert action != original and len(bpy.data.actions) == 2
    assert action.use_cyclic and action.use_frame_range and action.frame_end == action.frame_range[1]
    assert original.users and original.frame_range[1] == 524
    armature.animation_data.action = original
    assert sum(len(curve.keyframe_points) for curve in curves(armature)) == keys


def test_a_shorter_playback_range_does_not_cut_the_action() -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    action = bpy.context.object.animation_data.action
    action.use_frame_range, action.frame_start, action.frame_end = True, 100, 120
    call("foot_lock")
    assert list(action.curve_frame_range) == [2, 524]


def test_a_loop_ends_as_it_begins() -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"))
    armature = bpy.context.object
    call("loop", in_place=True)
    first, last = armature.animation_data.action.frame_range
    begin, end = posed(armature, first), posed(armature, last)
    assert max(distance(begin[name], end[name]) for name in begin) < 1e-4
