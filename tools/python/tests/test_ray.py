"""The example on a cluster of two workers gives the rows that one process gives."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pyarrow as pa
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
