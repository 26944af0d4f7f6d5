"""Collects the licences of all crates in shipped artifacts: program, wheel, npm package, C library, for every target.

`tools/release/check` compares THIRD-PARTY.md with the result; `tools/release/check --write` writes it.
"""

import json
import re
import subprocess
from collections import defaultdict
from pathlib import Path

SHIPPED = ("mocap-cli", "mocap-python", "mocap-wasm", "mocap-wasm-bvh", "mocap-capi")
TARGETS = (
    "x86_64-unknown-linux-musl",
    "aarch64-unknown-linux-musl",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
    "x86_64-pc-windows-msvc",
    "wasm32-unknown-unknown",
)
# Packages without a licence file.
NOTES = {
    "flatbuffers": "Apache-2.0: the file LICENSE-APACHE.",
    "meshopt": "MIT: the terms of the file LICENSE-MIT, with: Copyright (c) 2016-2026 Arseny Kapoulkine",
    "ufbx": "The Unlicense: dedicated to the public domain.",
}
FILE = Path(__file__).resolve().parent / "THIRD-PARTY.md"
HEAD = """# Licences of third parties

Programs, wheels, npm packages and C libraries of mocap contain parts of these packages. `tools/release/check --write` writes
this file. The texts of the licences stand below the table; of a package with a choice that has MIT, the text of MIT.
"""
# The name of a file with a licence or a notice.
LICENCE = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)

OTHER = re.compile("apache|unlicense|zlib|lgpl|copying", re.IGNORECASE)


def shipped(root):
    """The packages of crates.io in the shipped artifacts."""
    words = ["cargo", "metadata", "--locked", "--offline", "--format-version=1", "--all-features"]
    words += [f"--filter-platform={target}" for target in TARGETS]
    found = json.loads(subprocess.run(words, cwd=root, check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    waiting = [id for id, package in packages.items() if package["name"] in SHIPPED]
    seen = set()
    while waiting:
        id = waiting.pop()
        # A procedural macro only runs during compilation, and is in no shipped artifact.
        is_macro = any("proc-macro" in target["kind"] for target in packages[id]["targets"])
        if id in seen or is_macro:
            continue
        seen.add(id)
        for dependency in nodes[id]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    return sorted((packages[id] for id in seen if packages[id]["source"]), key=lambda one: (one["name"], one["version"]))


def texts(package):
    """The texts of a package's licences; for a choice of licences, one text."""
    folder = Path(package["manifest_path"]).parent
    is_text = lambda path: path.is_file() and LICENCE.search(path.name) and path.suffix in ("", ".md", ".txt", ".MIT")
    # A package of C code has the licence file beside the code.
    paths = [*filter(is_text, folder.iterdir())] or [*filter(is_text, folder.rglob("*"))]
    for path in sorted(paths):
        if re.search(r"MIT$|^MIT|MIT ?(OR|/)", package["license"]) is None or " AND " in package["license"] or not OTHER.search(path.name):
            # Line and page breaks differ between copies of a text.
            lines = path.read_text(errors="replace").replace("\f", "").splitlines()
            yield "\n".join(line.rstrip() for line in lines).strip()


def document(root):
    packages = shipped(root)
    users = defaultdict(list)
    rows = []
    first = {}
    for package in packages:
        name = f"{package['name']} {package['version']}"
        rows.append(f"| {name} | {package['license']} |")
        for text in [*texts(package)] or [NOTES[package["name"]]]:
            # Copies differ in their line breaks.
            users[first.setdefault(" ".join(text.split()), text)].append(name)
    parts = [f"## {', '.join(names)}\n\n```text\n{text}\n```\n" for text, names in sorted(users.items(), key=lambda one: one[1])]
    return "\n".join([HEAD, "| package | licence |\n|---|---|", *rows, "", *parts]), packages
