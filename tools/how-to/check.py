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
# The pages of the guide whose commands run without `--all`. They need only the files above.
GUIDE_PAGES = [ROOT / "docs/looking.md", ROOT / "docs/asking.md"]
# The files of these pages. One command makes `take.bvh`; its graph joins jumps by transitions.
README_FILES = {name: file for name, file in FILES.items() if name != "take.bvh" and not name.startswith("takes/")} | {
    "takes/a.bvh": "real/cmu_01_01.bvh",
}
# The files of the guide that are not above, or that differ.
GUIDE_FILES = {
    "idle.bvh": "real/cmu_12_01_walk.bvh",
    "run.bvh": "real/cmu_12_01_walk.bvh",
    "turn.bvh": "real/cmu_12_01_walk.bvh",
    "clip.bvh": "real/rokoko_dance.bvh",
    "walks/a.bvh": "real/cmu_12_01_walk.bvh",
    "robot.bvh": "real/mocopi_jump_six_channels.bvh",
    "lafan_skeleton.bvh": "real/cmu_12_01_walk.bvh",
    "dance.vmd": "made/dancer.vmd",
    "dancer.pmx": "made/dancer.pmx",
    "miku.pmx": "made/dancer.pmx",
    "take.npz": "arrays/amass_smplh.npz",
    "SMPLH_NEUTRAL.npz": "arrays/body_smplh.npz",
    "h1.urdf": "robots/h1.urdf",
    "go1.urdf": "robots/max.urdf",
    "dog.bvh": "made/dog_walk.bvh",
}
# The files that differ on one page: clips of one skeleton, and longer clips.
PAGE_FILES = {
    "docs/arrays.md": {"take.npz": "arrays/amass_smpl.npz"},
    "docs/positions.md": {"take.npz": "arrays/sam3d_stack.npz"},
    "docs/editing.md": {"walk.bvh": "real/cmu_12_01_walk.bvh"},
    "docs/motion-graphs.md": {"turn.bvh": "real/cmu_short.bvh", "hero.bvh": "real/cmu_12_01_walk.bvh"},
}
# The commands that make further files of the guide. A page gets those that it names and does not make itself.
MADE = {
    "hero_walk.glb": "retarget walk.bvh hero.glb -o hero_walk.glb",
    "walk.vrma": "convert walk.bvh walk.vrma",
    "walk_ik.mot": "angles walk.bvh -o walk_ik.mot",
    "walk.trc": "convert take.c3d walk.trc",
    "standing.trc": "convert take.c3d standing.trc",
    "walk.npz": "robot walk.bvh --robot g1.urdf -o walk.npz",
    "g1.npz": "robot walk.bvh --robot g1.urdf -o g1.npz",
    "motions/": "robot takes/ --robot g1.urdf -o motions",
}
# The commands that replace `takes/` on one page: clips of one skeleton, with a pause between two jumps.
JUMPS = "edit fixtures/real/cmu_01_01.bvh --step trim:range={} -o takes/{}.bvh"
PAGE_TAKES = {"docs/motion-graphs.md": {"walk": "0f..1100f", "turn": "800f..1900f", "jump": "1600f..2700f"}}
# The files of the guide that the repository does not hold. Lines that name them are parsed, and do not run.
MISSING = {
    "theia.c3d": "a recording of a markerless system",
    "joints.npy": "positions in the order of COCO or MediaPipe",
    "keypoints.csv": "positions in the order of Human3.6M",
    "talos.urdf": "a slow robot",
    "policy.npz": "the motion of a policy",
}
# These commands receive or send without end.
WAITS = ("record", "play", "bridge", "mcp")


def printed(after):
    """The lines of the block ```text after a command; the command must print each of them."""
    start = next((number for number, line in enumerate(after) if line not in ("", "```")), len(after))
    if after[start : start + 1] != ["```text"]:
        return []
    return after[start + 1 : after.index("```", start)]


