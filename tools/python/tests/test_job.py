"""Whole jobs, as `mocap run` does them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

import mocap


def test_a_job_writes_what_the_program_writes(program: Path, walk: Path, tmp_path: Path) -> None:
    words = [program, "convert", walk, tmp_path / "there.glb", "--fps", "30", "--max-error", "1mm"]
    subprocess.run(words, check=True, capture_output=True)
    printed = subprocess.run([*words[:3], tmp_path / "here.glb", *words[4:], "--print-job"], check=True, capture_output=True)
    report = mocap.run(json.loads(printed.stdout))
    assert (tmp_path / "here.glb").read_bytes() == (tmp_path / "there.glb").read_bytes()
    assert report["files"] == [{"name": "here.glb", "bytes": (tmp_path / "here.glb").stat().st_size}]
    assert report["error"]["max_error"] <= 0.001


def test_extensions_are_those_that_the_program_knows(program: Path) -> None:
    rows = json.loads(subprocess.run([program, "formats", "--json"], check=True, capture_output=True).stdout)
    read = {name for row in rows if row["read"] for name in row["extensions"]}
    assert set(mocap.extensions()) == read | {"bip"}


def test_steps_and_their_reports(walk: Path, tmp_path: Path) -> None:
    job = {"source": {"inputs": [walk]}, "steps": ["mirror"], "write": {"output": tmp_path / "mirrored.bvh"}}
    report = mocap.run(job)
    assert report["steps"][0]["step"].startswith("mirror")
    assert mocap.read(tmp_path / "mirrored.bvh").frames == mocap.read(walk).frames


def test_what_is_wrong_with_a_job(walk: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="the job: write.outptu: a motion job has no outptu in write"):
        mocap.run({"write": {"outptu": "a.glb"}})
    with pytest.raises(mocap.MocapError, match="would replace"):
        mocap.run({"source": {"inputs": [walk]}, "write": {"output": walk, "force": True}})
