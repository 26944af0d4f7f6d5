"""The judge of `check`."""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOCAP = os.environ["MOCAP"]
# The files that the pages name.
FILES = {
    "Test.bvh": "real/lecture_Test.bvh",
    "run.fbx": "real/run.fbx",
    "walk.bvh": "real/cmu_short.bvh",
    "12_01.bvh": "real/cmu_12_01_walk.bvh",
    "take.bvh": "real/rokoko_dance.bvh",
    "kinect.bvh": "real/kinect_openni.bvh",
    "hero.vrm": "characters/human_vrm0.vrm",
    "hero.glb": "characters/human_game_engine.glb",
    "take.c3d": "markers/cmu_01_01.c3d",
    "walk.c3d": "made/plates.c3d",
    "g1.urdf": "robots/g1_29dof_rev_1_0.urdf",
    "takes/a.bvh": "real/cmu_short.bvh",
    "takes/b.bvh": "real/mocopi_jump_six_channels.bvh",
    "takes/c.bvh": "real/makehuman_zombie_walk.bvh",
}
# Those of the README: it makes `take.bvh`, and its graph is of jumps that pass into each other.
README_FILES = {name: file for name, file in FILES.items() if name != "take.bvh" and not name.startswith("takes/")} | {
    "takes/a.bvh": "real/cmu_01_01.bvh",
}
# What these hear or send has no end.
WAITS = ("mocap record ", "mocap play ", "mocap bridge ")


def printed(after):
    """The lines of the block ```text that follows a command, each of which it prints."""
    if after[1:2] != ["```text"]:
        return []
    return after[2 : after.index("```", 2)]


def main(pages):
    passed = failed = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs/how-to").glob("*.md"))]:
        if pages and not any(name in page.name for name in pages):
            continue
        with tempfile.TemporaryDirectory() as folder:
            files = README_FILES if page.name == "README.md" else FILES
            for name, fixture in files.items():
                path = Path(folder, name)
                path.parent.mkdir(exist_ok=True)
                shutil.copyfile(ROOT / "fixtures" / fixture, path)
            lines = page.read_text().splitlines()
            for number, line in enumerate(lines):
                if not line.startswith(("    mocap ", "mocap ")) or line.startswith(WAITS):
                    continue
                words = shlex.split(line, comments=True)[1:]
                if words[0] == "view" and "-o" not in words:
                    words += ["-o", "view.html"]
                output = words[words.index("-o") + 1] if "-o" in words else words[2] if words[0] == "convert" else "."
                # A command can be run again, and replaces its own output.
                for _ in range(2):
                    ran = subprocess.run([MOCAP, *words], cwd=folder, capture_output=True, text=True)
                    missing = [wanted for wanted in printed(lines[number + 1 :]) if wanted not in ran.stdout]
                    if ran.returncode == 0 and Path(folder, output).exists() and not missing:
                        passed += 1
                    else:
                        failed += 1
                        print(f"FAILED {page.name}: {line.strip()}: exit code {ran.returncode}\n{ran.stderr}")
                        print("".join(f"not printed: {wanted}\n" for wanted in missing), end="")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


sys.exit(main(sys.argv[1:]))
