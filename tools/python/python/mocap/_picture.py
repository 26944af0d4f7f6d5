"""Pictures of motions."""

from __future__ import annotations

import os
from pathlib import Path

from . import _mocap
from ._errors import OptionError


class Picture:
    """A picture that a notebook shows, and that is saved as SVG or PNG: of :meth:`Scene.plot` or :meth:`Scene.sheet`."""

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
            OSError: Where it cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() == ".svg":
            path.write_text(self.svg, encoding="utf-8")
        elif path.suffix.lower() == ".png":
            path.write_bytes(self.png)
        else:
            raise OptionError(f"the file must end in .svg or .png, got {str(path)!r}")

    def _repr_svg_(self) -> str:
        return self.svg
