"""Options of arrays as plain data, which compare, print and pickle."""

from __future__ import annotations

import inspect
import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar, cast, get_type_hints

from ._call import checker, fits, refusal, unknown_option
from ._options import Axis, Unit, metres

if sys.version_info >= (3, 11):
    from typing import Unpack as Unpack
elif TYPE_CHECKING:
    from typing_extensions import Unpack as Unpack
else:
    Unpack = Mapping


@dataclass(frozen=True)
class Contacts:
    """What counts as a foot that stands on the ground: low and slow at once.

    A foot in contact leaves when it is 1.6 times too high or too fast, as for the steps of ``edit``. It rests where it is
    in most frames: at the height below which it is in a twentieth of them.

    Attributes:
        feet: A regular expression for the names of the feet; ``None`` for those of the humanoid.
        height: Metres above where it rests, at most.
        speed: Metres a second, at most.
    """

    feet: str | None = None
    height: float = 0.05
    speed: float = 0.25


@dataclass(frozen=True)
class Options:
    """Options of the arrays. By default nothing is converted.

    Attributes:
        rot: What the numbers of a rotation are: ``"quat"`` is x, y, z, w; ``"6d"`` the first two columns of the
            matrix, one after the other; ``"matrix"`` 3 x 3; ``"euler"`` degrees about x, y and z, which the joint's
            ``rotation_order`` puts in order.
        space: What positions are relative to: the ``"world"``; the position of the ``"root"`` in the same frame, along
            the world's axes; ``"local"`` is the listed parent, in its axes.
        rot_space: What rotations are relative to: the listed parent (``"local"``) or the ``"world"``.
        joints: A regular expression for the names of the joints and end sites to keep; all if ``None``.
        fps: Frames per second; the file's own frames if ``None``. In between, positions move on a line and rotations
            on the shorter arc.
        trim: The part to keep, from and to, in seconds, both included; either may be ``None``.
        unit: Unit of length of the file, by name or as metres in one; if ``None``, what the file says, else a guess
            where it is needed.
        up: The axis of the file that points up; if ``None``, what the file says, else a guess where it is needed.
        out_unit: Unit of length of the output; the file's own if ``None``.
        out_up: The axis of the output that points up; the file's own axes if ``None``.
        bones: Joints of the file for bones of the humanoid, by name, as ``{"head": "Neck"}``; ``None`` in place of a
            name for a bone that there is not. The unit and the up axis are guessed from the bones.
        velocities: Give velocities too, in units a second: central differences, one-sided at the first and the last
            frame.
        contacts: Say which feet stand on the ground; ``True`` stands for ``Contacts()``.
    """

    rot: Literal["quat", "6d", "matrix", "euler"] = "quat"
    space: Literal["world", "root", "local"] = "world"
    rot_space: Literal["local", "world"] = "local"
    joints: str | None = None
    fps: float | None = None
    trim: tuple[float | None, float | None] = (None, None)
    unit: Unit | float | None = None
    up: Axis | None = None
    out_unit: Unit | float | None = None
    out_up: Axis | None = None
    bones: Mapping[str, str | None] = field(default_factory=dict, hash=False)
    velocities: bool = False
    contacts: Contacts | bool = field(default=False)

    def to_json(self) -> str:
        """The options as the native half reads them."""
        contacts = Contacts() if self.contacts is True else self.contacts or None
        first, last = self.trim
        values: dict[str, Any] = {
            "rotation": self.rot,
            "space": self.space,
            "rotation_space": self.rot_space,
            "joints": self.joints,
            "frames_per_second": self.fps,
            "first": None if first is None else {"seconds": first},
            "last": None if last is None else {"seconds": last},
            "metres_per_unit": metres(self.unit),
            "up": self.up,
            "out_metres_per_unit": metres(self.out_unit),
            "out_up": self.out_up,
            "bones": dict(self.bones),
            "velocities": self.velocities,
            "contacts": contacts and vars(contacts),
        }
        return json.dumps(values)


class OptionChanges(TypedDict, total=False):
    """The fields of :class:`Options`, of which a call names some."""

    rot: Literal["quat", "6d", "matrix", "euler"]
    space: Literal["world", "root", "local"]
    rot_space: Literal["local", "world"]
    joints: str | None
    fps: float | None
    trim: tuple[float | None, float | None]
    unit: Unit | float | None
    up: Axis | None
    out_unit: Unit | float | None
    out_up: Axis | None
    bones: Mapping[str, str | None]
    velocities: bool
    contacts: Contacts | bool


def changed(options: Options, changes: OptionChanges, *also: str) -> Options:
    """The options with other values for the fields named. ``also`` are options that the caller takes itself.

    Raises:
        TypeError: Where no field has a name, with the names that there are.
    """
    hints = get_type_hints(Options)
    for name, value in changes.items():
        if name not in hints:
            raise unknown_option(name, [*also, *hints])
        if not fits(value, hints[name]):
            raise refusal(name, value, hints[name])
    return replace(options, **changes)


Method = TypeVar("Method", bound=Callable[..., Any])


def takes_fields(method: Method) -> Method:
    """The method, whose help names the fields that its last parameter stands for, and which checks its arguments."""
    own = inspect.signature(method)
    check = checker(method)
    named = [parameter for parameter in own.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD]
    has_name = {parameter.name for parameter in named}

    def checked(*args: Any, **kwargs: Any) -> Any:
        check(args, {name: value for name, value in kwargs.items() if name in has_name})
        return method(*args, **kwargs)

    kind = inspect.Parameter.KEYWORD_ONLY
    more = [inspect.Parameter(of.name, kind, default=_default(of), annotation=of.type) for of in fields(Options)]
    checked.__signature__ = own.replace(parameters=[*named, *more])  # type: ignore[attr-defined]
    checked.__name__, checked.__qualname__, checked.__doc__ = method.__name__, method.__qualname__, method.__doc__
    checked.__module__ = method.__module__
    return cast(Method, checked)


def _default(of: Any) -> object:
    return {} if of.name == "bones" else of.default
