"""Reads the recordings of ``rerun-importer-mocap`` with rerun-sdk, and opens a file in the viewer."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REAL, REPOSITORY
from numpy.typing import NDArray

import mocap

pytest.importorskip("rerun")
PROGRAMS = Path(sysconfig.get_path("scripts"))
IMPORTER = PROGRAMS / "rerun-importer-mocap"


def recorded(path: Path) -> dict[str, dict[str, list[Any]]]:
    """The columns of each entity: first of the rows with times, then of the static rows."""
    from rerun.chunk import RrdReader

    found: dict[str, dict[str, list[Any]]] = defaultdict(lambda: defaultdict(list))
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        for name, column in zip(batch.schema.names, batch.columns):
            found[str(chunk.entity_path)][name] += column.to_pylist()
    return found


def imported(file: Path, folder: Path, *words: str) -> dict[str, dict[str, list[Any]]]:
    recording = folder / "recording.rrd"
    with open(recording, "wb") as out:
        subprocess.run([IMPORTER, file, *words], stdout=out, check=True)
    return recorded(recording)


def in_order(entity: dict[str, list[Any]], column: str) -> NDArray[np.float64]:
    """The values of a column, by ticks."""
    ticks = entity["tick"]
    # Chunks of static rows have no ticks.
    values = [value for value in entity[column] if value is not None]
    assert len(values) == len(ticks)
    return np.array([values[at] for at in np.argsort(ticks)], np.float64)


def test_a_walk_has_its_joints_curves_contacts_and_times(walk: Path, tmp_path: Path) -> None:
    found = imported(walk, tmp_path, "--recording-id", "r1", "--entity-path-prefix", "takes/walk")
    scene = mocap.read(walk)
    motion = scene.to_numpy(rot="euler", contacts=True)
    joints = found["/takes/walk/joints"]
    assert sorted(joints["tick"]) == list(range(scene.frames))
    seconds = sorted(time.total_seconds() for time in joints["time"])
    np.testing.assert_allclose(seconds, np.arange(scene.frames) / scene.frame_rate, atol=1e-6)
    np.testing.assert_array_equal(in_order(joints, "Points3D:positions"), motion.positions)
    assert joints["Points3D:labels"] == [motion.names]
    links = in_order(found["/takes/walk/links"], "LineStrips3D:strips")
    children = np.flatnonzero(motion.parents >= 0)
    np.testing.assert_array_equal(links[:, :, 1], motion.positions[:, children])
    np.testing.assert_array_equal(links[:, :, 0], motion.positions[:, motion.parents[children]])
    hips = in_order(found["/takes/walk/rotations/Hips"], "Scalars:scalars")
    np.testing.assert_array_equal(hips, motion.rotations[:, 0])
    assert motion.contacts is not None
    foot = motion.names.index("LeftToeBase")
    contacts = in_order(found["/takes/walk/contacts/LeftToeBase"], "Scalars:scalars")
    np.testing.assert_array_equal(contacts[:, 0].astype(bool), motion.contacts[:, foot])
    # Metres with +Y up, because the file states neither unit nor axis.
    assert found["/takes/walk"]["Transform3D:scale"] == [[[pytest.approx(0.0564, rel=0.1)] * 3]]


def test_a_skin_is_deformed_as_its_bones_move(tmp_path: Path) -> None:
    character = tmp_path / "moving.glb"
    body = REPOSITORY / "fixtures/characters/human_default.glb"
    mocap.add_motions({"walk": REAL / "cmu_12_01_walk.bvh"}, body, character)
    found = imported(character, tmp_path)
    skins = [entity for entity in found if "/skin/" in entity]
    assert skins
    scene = mocap.read(character)
    positions = scene.to_numpy().positions
    for entity in skins:
        vertices = in_order(found[entity], "Mesh3D:vertex_positions")
        assert len(vertices) == scene.frames
        assert max(map(max, found[entity]["Mesh3D:triangle_indices"][0])) < vertices.shape[1]
        # The skin follows the skeleton: in every frame, it is at most about half the skeleton's height away.
        height = np.ptp(positions[0, :, 1])
        assert np.abs(vertices.mean(axis=1) - positions.mean(axis=1)).max() < height / 2
        assert np.ptp(vertices[:, 0], axis=0).max() > height / 2, "the walk goes somewhere"


def test_a_static_import_is_one_pose_without_times(lecture: Path, tmp_path: Path) -> None:
    found = imported(lecture, tmp_path, "--static")
    joints = found["/lecture_Test/joints"]
    assert "tick" not in joints and "time" not in joints
    assert len(joints["Points3D:positions"]) >= 1


@pytest.mark.parametrize("name", ["README.md", "fixtures/robots/h1.urdf", "fixtures/characters/human_default.glb", "none.bvh"])
def test_other_files_are_for_other_importers(name: str) -> None:
    done = subprocess.run([IMPORTER, REPOSITORY / name], check=False, capture_output=True)
    assert (done.returncode, done.stdout) == (66, b"")


def test_a_broken_motion_is_an_error() -> None:
    broken = REPOSITORY / "fixtures/broken/channel_count_negative.bvh"
    done = subprocess.run([IMPORTER, broken], check=False, capture_output=True, text=True)
    assert done.returncode == 1 and "channel" in done.stderr


def test_the_viewer_finds_the_importer(walk: Path, tmp_path: Path) -> None:
    """The viewer looks for importers in the path, and saves what it receives."""
    words = [PROGRAMS / "rerun", walk, "--save", tmp_path / "viewer.rrd", "--port", "auto"]
    subprocess.run(words, env={"PATH": str(PROGRAMS), "HOME": str(tmp_path)}, check=True, timeout=120, stderr=sys.stderr)
    assert len(recorded(tmp_path / "viewer.rrd")["/cmu_12_01_walk/joints"]["tick"]) == mocap.read(walk).frames
