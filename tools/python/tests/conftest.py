"""The folders of the files."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

# The tests keep their own record of outputs, apart from the user's record. The module reads the record's folder once,
# at its import.
STATE = tempfile.TemporaryDirectory()
os.environ["XDG_STATE_HOME"] = STATE.name

REPOSITORY = Path(__file__).parents[3]
REAL = REPOSITORY / "fixtures" / "real"

# Five dialects: a plain file, a root that adds to its OFFSET, six moving channels per joint, different rotation orders,
# and NaN among the values.
DIALECTS = {
    "cmu_12_01_walk.bvh": False,
    "additive_root_walk.bvh": True,
    "perception_neuron_moving_positions.bvh": False,
    "cmu_mixed_rotation_orders.bvh": False,
    "nan_tokens.bvh": True,
}


@pytest.fixture(params=DIALECTS)
def dialect(request: pytest.FixtureRequest) -> tuple[Path, bool]:
    """A file, and whether its root adds to its OFFSET."""
    return REAL / request.param, DIALECTS[request.param]


@pytest.fixture
def walk() -> Path:
    return REAL / "cmu_12_01_walk.bvh"


@pytest.fixture
def lecture() -> Path:
    return REAL / "lecture_Test.bvh"


@pytest.fixture(scope="session")
def program() -> Path:
    """The command line, with Parquet; `check` builds it, or MOCAP names it."""
    path = Path(os.environ.get("MOCAP", REPOSITORY / "target" / "release" / "mocap"))
    if not path.exists():
        pytest.skip("cargo build --release --features parquet has not been run")
    return path
