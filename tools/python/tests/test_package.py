"""What the package promises beyond numbers."""

from __future__ import annotations

import hashlib
import json
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import duckdb
import numpy as np
import polars
import pyarrow as pa
import pytest
from conftest import REAL

import mocap


def test_shapes(walk: Path) -> None:
    scene = mocap.read(walk)
    joints = len(scene.nodes)
    for rot, shape in {"quat": (4,), "6d": (6,), "matrix": (3, 3), "euler": (3,)}.items():
        motion = scene.to_numpy(rot=rot, velocities=True, contacts=True)
        assert motion.rotations.shape == (scene.frames, joints, *shape)
        assert motion.rotations.dtype == np.float32
        assert motion.velocities is not None and motion.velocities.shape == (scene.frames, joints, 3)
        assert motion.contacts is not None and motion.contacts.shape == (scene.frames, joints)
        assert motion.contacts.dtype == np.bool_
    assert motion.parents.tolist() == [-1 if node.parent is None else node.parent for node in scene.nodes]
    assert motion.offsets.shape == (joints, 3)
    assert motion.header["provenance"]["source"]["name"] == walk.name


def test_six_numbers_are_the_columns_of_the_matrix(walk: Path) -> None:
    scene = mocap.read(walk)
    matrices = scene.to_numpy(rot="matrix").rotations
    six = scene.to_numpy(rot="6d").rotations
    np.testing.assert_array_equal(six[..., :3], matrices[..., :, 0])
    np.testing.assert_array_equal(six[..., 3:], matrices[..., :, 1])


def test_rate_unit_axis_and_part(walk: Path) -> None:
    scene = mocap.read(walk)
    plain = scene.to_numpy(trim=(1, 2), fps=scene.frame_rate)
    turned = scene.to_numpy(trim=(1, 2), fps=scene.frame_rate, unit=0.5, out_unit=1.0, up="y", out_up="z")
    x, y, z = np.moveaxis(plain.positions, -1, 0)
    np.testing.assert_allclose(turned.positions, np.stack([0.5 * x, -0.5 * z, 0.5 * y], axis=-1), atol=1e-5)
    slower = scene.to_numpy(trim=(1, 2), fps=scene.frame_rate / 4)
    np.testing.assert_allclose(slower.positions, plain.positions[::4], atol=1e-5)
    assert slower.frame_rate == scene.frame_rate / 4


def test_an_error_says_where() -> None:
    text = b"HIERARCHY\nROOT a\n{\n  OFFSET 0 zero 0\n}\n"
    with pytest.raises(mocap.MocapError, match="is not a number") as caught:
        mocap.read_bytes(text, "a.bvh")
    for error in (caught.value, pickle.loads(pickle.dumps(caught.value))):
        assert (error.code, error.path) == ("invalid-number", "a.bvh")
        assert (error.line, error.column, error.joint) == (4, 12, "a")
    with pytest.raises(mocap.MocapError, match="no joint's name matches") as caught:
        mocap.read(REAL / "cmu_short.bvh").to_numpy(joints="nobody")
    assert (caught.value.code, caught.value.line) == ("invalid-value", None)
    with pytest.raises(ValueError, match="expected one of `quat`, `6d`, `matrix`, `euler`$"):
        mocap.read(REAL / "cmu_short.bvh").to_numpy(rot="7d")
    with pytest.raises(ValueError, match="furlong"):
        mocap.read(REAL / "cmu_short.bvh").to_numpy(unit="furlong")


def test_errors_are_those_that_python_knows(tmp_path: Path) -> None:
    many = b"HIERARCHY\n" + b"ROOT a\n{\nOFFSET 0 0 0\n" + b"JOINT a\n{\nOFFSET 0 0 0\n" * 2000
    walk = REAL / "cmu_short.bvh"
    folder = tmp_path / "folder.glb"
    folder.mkdir()
    for kind, action, path in [
        (FileNotFoundError, lambda: mocap.read(tmp_path / "no.bvh"), tmp_path / "no.bvh"),
        (FileNotFoundError, lambda: mocap.convert(walk, tmp_path / "no" / "a.glb"), tmp_path / "no" / "a.glb"),
        (IsADirectoryError, lambda: mocap.read(tmp_path), tmp_path),
        (IsADirectoryError, lambda: mocap.convert(walk, folder), folder),
        (MemoryError, lambda: mocap.read_bytes(many, "deep.bvh"), Path("deep.bvh")),
        (MemoryError, lambda: mocap.read(walk).to_numpy(fps=1e6, trim=(0, None), joints=None).positions, None),
    ]:
        with pytest.raises(kind) as caught:
            action()
        error = pickle.loads(pickle.dumps(caught.value))
        for error in (caught.value, error):
            assert isinstance(error, mocap.MocapError) and isinstance(error, ValueError)
            assert type(error) is type(caught.value)
            if path is not None:
                assert error.path == str(path)
                assert str(error).startswith(str(path))
            if isinstance(error, OSError):
                assert error.filename == str(path) and error.errno and str(path) in str(error)


def test_the_wheel_reads_fbx() -> None:
    scene = mocap.read(REAL / "animation_with_skeleton.fbx")
    assert scene.frames > 1


