"""Compares a peer's result for a file with the expected result, which a person worked out."""

import math
from copy import deepcopy
from dataclasses import dataclass
from enum import Enum
from itertools import permutations

# The largest difference of a coordinate. The fixtures measure a few units; a rotation in single precision keeps six
# digits.
TOLERANCE = 1e-4
# Fixtures that do not test time have ten frames a second.
USUAL_RATE = 10.0
# The End Sites of the fixtures with their own names; the other End Sites have the name of their joint.
NAMED_END_SITES = {"knee_end", "toe"}
# The parent of several roots in scenes with a single root; a peer may omit it.
PARENT_OF_ROOTS = "Roots"

# The files with more rows than `Frames:` says: a peer may go by the rows. They are compared at the last declared frame.
ROWS_ABOVE_THE_COUNT = {"one_row_more", "many_rows_more"}
# In these files, and if a row has an extra value, more frames are another accepted policy.
MAY_KEEP_ROWS = ROWS_ABOVE_THE_COUNT | {"a_long_row"}
# The alternative positions, depth-first, in files for which the format does not define whether a position channel
# replaces an OFFSET.
REPLACES = "the position replaces the OFFSET"
ADDS = "the position is added to the OFFSET"
OTHER_POLICIES = {
    "root_offset_added": (REPLACES, [[1, 2, 3], [1, 2, 5], [1, 2, 6]]),
    "root_offset_replaced": (ADDS, [[6, 8, 10], [6, 8, 12], [6, 8, 13]]),
    "position_channels_on_joint": (ADDS, [[1, 2, 3], [1, 2, 8], [1, 2, 9]]),
    "channels_0_to_6": (
        ADDS,
        [[1, 0, 0], [2, 0, 0], [2, 1, 2], [7, 6, 5], [15, 13, 12], [13, 15, 12], [16, 10, 17], [16, 10, 16]],
    ),
    "position_only_joint": (ADDS, [[1, 2, 3], [6, 5, 9], [7, 5, 9]]),
}


class Verdict(Enum):
    """A cell of the table; the value is its sign."""

    RIGHT = "✔"
    POLICY = "≠"
    LOST = "◐"
    REFUSED = "✖"
    TOLD = "△"
    WRONG = "▲"
    CRASH = "☠"


@dataclass
class Node:
    name: str
    position: list[float]
    end: bool | None
    optional: bool
    children: list["Node"]


@dataclass
class Expected:
    frames: int
    rate: float
    root: str
    roots: list[Node]


def read_expected(path):
    """Reads an expected result; `fixtures/README.md` describes the format."""
    head, _, tree = path.read_text(encoding="utf-8").partition("\n\n")
    facts = {}
    for line in head.splitlines():
        word, _, value = line.partition(" ")
        facts.setdefault(word, value.strip())

    roots = []
    open_nodes = []
    for line in tree.splitlines():
        name, x, y, z = line.rsplit(maxsplit=3)
        depth = (len(name) - len(name.lstrip())) // 2
        name = name.strip()
        end = name.startswith("EndSite_") or name in NAMED_END_SITES
        node = Node(name, [float(x), float(y), float(z)], end, False, [])
        del open_nodes[depth:]
        (open_nodes[-1].children if open_nodes else roots).append(node)
        open_nodes.append(node)
    rate = float(facts.get("rate", USUAL_RATE))
    return Expected(int(facts["frames"]), rate, facts.get("root", "replace"), without_parent_of_roots(roots))


def without_parent_of_roots(roots):
    if len(roots) == 1 and roots[0].name == PARENT_OF_ROOTS:
        return roots[0].children
    return roots


def tree_of(answer):
    """The roots of an answer. JSON of other languages writes NaN as null."""
    nodes = []
    roots = []
    for item in answer["nodes"]:
        place = [math.nan if value is None else value for value in item["position"]]
        node = Node(item["name"], place, item["end"], item["optional"], [])
        nodes.append(node)
        (roots if item["parent"] is None else nodes[item["parent"]].children).append(node)
    return without_parent_of_roots(roots)


