"""Types of options, and their conversion."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from . import _mocap
from ._errors import WrongTypeError
from ._words import Axis as Axis
from ._words import Unit as Unit


StrPath = str | os.PathLike[str]
Bones = Mapping[str, str | Mapping[str, str] | None]
"""The names of joints for bones, as ``{"leftFoot": "ankle_L"}``; ``None`` for an absent bone."""
Weights = Mapping[str, Mapping[str, float]]
"""Weights of solvers by solver, as ``{"robot": {"hand": 1.0}}``: ``robot``, ``foot_lock``, ``clean``, ``markers``."""
TimeRange = str | tuple[float | None, float | None]
"""A part of a motion: ``(1, 2.5)`` in seconds, either may be ``None``; or in the program's form, ``"30f..75f"`` in
frames."""


def part(*options: tuple[str, object]) -> dict[str, Any]:
    """Nests options by their paths, without absent options."""
    whole: dict[str, Any] = {}
    for path, value in options:
        if value is None or value is False:
            continue
        *above, name = path.split("/")
        here = whole
        for key in above:
            here = here.setdefault(key, {})
        here[name] = value
    return whole


def as_json(value: object) -> str:
    """JSON for the native module: paths become text, and values of NumPy become numbers and lists."""
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> object:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise WrongTypeError(f"an option cannot be {type(value).__name__}: {value!r}")


def time_range(given: TimeRange | None) -> str | None:
    """A part of a motion in the form of a job."""
    if given is None or isinstance(given, str):
        return given
    first, last = ("" if end is None else f"{end}" for end in given)
    return f"{first}..{last}"


def metres(unit: Unit | float | None) -> float | None:
    """The length of a unit in metres. The unit is a name, or already a number."""
    return _mocap.metres_in(unit) if isinstance(unit, str) else unit


def weights_of(weights: Weights | None) -> dict[str, dict[str, float]]:
    """The weights of solvers in the form of a job."""
    return {
        solver.replace("_", "-"): {name.replace("_", "-"): value for name, value in own.items()}
        for solver, own in (weights or {}).items()
    }


def names_of(bones: Bones | None) -> str | None:
    """The names of joints for bones, in the form of the native module."""
    return None if bones is None else json.dumps(dict(bones))
