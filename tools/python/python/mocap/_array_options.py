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
    """Thresholds of foot contact: a foot in contact is low and slow.

    A contact ends when the foot is above 1.6 times the height or the speed, as in the steps of ``edit``. The resting
    height of a foot is the height below which it is in a twentieth of the frames.

    Attributes:
        feet: A regular expression for the names of the feet; ``None`` for the feet of the humanoid.
        height: The largest height above the resting height, in metres.
        speed: The largest speed, in m/s.
    """

    feet: str | None = None
    height: float = 0.05
    speed: float = 0.25


@dataclass(frozen=True)
class Options:
    """Options of the arrays. By default nothing is converted.

    Attributes:
        rot: The representation of rotations. ``"quat"`` is x, y, z, w; ``"6d"`` the first two columns of the matrix;
            ``"matrix"`` 3 x 3; ``"euler"`` degrees about x, y and z, applied in the joint's ``rotation_order``.
        space: What positions are relative to: the ``"world"``; the position of the ``"root"`` in the same frame, along
            the world's axes; ``"local"`` is the listed parent, in its axes.
        rot_space: What rotations are relative to: the listed parent (``"local"``) or the ``"world"``.
        joints: A regular expression for the names of the joints and end sites to keep; all if ``None``.
        fps: Frames per second; ``None`` keeps the frames of the file. Between frames, positions are interpolated
            linearly and rotations along the shorter arc.
        trim: The part to keep, as begin and end in seconds, both included; either may be ``None``.
        unit: Unit of length of the file, as a name or in metres. ``None`` takes the unit that the file states, or else
            infers it if necessary.
        up: The up axis of the file. ``None`` takes the axis that the file states, or else infers it if necessary.
        out_unit: Unit of length of the output; ``None`` keeps the unit of the file.
        out_up: The up axis of the output; ``None`` keeps the axes of the file.
        bones: The joints of humanoid bones by name, such as ``{"head": "Neck"}``; ``None`` for an absent bone. The unit
            and the up axis are inferred from the bones.
        velocities: Also return velocities, in units per second: central differences, one-sided at the first and the
            last frame.
        contacts: Also return foot contacts; ``True`` means ``Contacts()``.
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
        """The options in the form of the native module."""
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
    """The fields of :class:`Options` that a call can set by name."""

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
    """Returns the options with changed fields. ``also`` are options that the caller handles itself.

    Raises:
        TypeError: If a name is not a field; the message lists the fields.
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
    """Adds the fields behind the last parameter to the method's help, and a check of its arguments."""
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
