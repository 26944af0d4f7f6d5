"""Compares `mocap.index` and `mocap.Database` with the program's results, and with features that NumPy computes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import REAL

import mocap

FILES = [str(REAL / name) for name in ("cmu_12_01_walk.bvh", "cmu_short.bvh", "rokoko_dance.bvh")]


def test_a_database_is_that_of_the_program(program: Path, tmp_path: Path) -> None:
    for options, words in (({}, []), ({"mirror": True, "pack": True}, ["--mirror", "--pack"])):
        theirs, own = tmp_path / f"theirs{len(words)}.mdb", tmp_path / f"own{len(words)}.mdb"
        subprocess.run([program, "index", *FILES, "-q", "-o", theirs, *words], check=True)
        mocap.index(FILES, **options).write(own)
        assert own.read_bytes() == theirs.read_bytes()
        with pytest.raises(mocap.MocapError):
            (tmp_path / "cut.mdb").write_bytes(own.read_bytes()[:-1])
            mocap.Database.read(tmp_path / "cut.mdb")


def test_what_is_found_is_what_the_program_finds(program: Path, tmp_path: Path) -> None:
    database = mocap.index(FILES)
    database.write(tmp_path / "moves.mdb")
    read = mocap.Database.read(tmp_path / "moves.mdb")
    assert len(read) == 3 and np.array_equal(read.features, database.features)
    scene = mocap.read(FILES[0])
    for words, found in (
        (["--like", f"{FILES[0]}@1..2.5"], read.find(scene, 1.0, 2.5)),
        (["--pose", f"{FILES[0]}@2s", "-n", "3", "--no-mirror"], read.find(scene, 2.0, pose=True, count=3, mirror=False)),
        (["--like", FILES[0], "--where", "walking > 0.5"], read.find(scene, where="walking > 0.5")),
        (["--like", f"{FILES[0]}@1..2", "--per-clip", "2"], read.find(scene, 1.0, 2.0, per_clip=2)),
    ):
        done = subprocess.run([program, "find", tmp_path / "moves.mdb", *words, "--json"], check=True, capture_output=True)
        assert found == json.loads(done.stdout) and found
    with pytest.raises(mocap.MocapError):
        read.find(scene, 90.0, 91.0)
    with pytest.raises(mocap.MocapError):
        read.find(scene, where="walking >")
    with pytest.raises(ValueError, match="first"):
        read.find(scene, pose=True)


def test_features_are_those_of_the_joints() -> None:
    database = mocap.index(FILES[0], mirror=True)
    clip, mirrored = database.clips
    assert (clip["first"], clip["mirrored"], mirrored["first"], mirrored["mirrored"]) == (0, False, clip["frames"], True)
    features = database.features[: clip["frames"]]
    assert features.shape == (clip["frames"], 27) and database.contacts.shape == (2 * clip["frames"],)
    # A walk of 1.2 m/s: the positions after a third, two thirds and a whole second are ahead of the present position.
    ahead = features[:-60, [16, 18, 20]].mean(0)
    assert np.all(np.diff([0.0, *ahead]) > 0.2)
    # The mirror image has its left foot at the mirrored position of the right foot.
    other = database.features[clip["frames"] :]
    assert np.array_equal(other[:, 1], features[:, 4]) and np.array_equal(other[:, 0], -features[:, 3])