def commands(lines):
    """The commands of a page: lines of a block, and cells of a table."""
    block = ""
    for number, line in enumerate(lines):
        if line.startswith("```"):
            block = "" if block else line
        elif line.startswith("    mocap ") or block == "```sh" and line.startswith("mocap "):
            yield number, line
        elif block == "```sh" and line.startswith("cargo run -- "):
            yield number, line.replace("cargo run --", "mocap")
        elif line.startswith("| ") and line.endswith("` |"):
            cell = line.rsplit(" | `", 1)[-1].removesuffix("` |")
            if cell.startswith("mocap "):
                yield number, cell


def words_of(line, folder):
    """The words of a command after `mocap`, as a shell in this folder expands them."""
    shell = ["bash", "-c", f'mocap() {{ printf "%s\\0" "$@"; }}\n{line}']
    ran = subprocess.run(shell, cwd=folder, capture_output=True, text=True, check=True)
    return ran.stdout.split("\0")[:-1]


def misuse(words, folder=None, is_part=False):
    """What the program says about an unknown command, option or value. A part of a command may lack values, and may have
    placeholders, such as N or FILE."""
    ran = subprocess.run([MOCAP, *words, "--help"], cwd=folder, capture_output=True, text=True)
    if ran.returncode == 0 or is_part and "a value is required" in ran.stderr:
        return ""
    placeholder = is_part and any(re.fullmatch("[A-Z]+|.*[.]{3}", word) for word in words)
    return "" if placeholder and "invalid value" in ran.stderr else ran.stderr


def spans(lines):
    """The commands in the sentences and tables of a page, as words."""
    text = re.sub(r"^```.*?^```", "", "\n".join(lines), flags=re.DOTALL | re.MULTILINE)
    for span in re.findall(r"`mocap ([^`|]+)`", re.sub(r"^    .*", "", text, flags=re.MULTILINE)):
        if not span.startswith("COMMAND"):
            yield shlex.split(span)


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


def prepare(page, folder, lines):
    """Puts the files that a page names into the folder."""
    name = str(page.relative_to(ROOT))
    files = README_FILES if page in README_PAGES else FILES
    is_guide = page.parent == ROOT / "docs" and page not in README_PAGES
    files = files | GUIDE_FILES | PAGE_FILES.get(name, {}) if is_guide else files
    for file, fixture in files.items():
        path = Path(folder, file)
        if name in PAGE_TAKES and path.parent.name == "takes":
            continue
        path.parent.mkdir(exist_ok=True)
        shutil.copyfile(ROOT / "fixtures" / fixture, path)
    Path(folder, "bones.json").write_text('{"bones": {"leftHand": "LeftHand", "leftEye": null}}')
    Path(folder, "job.json").write_text('{"source": {"inputs": ["walk.bvh"]}, "write": {"output": "walk.glb"}}')
    Path(folder, "sticks.csv").write_text("seconds,left_x,left_y\n0,0,1\n2.5,1,0\n4,0,0\n")
    Path(folder, "resources").mkdir()
    Path(folder, "fixtures").symlink_to(ROOT / "fixtures")
    Path(folder, "takes").mkdir(exist_ok=True)
    Path(folder, "takes/mocap.toml").write_text('person = "Ada"\n')
    for clip, part in PAGE_TAKES.get(name, {}).items():
        subprocess.run([MOCAP, *JUMPS.format(part, clip).split()], cwd=folder, capture_output=True, check=True)
    text = "\n".join(line for _, line in commands(lines))
    for file, command in MADE.items() if is_guide else ():
        if re.search(rf"(?<![\w.-]){file}", text) and not Path(folder, file).exists():
            subprocess.run([MOCAP, *command.split()], cwd=folder, capture_output=True, check=True)


def output_of(words):
    """The file or folder that a command writes; the working folder if it writes none."""
    if "-o" not in words:
        return words[2] if words[0] == "convert" and "--print-job" not in words else "."
    output = Path(words[words.index("-o") + 1])
    if "--shard" in words and output.suffix:
        shard = words[words.index("--shard") + 1].replace("/", "-of-")
        return f"{output.stem}.{shard}{output.suffix}"
    return str(output)


