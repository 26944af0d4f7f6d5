"""Compares packed clips in Python with their original scene."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import mocap
from mocap import edit


def test_poses_are_those_of_the_scene_within_the_error(walk: Path) -> None:
    scene = edit.prepare(mocap.read(walk))
    clip = mocap.PackedClip.of(scene, max_error=0.001)
    assert clip.names == [node.name for node in scene.nodes]
    assert clip.parents == [-1 if node.parent is None else node.parent for node in scene.nodes]
    assert (clip.frames, clip.ticks_per_second) == (scene.frames, scene.frame_rate) and 0.0005 < clip.max_error <= 0.001
    for tick in range(0, scene.frames, 37):
        error = np.linalg.norm(clip.pose(tick)[:, :3, 3] - scene.pose(tick)[:, :3, 3], axis=1).max()
        assert error <= 0.001  # as requested, and no frame exceeds the stated error
        assert error <= clip.max_error + 1e-6
    local, world = clip.pose(30.5, space="local"), clip.pose(30.5)
    chained: list[np.ndarray] = []
    for matrix, parent in zip(local.astype(float), clip.parents):
        chained.append(matrix if parent < 0 else chained[parent] @ matrix)
    np.testing.assert_allclose(np.array(chained), world, atol=1e-5)


def test_it_is_the_file_that_convert_writes(walk: Path, tmp_path: Path) -> None:
    mocap.convert(walk, tmp_path / "walk.mclip", max_error=0.002)
    clip = mocap.PackedClip.open(tmp_path / "walk.mclip")
    assert 0.001 < clip.max_error <= 0.002
    assert pickle.loads(pickle.dumps(clip)) == clip != mocap.PackedClip.of(edit.prepare(mocap.read(walk)))
    back = mocap.read(tmp_path / "walk.mclip")
    np.testing.assert_allclose(back.pose(7), clip.pose(7), atol=1e-5)
    for end in (0, 10, len(clip.data) - 1):
        with pytest.raises(mocap.MocapError):
            mocap.PackedClip(clip.data[:end])
    with pytest.raises(FileNotFoundError):
        mocap.PackedClip.open(tmp_path / "no.mclip")
