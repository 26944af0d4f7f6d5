"""The exceptions for invalid files and options."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Mapping
from typing import Any

from ._words import DASHED

# The fields of an error without a file.
_NOTHING_KNOWN: Mapping[str, Any] = {
    "code": "invalid-value",
    **dict.fromkeys(("path", "line", "column", "joint", "expected", "found", "help")),
}


class MocapError(ValueError):
    """A file could not be read or written, or an option is invalid for the file.

    Subclasses also derive from Python's own exceptions: ``except FileNotFoundError`` and ``except MocapError`` both
    catch a :class:`MissingFileError`.

    ``str(error)`` is the line that the program prints: file, line and column, code, message, joint, expected and found
    text. The attributes have these parts; an absent part is ``None``.

    Attributes:
        code: The stable name of the error, such as ``"invalid-number"``.
        path: The file.
        line: Line in the file, from 1.
        column: Column in the line, from 1, in characters.
        joint: The joint of the error.
        expected: The expected text.
        found: The text in the file.
        help: The remedy.
    """

    code: str
    path: str | None
    line: int | None
    column: int | None
    joint: str | None
    expected: str | None
    found: str | None
    help: str | None

    def __init__(self, message: str, details: Mapping[str, Any] | None = None) -> None:
        super().__init__(message)
        self._details = {**_NOTHING_KNOWN, **(details or {})}
        for name, value in self._details.items():
            setattr(self, name, value)

    def __str__(self) -> str:
        # OSError's own text would add the error number and the path.
        return str(self.args[0])

    def __reduce__(self) -> tuple[type[MocapError], tuple[str, dict[str, Any]]]:
        # Worker processes send exceptions to each other.
        return (type(self), (str(self), self._details))


class OptionError(MocapError):
    """An argument is invalid for every file. Also a ``ValueError``."""


class UnknownOptionError(OptionError, TypeError):
    """An option is unknown, or options exclude each other. Also a ``TypeError``."""


class WrongTypeError(OptionError, TypeError):
    """An argument has a wrong type. Also a ``TypeError``."""


class FileError(MocapError, OSError):
    """A file that the operating system does not open, read or write."""

    def __init__(self, message: str, details: Mapping[str, Any] | None = None) -> None:
        super().__init__(message, details)
        self.filename = self.path
        self.strerror = message


class MissingFileError(FileError, FileNotFoundError):
    """A missing file or folder."""

    errno = errno.ENOENT


class FileIsFolderError(FileError, IsADirectoryError):
    """A folder where a file is needed."""

    errno = errno.EISDIR


class FilePermissionError(FileError, PermissionError):
    """A file that may not be read or written."""

    errno = errno.EACCES


class LimitError(MocapError, MemoryError):
    """A file or options that would need more memory than the limits allow."""


# Show the public names, also in tracebacks.
for _kind in (
    MocapError,
    OptionError,
    UnknownOptionError,
    WrongTypeError,
    FileError,
    MissingFileError,
    FileIsFolderError,
    FilePermissionError,
    LimitError,
):
    _kind.__module__ = "mocap"


# Options of jobs and steps with a dash in their names, but not options of a command line in a message.
_OPTION = re.compile(rf"(?<![\w-])(?:{'|'.join(DASHED)})(?![\w-])")


def in_python(message: str, path: str | None = None) -> str:
    """Converts a message of the library to Python's names of options. ``path`` at the beginning stays unchanged."""
    begin = path if path and message.startswith(path) else ""
    rest = _OPTION.sub(lambda found: found[0].replace("-", "_"), message[len(begin) :])
    return begin + rest


def error(kind: str, message: str, details: dict[str, Any]) -> MocapError:
    """The exception of a kind."""
    message = in_python(message, details.get("path"))
    if details.get("help"):
        details["help"] = in_python(details["help"])
    kinds = {
        "file": FileError,
        "missing": MissingFileError,
        "folder": FileIsFolderError,
        "permission": FilePermissionError,
        "limit": LimitError,
    }
    return kinds.get(kind, MocapError)(message, details)


def of_file(failure: OSError, path: str | os.PathLike[str]) -> MocapError:
    """The exception of a file that Python could not open, read or write."""
    kinds: list[tuple[type[OSError], str]] = [
        (FileNotFoundError, "missing"),
        (IsADirectoryError, "folder"),
        (PermissionError, "permission"),
    ]
    kind = next((kind for known, kind in kinds if isinstance(failure, known)), "file")
    name = os.fspath(path)
    return error(kind, f"{name}: error[io]: {failure.strerror or failure}", {"code": "io", "path": name})
