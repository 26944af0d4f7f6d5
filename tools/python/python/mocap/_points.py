"""Converts points and other numbers of the caller to single precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import OptionError


def numbers(value: ArrayLike, name: str, count: int) -> list[float]:
    """Checks a list of finite numbers with the expected length."""
    array = single(value)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise OptionError(f"{name} must be {count} finite numbers, got {value!r}")
    listed: list[float] = array.tolist()
    return listed


def single(value: ArrayLike) -> NDArray[np.float32]:
    """Numbers in single precision."""
    # Numbers too large for single precision become infinite, and are rejected.
    with np.errstate(over="ignore"):
        return np.asarray(value, np.float64).astype(np.float32)