def near(a, b):
    # A comparison with NaN is false, so NaN is near no number.
    return all(abs(x - y) <= TOLERANCE for x, y in zip(a, b))


def same_name(expected, found):
    """A peer may distinguish equal names by a number after a dot."""
    base, dot, digits = found.rpartition(".")
    return found == expected or (dot and digits.isdigit() and base == expected)


def compare_nodes(expected, found, wrong, lost):
    """Adds wrong positions to `wrong`, and right but incomplete results to `lost`."""
    joints = [node for node in found if node.end is not True]
    for node in [node for node in expected if not node.end]:
        if not joints:
            wrong.append(f"no {node.name}")
            continue
        named = [joint for joint in joints if same_name(node.name, joint.name)]
        match = (named or joints)[0]
        joints.remove(match)
        if not near(node.position, match.position):
            wrong.append(f"{node.name} at {place(match.position)}, not {place(node.position)}")
        if not same_name(node.name, match.name):
            lost.append(f"`{node.name}` is called `{match.name}`")
        compare_nodes(node.children, match.children, wrong, lost)

    ends = [node for node in expected if node.end]
    tips = [node for node in found if node.end is True] + [node for node in joints if node.end is None]
    extra = [node for node in joints if node.end is False]
    wrong.extend(f"{node.name} does not belong here" for node in extra)
    for end, tip in best_pairs(ends, tips):
        if tip is None:
            lost.append(f"no {end.name}")
        elif not near(end.position, tip.position):
            wrong.append(f"{end.name} at {place(tip.position)}, not {place(end.position)}")
    surplus = len(tips) - len(ends)
    if surplus > 0 and not any(tip.optional for tip in tips):
        wrong.append("an End Site that the file does not have")


def best_pairs(ends, tips):
    """Pairs End Sites and tips so that most pairs are near each other, because their order has no meaning."""
    tips = tips + [None] * max(0, len(ends) - len(tips))
    arrangements = (list(zip(ends, order)) for order in permutations(tips, len(ends)))

    def count_near(pairs):
        return sum(tip is not None and near(end.position, tip.position) for end, tip in pairs)

    return max(arrangements, key=count_near)


def place(position):
    return " ".join(f"{value:.4g}" for value in position)


def depth_first(roots):
    for node in roots:
        yield node
        yield from depth_first(node.children)


def compare(fixture, expected, answer):
    """The verdict on an answer, and the reasons."""
    verdict, reasons = compare_with(expected, answer, fixture in MAY_KEEP_ROWS)
    if fixture in OTHER_POLICIES and verdict in (Verdict.WRONG, Verdict.TOLD):
        policy, positions = OTHER_POLICIES[fixture]
        other = deepcopy(expected)
        for node, position in zip(depth_first(other.roots), positions, strict=True):
            node.position = position
        if compare_with(other, answer, False)[0] in (Verdict.RIGHT, Verdict.LOST):
            return Verdict.POLICY, [policy]
    return verdict, reasons


def compare_with(expected, answer, keeps_rows):
    wrong = []
    lost = []
    found = tree_of(answer)
    compare_nodes(expected.roots, found, wrong, lost)
    if len(found) > len(expected.roots):
        wrong.append(f"{len(found)} roots")

    frames = answer["frames"]
    if frames != expected.frames and not (keeps_rows and frames > expected.frames):
        wrong.append(f"{frames} frames, not {expected.frames}")
    rate = answer["rate"]
    if expected.frames > 1 and rate is not None and not abs(rate - expected.rate) <= 1e-3 * expected.rate:
        lost.append(f"{rate:.4g} frames a second, not {expected.rate:g}")

    if wrong:
        return (Verdict.TOLD, wrong + list(dict.fromkeys(answer["said"]))) if answer["said"] else (Verdict.WRONG, wrong)
    if frames != expected.frames:
        return Verdict.POLICY, [f"keeps all {frames} rows"]
    return (Verdict.LOST, lost) if lost else (Verdict.RIGHT, [])
