"""Tests that `mocap pack` gives the same rows on one thread and on two, in shards, after a resumed run, and from
Python."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import duckdb
import polars
import pyarrow as pa
import pyarrow.parquet
import pytest
from conftest import REAL
from make_clips import make_clips

import mocap


def pack(program: Path, folder: Path, output: Path, *options: str) -> int:
    command = [program, "pack", folder, "-o", output, "--quiet", *options]
    return subprocess.run(command, check=False).returncode


def rows(output: Path) -> pa.Table:
    """All rows, in the order of their clips."""
    parts = sorted(output.glob("*.parquet"))
    table = pa.concat_tables([pyarrow.parquet.read_table(part) for part in parts])
    return table.sort_by("clip").combine_chunks()


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """2,000 files, one of them broken."""
    folder = tmp_path_factory.mktemp("clips")
    make_clips(folder, 2000)[7].write_bytes(b"HIERARCHY\nROOT broken\n{\n")
    return folder


@pytest.fixture(scope="module")
def packed(program: Path, clips: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Packed by one thread into files of about a megabyte at most."""
    output = tmp_path_factory.mktemp("packed")
    assert pack(program, clips, output, "--threads", "1", "--part-size", "1") == 3
    return output


def test_two_threads_write_the_same_bytes(program: Path, clips: Path, packed: Path, tmp_path: Path) -> None:
    assert pack(program, clips, tmp_path, "--threads", "2", "--part-size", "1") == 3
    names = sorted(part.name for part in packed.glob("*.parquet"))
    assert len(names) > 1
    assert names == sorted(part.name for part in tmp_path.glob("*.parquet"))
    assert all((tmp_path / name).read_bytes() == (packed / name).read_bytes() for name in names)


def test_shards_come_together(program: Path, clips: Path, packed: Path, tmp_path: Path) -> None:
    codes = {pack(program, clips, tmp_path, "--shard", f"{part}/3") for part in (1, 2, 3)}
    assert codes == {0, 3}
    assert rows(tmp_path).equals(rows(packed))
    merged = subprocess.run([program, "merge-manifest", tmp_path], check=False, capture_output=True)
    assert merged.returncode == 3
    records = [json.loads(line) for line in (tmp_path / "mocap-manifest.jsonl").read_text().splitlines()]
    assert len(records) == 2000
    assert [record["input"] for record in records if record["error"]] == ["clip_00007.bvh"]


def test_the_tasks_of_a_slurm_array_pack_what_one_run_packs(program: Path, clips: Path, tmp_path: Path) -> None:
    script = Path(__file__).parents[1] / "examples" / "pack.sbatch"
    command = ["bash", script, clips, tmp_path / "array"]
    for task in ("1", "2", "3"):
        environment = {
            "PATH": f"{program.parent}:{os.environ['PATH']}",
            "SLURM_ARRAY_TASK_ID": task,
            "SLURM_ARRAY_TASK_COUNT": "3",
            "SLURM_CPUS_PER_TASK": "2",
        }
        assert subprocess.run(command, env=environment, check=False, capture_output=True).returncode == 0
    options = ("--rot", "6d", "--fps", "30", "--out-unit", "m", "--out-up", "y")
    assert pack(program, clips, tmp_path / "alone", *options) == 3
    assert rows(tmp_path / "array").equals(rows(tmp_path / "alone"))
    assert rows(tmp_path / "array").num_rows == 2000


def test_the_package_gives_the_same_rows(clips: Path, packed: Path) -> None:
    files = [(path.name, path.read_bytes()) for path in sorted(clips.iterdir())]
    found = rows(packed)
    expected = pa.table(mocap.table(files))
    # Errors name the file by the given path.
    assert found.drop_columns("error").equals(expected.drop_columns("error"))
    errors = [row for row in found.select(["clip", "error"]).to_pylist() if row["error"]]
    assert [row["clip"] for row in errors] == ["clip_00007.bvh"] and "unexpected-end" in errors[0]["error"]


def test_other_readers_read_it(packed: Path) -> None:
    pattern = str(packed / "*.parquet")
    assert duckdb.sql(f"select count(*), count(error), sum(frames) from '{pattern}'").fetchall() == [(2000, 1, 39980)]
    frame = polars.read_parquet(pattern)
    assert frame.height == 2000
    first = frame.filter(polars.col("clip") == "clip_00000.bvh")["positions"].to_list()[0]
    assert len(first) == 20 * 3 and len(first[0]) == 3


def test_a_run_goes_on_where_the_last_one_stopped(program: Path, tmp_path: Path) -> None:
    folder, output, fresh = tmp_path / "clips", tmp_path / "out", tmp_path / "fresh"
    folder.mkdir()
    paths = make_clips(folder, 30)
    assert pack(program, folder, output) == 0
    before = {part.name: part.stat().st_mtime_ns for part in output.glob("*.parquet")}
    assert pack(program, folder, output, "--resume") == 0
    assert before == {part.name: part.stat().st_mtime_ns for part in output.glob("*.parquet")}
    # One file changes, one disappears, and one is added: no row is outdated, repeated or missing.
    paths[3].write_bytes(paths[4].read_bytes())
    paths[5].unlink()
    shutil.copy(REAL / "lecture_Test.bvh", folder)
    assert pack(program, folder, output, "--resume") == 0
    assert pack(program, folder, fresh) == 0
    assert rows(output).equals(rows(fresh))
    assert rows(output).num_rows == 30


def test_long_table_and_inventory(program: Path, clips: Path, tmp_path: Path) -> None:
    assert pack(program, clips, tmp_path / "long", "--table", "long") == 3
    long = rows(tmp_path / "long")
    assert long.num_rows == 1999 * 20 * 3
    assert long.column_names == ["clip", "frame", "time", "joint", "x", "y", "z", "qx", "qy", "qz", "qw"]
    assert pack(program, clips, tmp_path / "inventory", "--inventory") == 3
    first = rows(tmp_path / "inventory").to_pylist()[0]
    assert (first["frames"], first["joints"], first["warnings"]) == (20, 3, [])
    assert first["duration"] == pytest.approx(19 * 0.0166667)
