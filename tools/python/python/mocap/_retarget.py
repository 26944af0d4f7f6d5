"""Retargets motions to other skeletons, and adds them to character files."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Literal, NamedTuple

from . import _mocap
from ._call import public
from ._options import Bones, StrPath, Weights, as_json, names_of, weights_of
from ._report import Reports, parsed
from ._scene import Scene, SceneLike, native_of
from ._words import Feet, Hands

Scale = Literal["auto", "none"] | float


class Retargeted(NamedTuple):
    """Retargeted motions: the scene, and a quality report for each motion, in degrees and metres."""

    scene: Scene
    reports: Reports

    def __repr__(self) -> str:
        return f"{self.scene!r}\n{self.reports!r}"

    def _repr_html_(self) -> str:
        return self.reports._repr_html_() + self.scene._repr_html_()


@public
def retarget(
    source: SceneLike,
    target: SceneLike,
    *,
    scale: Scale = "auto",
    feet: Feet = "lock",
    hands: Hands = "keep",
    bones: Bones | None = None,
    target_bones: Bones | None = None,
    weights: Weights | None = None,
) -> Retargeted:
    """Retargets the motions of ``source`` to the skeleton of ``target``, and drops the target's own motions. Both are
    humanoids with any names, rest pose, unit and axes.

    >>> moved, reports = mocap.retarget("walk.bvh", "hero.glb")   # doctest: +SKIP
    >>> reports[0]["verdict"], reports[0]["mean_degrees"]         # doctest: +SKIP
    ('good', 0.01)

    Args:
        source: A motion: a scene, or the path of a file. A rest pose in its first frame is dropped.
        target: A skeleton: a scene, or the path of a file.
        scale: Scale of the path: ``"auto"``, the ratio of the leg lengths; ``"none"``, unchanged in metres; or a
            factor.
        feet: ``"lock"`` holds a foot still while the source foot is in contact, if the foot would slide more than the
            source foot.
        hands: ``"keep"`` keeps the source's contacts of hands with the body, each other or the floor.
        bones: The source joints of bones, to correct mocap's choice: ``{"leftFoot": "ankle_L"}``; ``None`` for an
            absent bone. :attr:`Scene.bones` has mocap's choice.
        target_bones: The target joints of bones, in the same form. ``{"follow": {"FootIK.L": "leftFoot"}}`` makes a
            joint follow a bone or another joint instead of its parent.
        weights: Weights of the foot lock that differ from their defaults, such as ``{"foot_lock": {"aim": 0.9}}``;
            docs/weights.md lists them.

    Raises:
        MocapError: If the source or the target is not a humanoid; the message has the reason.
    """
    native, reports = _mocap.retarget(
        native_of(source),
        native_of(target),
        _factor(scale),
        _locks(feet),
        hands == "keep",
        names_of(bones),
        names_of(target_bones),
        as_json(weights_of(weights)),
    )
    return Retargeted(Scene(native), parsed(reports))


@public
def add_motions(
    motions: Mapping[str, SceneLike],
    character: StrPath,
    target: StrPath,
    *,
    scale: Scale = "auto",
    feet: Feet = "lock",
    hands: Hands = "keep",
    replace: bool = False,
    overwrite: bool = False,
    bones: Bones | None = None,
    target_bones: Bones | None = None,
    weights: Weights | None = None,
) -> Reports:
    """Writes a glTF or VRM character with added motions, and returns a report for each motion. All other bytes of the
    file stay unchanged.

    >>> motions = {"walk": "walk.bvh", "run": mocap.read("run.bvh")}     # doctest: +SKIP
    >>> reports = mocap.add_motions(motions, "hero.vrm", "moving.vrm")   # doctest: +SKIP

    Args:
        motions: Names and motions, each a scene or the path of a file.
        character: A ``.glb``, ``.gltf`` or ``.vrm`` file.
        target: The file to write, in the same format. A failed call writes no partial file.
        scale: As for :func:`retarget`.
        feet: As for :func:`retarget`.
        hands: As for :func:`retarget`.
        replace: Drop the character's own motions.
        overwrite: Replace a file that may be a source. The character is never replaced.
        bones: As for :func:`retarget`, for all motions.
        target_bones: As for :func:`retarget`.
        weights: As for :func:`retarget`.

    Warns:
        UserWarning: If the character cannot show an expression or the gaze of a motion.

    Raises:
        MocapError: As for :func:`retarget`, if the character cannot be read, or if ``target`` is the character or may
            be a source.
    """
    named = [(name, native_of(motion)) for name, motion in motions.items()]
    reports, notes = _mocap.add_motions(
        named,
        character,
        target,
        _factor(scale),
        _locks(feet),
        hands == "keep",
        replace,
        overwrite,
        names_of(bones),
        names_of(target_bones),
        as_json(weights_of(weights)),
    )
    for note in notes:
        warnings.warn(note, stacklevel=3)
    return Reports(parsed(reports))


def _factor(scale: Scale) -> float | None:
    if scale == "auto":
        return None
    if scale == "none":
        return 1.0
    return float(scale)


def _locks(feet: Feet) -> bool:
    return feet == "lock"