def test_an_option_that_is_not_there_is_told_those_that_are(walk: Path, tmp_path: Path) -> None:
    message = "^there is no option 'fsp'; the options are "
    read_options = (
        "format, root_offset, all_rows, retime, strict, hash, clip, skeleton, joints, lengths, markers, static, body$"
    )
    with pytest.raises(TypeError, match=message + read_options):
        mocap.read(walk, strict=True, fsp=30)
    with pytest.raises(TypeError, match=message + read_options):
        mocap.read_bytes(walk.read_bytes(), "walk.bvh", fsp=30)
    with pytest.raises(TypeError, match=message + "unit, up, fps, rest, t_pose_first, names, bones, max_error, .*, overwrite, skeleton_only, " + read_options):
        mocap.convert(walk, tmp_path / "walk.glb", fsp=30)
    scene = mocap.read(walk)
    with pytest.raises(TypeError, match=message + "rot, space, .*, fps, .*, contacts$"):
        scene.to_numpy(fsp=30)
    with pytest.raises(TypeError, match=message + "clip, rot, space, .*, fps, .*, contacts$"):
        scene.to_arrow(fsp=30)


def test_convert_gives_a_rest_pose_and_names(walk: Path, tmp_path: Path) -> None:
    frames = mocap.read(walk).frames
    mocap.convert(walk, tmp_path / "walk.bvh", rest="t-pose", t_pose_first=True, names="mixamo")
    scene = mocap.read(tmp_path / "walk.bvh")
    assert scene.frames == frames + 1
    assert {"mixamorig:LeftForeArm", "LHipJoint"} <= {node.name for node in scene.nodes}
    # In the first frame no joint of the T-pose has a rotation.
    first = scene.to_numpy(rot="quat").rotations[0]
    np.testing.assert_allclose(np.abs(first[:, 3]), 1, atol=1e-5)
    mocap.convert(walk, tmp_path / "own.bvh", names={"hips": "Pelvis"})
    assert mocap.read(tmp_path / "own.bvh").nodes[0].name == "Pelvis"
    with pytest.raises(ValueError, match="rest: expected zero, t-pose, a-pose or frame:N"):
        mocap.convert(walk, tmp_path / "no.bvh", rest="x-pose")
    with pytest.raises(ValueError, match="names: neither vrm, mixamo, unreal, cmu nor a file"):
        mocap.convert(walk, tmp_path / "no.bvh", names="mixanu")
    with pytest.raises(ValueError, match="rest has no effect on a VRM animation"):
        mocap.convert(walk, tmp_path / "no.vrma", rest="t-pose")


def test_motions_print_short_and_pickle_whole(walk: Path) -> None:
    motion = mocap.read(walk).to_numpy()
    assert repr(motion) == "<mocap.Motion of 524 frames and 38 joints at 120 a second>"
    back = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(back.positions, motion.positions)
    assert back.header == motion.header


def test_the_hash_may_be_left_out(walk: Path) -> None:
    with_hash, without = mocap.read(walk), mocap.read(walk, hash=False)
    digest = hashlib.sha256(walk.read_bytes()).hexdigest()
    assert with_hash.metadata["origin"]["sha256"] == digest
    assert without.metadata["origin"]["sha256"] == ""
    np.testing.assert_array_equal(with_hash.to_numpy().positions, without.to_numpy().positions)


def test_options_pickle() -> None:
    options = mocap.Options(rot="6d", contacts=mocap.Contacts(height=0.1), trim=(0.5, None))
    assert pickle.loads(pickle.dumps(options)) == options
    read_options = mocap.ReadOptions(root_offset="add")
    assert pickle.loads(pickle.dumps(read_options)) == read_options


def test_every_library_takes_the_table(walk: Path) -> None:
    rows = mocap.read(walk).to_arrow(clip="walk", velocities=True)
    arrow = pa.table(rows)
    assert arrow.num_rows == len(rows) == 524 * 38
    assert arrow.column_names == rows.column_names
    assert json.loads(arrow.schema.metadata[b"mocap"])["joints"][0]["name"] == "Hips"
    assert pa.record_batch(rows).equals(arrow.to_batches()[0])
    frame = polars.DataFrame(rows)
    assert frame["x"].to_list() == arrow["x"].to_pylist()
    highest = duckdb.sql("select max(y) from arrow where joint = 'Head'").fetchall()
    assert highest == [(frame.filter(polars.col("joint") == "Head")["y"].max(),)]


def test_a_broken_file_is_a_row(walk: Path) -> None:
    files = [("walk", walk.read_bytes()), ("broken", b"HIERARCHY\nROOT a\n{\n")]
    for shape in ("clips", "inventory"):
        table = pa.table(mocap.table(files, shape))
        walked, broken = table.to_pylist()
        assert (walked["clip"], walked["error"], walked["frames"], walked["joints"]) == ("walk", None, 524, 38)
        assert broken["clip"] == "broken" and "unexpected-end" in broken["error"]
        assert all(value is None for name, value in broken.items() if name not in ("clip", "error"))


def test_threads_give_what_one_gives(walk: Path) -> None:
    expected = mocap.read(walk).to_numpy().positions
    with ThreadPoolExecutor(4) as pool:
        for motion in pool.map(lambda _: mocap.read(walk).to_numpy(), range(8)):
            np.testing.assert_array_equal(motion.positions, expected)


def test_arrays_outlive_the_scene(walk: Path) -> None:
    positions = mocap.read(walk).to_numpy().positions
    assert positions.flags.writeable
    assert np.isfinite(positions).all()


def test_convert(walk: Path, tmp_path: Path) -> None:
    output = tmp_path / "walk.glb"
    size = mocap.convert(walk, output)
    assert output.stat().st_size == size
    back = mocap.read(output)
    # Metres: the walk's figure is as tall as a person.
    height = np.ptp(back.to_numpy().positions[0], axis=0).max()
    assert 1.2 < height < 2.1
    with pytest.raises(mocap.MocapError) as caught:
        mocap.convert(REAL / "missing.bvh", output)
    assert caught.value.code == "io"
    with pytest.raises(mocap.MocapError) as caught:
        mocap.convert(output, tmp_path / ".." / tmp_path.name / "walk.glb")
    assert caught.value.code == "output-is-input" and output.stat().st_size == size
