"""Tests retargeting in place: bones are where the program puts the nodes of the same character, exported by Blender."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
import targets
from conftest import FIXTURES, Written, angle, call, curves, distance, mocap, posed, sampled
from targets import CHARACTERS, SKELETONS

REAL = FIXTURES / "real"
MILLIMETRES, DEGREES = 0.1, 0.1

CMU = SKELETONS / "human_cmu.gltf"
APOSE = SKELETONS / "human_apose.gltf"
TPOSE = SKELETONS / "human_vrm1.gltf"
GAME = SKELETONS / "human_game_engine.gltf"

# A motion, a character, and a change of the character.
PAIRS: list[tuple[Path, Path, list[Callable[[bpy.types.Object], object]]]] = [
    (REAL / "cmu_short.bvh", CHARACTERS / "human_default.glb", []),
    (REAL / "cmu_12_01_walk.bvh", CHARACTERS / "human_game_engine.glb", []),
    (REAL / "z_up_dab.bvh", CHARACTERS / "human_vrm0.vrm", []),
    (REAL / "rokoko_dance.bvh", CHARACTERS / "arnaud.fbx", []),
    (REAL / "perception_neuron_moving_positions.bvh", CMU, []),
    (SKELETONS / "vicon_sword_attack.bvh", APOSE, []),
    (REAL / "cmu_02_01.amc", TPOSE, []),
    (SKELETONS / "accad_run_turn.bvh", GAME, []),
    (REAL / "mocopi_jump_six_channels.bvh", SKELETONS / "bvhtoolbox_walk01.bvh", []),
    (REAL / "cmu_short.bvh", CMU, [targets.rolled]),
    (REAL / "z_up_dab.bvh", CMU, [targets.resting(targets.T_POSE)]),
    (REAL / "cmu_12_01_walk.bvh", CMU, [targets.resting(targets.ARMS_DOWN), targets.rolled]),
    (FIXTURES / "arrays/kimodo_soma_01.npz", CMU, [targets.resting(targets.BENT)]),
    (REAL / "motionbuilder_vicon_walk.bvh", CMU, [targets.placed(scale=0.01)]),
    (REAL / "rokoko_dance.bvh", CMU, [targets.placed(scale=2.5, degrees=(0, 0, 120), at=(3, -2, 0.5)), targets.rolled]),
    (SKELETONS / "animics_all_along_z.bvh", APOSE, [targets.laid]),
    (REAL / "cmu_short.bvh", TPOSE, [targets.laid, targets.placed(scale=100), targets.mode("XYZ")]),
    (SKELETONS / "snu_character1_boxes.bvh", GAME, [targets.rolled, targets.mode("YZX"), targets.posed_before]),
    (REAL / "kinect_openni.bvh", CMU, [targets.loose, targets.mode("AXIS_ANGLE")]),
    (
        SKELETONS / "xsens_names_tpose.bvh",
        CMU,
        [targets.resting(targets.T_POSE), targets.connected, targets.placed(scale=0.1)],
    ),
]


def exported(folder: Path) -> Path:
    """Exports the whole scene with Blender's own exporter."""
    path = folder / "target.glb"
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", export_animations=False)
    return path


def compare(armature: bpy.types.Object, written: Written, rate: float) -> None:
    """Compares bones, as Blender evaluates them, with nodes."""
    first, last = armature.animation_data.action.frame_range
    # Blender rounds 30.0003 frames a second to 30.
    assert abs(written.duration * rate - (last - first)) < 1e-3 + 2e-5 * last
    for index in sampled(round(last - first) + 1):
        expected, found = written.pose(index / (last - first) * written.duration), posed(armature, first + index)
        for name, matrix in found.items():
            off, turned = distance(matrix, expected[name]) * 1000, angle(matrix, expected[name])
            assert off <= MILLIMETRES and turned <= DEGREES, (
                f"frame {index}, {name}: {off:.3f} mm, {turned:.3f} degrees off"
            )


@pytest.mark.parametrize(
    "pair", range(len(PAIRS)), ids=lambda pair: f"{PAIRS[pair][0].stem}-{PAIRS[pair][1].stem}-{pair}"
)
def test_bones_are_where_the_program_puts_them(pair: int, tmp_path: Path) -> None:
    motion, character, changes = PAIRS[pair]
    armature = targets.read(character)
    for change in changes:
        change(armature)
    target = exported(tmp_path)
    mocap("retarget", motion, target, "-o", tmp_path / "out.glb")
    call("retarget_files", filepath=str(motion), rate="SET")
    assert bpy.context.object == armature and len(bpy.data.actions) == 1
    written = Written(tmp_path / "out.glb")
    scene = bpy.context.scene
    compare(armature, written, scene.render.fps / scene.render.fps_base)
    assert scene.frame_end == armature.animation_data.action.frame_range[1]


def test_the_action_of_another_armature_stays_in_its_frames(tmp_path: Path) -> None:
    call("import_motion", filepath=str(REAL / "cmu_12_01_walk.bvh"), rate="KEEP")
    source = bpy.context.object
    for curve in curves(source):
        for point in curve.keyframe_points:
            point.co.x += 49
        curve.update()
    first, last = source.animation_data.action.frame_range
    armature = targets.read(CHARACTERS / "human_game_engine.glb")
    source.select_set(True)
    call("retarget_selected")
    action = armature.animation_data.action
    assert action.name.startswith("cmu_12_01_walk")
    # The source begins with a T-pose, which is omitted.
    assert list(action.frame_range) == [first + 1, last]

    def limb(bones: dict[str, np.ndarray], upper: str, lower: str) -> np.ndarray:
        return bones[lower][:3, 3] - bones[upper][:3, 3]

    for frame in sampled(round(last - first)):
        one = limb(posed(source, first + 1 + frame), "LeftArm", "LeftForeArm")
        other = limb(posed(armature, first + 1 + frame), "upperarm_l", "lowerarm_l")
        assert np.degrees(np.arccos(one @ other / np.linalg.norm(one) / np.linalg.norm(other))) < 0.2
