"""Steps as values, and how they are applied."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import update_wrapper
from inspect import Parameter, signature
from typing import Any, NamedTuple, ParamSpec, Protocol, cast

from . import _mocap
from ._errors import MocapError, OptionError, UnknownOptionError
from ._options import names_of
from ._scene import Scene


class Edited(NamedTuple):
    """A changed scene, and what was changed."""

    scene: Scene
    report: dict[str, Any]


@dataclass(frozen=True)
class Step:
    """A step of ``mocap edit`` and its options, as :func:`mocap.edit.smooth.step` and its sisters make it.

    >>> step = mocap.edit.Step("smooth", {"cut_off": 8})    # doctest: +SKIP
    >>> walk, report = step(walk)                           # doctest: +SKIP

    Attributes:
        name: Its name, as ``docs/editing.md`` lists them.
        options: Its options by name; an option that is ``None``, or is not there, has its default.
        other: The second motion of a concat, a blend or a layer.
        bones: The names of joints for bones, where the guess is wrong.
    """

    name: str
    options: Mapping[str, object] = field(default_factory=dict, hash=False)
    other: Scene | None = None
    bones: Mapping[str, str | None] | None = field(default=None, hash=False)

    def __call__(self, scene: Scene) -> Edited:
        """Applies the step."""
        return apply(scene, self)

    def to_dict(self) -> dict[str, object]:
        """The step as a job has it, without its second motion, which a job names in ``source.with``."""
        given = {key: value for key, value in self.options.items() if value is not None}
        return {"step": self.name, **given}


P = ParamSpec("P")


class StepFunction(Protocol[P]):
    """A function that applies a step to a scene, or with ``step`` makes the step alone."""

    __name__: str

    def __call__(self, scene: Scene, *args: P.args, **kwargs: P.kwargs) -> Edited:
        """Applies the step to a scene."""

    def step(self, *args: P.args, **kwargs: P.kwargs) -> Step:
        """The step, to be applied later."""


def step_function(make: Callable[P, Step]) -> StepFunction[P]:
    """The function that applies what ``make`` makes, and has it as ``step``."""

    def function(scene: Scene, *args: P.args, **kwargs: P.kwargs) -> Edited:
        return make(*args, **kwargs)(scene)

    update_wrapper(function, make)
    made = cast(Any, function)
    of_step = signature(make)
    scene = Parameter("scene", Parameter.POSITIONAL_OR_KEYWORD, annotation="Scene")
    made.__signature__ = of_step.replace(parameters=[scene, *of_step.parameters.values()], return_annotation="Edited")
    made.step = make
    return cast(StepFunction[P], made)


def apply(
    scene: Scene,
    step: Step | str | Mapping[str, object],
    other: Scene | None = None,
    *,
    bones: Mapping[str, str | None] | None = None,
) -> Edited:
    """Applies a step: a :class:`Step`, ``{"step": "smooth", "cut_off": 8}``, or as the program takes it, ``"smooth:cut-off=8"``.

    Args:
        scene: A motion.
        step: Its name and its options; an option that is ``None`` has its default.
        other: The second motion of a concat, a blend or a layer; that of the :class:`Step` if ``None``.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    if isinstance(step, Step):
        other, bones = step.other if other is None else other, step.bones if bones is None else bones
    native, report = _mocap.edit(
        scene._native,
        _text(_json_of(step)),
        None if other is None else other._native,
        names_of(bones),
    )
    return Edited(Scene(native), json.loads(report)["changed"])


def apply_all(
    scene: Scene,
    steps: Sequence[Step | str | Mapping[str, object]],
    others: Sequence[Scene] = (),
    *,
    bones: Mapping[str, str | None] | None = None,
) -> tuple[Scene, list[dict[str, Any]]]:
    """Applies steps in their order, and returns the scene with a report for each step. Bones are found once for all.

    Args:
        scene: A motion.
        steps: As for :func:`apply`.
        others: The second motions of those steps that take one and are no :class:`Step` with one, in their order.
        bones: As for :func:`apply`, for all steps.

    Raises:
        UnknownOptionError: Where a :class:`Step` has bones of its own; give them here.
    """
    waiting = list(others)
    motions = []
    for step in steps:
        if isinstance(step, Step) and step.bones is not None and step.bones != bones:
            raise UnknownOptionError(f"the step {step.name} has bones of its own: give them to apply_all, for all steps")
        if isinstance(step, Step) and step.other is not None:
            motions.append(step.other)
        elif waiting and _name_of(step) in ("concat", "blend", "layer"):
            motions.append(waiting.pop(0))
    native, reports = _mocap.edit_all(
        scene._native,
        _text([_json_of(step) for step in steps]),
        [motion._native for motion in [*motions, *waiting]],
        names_of(bones),
    )
    return Scene(native), [report["changed"] for report in json.loads(reports)]


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
    """Numbers and arrays of NumPy."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise UnknownOptionError(f"an option of a step cannot be {type(value).__name__}: {value!r}")


def step_of(name: str, **options: object) -> Step:
    """The step of a name, with the options that are given."""
    return Step(name, {key: value for key, value in options.items() if value is not None})
