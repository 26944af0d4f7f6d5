"""Judges links, the summary, and the length of pages, for `check`."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
LIMIT = 1500  # words on a page, counted as the test of sentences does: words with a letter or a digit
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def words(text):
    return sum(any(sign.isalnum() for sign in word) for word in text.split())


def prose(text):
    """The text without blocks and spans of code."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE))


def anchors(path):
    """The anchors of the headings, as GitHub and mdBook name them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in plain}


def links(page):
    for target in LINK.findall(prose(page.read_text())):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        if not path.exists():
            yield f"{page.relative_to(ROOT)}: no file {target}"
        elif anchor and path.suffix == ".md" and anchor not in anchors(path):
            yield f"{page.relative_to(ROOT)}: no heading {target}"


def main():
    pages = sorted(DOCS.rglob("*.md"))
    documents = [*sorted(ROOT.glob("*.md")), *pages, ROOT / "fixtures/README.md"]
    documents += [path for folder in ("tools", "examples", "src") for path in sorted((ROOT / folder).glob("*/README.md"))]
    faults = [fault for page in documents for fault in links(page)]
    listed = {(DOCS / target).resolve() for target in LINK.findall((DOCS / "SUMMARY.md").read_text())}
    faults += [f"docs/SUMMARY.md lacks {page.relative_to(DOCS)}" for page in pages if page not in listed | {DOCS / "SUMMARY.md"}]
    long = [page for page in pages if words(page.read_text()) > LIMIT]
    faults += [f"{page.relative_to(ROOT)}: more than {LIMIT} words" for page in long]
    print("".join(f"{fault}\n" for fault in faults), end="")
    print(f"{len(documents)} passed, {len(faults)} failed")
    return 1 if faults else 0


sys.exit(main())
