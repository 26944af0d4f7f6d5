"""A preprocessor of mdBook that turns links to files outside docs into links to the repository."""

import json
import posixpath
import re
import sys

LINK = re.compile(r"(\]\()((?:\.\./)[^)#\s]*)")


def outside(chapter, repository):
    def target(match):
        path = posixpath.normpath(posixpath.join("docs", posixpath.dirname(chapter["path"]), match[2]))
        return match[0] if path.startswith("docs/") else f"{match[1]}{repository}/blob/main/{path}"

    if chapter.get("path"):
        chapter["content"] = LINK.sub(target, chapter["content"])
    for item in chapter["sub_items"]:
        outside(item["Chapter"], repository)


if sys.argv[1:2] != ["supports"]:
    context, book = json.load(sys.stdin)
    for item in book.get("items", book.get("sections")):
        if isinstance(item, dict) and "Chapter" in item:
            outside(item["Chapter"], context["config"]["output"]["html"]["git-repository-url"])
    json.dump(book, sys.stdout)
