"""Edit steps as values, and their application."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import update_wrapper
from inspect import Parameter, signature
from typing import Any, NamedTuple, ParamSpec, Protocol, cast

from . import _mocap
from ._call import public
from ._errors import MocapError, OptionError, UnknownOptionError, WrongTypeError
from ._options import Bones, names_of
from ._report import Report, Reports, parsed
from ._scene import Scene, SceneLike, native_of


Point = Sequence[float]
"""Three coordinates in metres."""


class Edited(NamedTuple):
    """An edited scene, with the report of the changes."""

    scene: Scene
    report: Report

    def __repr__(self) -> str:
        return f"{self.scene!r}\n{self.report!r}"

    def _repr_html_(self) -> str:
        return self.report._repr_html_() + self.scene._repr_html_()


@dataclass(frozen=True)
class Step:
    """A step of ``mocap edit`` with its options. :func:`mocap.edit.smooth.step` and similar functions make steps.

    >>> step = mocap.edit.Step("smooth", {"cut_off": 8})    # doctest: +SKIP
    >>> walk, report = step(walk)                           # doctest: +SKIP

    Attributes:
        name: The name of the step; ``docs/editing.md`` lists the names.
        options: The options by name. An absent option, or ``None``, means the default.
        other: The second motion of a concat, a blend or a layer.
        bones: The joints of bones, to correct mocap's choice.
    """

    name: str
    options: Mapping[str, object] = field(default_factory=dict, hash=False)
    other: SceneLike | None = None
    bones: Bones | None = field(default=None, hash=False)

    def __call__(self, scene: SceneLike) -> Edited:
        """Applies the step."""
        return apply(scene, self)

    def to_dict(self) -> dict[str, object]:
        """The step in the form of a job, without its second motion, which a job names in ``source.with``."""
        given = {key: value for key, value in self.options.items() if value is not None}
        return {"step": self.name, **given}


P = ParamSpec("P")


class StepFunction(Protocol[P]):
    """A function that applies a step to a scene. Its method ``step`` only makes the step."""

    __name__: str

    def __call__(self, scene: SceneLike, *args: P.args, **kwargs: P.kwargs) -> Edited:
        """Applies the step to a scene."""

    def step(self, *args: P.args, **kwargs: P.kwargs) -> Step:
        """Makes the step for later use."""


def step_function(make: Callable[P, Step]) -> StepFunction[P]:
    """Makes a function that applies the step of ``make``, with ``make`` as its method ``step``."""

    step = public(make)

    def function(*args: Any, **kwargs: Any) -> Edited:
        if args:
            scene, *rest = args
        elif "scene" in kwargs:
            rest, scene = [], kwargs.pop("scene")
        else:
            raise TypeError(f"{make.__name__}() missing 1 required argument: 'scene'")
        return step(*rest, **kwargs)(scene)

    update_wrapper(function, make)
    made = cast(Any, function)
    of_step = signature(make)
    first = Parameter("scene", Parameter.POSITIONAL_OR_KEYWORD, annotation="SceneLike")
    made.__signature__ = of_step.replace(parameters=[first, *of_step.parameters.values()], return_annotation="Edited")
    made.step = step
    return cast(StepFunction[P], made)


@public
def apply(
    scene: SceneLike,
    step: Step | str | Mapping[str, object],
    other: SceneLike | None = None,
    *,
    bones: Bones | None = None,
) -> Edited:
    """Applies a step: a :class:`Step`, ``{"step": "smooth", "cut_off": 8}``, or the program's form,
    ``"smooth:cut-off=8"``.

    The step changes every animation. Of several animations, the report describes the first; :func:`apply_all` returns
    all reports.

    Args:
        scene: A motion, or the path of one, which is read and prepared as :func:`mocap.edit.prepare` does.
        step: The name and the options; an option that is ``None`` has its default.
        other: The second motion of a concat, a blend or a layer; ``None`` takes the motion of the :class:`Step`.
        bones: The joints of bones, to correct mocap's choice: ``{"leftFoot": "ankle_L"}``.
    """
    if isinstance(step, Step):
        other, bones = step.other if other is None else other, step.bones if bones is None else bones
    native, report = _mocap.edit(
        prepared(scene),
        _text(_json_of(step)),
        None if other is None else prepared(other),
        names_of(bones),
    )
    return Edited(Scene(native), parsed(report)["changed"])


@public
def apply_all(
    scene: SceneLike,
    steps: Sequence[Step | str | Mapping[str, object]],
    others: Sequence[SceneLike] = (),
    *,
    bones: Bones | None = None,
) -> tuple[Scene, Reports]:
    """Applies steps in order. Returns the scene, and a report for each step and animation. The bones are found only once.

    Args:
        scene: As for :func:`apply`.
        steps: As for :func:`apply`.
        others: The second motions of the steps that take one, in order, except for a :class:`Step` with its own.
        bones: As for :func:`apply`, for all steps.

    Raises:
        UnknownOptionError: If a :class:`Step` has its own bones; pass bones here.
    """
    waiting = list(others)
    motions: list[SceneLike] = []
    for step in steps:
        if isinstance(step, Step) and step.bones is not None and step.bones != bones:
            raise UnknownOptionError(f"the step {step.name} has its own bones: give the bones of all steps to apply_all")
        if isinstance(step, Step) and step.other is not None:
            motions.append(step.other)
        elif waiting and _name_of(step) in ("concat", "blend", "layer"):
            motions.append(waiting.pop(0))
    native, reports = _mocap.edit_all(
        prepared(scene),
        _text([_json_of(step) for step in steps]),
        [prepared(motion) for motion in [*motions, *waiting]],
        names_of(bones),
    )
    return Scene(native), Reports(report["changed"] for report in parsed(reports))


def prepared(motion: SceneLike) -> _mocap.Scene:
    """Returns a scene unchanged. A file is read and prepared as the program does: in metres with +Y up, without a rest
    pose in the first frame."""
    native = native_of(motion)
    return native if isinstance(motion, Scene) else _mocap.prepare(native, None, None, None)


def _name_of(step: Step | str | Mapping[str, object]) -> object:
    if isinstance(step, str):
        return step.partition(":")[0]
    return step.name if isinstance(step, Step) else step.get("step")


def _json_of(step: Step | str | Mapping[str, object]) -> object:
    if isinstance(step, str):
        return step
    if isinstance(step, Step):
        return step.to_dict()
    return {key: value for key, value in step.items() if value is not None}


def _text(steps: object) -> str:
    try:
        return json.dumps(steps, default=_plain, allow_nan=False)
    except ValueError as failure:
        if isinstance(failure, MocapError):
            raise
        raise OptionError(f"a number in the options of a step must be finite, got {steps!r}") from None


def _plain(value: Any) -> object:
    """Converts numbers and NumPy arrays."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise WrongTypeError(f"an option of a step cannot be {type(value).__name__}: {value!r}")


def step_of(
    name: str, *, other: SceneLike | None = None, bones: Bones | None = None, **options: object
) -> Step:
    """Makes the step with this name and the given options."""
    given = {key: value for key, value in options.items() if value is not None}
    return Step(name, given, other, bones)


def target_of(to: str | Point | None) -> object:
    """A point as a list, or the name of a joint."""
    return to if to is None or isinstance(to, str) else [float(number) for number in to]


def path_points(points: Sequence[Sequence[float]] | None) -> list[dict[str, object]] | None:
    """Points over the ground in the form of a step: two coordinates, optionally after a time."""

    def point(numbers: Sequence[float]) -> dict[str, object]:
        at: dict[str, object] = {"at": [float(number) for number in numbers[-2:]]}
        return at if len(numbers) == 2 else {"seconds": float(numbers[0]), **at}

    return None if points is None else [point(numbers) for numbers in points]
