"""The paths of a scene's nodes from any reader, and the comparison of two readers."""

from dataclasses import dataclass

import numpy as np

# The limits in metres and seconds.
MOVES, ALLOWED, ALLOWED_SECONDS = 1e-4, 1e-4, 1e-3
# The error of single precision along a chain of nodes, as a fraction of the farthest coordinate.
SINGLE = 4e-6


class Refused(Exception):
    """The reader refuses the file."""


class Nothing(Exception):
    """The reader finds neither a skeleton nor a motion in the file."""


@dataclass
class Motion:
    seconds: float
    """The path of each node from the first to the last frame, or its rest position, in metres with +Y up."""
    paths: dict
    """The seconds of the path, if they are not evenly spaced from first to last."""
    times: np.ndarray | None = None
    """Whether positions are relative to mocap's first node that both scenes have."""
    from_base: bool = False


def unique(pairs):
    """The pairs of nodes with unique names; a node without a unique name has no counterpart."""
    names = [name for name, _ in pairs]
    return {name: value for name, value in pairs if name and names.count(name) == 1}


def displacement(path):
    return float(np.linalg.norm(path - path[0], axis=1).max(initial=0))


def faults(ours, theirs):
    """The differences between mocap's motion and another reader's, as sentences."""
    shared = ours.paths.keys() & theirs.paths.keys()
    moving = {name for name, path in theirs.paths.items() if displacement(path) > MOVES}
    if absent := moving - shared:
        yield f"{len(absent)} moving nodes are absent: {sorted(absent)[:3]}"
    if theirs.paths and not shared:
        yield f"none of {len(theirs.paths)} nodes is there"
    if not shared:
        return
    if moving and abs(ours.seconds - theirs.seconds) > ALLOWED_SECONDS:
        yield f"{ours.seconds:.4f} s, not {theirs.seconds:.4f} s"
    if theirs.from_base:
        base = next(name for name in ours.paths if name in shared)
        theirs = Motion(theirs.seconds, {name: path - theirs.paths[base] for name, path in theirs.paths.items()})
        ours = Motion(ours.seconds, {name: path - ours.paths[base] for name, path in ours.paths.items()})
    size = max(np.abs(theirs.paths[name]).max() for name in shared)
    allowed = ALLOWED + SINGLE * size
    errors = {name: np.abs(ours.paths[name][0] - theirs.paths[name][0]).max() for name in shared}
    worst = max(errors, key=errors.get)
    if errors[worst] > allowed:
        yield f"{worst} begins {1000 * errors[worst]:.2f} mm off"
    for name in sorted(shared):
        own, other = displacement(ours.paths[name]), displacement(theirs.paths[name])
        if abs(own - other) > allowed:
            yield f"{name} moves {own:.5f} m, not {other:.5f} m"
            return
