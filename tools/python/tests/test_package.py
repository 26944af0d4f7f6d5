"""Tests the package beyond its numbers."""

from __future__ import annotations

import hashlib
import inspect
import json
import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import get_type_hints

import duckdb
import numpy as np
import polars
import pyarrow as pa
import pytest
from conftest import REAL

import mocap
from mocap import edit, ik


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
    with pytest.raises(ValueError, match="^rot must be 'quat', '6d', 'matrix' or 'euler', got '7d'$"):
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


def test_an_option_that_is_not_there_is_told_what_is_meant(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    for call, meant in [
        (lambda: mocap.read(walk, root_ofset="add"), "root_offset"),
        (lambda: mocap.read_bytes(walk.read_bytes(), "walk.bvh", strickt=True), "strict"),
        (lambda: mocap.convert(walk, tmp_path / "walk.glb", maxerror=0.001), "max_error"),
        (lambda: scene.to_numpy(fsp=30), "fps"),
        (lambda: scene.to_arrow(velocity=True), "velocities"),
        (lambda: edit.smooth(scene, cutoff=8), "cut_off"),
        (lambda: edit.smooth.step(cutoff=8), "cut_off"),
        (lambda: mocap.retarget(walk, walk, feets="free"), "feet"),
    ]:
        with pytest.raises(TypeError, match=f"^there is no option '[a-z_]+'; did you mean '{meant}'\\?$") as caught:
            call()
        assert isinstance(caught.value, mocap.UnknownOptionError)
    with pytest.raises(TypeError, match="^there is no option 'zzz'; the options are all_rows, body, .*, strict, hash$"):
        mocap.read(walk, zzz=30)
    with pytest.raises(TypeError, match="^there is no option 'zzz'; the options are rot, space, .*, contacts$"):
        scene.to_numpy(zzz=30)


def test_a_wrong_value_is_told_its_argument_and_what_it_must_be(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    target = tmp_path / "walk.glb"
    for call, kind, message in [
        (lambda: mocap.read(walk, root_offset="ad"), ValueError, "root_offset must be 'auto', 'replace' or 'add', got 'ad'"),
        (lambda: mocap.read(walk, strict=1), TypeError, "strict must be True or False, got 1"),
        (lambda: mocap.read(3), TypeError, "path must be a path, got 3"),
        (lambda: mocap.read(walk, clip=1.5), TypeError, "clip must be a whole number or a string, got 1.5"),
        (lambda: mocap.convert(walk, target, max_error=walk), TypeError, "max_error must be a number, got .*PosixPath"),
        (lambda: mocap.convert(walk, target, up="x"), ValueError, "up must be 'y', 'z', '-y' or '-z', got 'x'"),
        (lambda: mocap.retarget(None, scene), TypeError, "source must be a Scene or a path, got None"),
        (lambda: mocap.retarget(scene, scene, feet="locked"), ValueError, "feet must be .*; did you mean 'lock'"),
        (lambda: scene.to_numpy(trim=3), TypeError, "trim must be a pair of numbers, got 3"),
        (lambda: edit.smooth(scene, part="leg"), ValueError, "part must be .*, got 'leg'; did you mean 'legs'"),
        (lambda: edit.loop_clip(scene, frames=[1]), TypeError, r"frames must be a pair of whole numbers, got \[1\]"),
        (lambda: edit.smooth(scene, joints="Hips"), TypeError, "joints must be a list of names, got 'Hips'"),
        (lambda: edit.smooth(scene, cut_off=-1), ValueError, "cut_off must be"),
        (lambda: scene.plot(3), TypeError, "joints must be a string, got 3"),
        (lambda: mocap.PackedClip.of(scene, max_error="1mm"), TypeError, "max_error must be a number, got '1mm'"),
        (lambda: mocap.add_motions({"a": 1}, target, target), TypeError, "motions must be a dictionary, got"),
    ]:
        with pytest.raises(kind, match=message) as caught:
            call()
        assert isinstance(caught.value, mocap.MocapError) and "--" not in str(caught.value)
    with pytest.raises(TypeError, match=r"retarget\(\) missing 1 required positional argument: 'target'"):
        mocap.retarget(scene)


def test_options_are_spelled_as_python_spells_them() -> None:
    from mocap._errors import in_python

    said = "/data/max-error/a.bvh: error: max-error is too large; see mocap verify --max-error 1mm"
    wanted = "/data/max-error/a.bvh: error: max_error is too large; see mocap verify --max-error 1mm"
    assert in_python(said, "/data/max-error/a.bvh") == wanted


def test_every_function_takes_a_path_or_a_scene(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    hero = REAL.parent / "skeletons" / "human_vrm1.gltf"
    robot = mocap.Robot(REAL.parent / "robots" / "g1_29dof_rev_1_0.urdf")
    database = mocap.index(walk)
    same: list[Callable[[mocap.Scene | Path], object]] = [
        lambda motion: mocap.retarget(motion, hero).scene.pose(7).tolist(),
        lambda motion: mocap.retarget(walk, motion).reports,
        lambda motion: mocap.add_motions({"walk": motion}, hero, tmp_path / "moving.gltf", overwrite=True),
        lambda motion: robot.retarget(motion, passes=1).qpos.tolist(),
        lambda motion: robot.stream(motion, passes=1).delay,
        lambda motion: database.find(motion, 1.0, 2.0, count=2),
        lambda motion: mocap.PackedClip.of(motion).data,
        lambda motion: ik.bend(motion, 3, ["LeftArm", "LeftForeArm", "LeftHand"], [0, 1, 0]).distance,
        lambda motion: edit.prepare(motion).pose(7).tolist(),
        lambda motion: edit.contacts(motion)["points"],
        lambda motion: mocap.convert(motion, tmp_path / "walk.bvh", fps=30),
    ]
    for function in same:
        assert function(walk) == function(scene)
    prepared = edit.prepare(scene)
    # A step prepares a file, as `mocap edit` does.
    assert edit.mirror(walk).report == edit.mirror(str(walk)).report == edit.mirror(prepared).report
    assert edit.concat(walk, walk).report == edit.concat(prepared, prepared).report
    assert edit.apply_all(walk, ["mirror", "concat"], [walk])[1] == edit.apply_all(prepared, ["mirror", "concat"], [prepared])[1]
    edit.write(walk, tmp_path / "there.glb")
    assert mocap.read(tmp_path / "there.glb").frames == scene.frames
    with pytest.raises(mocap.OptionError, match="the source is a scene, so its file was read before"):
        mocap.convert(scene, tmp_path / "other.glb", strict=True)


def test_a_scene_is_written_with_the_options_of_a_file(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    for kind, options in (("fbx", {"fbx_target": "unreal"}), ("bvh", {"out_unit": "cm", "out_up": "z", "digits": 5})):
        of_scene, of_file = (tmp_path / f"{name}.{kind}" for name in ("of_scene", "of_file"))
        mocap.convert(scene, of_scene, **options)
        mocap.convert(walk, of_file, **options)
        np.testing.assert_allclose(mocap.read(of_scene).pose(9), mocap.read(of_file).pose(9), atol=1e-3)
    with pytest.raises(ValueError, match="digits has no effect on FBX"):
        mocap.convert(scene, tmp_path / "of_scene.fbx", digits=5)


def test_clips_are_listed_and_chosen(walk: Path, tmp_path: Path) -> None:
    hero, moving = REAL.parent / "skeletons" / "human_vrm1.gltf", tmp_path / "moving.gltf"
    mocap.add_motions({"Walk": walk, "Short": REAL / "cmu_short.bvh"}, hero, moving)
    clips = [animation["name"] for animation in json.loads(moving.read_text(encoding="utf-8"))["animations"]]
    scene = mocap.read(moving)
    assert scene.clips == clips == ["Walk", "Short"] and "the first of 2 clips" in repr(scene)
    for number, name in enumerate(clips):
        one = scene.clip(name)
        assert one.clips == [name] and one.frames == mocap.read(moving, clip=number).frames
        np.testing.assert_array_equal(one.pose(9), mocap.read(moving, clip=name).pose(9))
        np.testing.assert_array_equal(one.pose(9), scene.clip(number).pose(9))
    with pytest.raises(mocap.MocapError, match="does not have this clip.*did you mean \"Short\""):
        scene.clip("short")
    with pytest.raises(mocap.OptionError, match="clip must be a number from 0, got -1"):
        scene.clip(-1)


def test_the_version_is_that_of_the_package() -> None:
    manifest = (REAL.parents[1] / "tools" / "python" / "Cargo.toml").read_text(encoding="utf-8")
    assert f'version = "{mocap.__version__}"' in manifest


def test_results_print_as_lines_and_tables(walk: Path) -> None:
    changed, report = edit.mirror(walk)
    assert f"\npairs: {report['pairs']}\n" in repr(report) and report["pairs"] >= 10 and isinstance(report, dict)
    assert json.loads(json.dumps(report)) == report == pickle.loads(pickle.dumps(report))
    assert "<table>" in report._repr_html_() and "{" not in repr(report)
    database = mocap.index(walk)
    found = database.find(walk, 1.0, 2.0, count=3, per_clip=3)
    head, *rows = repr(found).splitlines()
    assert "file" in head.split()
    assert len(rows) == len(found) == 3 and isinstance(found, list) and found[0]["file"] == str(walk)
    moved = mocap.retarget(walk, walk)
    assert "verdict" in repr(moved) and "{" not in repr(moved)
    columns = mocap.read(walk).joint_angles()
    assert repr(columns).splitlines()[0] == f"time: float64 ({len(columns['time'])},)"
    for result in (database, moved, mocap.survey(walk), mocap.graph(walk), mocap.read(walk).to_numpy()):
        assert "<table>" in result._repr_html_()
    injected = mocap.Report(name="<script>")
    assert "<script>" not in injected._repr_html_() and "<script>" not in mocap.Reports([injected])._repr_html_()


def test_functions_by_hand_have_every_option_of_a_job() -> None:
    schema = json.loads((REAL.parents[1] / "src" / "job" / "job.schema.json").read_text(encoding="utf-8"))["$defs"]
    # Options of files and of the program, and options that Python names differently or lacks.
    for function, record, names, others in [
        (mocap.Robot.retarget, "RobotTarget", {}, {"file", "names_of_clips", "require", "scale"}),
        (mocap.retarget, "SkeletonTarget", {"map": "target_bones"}, {"file", "max_angle", "names_of_clips"}),
        (
            mocap.add_motions,
            "CharacterTarget",
            {"file": "character", "map": "target_bones", "replace_animations": "replace"},
            {"max_angle", "names_of_clips"},
        ),
        (mocap.graph, "GraphJobOptions", {}, set()),
        (mocap.Graph.walk, "WalkOptions", {}, set()),
        (mocap.survey, "SurveyOptions", {}, {"html", "sarif"}),
    ]:
        options = {name.replace("-", "_") for name in schema[record]["properties"]} - others
        taken = inspect.signature(function).parameters
        assert {names.get(name, name) for name in options} <= taken.keys(), function


def test_fields_of_options_have_one_declaration() -> None:
    from mocap._array_options import OptionChanges

    assert OptionChanges.__annotations__.keys() == mocap.Options.__annotations__.keys()
    for name, kind in get_type_hints(OptionChanges).items():
        assert kind == get_type_hints(mocap.Options)[name]
    shown = inspect.signature(mocap.Scene.to_numpy).parameters
    assert [*shown][2:] == [*mocap.Options.__annotations__]


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
    with pytest.raises(ValueError, match="^rest: \"x-pose\": expected zero, t-pose, a-pose or frame:N$"):
        mocap.convert(walk, tmp_path / "no.bvh", rest="x-pose")
    with pytest.raises(ValueError, match="names: neither vrm, mixamo, unreal, cmu, godot, unity, mhr, soma nor a file"):
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
    # The unit is the metre, because the walk's figure is as tall as a person.
    height = np.ptp(back.to_numpy().positions[0], axis=0).max()
    assert 1.2 < height < 2.1
    with pytest.raises(mocap.MocapError) as caught:
        mocap.convert(REAL / "missing.bvh", output)
    assert caught.value.code == "io"
    with pytest.raises(mocap.MocapError) as caught:
        mocap.convert(output, tmp_path / ".." / tmp_path.name / "walk.glb")
    assert caught.value.code == "output-is-input" and output.stat().st_size == size
