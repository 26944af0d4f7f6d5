"""Judges the commands for `check`."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import textwrap
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
    "gvhmr.pt": "arrays/gvhmr.pt",
    "sam3d_take.npz": "arrays/sam3d_take.npz",
    "frames/frame_1_subj0.npz": "arrays/sam3d_body.npz",
    "frames/frame_2_subj0.npz": "arrays/sam3d_body.npz",
    "points_smpl22.npy": "arrays/points_smpl22.npy",
    "amass.npz": "arrays/amass_smplh.npz",
    "body_smplh.npz": "arrays/body_smplh.npz",
    "g1.urdf": "robots/g1_29dof_rev_1_0.urdf",
    "takes/a.bvh": "real/cmu_short.bvh",
    "takes/b.bvh": "real/mocopi_jump_six_channels.bvh",
    "takes/c.bvh": "real/makehuman_zombie_walk.bvh",
}
# The pages whose commands use each other's results.
README_PAGES = [ROOT / "README.md", ROOT / "docs/commands.md"]
# The pages whose commands need only the files above.
GUIDE_PAGES = [ROOT / "docs/looking.md", ROOT / "docs/asking.md"]
# The files of these pages. One command makes `take.bvh`; its graph joins jumps by transitions.
README_FILES = {name: file for name, file in FILES.items() if name != "take.bvh" and not name.startswith("takes/")} | {
    "takes/a.bvh": "real/cmu_01_01.bvh",
}
# These commands receive or send without end.
WAITS = ("mocap record ", "mocap play ", "mocap bridge ")


def printed(after):
    """The lines of the block ```text after a command; the command must print each of them."""
    if after[1:2] != ["```text"]:
        return []
    return after[2 : after.index("```", 2)]


def commands(lines):
    """The commands of a page: lines of a block, and cells of a table."""
    block = ""
    for number, line in enumerate(lines):
        if line.startswith("```"):
            block = "" if block else line
        elif line.startswith("    mocap ") or block == "```sh" and line.startswith("mocap ") and not line.startswith(WAITS):
            yield number, line
        elif line.startswith("| ") and line.endswith("` |"):
            cell = line.rsplit(" | `", 1)[-1].removesuffix("` |")
            if cell.startswith("mocap "):
                yield number, cell


def picture_blocks(page):
    """Each block of a page that makes pictures beside the page: its text, and the names of the pictures."""
    for block in re.findall(r"(?:^    .*\n)+", page.read_text(), re.MULTILINE):
        names = [name for name in re.findall(r" ([\w-]+\.png)\b", block) if (page.parent / name).is_file()]
        if names:
            yield textwrap.dedent(block), names


def draw(page):
    """Runs the blocks of a guide page or an example that make its pictures, and replaces the pictures. Returns the numbers of
    blocks that passed and failed."""
    passed = failed = 0
    for block, names in picture_blocks(page):
        if block.startswith("python ") and "PYTHON" not in os.environ:
            print(f"skipped {page.relative_to(ROOT)}: PYTHON names no Python with the packages of the example")
            continue
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "job.json").write_text('{"source": {"inputs": ["walk.bvh"]}, "write": {"output": "walk.glb"}}')
            Path(folder, "fixtures").symlink_to(ROOT / "fixtures")
            place = Path(folder) if page.parent == ROOT / "docs" else Path(folder, page.parent.relative_to(ROOT))
            place.mkdir(parents=True, exist_ok=True)
            for file in page.parent.iterdir() if page.parent != ROOT / "docs" else []:
                if file.suffix in (".py", ".safetensors"):
                    (place / file.name).symlink_to(file)
            for name, fixture in FILES.items():
                if "/" not in name:
                    shutil.copyfile(ROOT / "fixtures" / fixture, place / name)
            commands = f'mocap() {{ "$MOCAP" "$@"; }}\npython() {{ "$PYTHON" "$@"; }}\n{block}'
            ran = subprocess.run(["bash", "-euc", commands], cwd=place, capture_output=True, text=True)
            if ran.returncode != 0:
                failed += 1
                print(f"FAILED {page.relative_to(ROOT)}: exit code {ran.returncode}\n{block}{ran.stderr}")
                continue
            passed += 1
            for name in names:
                shutil.copyfile(place / name, page.parent / name)
    return passed, failed


def keep(folder):
    """Replaces the pictures of the pages by those that their commands have made."""
    for name in ("fixtures/pictures", "docs/how-to"):
        for picture in (ROOT / name).iterdir():
            if Path(folder, picture.name).is_file() and picture.suffix in (".png", ".gif"):
                shutil.copyfile(Path(folder, picture.name), picture)


def main(pages):
    passed = failed = 0
    pictures = "--pictures" in pages
    pages = [name for name in pages if name != "--pictures"]
    guide = [*GUIDE_PAGES, *sorted((ROOT / "docs/how-to").glob("*.md"))]
    for page in [*README_PAGES, ROOT / "fixtures/README.md", *guide]:
        if pages and not any(name in str(page.relative_to(ROOT)) for name in pages):
            continue
        with tempfile.TemporaryDirectory() as folder:
            files = README_FILES if page in README_PAGES else FILES
            for name, fixture in files.items():
                path = Path(folder, name)
                path.parent.mkdir(exist_ok=True)
                shutil.copyfile(ROOT / "fixtures" / fixture, path)
            Path(folder, "bones.json").write_text('{"bones": {"leftHand": "LeftHand", "leftEye": null}}')
            Path(folder, "job.json").write_text('{"source": {"inputs": ["walk.bvh"]}, "write": {"output": "walk.glb"}}')
            Path(folder, "fixtures").symlink_to(ROOT / "fixtures")
            lines = page.read_text().splitlines()
            for number, line in commands(lines):
                words = shlex.split(line, comments=True)[1:]
                if words[0] == "view" and "-o" not in words:
                    words += ["-o", "view.html"]
                writes = words[0] == "convert" and "--print-job" not in words
                output = words[words.index("-o") + 1] if "-o" in words else words[2] if writes else "."
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
            if pictures:
                keep(folder)
                if page.name == "rokoko-into-blender.md" and "BLENDER_PYTHON" in os.environ:
                    picture = ROOT / "docs/how-to/rokoko-in-blender.jpg"
                    script = [ROOT / "tools/how-to/blender.py", Path(folder, "hero_take.fbx"), picture]
                    subprocess.run([os.environ["BLENDER_PYTHON"].split()[0], *script], check=True, capture_output=True)
    for page in [*sorted((ROOT / "docs").glob("*.md")), ROOT / "examples/learned/README.md"] if pictures else []:
        if not pages or any(name in str(page.relative_to(ROOT)) for name in pages):
            drawn = draw(page)
            passed, failed = passed + drawn[0], failed + drawn[1]
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


sys.exit(main(sys.argv[1:]))
