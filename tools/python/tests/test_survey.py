"""Compares the rows of `mocap.survey` with the program's: from files, from records, and in data frames."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import duckdb
import polars
import pytest
from conftest import REAL, REPOSITORY

import mocap

DOCS = (REPOSITORY / "docs" / "survey.md").read_text(encoding="utf-8")
FILES = ["cmu_12_01_walk.bvh", "cmu_short.bvh", "rokoko_dance.bvh", "brackets_in_numbers.bvh"]


def block(language: str) -> str:
    """The only block of docs/survey.md in this language."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCS, re.DOTALL)
    return found.strip()


@pytest.fixture
def takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of four files, one of them broken, and a copy of the first."""
    folder = tmp_path / "takes"
    folder.mkdir()
    for name in FILES:
        shutil.copy(REAL / name, folder)
    shutil.copy(REAL / FILES[0], folder / "zz_copy.bvh")
    (folder / "notes.md").write_text("no motion")
    monkeypatch.chdir(tmp_path)
    return folder


def test_rows_are_those_of_the_program(program: Path, takes: Path) -> None:
    done = subprocess.run([program, "survey", "takes", "-o", "rows.json", "-q"], check=False, capture_output=True)
    assert done.returncode == 3
    found = mocap.survey("takes")
    assert found.rows == json.loads(Path("rows.json").read_text())
    assert len(found) == 5 and [row["verdict"] for row in found.rows].count("unreadable") == 1
    assert "takes/brackets_in_numbers.bvh:91:1" in found.rows[0]["error"]
    twin = found.rows[-1]
    assert (twin["twin"], twin["twin_of"], twin["twin_reason"]) == (True, "takes/cmu_12_01_walk.bvh", "bytes")


def test_records_of_bytes_give_the_rows_of_files(takes: Path) -> None:
    paths = sorted(str(path.relative_to(takes.parent)) for path in takes.glob("*.bvh"))
    parts = [mocap.examine([(path, Path(path).read_bytes())]) for path in paths]
    merged = mocap.survey(records=[line for part in reversed(parts) for line in part])
    alone = mocap.survey(paths).rows

    # Without a path, the message about a file gives its name.
    def unsaid(rows: list[dict[str, object]]) -> list[dict[str, object]]:
        return [{**row, "error": bool(row["error"])} for row in rows]

    assert unsaid(merged.rows) == unsaid(alone)


def test_what_is_kept_and_chosen(takes: Path) -> None:
    kept = mocap.survey("takes", where="humanoid and not twin")
    assert len(kept) == 3 and all(not row["twin"] for row in kept.rows)
    assert len(mocap.survey("takes", select=2, by=["diversity"])) == 2
    assert len(mocap.survey("takes", select="20%", by=["diversity"])) == 1
    strict = mocap.survey(takes / FILES[0], threshold={"skate": 0.1, "drift": (1, float("inf"))}, fail_on="bad")
    assert strict.rows[0]["verdict"] == "bad" and strict.problem and "1 clips are bad" in strict.problem
    assert mocap.survey(takes / FILES[0], fail_on="bad").problem is None
    with pytest.raises(ValueError, match="skate"):
        mocap.survey("takes", where="skat < 1")
    with pytest.raises(mocap.MocapError, match="is not a kind of defect"):
        mocap.survey("takes", threshold={"skid": 1})
    with pytest.raises(ValueError, match="no file to survey"):
        mocap.survey([])


def test_outputs(takes: Path) -> None:
    found = mocap.survey("takes")
    for name in ("rows.csv", "rows.json", "rows.jsonl", "list.txt", "card.html", "found.sarif"):
        found.write(name)
    assert Path("list.txt").read_text().split() == found.files
    assert mocap.survey("rows.jsonl").rows == found.rows
    assert Path("card.html").read_text().startswith("<!doctype html>")
    assert json.loads(Path("found.sarif").read_text())["version"] == "2.1.0"
    before = (takes / FILES[0]).read_bytes()
    with pytest.raises(mocap.MocapError):
        found.write(takes / FILES[0], overwrite=True)
    with pytest.raises(mocap.MocapError, match="cannot be written in this format"):
        found.write("rows.xlsx")
    assert (takes / FILES[0]).read_bytes() == before


def test_data_frames_read_the_tables(program: Path, takes: Path) -> None:
    subprocess.run([program, "survey", "takes", "-o", "survey.parquet", "-q"], check=False)
    found = mocap.survey("takes").rows
    counts = {row["skeleton"]: 0 for row in found if not row["twin"]}
    for row in found:
        counts[row["skeleton"]] += not row["twin"]
    by_skeleton = duckdb.sql(block("sql")).fetchall()
    assert {skeleton: count for skeleton, count, _ in by_skeleton} == counts
    good = [row["file"] for row in found if row.get("skate", 3) < 3 and not row["twin"]]
    assert good and eval(block("python"), {"polars": polars}).to_list() == good
    frame = polars.DataFrame(mocap.survey("takes").to_arrow())
    assert frame["file"].to_list() == [row["file"] for row in found]
    assert frame.equals(polars.read_parquet("survey.parquet"))


def test_a_job_gives_the_rows(takes: Path) -> None:
    inputs = ["takes/cmu_short.bvh", "takes/rokoko_dance.bvh"]
    job = {"source": {"inputs": inputs}, "survey": {"html": "card.html"}, "write": {"output": "rows.csv"}}
    report = mocap.run(job)
    assert report["survey"] == mocap.survey(inputs).rows
    assert [file["name"] for file in report["files"]] == ["card.html", "rows.csv"]
    with pytest.raises(mocap.MocapError, match="a survey job has no steps"):
        mocap.run({**job, "steps": ["mirror"]})
