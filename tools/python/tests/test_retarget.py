"""Compares motions on other skeletons with the program, and by the directions of limbs."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REAL, REPOSITORY

import mocap
from mocap import edit

SKELETONS = REPOSITORY / "fixtures" / "skeletons"
CMU = {"upper": "LeftArm", "lower": "LeftForeArm", "hand": "LeftHand"}
MAKEHUMAN = {"upper": "upperarm01.L", "lower": "lowerarm01.L", "hand": "wrist.L"}


@pytest.fixture
def clip() -> mocap.Scene:
    return edit.prepare(mocap.read(REAL / "cmu_short.bvh"))


def directions(scene: mocap.Scene, joints: dict[str, str]) -> Any:
    places = {node.name: index for index, node in enumerate(scene.nodes)}
    ways = []
    for tick in range(0, scene.frames, 10):
        matrices = scene.pose(tick)
        upper, lower, hand = (matrices[places[joints[part]], :3, 3] for part in ("upper", "lower", "hand"))
        ways += [lower - upper, hand - lower]
    found = np.array(ways, dtype=np.float64)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_limbs_point_where_those_of_the_source_do(clip: mocap.Scene) -> None:
    moved, reports = mocap.retarget(clip, mocap.read(SKELETONS / "human_default.gltf"))
    assert moved.frames == clip.frames
    assert len(reports) == 1
    assert reports[0]["verdict"] == "good"
    sines = np.linalg.norm(directions(clip, CMU) - directions(moved, MAKEHUMAN), axis=1)
    assert np.degrees(sines.max()) < 0.1


def test_the_program_does_the_same(program: Path, tmp_path: Path) -> None:
    character = SKELETONS / "human_vrm1.gltf"
    reports = mocap.add_motions({"cmu_short": mocap.read(REAL / "cmu_short.bvh")}, character, tmp_path / "ours.gltf")
    made = subprocess.run(
        [program, "retarget", REAL / "cmu_short.bvh", character, "-o", tmp_path / "theirs.gltf", "--json"],
        check=True,
        capture_output=True,
    )
    theirs = json.loads(made.stdout)
    assert [report["clip"] for report in reports] == [report["clip"] for report in theirs]
    assert reports[0]["mean_degrees"] == pytest.approx(theirs[0]["mean_degrees"], abs=1e-3)
    text = json.loads((tmp_path / "ours.gltf").read_text())
    assert [clip["name"] for clip in text["animations"]] == ["cmu_short"]
    assert text["nodes"] == json.loads(character.read_text())["nodes"]


def test_options_change_the_path_and_the_feet(clip: mocap.Scene) -> None:
    target = mocap.read(SKELETONS / "human_vrm0.gltf")

    def path(**options: Any) -> Any:
        moved, _ = mocap.retarget(clip, target, feet="free", **options)
        ends = [moved.pose(tick)[:, :3, 3] for tick in (0, moved.frames - 1)]
        return np.linalg.norm(np.ptp(np.array([end[:, [0, 2]].mean(axis=0) for end in ends]), axis=0))

    once, twice = path(scale="none"), path(scale=2.0)
    assert twice == pytest.approx(2 * once, rel=0.1)
    with pytest.raises(ValueError, match="scale must be 'auto', 'none' or a number, got 'big'"):
        mocap.retarget(clip, target, scale="big")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="feet must be 'lock' or 'free', got 'none'"):
        mocap.retarget(clip, target, feet="none")  # type: ignore[arg-type]


def test_what_is_no_humanoid_is_refused(clip: mocap.Scene, tmp_path: Path) -> None:
    markers = mocap.read(REAL / "hand_take.c3d")
    with pytest.raises(mocap.MocapError, match="the target is not a humanoid"):
        mocap.retarget(clip, markers)
    with pytest.raises(mocap.MocapError, match="the source is not a humanoid"):
        mocap.add_motions({"hand": markers}, SKELETONS / "human_vrm1.gltf", tmp_path / "out.gltf")
    assert not (tmp_path / "out.gltf").exists()


def test_a_vrm_animation_is_written_and_read(walk: Path, tmp_path: Path) -> None:
    assert mocap.convert(walk, tmp_path / "walk.vrma") > 10_000
    scene = mocap.read(tmp_path / "walk.vrma")
    assert scene.metadata["format"] == "vrma"
    moved, reports = mocap.retarget(scene, mocap.read(SKELETONS / "human_vrm1.gltf"))
    assert reports[0]["verdict"] == "good"
    edit.write(moved, tmp_path / "again.vrma")
    # The first frame, a rest pose, is omitted, as in the walk itself.
    assert mocap.read(tmp_path / "again.vrma").frames == scene.frames - 1


def test_weights_of_a_conversion_and_of_feet_are_those_of_a_job(tmp_path: Path) -> None:
    trial = REPOSITORY / "fixtures" / "markers" / "cmu_01_01.c3d"
    weights = {"markers": {"on_bone": 0.06, "hold": 0.02}}
    mocap.convert(trial, tmp_path / "usual.bvh", markers="auto")
    mocap.convert(trial, tmp_path / "other.bvh", markers="auto", weights=weights)
    assert (tmp_path / "usual.bvh").read_bytes() != (tmp_path / "other.bvh").read_bytes()
    with pytest.raises(ValueError, match="robto: there is no robto in weights; known keys: robot"):
        mocap.convert(REAL / "cmu_short.bvh", tmp_path / "never.glb", weights={"robto": {}})
    with pytest.raises(ValueError, match="the weight aim of foot-lock must be from"):
        mocap.retarget(REAL / "cmu_short.bvh", REAL / "cmu_short.bvh", weights={"foot_lock": {"aim": 1e9}})
