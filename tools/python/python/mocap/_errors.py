"""The exceptions of everything that is wrong with a file or an option."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Mapping
from typing import Any

from ._words import DASHED

# What an error knows that comes from no file.
_NOTHING_KNOWN: Mapping[str, Any] = {
    "code": "invalid-value",
    **dict.fromkeys(("path", "line", "column", "joint", "expected", "found", "help")),
}


class MocapError(ValueError):
    """A file could not be read or written, or an option has no meaning for it.

    What Python has an exception for is that exception too: ``except FileNotFoundError`` and ``except MocapError`` both
    catch a :class:`MissingFileError`.

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

    def __init__(self, message: str, details: Mapping[str, Any] | None = None) -> None:
        super().__init__(message)
        self._details = {**_NOTHING_KNOWN, **(details or {})}
        for name, value in self._details.items():
            setattr(self, name, value)

    def __str__(self) -> str:
        # That of OSError would add the number and the path.
        return str(self.args[0])

    def __reduce__(self) -> tuple[type[MocapError], tuple[str, dict[str, Any]]]:
        # Worker processes send exceptions to each other.
        return (type(self), (str(self), self._details))


class OptionError(MocapError):
    """An argument has no meaning, whatever the file: a ``ValueError`` as Python has it."""


class UnknownOptionError(OptionError, TypeError):
    """There is no option of this name, or the options cannot be given together: a ``TypeError`` as Python has it."""


class WrongTypeError(OptionError, TypeError):
    """An argument has another type than it must have: a ``TypeError`` as Python has it."""


class FileError(MocapError, OSError):
    """A file that the operating system does not open, read or write."""

    def __init__(self, message: str, details: Mapping[str, Any] | None = None) -> None:
        super().__init__(message, details)
        self.filename = self.path
        self.strerror = message


class MissingFileError(FileError, FileNotFoundError):
    """A file or a folder that is not there."""

    errno = errno.ENOENT


class FileIsFolderError(FileError, IsADirectoryError):
    """A folder where a file is needed."""

    errno = errno.EISDIR


class FilePermissionError(FileError, PermissionError):
    """A file that may not be read or written."""

    errno = errno.EACCES


class LimitError(MocapError, MemoryError):
    """A file that would need more memory than the limits allow, or options that would."""


# As users name them, in a traceback too.
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


# Options of jobs and steps with a dash in their names, but not those of a command line that a message has.
_OPTION = re.compile(rf"(?<![\w-])(?:{'|'.join(DASHED)})(?![\w-])")


def in_python(message: str, path: str | None = None) -> str:
    """A message of the library with the options as Python spells them; ``path`` at its beginning stays."""
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
