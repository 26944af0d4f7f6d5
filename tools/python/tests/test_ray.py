"""The example on a cluster of two workers gives the rows of a single process."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from make_clips import make_clips

ray = pytest.importorskip("ray", reason="`check --ray` installs it")
EXAMPLES = str(Path(__file__).parents[1] / "examples")
sys.path.insert(0, EXAMPLES)


@pytest.fixture(scope="module")
def cluster() -> Iterator[None]:
    workers_find_the_example = {"env_vars": {"PYTHONPATH": EXAMPLES}}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env=workers_find_the_example)
    yield
    ray.shutdown()


def test_rows_equal_those_of_one_process(cluster: None, tmp_path: Path) -> None:
    import ray_pack

    paths = make_clips(tmp_path, 2000)
    paths[7].write_bytes(b"HIERARCHY\nROOT broken\n{\n")
    found = [row for batch in ray_pack.pack(tmp_path).iter_batches(batch_format="pyarrow") for row in batch.to_pylist()]
    alone = pa.table({"path": [str(path) for path in paths], "bytes": [path.read_bytes() for path in paths]})
    expected = ray_pack.clips(alone).to_pylist()
    found.sort(key=lambda row: row["clip"])
    assert found == expected
    errors = [row for row in found if row["error"] is not None]
    assert [row["clip"] for row in errors] == [paths[7].name]
    assert "unexpected-end" in errors[0]["error"]


def test_motions_on_a_robot_equal_those_of_one_process(cluster: None, tmp_path: Path) -> None:
    import mocap
    import ray_robot

    fixtures = Path(__file__).parents[3] / "fixtures"
    robot, clip = fixtures / "robots/h1.urdf", (fixtures / "real/cmu_short.bvh").read_bytes()
    (tmp_path / "a.bvh").write_bytes(clip)
    (tmp_path / "b.bvh").write_bytes(clip[:2000])
    ray_robot.on_robot(tmp_path, robot).write_parquet(str(tmp_path / "out"))
    found = pq.read_table(tmp_path / "out").sort_by("clip").to_pylist()
    assert [row["clip"] for row in found] == ["a.bvh", "b.bvh"]
    motion = mocap.Robot(str(robot)).retarget(mocap.read(str(tmp_path / "a.bvh")), fps=50)
    assert [list(pose) for pose in found[0]["qpos"]] == motion.qpos.tolist()
    assert (found[0]["verdict"], found[0]["error"]) == (motion.report["verdict"], None)
    assert found[1]["qpos"] is None and "unexpected-end" in found[1]["error"]


def test_a_survey_equals_that_of_one_process(cluster: None, tmp_path: Path) -> None:
    import mocap
    import ray_survey

    real = Path(__file__).parents[3] / "fixtures/real"
    for name in ("cmu_12_01_walk.bvh", "cmu_short.bvh", "rokoko_dance.bvh"):
        (tmp_path / name).write_bytes((real / name).read_bytes())
    (tmp_path / "copy.bvh").write_bytes((tmp_path / "cmu_short.bvh").read_bytes())
    found = ray_survey.survey(tmp_path, where="not twin")
    assert found.rows == mocap.survey(tmp_path, where="not twin").rows
    assert len(found) == 3