def reason_to_parse(words, line):
    """Why a command does not run; None if it runs."""
    if words[0] in WAITS:
        return "waits for another program"
    missing = [file for file in MISSING if file in line]
    return f"no file {missing[0]}, {MISSING[missing[0]]}" if missing else None


def run(words, line, after, folder):
    """Runs a command. Returns what is wrong: the exit code, the output file, or the printed lines."""
    code = int(re.search(r"# exit code (\d)|$", line)[1] or 0)
    ran = subprocess.run([MOCAP, *words], cwd=folder, capture_output=True, text=True)
    missing = [f"not printed: {wanted}\n" for wanted in printed(after) if wanted not in ran.stdout]
    if ran.returncode == code and Path(folder, output_of(words)).exists() and not missing:
        return ""
    return f"exit code {ran.returncode}\n{ran.stderr}" + "".join(missing)


def check(page, folder, is_run):
    """Parses the commands of a page, and runs each twice if `is_run`. Returns for each command whether it ran, and what is
    wrong."""
    lines = page.read_text().splitlines()
    for words in spans(lines):
        yield f"`mocap {shlex.join(words)}`", False, misuse(words, is_part=True)
    # The program reads weights when it parses a command.
    Path(folder, "weights.json").write_text("{}")
    if is_run:
        prepare(page, folder, lines)
    given = {str(path.relative_to(folder)) for path in Path(folder).glob("*.*")}
    for number, line in commands(lines):
        words = words_of(line, folder)
        reason = reason_to_parse(words, line)
        if reason or not is_run:
            if is_run:
                print(f"not run, {reason}: {page.name}: {line.strip()}")
            yield line.strip(), False, misuse(words, folder)
            continue
        if words[0] == "view" and "-o" not in words:
            words += ["-o", "view.html"]
        # The reader's folder has no such file yet.
        if output_of(words) in given and words.count(output_of(words)) == 1:
            Path(folder, output_of(words)).unlink()
            given.remove(output_of(words))
        # A command can be run again, and replaces its own output.
        for _ in range(2):
            yield line.strip(), True, run(words, line, lines[number + 1 :], folder)


def main(options):
    passed = failed = parsed = 0
    pictures = "--pictures" in options
    names = [name for name in options if not name.startswith("--")]

    def is_wanted(page):
        return not names or any(name in str(page.relative_to(ROOT)) for name in names)

    guide = [page for page in sorted((ROOT / "docs").glob("*.md")) if page not in README_PAGES]
    how_to = sorted((ROOT / "docs/how-to").glob("*.md"))
    pages = [*README_PAGES, ROOT / "fixtures/README.md", *how_to, *guide]
    for page in filter(is_wanted, pages):
        is_run = names or "--all" in options or page in GUIDE_PAGES or page not in guide
        with tempfile.TemporaryDirectory() as folder:
            for command, ran, fault in check(page, folder, is_run):
                if fault:
                    print(f"FAILED {page.name}: {command}: {fault}")
                failed += bool(fault)
                passed += ran and not fault
                parsed += not ran
            if pictures:
                keep(folder)
                if page.name == "rokoko-into-blender.md" and "BLENDER_PYTHON" in os.environ:
                    picture = ROOT / "docs/how-to/rokoko-in-blender.jpg"
                    script = [ROOT / "tools/how-to/blender.py", Path(folder, "hero_take.fbx"), picture]
                    subprocess.run([os.environ["BLENDER_PYTHON"].split()[0], *script], check=True, capture_output=True)
    for page in filter(is_wanted, [*sorted((ROOT / "docs").glob("*.md")), ROOT / "examples/learned/README.md"] if pictures else []):
        drawn = draw(page)
        passed, failed = passed + drawn[0], failed + drawn[1]
    texts = [page.read_text() for page in pages]
    for file in MISSING:
        if not any(file in text for text in texts):
            failed += 1
            print(f"FAILED: no page names {file}")
    print(f"{parsed} commands parsed, but not run")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed + parsed else 0


sys.exit(main(sys.argv[1:]))
