"""Motions on other skeletons, and in the files of characters."""

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
    """A skeleton with motions of another, and how well they are the same: a report for each motion, in degrees and metres."""

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
    """The motions of ``source`` on the skeleton of ``target``, in place of its own. Both are humanoids, of any names, rest
    pose, unit and axes.

    >>> moved, reports = mocap.retarget("walk.bvh", "hero.glb")   # doctest: +SKIP
    >>> reports[0]["verdict"], reports[0]["mean_degrees"]         # doctest: +SKIP
    ('good', 0.01)

    Args:
        source: A motion: a scene, or the path of a file. A rest pose in its first frame is left out.
        target: A skeleton, likewise.
        scale: Length of the steps: ``"auto"``, in the proportion of the legs; ``"none"``, as those of the source in metres;
            or a factor.
        feet: ``"lock"`` holds feet still while those of the source stand, where they would slide more.
        hands: ``"keep"`` brings hands to where those of the source touch the body, each other or the floor.
        bones: The names of joints of the source for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``; ``None``
            for a bone that it does not have. :attr:`Scene.bones` has the guess.
        target_bones: Those of the target, likewise. ``{"follow": {"FootIK.L": "leftFoot"}}`` lets a joint follow a
            bone, or another joint, instead of its parent.
        weights: The weights by which feet are held that differ from their defaults, as ``{"foot_lock": {"aim": 0.9}}``;
            docs/weights.md lists them.

    Raises:
        MocapError: Where one of the two is not a humanoid, with the reason.
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
    """Writes a glTF or VRM character with motions added, and returns a report for each. Everything else in the file stays as
    it is, byte by byte.

    >>> motions = {"walk": "walk.bvh", "run": mocap.read("run.bvh")}     # doctest: +SKIP
    >>> reports = mocap.add_motions(motions, "hero.vrm", "moving.vrm")   # doctest: +SKIP

    Args:
        motions: Names and motions, each a scene or the path of a file.
        character: A ``.glb``, ``.gltf`` or ``.vrm`` file.
        target: The file to write, of the same kind; it is whole or absent.
        scale: As for :func:`retarget`.
        feet: As for :func:`retarget`.
        hands: As for :func:`retarget`.
        replace: Leave out the motions that the character has.
        overwrite: Replace a file that may be somebody's source; the character is never replaced.
        bones: As for :func:`retarget`, for all motions.
        target_bones: As for :func:`retarget`.
        weights: As for :func:`retarget`.

    Warns:
        UserWarning: Where the character cannot show an expression, or the gaze, of a motion.

    Raises:
        MocapError: As :func:`retarget`, where the character cannot be read, and where ``target`` is the character or may be
            somebody's source.
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
