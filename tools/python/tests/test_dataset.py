"""Reads the datasets of ``mocap pack --to hf`` and ``mocap.write_dataset`` with the library ``datasets``."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REAL

import mocap

NAMES = ("cmu_12_01_walk.bvh", "cmu_short.bvh", "rokoko_dance.bvh")


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    """Three motions in two folders, with a licence, and a broken file."""
    folder = tmp_path / "clips"
    for at, name in enumerate(NAMES):
        (folder / f"{at % 2}").mkdir(parents=True, exist_ok=True)
        (folder / f"{at % 2}" / name).write_bytes((REAL / name).read_bytes())
    (folder / "1" / "LICENSE.txt").write_text("Free for all uses.")
    (folder / "broken.bvh").write_text("HIERARCHY\nROOT broken | pipe\n{\n")
    return folder


def load(folder: Path, cache: Path) -> Any:
    os.environ["HF_HUB_OFFLINE"] = os.environ["HF_DATASETS_OFFLINE"] = "1"
    datasets = pytest.importorskip("datasets")
    return datasets.load_dataset(str(folder), split="train", cache_dir=str(cache))


def assert_whole(found: Any) -> None:
    """The rows equal the NumPy arrays of the files, in metres with +Y up."""
    assert sorted(found["clip"]) == sorted(f"{at % 2}/{name}" for at, name in enumerate(NAMES))
    for row in found.with_format("numpy"):
        motion = mocap.read(REAL / Path(row["clip"]).name).to_numpy(out_unit="m", out_up="y")
        assert (row["frames"], row["joints"]) == motion.positions.shape[:2]
        assert row["positions"].dtype == np.float32
        np.testing.assert_array_equal(row["positions"].reshape(motion.positions.shape), motion.positions)
        np.testing.assert_array_equal(row["rotations"].reshape(motion.rotations.shape), motion.rotations)
        assert list(row["names"]) == motion.names


def test_datasets_reads_what_the_command_writes(program: Path, clips: Path, tmp_path: Path) -> None:
    words = [program, "pack", clips, "-o", tmp_path / "out", "--to", "hf", "--license", "cc0-1.0", "--part-size", "1"]
    done = subprocess.run(words, check=False, capture_output=True, text=True)
    # One of many files cannot be read.
    assert done.returncode == 3 and "broken.bvh" in done.stderr
    shards = sorted(path.name for path in (tmp_path / "out" / "data").iterdir())
    count = len(shards)
    assert count > 1
    assert shards == [f"train-{at:05}-of-{count:05}.parquet" for at in range(count)]
    assert_whole(load(tmp_path / "out", tmp_path / "cache"))


def test_the_card_is_read_as_one(program: Path, clips: Path, tmp_path: Path) -> None:
    hub = pytest.importorskip("huggingface_hub")
    words = [program, "pack", clips, "-o", tmp_path / "out", "--to", "hf", "--license", "cc0-1.0", "--rot", "6d"]
    subprocess.run([*words, "--velocities", "--contacts"], check=False)
    card = hub.DatasetCard.load(tmp_path / "out" / "README.md")
    assert card.data.license == "cc0-1.0"
    assert card.data.size_categories == ["n<1K"]
    features = {feature["name"]: feature for feature in card.data.dataset_info["features"]}
    found = load(tmp_path / "out", tmp_path / "cache")
    assert list(features) == found.column_names
    assert card.data.dataset_info["splits"][0]["num_examples"] == len(found) == 3
    assert "Rotations are the first column of the rotation matrix" in card.text
    assert r"[licenses/1/LICENSE.txt](<licenses/1/LICENSE.txt>)" in card.text
    assert (tmp_path / "out/licenses/1/LICENSE.txt").read_text() == "Free for all uses."
    assert "| broken.bvh |" in card.text
    # The table has each column with its unit.
    for name in features:
        assert f"| `{name}` |" in card.text
    assert "| `velocities` | list of 3 x float32 | m | per second" in card.text


def test_the_package_writes_the_same_dataset(program: Path, clips: Path, tmp_path: Path) -> None:
    failed = mocap.write_dataset(clips, tmp_path / "python", license="cc0-1.0")
    assert list(failed) == ["broken.bvh"]
    words = [program, "pack", clips, "-o", tmp_path / "command" / "python", "--to", "hf", "--license", "cc0-1.0"]
    subprocess.run(words, check=False)
    for path in (tmp_path / "python").rglob("*"):
        if path.is_file():
            other = tmp_path / "command" / path.relative_to(tmp_path)
            assert other.read_bytes() == path.read_bytes(), path


def test_a_dataset_is_training_data(walk: Path, tmp_path: Path) -> None:
    mocap.write_dataset(walk, tmp_path / "out")
    windows = mocap.torch.Windows(tmp_path / "out" / "data", 32, features=("positions",))
    assert len(windows) > 3


def test_a_folder_with_files_stays_as_it_is(program: Path, clips: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(mocap.MocapError) as refused:
        mocap.write_dataset(clips, folder)
    assert refused.value.code == "output-exists"
    done = subprocess.run([program, "pack", clips, "-o", folder, "--to", "hf", "--force"], check=False)
    assert done.returncode == 2
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]
    # No other file remains in the folder.
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clips", "mine"]


def test_a_licence_is_an_identifier(clips: Path, tmp_path: Path) -> None:
    with pytest.raises(mocap.MocapError, match="license is not an identifier"):
        mocap.write_dataset(clips, tmp_path / "out", license="CC BY\nfoo: bar")
    assert not (tmp_path / "out").exists()
