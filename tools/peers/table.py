"""The Markdown of the tables, and their position in README.md."""

import platform
from collections import Counter
from datetime import date

from judge import Verdict
from peers import HERE, ROOT

README = HERE / "README.md"
BEGIN = "<!-- begin: written by tools/peers/run --write -->"
END = "<!-- end -->"

SIGNS = {
    Verdict.RIGHT: "right",
    Verdict.POLICY: "right by another policy",
    Verdict.LOST: "lost something",
    Verdict.REFUSED: "refused",
    Verdict.TOLD: "wrong, and said so",
    Verdict.WRONG: "wrong in silence",
    Verdict.CRASH: "crash or no end",
}

# The rows of the compact table. Every fixture is in one of them.
GROUPS = {
    "No dialect": ["plain", "one_frame"],
    "Keywords and channels in any case": [
        "keywords_lower_case",
        "keywords_mixed_case",
        "channels_upper_case",
        "second_course_sample",
    ],
    "Line ends, blanks, comments, braces": [
        "line_ends_cr",
        "line_ends_crlf",
        "line_ends_mixed",
        "tabs",
        "blank_lines",
        "blanks_around_lines",
        "comments_before_hierarchy",
        "brace_on_the_same_line",
        "hierarchy_on_one_line",
        "no_final_newline",
    ],
    "Byte order mark, UTF-16": ["byte_order_mark", "utf_16_little_endian", "utf_16_big_endian"],
    "Spellings of `Frames:` and of numbers": [
        "frames_blank_before_colon",
        "frames_no_blank_after_colon",
        "exponents",
        "bare_decimal_points",
        "decimal_comma",
        "decimal_comma_no_motion",
        "numbers_without_a_blank",
    ],
    "End Sites": [
        "end_site_lower_case",
        "end_site_with_digit",
        "end_site_named",
        "end_site_named_in_comment",
        "several_end_sites",
        "end_site_beside_joint",
        "leaf_without_end_site",
    ],
    "Names": [
        "name_with_hash",
        "name_with_blanks",
        "name_with_colon_and_dot",
        "name_latin_1",
        "name_utf_8",
        "name_like_a_keyword",
        "names_differ_in_case",
        "names_equal",
    ],
    "Channels: none to six, any order": [
        "joint_without_channels",
        "channels_0_to_6",
        "rotation_before_position",
        "all_six_rotation_orders",
        "repeated_channel",
        "scale_channels",
        "channels_before_offset",
    ],
    "Positions and OFFSETs": [
        "position_channels_on_joint",
        "partial_position_channels",
        "position_only_joint",
        "root_offset_replaced",
        "root_offset_added",
    ],
    "Lines twice, braces, roots": [
        "repeated_offset",
        "repeated_channels",
        "repeated_channels_meant_once",
        "missing_braces_at_motion",
        "extra_brace",
        "joint_after_root_closed",
        "two_roots",
    ],
    "Rows: wrapped, too many, too few": [
        "wrapped_rows",
        "all_frames_on_one_line",
        "one_row_more",
        "many_rows_more",
        "fewer_rows",
        "trailing_text",
    ],
    "No motion": ["frames_0", "no_rows", "no_motion"],
    "Damaged motion": ["nan_in_motion", "infinity_in_motion", "a_short_row", "a_long_row", "last_row_cut_off"],
}


def titles():
    """The files of fixtures/dialects and their subjects, from the list in fixtures/README.md."""
    text = (ROOT / "fixtures" / "README.md").read_text(encoding="utf-8")
    section = text.split("\n## `dialects/`")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ", 1) for line in section.splitlines() if line.startswith("| `")]
    return {name.strip("`").removesuffix(".bvh"): title for name, title in rows}


def deviates(fixture):
    """Whether the file violates the format beyond its spelling: the expected result has a warning."""
    expected = (ROOT / "fixtures" / "dialects" / f"{fixture}.expected").read_text(encoding="utf-8")
    return any(line.startswith("warning") for line in expected.splitlines())


