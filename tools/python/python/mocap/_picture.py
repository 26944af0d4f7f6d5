"""Pictures of motions."""

from __future__ import annotations

import os
from pathlib import Path

from . import _mocap
from ._errors import OptionError, of_file


class Picture:
    """A picture from :meth:`Scene.plot` or :meth:`Scene.sheet`. A notebook shows it; :meth:`save` writes SVG or PNG."""

    def __init__(self, native: _mocap.Picture) -> None:
        self._native = native

    def __repr__(self) -> str:
        return "<mocap.Picture of {} by {} pixels>".format(*self._native.size)

    @property
    def svg(self) -> str:
        """The picture as SVG."""
        return self._native.svg()

    @property
    def png(self) -> bytes:
        """The picture as PNG."""
        return self._native.png()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture to ``.svg`` or ``.png``.

        Raises:
            OptionError: For another extension.
            OSError: If the file cannot be written.
        """
        extension = Path(path).suffix.lower()
        if extension not in (".svg", ".png"):
            raise OptionError(f"the file must end in .svg or .png, got {os.fspath(path)!r}")
        picture = self.png if extension == ".png" else self.svg.encode()
        try:
            Path(path).write_bytes(picture)
        except OSError as failure:
            raise of_file(failure, path) from None

    def _repr_svg_(self) -> str:
        return self.svg


def positive(name: str, value: int) -> int:
    """A number of pixels or poses.

    Raises:
        OptionError: If the number is not above 0, or too large for a picture.
    """
    if not 0 < value < 1 << 31:
        raise OptionError(f"{name} must be above 0 and below {1 << 31}, got {value!r}")
    return value
