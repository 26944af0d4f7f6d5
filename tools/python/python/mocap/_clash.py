"""Detects an unrelated PyPI package whose module has the same name."""

from __future__ import annotations

import warnings
from importlib.metadata import PackageNotFoundError, version


def warn_of_other() -> None:
    """Warns if the PyPI package ``mocap``, for ArUco markers, is also installed: both packages write to the same
    folder."""
    try:
        other = version("mocap")
    except PackageNotFoundError:
        return
    warnings.warn(
        f"the package mocap {other} of PyPI, which is unrelated, is installed beside mocap-kit, and both have a module "
        "mocap: pip uninstall mocap mocap-kit, then pip install mocap-kit",
        RuntimeWarning,
        stacklevel=3,
    )