def row(*cells):
    return "| " + " | ".join(cells) + " |"


def header(first, peers):
    return [row(first, *[peer.name for peer in peers]), "|---|" + ":-:|" * len(peers)]


def tables(fixtures, peers, cells):
    versions = ", ".join(f"{peer.name} {peer.version}" for peer in peers)
    blender = " --blender" if any(peer.name == "Blender" for peer in peers) else ""
    made = (
        f"Made by `tools/peers/run{blender} --write` on {date.today()} with {versions}; "
        f"Python {platform.python_version()}."
    )
    parts = [made, "## File by file", whole(fixtures, peers, cells), "## Totals", totals(fixtures, peers, cells)]
    if set(fixtures) == set(titles()):
        parts += ["## Compact", compact(fixtures, peers, cells)]
    return "\n\n".join(parts)


def whole(fixtures, peers, cells):
    lines = header("file", peers)
    for fixture in fixtures:
        star = " \\*" if deviates(fixture) else ""
        signs = [cells[fixture, peer.name][0].value for peer in peers]
        lines.append(row(f"`{fixture}`{star}: {titles()[fixture]}", *signs))
    return "\n".join(lines)


def totals(fixtures, peers, cells):
    lines = header(f"of {len(fixtures)} files", peers)
    for verdict, name in SIGNS.items():
        counts = [Counter(cells[fixture, peer.name][0] for fixture in fixtures)[verdict] for peer in peers]
        lines.append(row(f"{verdict.value} {name}", *map(str, counts)))
    spelling = [fixture for fixture in fixtures if not deviates(fixture)]
    starred = [fixture for fixture in fixtures if deviates(fixture)]
    for name, some in [("right, without the files with a star", spelling), ("right, of those with a star", starred)]:
        counts = [sum(cells[fixture, peer.name][0] is Verdict.RIGHT for fixture in some) for peer in peers]
        lines.append(row(f"{name} ({len(some)})", *map(str, counts)))
    return "\n".join(lines)


def compact(fixtures, peers, cells):
    grouped = [fixture for group in GROUPS.values() for fixture in group]
    if sorted(grouped) != sorted(fixtures):
        raise SystemExit(f"not in one group: {sorted(set(grouped) ^ set(fixtures))}")

    def count(some, peer, *verdicts):
        return sum(cells[fixture, peer.name][0] in verdicts for fixture in some)

    lines = header("files read right", peers)
    for title, group in GROUPS.items():
        counts = [count(group, peer, Verdict.RIGHT) for peer in peers]
        lines.append(row(f"{title} ({len(group)})", *map(str, counts)))
    bold = [f"**{count(fixtures, peer, Verdict.RIGHT)}**" for peer in peers]
    lines.append(row(f"**all ({len(fixtures)})**", *bold))
    for title, verdicts in [
        ("right by another policy, or something lost", (Verdict.POLICY, Verdict.LOST)),
        ("refused", (Verdict.REFUSED,)),
        ("wrong positions", (Verdict.WRONG, Verdict.TOLD)),
        ("crash or no end", (Verdict.CRASH,)),
    ]:
        lines.append(row(title, *[str(count(fixtures, peer, *verdicts)) for peer in peers]))
    return "\n".join(lines)


def reasons(fixtures, peers, cells):
    lines = []
    for fixture in fixtures:
        lines.append(f"{fixture}: {titles()[fixture]}")
        for peer in peers:
            verdict, why = cells[fixture, peer.name]
            lines.append(f"  {verdict.value} {peer.name:9} {'; '.join(why)}".rstrip())
    return "\n".join(lines)


def write(fixtures, peers, cells):
    before, rest = README.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    README.write_text(f"{before}{BEGIN}\n\n{tables(fixtures, peers, cells)}\n\n{END}{after}", encoding="utf-8")
