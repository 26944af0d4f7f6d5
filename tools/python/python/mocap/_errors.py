"""The exception of everything that is wrong with a file or an option."""

from __future__ import annotations

from typing import Any


class MocapError(ValueError):
    """A file could not be read or written, or an option has no meaning for it.

    ``str(error)`` is the one line that the program prints: file, line and column, code, message, joint, what was
    expected, what was found. The parts are attributes; each is ``None`` where it does not apply.

    Attributes:
        code: The stable name of what is wrong, such as ``"invalid-number"``.
        path: The file.
        line: Line in the file, from 1.
        column: Column in the line, from 1, in characters.
        joint: The joint it belongs to.
        expected: What should have stood there.
        found: What stood there.
        help: How to mend it.
    """

    code: str
    path: str | None
    line: int | None
    column: int | None
    joint: str | None
    expected: str | None
    found: str | None
    help: str | None

    def __init__(self, message: str, details: dict[str, Any]) -> None:
        super().__init__(message)
        self._details = details
        for name, value in details.items():
            setattr(self, name, value)

    def __reduce__(self) -> tuple[type[MocapError], tuple[str, dict[str, Any]]]:
        # Worker processes send exceptions to each other.
        return (MocapError, (str(self), self._details))
