"""Shows the report of a job, as text and as colours of bones."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import bpy
import mocap

# docs/retargeting.md: a verdict is good up to a mean of 1 degree, and fair up to 3 degrees.
_GOOD, _FAIR = 1.0, 3.0
_COLORS = {"good": (0.25, 0.75, 0.3), "fair": (0.95, 0.75, 0.15), "poor": (0.9, 0.2, 0.2)}
# The property of an action that holds its report.
_KEY = "mocap_report"


def of_error(failure: Exception, names: Mapping[str, str] = {}) -> str:
    """An error as one text. ``names`` has the shown names of the job's files."""
    text = str(failure)
    advice = failure.help if isinstance(failure, mocap.MocapError) else None
    if advice and advice not in text:
        text += f"; help: {advice}"
    for path, name in names.items():
        text = text.replace(path, name)
    return text


def lines(report: Mapping[str, Any]) -> list[str]:
    """The assumptions, the warnings of the reader, and the reports of steps and motions."""
    found = [*report.get("notes", []), *map(_warning, report.get("warnings", []))]
    for step in report.get("steps", []):
        found.append(f"{step['step'].partition(':')[0]}: {_sentence(step['changed'])}")
    for clip in report.get("clips", []):
        found.append(f"{clip['clip']}: {clip['verdict']}, mean limb error {clip['mean_degrees']:.2f} degrees")
        found += [f"{limb['bone']}: {limb['mean_degrees']:.2f} degrees ({_grade(limb)})" for limb in clip["limbs"]]
    return found


def keep(action: bpy.types.Action, told: list[str]) -> None:
    """Stores a report in an action, so that the panel shows it and undo removes it."""
    action[_KEY] = json.dumps(told)


def kept(armature: bpy.types.Object) -> list[str]:
    """The report of the action of an armature."""
    action = armature.animation_data.action if armature.animation_data else None
    return json.loads(action.get(_KEY, "[]")) if action else []


def color(armature: bpy.types.Object, limbs: list[Mapping[str, Any]], bones: Mapping[str, str]) -> None:
    """Colours the bones of limbs by their mean error: green, yellow, red.

    ``bones`` has the bone of the armature for each bone of a humanoid.
    """
    for limb in limbs:
        posed = armature.pose.bones.get(bones.get(limb["bone"], ""))
        if posed is None:
            continue
        shade = _COLORS[_grade(limb)]
        posed.color.palette = "CUSTOM"
        posed.color.custom.normal = shade
        posed.color.custom.select = [0.5 + part / 2 for part in shade]
        posed.color.custom.active = [0.7 + 0.3 * part for part in shade]


def _warning(warning: Mapping[str, Any]) -> str:
    joint = f"; joint {warning['joint']!r}" if warning.get("joint") else ""
    times = f" ({warning['count']} times)" if warning.get("count", 1) > 1 else ""
    return f"warning: {warning['message']}{times}{joint}"


def _grade(limb: Mapping[str, Any]) -> str:
    degrees = limb["mean_degrees"]
    return "good" if degrees <= _GOOD else "fair" if degrees <= _FAIR else "poor"


def _sentence(changed: Any) -> str:
    """The numbers of a step's report, and the parts that changed something."""
    if not isinstance(changed, Mapping):
        return str(changed)
    parts = [f"{one['part']}: {one['about']}" for one in changed.get("parts", []) if one.get("about")]
    plain = {key: value for key, value in changed.items() if isinstance(value, (bool, int, float, str))}
    numbers = [
        f"{key.replace('_', ' ')} {value:.4g}" if isinstance(value, float) else f"{key.replace('_', ' ')} {value}"
        for key, value in plain.items()
    ]
    return ", ".join([*parts, *numbers]) or "nothing changed"
