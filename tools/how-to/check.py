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
    "run.fbx": "real/run.fbx",
    "walk.bvh": "real/cmu_short.bvh",
    "12_01.bvh": "real/cmu_12_01_walk.bvh",
    "take.bvh": "real/rokoko_dance.bvh",
    "kinect.bvh": "real/kinect_openni.bvh",
    "hero.vrm": "characters/human_vrm0.vrm",
    "hero.glb": "characters/human_game_engine.glb",
    "takes/a.bvh": "real/cmu_short.bvh",
    "takes/b.bvh": "real/mocopi_jump_six_channels.bvh",
    "takes/c.bvh": "real/makehuman_zombie_walk.bvh",
}


def main(pages):
    passed = failed = 0
    for page in sorted((ROOT / "docs/how-to").glob("*.md")):
        if pages and not any(name in page.name for name in pages):
            continue
        with tempfile.TemporaryDirectory() as folder:
            for name, fixture in FILES.items():
                path = Path(folder, name)
                path.parent.mkdir(exist_ok=True)
                shutil.copyfile(ROOT / "fixtures" / fixture, path)
            for line in page.read_text().splitlines():
                if not line.startswith("    mocap "):
                    continue
                words = shlex.split(line)[1:]
                ran = subprocess.run([MOCAP, *words], cwd=folder, capture_output=True, text=True)
                output = words[words.index("-o") + 1] if "-o" in words else words[2] if words[0] == "convert" else "."
                if ran.returncode == 0 and Path(folder, output).exists():
                    passed += 1
                else:
                    failed += 1
                    print(f"FAILED {page.name}: {line.strip()}: exit code {ran.returncode}\n{ran.stderr}")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


sys.exit(main(sys.argv[1:]))
