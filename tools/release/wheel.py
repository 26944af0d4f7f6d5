"""Tests the Python wheel in an environment without Rust, for the channels python, rerun and huggingface.

`MOCAP_WHEEL` names a built wheel; the default is to build one with `tools/release/wheels`.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WALK = ROOT / "fixtures/real/cmu_12_01_walk.bvh"
FOLDER = tempfile.TemporaryDirectory()
SCRATCH = Path(FOLDER.name)


def built():
    """The wheel."""
    if named := os.environ.get("MOCAP_WHEEL"):
        return Path(named).resolve()
    # The output of the build does not belong in the table.
    subprocess.run([ROOT / "tools/release/wheels"], check=True, stdout=sys.stderr)
    return max((ROOT / "target/wheels/release").glob("mocap_kit-*.whl"), key=lambda path: path.stat().st_mtime)


def bare(*folders):
    """Variables of a new user: no Rust, no cache, nothing installed."""
    home = SCRATCH / "home"
    home.mkdir(exist_ok=True)
    path = os.pathsep.join([*map(str, folders), "/usr/bin", "/bin"])
    # The source of packages is a setting of the machine.
    kept = {name: value for name, value in os.environ.items() if name.startswith(("PIP_", "UV_", "SSL_", "REQUESTS_"))}
    kept = {name: value for name, value in kept.items() if "CACHE" not in name}
    return {**kept, "HOME": str(home), "PATH": path, "PIP_NO_CACHE_DIR": "1", "UV_PYTHON": sys.executable}


def run(words, environment, **options):
    """Runs a command that must succeed, and returns its output."""
    done = subprocess.run(words, env=environment, cwd=SCRATCH, stdout=subprocess.PIPE, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}")
    return done.stdout


def environment(name, *packages):
    """Makes an environment with these packages. Returns its folder of programs, and the time."""
    start = time.monotonic()
    run([sys.executable, "-m", "venv", SCRATCH / name], bare())
    run([SCRATCH / name / "bin/python", "-m", "pip", "install", "--quiet", *packages], bare())
    return SCRATCH / name / "bin", time.monotonic() - start


def check_glb(path):
    """Whether a file is a complete GLB file, by its magic number, its version, and its length."""
    contents = path.read_bytes()
    header = [contents[:4], int.from_bytes(contents[4:8], "little"), int.from_bytes(contents[8:12], "little")]
    if header != [b"glTF", 2, len(contents)]:
        sys.exit(f"{path} is no GLB: {header}")


def row(channel, command, seconds, size, person):
    """The last line of a tested channel."""
    values = {"seconds": round(seconds, 1), "bytes": size, "status": "tried", "person": person}
    print(json.dumps({"channel": channel, "command": command, **values}))
