"""Runs the lines of the README in a folder with the files that they name."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy
import pyarrow as pa
import pyarrow.dataset
import pytest
from conftest import REAL, REPOSITORY
from make_clips import make_clips

import mocap

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def block(word: str) -> str:
    """The only Python block with this word."""
    (found,) = [block for block in BLOCKS if word in block]
    return found


def run(code: str, folder: Path) -> str:
    script = folder / "pasted.py"
    script.write_text(code, encoding="utf-8")
    # Workers use the same Python.
    environment = os.environ | {"PYSPARK_PYTHON": sys.executable}
    command = [sys.executable, script.name]
    done = subprocess.run(command, cwd=folder, env=environment, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def assert_packed(folder: Path, paths: list[Path], name_of: str) -> None:
    """The rows in `out/` equal the rows of a single process: 2,000 clips, one of them an error."""
    names = [name_of.format(path.name) for path in paths]
    files = [(name, path.read_bytes()) for name, path in zip(names, paths)]
    expected = pa.table(mocap.table(files, "clips", mocap.Options(rot="6d", fps=30)))
    found = pa.dataset.dataset(folder / "out", format="parquet").to_table().sort_by("clip")
    assert found.select(expected.column_names).to_pylist() == expected.to_pylist()
    errors = [row for row in expected.select(["clip", "error"]).to_pylist() if row["error"]]
    assert [row["clip"] for row in errors] == [names[7]] and "unexpected-end" in errors[0]["error"]


@pytest.fixture
def clips(tmp_path: Path) -> list[Path]:
    """2,000 files in `clips/`, one of them broken."""
    folder = tmp_path / "clips"
    folder.mkdir()
    paths = make_clips(folder, 2000)
    paths[7].write_bytes(b"HIERARCHY\nROOT broken\n{\n")
    return paths


def test_first_lines(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    first = block("mocap.convert")
    run(first, tmp_path)
    assert (tmp_path / "walk.glb").read_bytes().startswith(b"glTF")
    command = [sys.executable, "-m", "mypy", "--strict", "pasted.py"]
    checked = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout


def test_lines_that_change_a_motion(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    run(block("warp_path"), tmp_path)
    assert (tmp_path / "loop.glb").read_bytes().startswith(b"glTF")


def test_lines_that_show_a_motion(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    size, shape, distance = re.match(r"(\d+) (\(.*\)) (.*)\n", run(block("PackedClip"), tmp_path)).groups()
    assert 10_000 < int(size) < 200_000 and shape == "(38, 4, 4)" and float(distance) < 10
    assert (tmp_path / "walk.html").exists() and (tmp_path / "feet.svg").exists() and (tmp_path / "sheet.png").exists()


def test_lines_of_steps(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    run(block("apply_all"), tmp_path)
    assert (tmp_path / "gentle.glb").read_bytes().startswith(b"glTF")


def test_lines_of_a_character(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    shutil.copy(REPOSITORY / "fixtures" / "skeletons" / "human_vrm1.gltf", tmp_path / "hero.gltf")
    assert run(block("add_motions"), tmp_path) == "good 523\n"  # of 524 frames, because the first is a rest pose
    assert b'"walk"' in (tmp_path / "moving.gltf").read_bytes()


def test_lines_of_a_robot(tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    shutil.copy(REPOSITORY / "fixtures" / "robots" / "g1_29dof_rev_1_0.urdf", tmp_path / "g1.urdf")
    printed = run(block("mocap.Robot"), tmp_path)
    assert re.fullmatch(r"(good|fair) \(\d+, 36\) left_hip_pitch_joint\n", printed), printed
    with numpy.load(tmp_path / "walk.npz") as written:
        assert written["joint_pos"].shape[1] == 29 and written["fps"].tolist() == [50]


def test_lines_after_the_program(program: Path, tmp_path: Path) -> None:
    shutil.copy(REAL / "cmu_12_01_walk.bvh", tmp_path / "walk.bvh")
    for output in ("walk.npz", "walk.csv", "walk.parquet"):
        subprocess.run([program, "fk", "walk.bvh", "-o", output], cwd=tmp_path, check=True, capture_output=True)
    assert run(block("numpy.load"), tmp_path) == "(524, 38, 3)\n(19912, 10)\n(19912, 11)\n[(524,)]\n"


def test_dask(clips: list[Path], tmp_path: Path) -> None:
    run(block("dask"), tmp_path)
    assert_packed(tmp_path, clips, "clips/{}")


def test_spark(clips: list[Path], tmp_path: Path) -> None:
    pytest.importorskip("pyspark", reason="`check --spark` installs it")
    run(block("SparkSession"), tmp_path)
    assert_packed(tmp_path, clips, f"file:{tmp_path}/clips/{{}}")
