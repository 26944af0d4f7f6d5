"""Compares world positions of every kind of output with independent kinematics."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest
from kinematics import height, positions

import mocap

TOLERANCE = 1e-5
"""The largest difference as a fraction of the skeleton's height."""


def assert_close(found: np.ndarray, dialect: tuple[Path, bool]) -> None:
    expected = positions(*dialect)
    assert found.shape == expected.shape
    error = np.abs(found - expected).max() / height(expected)
    assert error <= TOLERANCE, f"{error:.1e} of height"


def from_rows(table: pa.Table) -> np.ndarray:
    """The positions of a table with a row for each frame and joint."""
    frames = table["frame"].to_numpy().max() + 1
    values = np.stack([table[axis].to_numpy() for axis in "xyz"], axis=1)
    return values.reshape(frames, -1, 3)


def test_numpy(dialect: tuple[Path, bool]) -> None:
    motion = mocap.read(dialect[0]).to_numpy()
    assert motion.positions.dtype == np.float32
    assert_close(motion.positions, dialect)


def test_poses(dialect: tuple[Path, bool]) -> None:
    scene = mocap.read(dialect[0])
    poses = np.stack([scene.pose(frame)[:, :3, 3] for frame in range(scene.frames)])
    assert_close(poses, dialect)


def test_arrow(dialect: tuple[Path, bool]) -> None:
    assert_close(from_rows(pa.table(mocap.read(dialect[0]).to_arrow())), dialect)


def test_clip_table(dialect: tuple[Path, bool]) -> None:
    table = pa.table(mocap.table([("clip", dialect[0].read_bytes())]))
    values = table["positions"].combine_chunks().flatten().flatten().to_numpy()
    assert_close(values.reshape(table["frames"][0].as_py(), table["joints"][0].as_py(), 3), dialect)


@pytest.mark.parametrize("extension", ["npz", "csv", "parquet"])
def test_program(dialect: tuple[Path, bool], extension: str, program: Path, tmp_path: Path) -> None:
    output = tmp_path / f"motion.{extension}"
    subprocess.run([program, "fk", dialect[0], "-o", output], check=True, capture_output=True)
    if extension == "npz":
        with np.load(output) as arrays:
            assert_close(arrays["positions"], dialect)
    elif extension == "csv":
        assert_close(from_rows(pyarrow.csv.read_csv(output, pyarrow.csv.ReadOptions(skip_rows=1))), dialect)
    else:
        assert_close(from_rows(pyarrow.parquet.read_table(output)), dialect)
