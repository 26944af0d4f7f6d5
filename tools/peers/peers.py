"""The compared readers: the installation of each by its name, and its command for one file."""

import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
READERS = HERE / "readers"
ROOT = HERE.parent.parent

THREE = "0.187.0"
PYTHON_PACKAGES = {"pybvh": "0.9.0", "bvhio": "1.5.4", "bvhtools": "1.6.0", "upc-pymotion": "0.3.4"}
BLENDER = "5.0.1"


@dataclass
class Peer:
    """`command` precedes the arguments FILE FRAME ROOT OUT of the reader."""

    name: str
    version: str
    command: list[str]
    environment: dict[str, str] = field(default_factory=dict)
    # V8 and Blender reserve far more address space than they use, so an address-space limit does not limit their
    # memory.
    limits_address_space: bool = True


def call(*command, **options):
    subprocess.run([str(part) for part in command], check=True, stdout=sys.stderr, **options)


def install(cache, mocap, blender):
    """Installs the peers that are not yet in the folder `cache`, and returns all peers, `mocap` first."""
    cache.mkdir(parents=True, exist_ok=True)
    peers = [own(mocap), assimp(cache), three(cache)]
    if blender:
        python = virtual_environment(cache / "blender", {"bpy": BLENDER})
        peers.append(
            Peer("Blender", BLENDER, [python, reader("blender_reader.py")], limits_address_space=False)
        )
    python = virtual_environment(cache / "python", PYTHON_PACKAGES)
    readers = {"pybvh": "pybvh", "bvhio": "bvhio", "bvhtools": "bvhTools", "upc-pymotion": "PyMotion"}
    for package, name in readers.items():
        peers.append(Peer(name, PYTHON_PACKAGES[package], [python, reader(f"{name.lower()}_reader.py")]))
    peers.append(bvh_anim(cache))
    return peers


def reader(file):
    return str(READERS / file)


def virtual_environment(folder, packages):
    """The Python of a virtual environment with exactly these versions."""
    python = folder / "bin" / "python"
    wanted = [f"{package}=={version}" for package, version in packages.items()]
    stamp = folder / "packages.txt"
    if not stamp.exists() or stamp.read_text() != "\n".join(wanted):
        call(sys.executable, "-m", "venv", folder)
        call(python, "-m", "pip", "install", "--quiet", *wanted)
        stamp.write_text("\n".join(wanted))
    return str(python)


def own(mocap):
    if mocap is None:
        call("cargo", "build", "--quiet", "--release", "--bin", "mocap", cwd=ROOT)
        mocap = ROOT / "target" / "release" / "mocap"
    version = subprocess.run([mocap, "-V"], check=True, capture_output=True, text=True).stdout.split()[-1]
    command = [sys.executable, reader("mocap_reader.py")]
    return Peer("mocap", version, command, {"MOCAP": str(Path(mocap).resolve())})


def assimp(cache):
    """Assimp is the system's library: `apt-get install g++ libassimp-dev`."""
    dump = cache / "assimp-dump"
    source = ROOT / "tools" / "oracle" / "assimp" / "dump.cpp"
    if not dump.exists():
        call("g++", "-std=c++17", "-O2", "-o", dump, source, "-lassimp")
    query = ["dpkg-query", "--show", "--showformat", "${Version}", "libassimp-dev"]
    version = subprocess.run(query, check=True, capture_output=True, text=True).stdout.split("~")[0].split("+")[0]
    command = [sys.executable, reader("assimp_reader.py")]
    return Peer("Assimp", version, command, {"ASSIMP_DUMP": str(dump)})


def three(cache):
    folder = cache / "three"
    package = folder / "node_modules" / "three"
    if not (package / "package.json").exists() or f'"version": "{THREE}"' not in (package / "package.json").read_text():
        folder.mkdir(exist_ok=True)
        call("npm", "install", "--silent", "--no-save", "--prefix", folder, f"three@{THREE}")
    command = ["node", "--max-old-space-size=1024", reader("three_reader.mjs"), str(package)]
    return Peer("three.js", THREE, command, limits_address_space=False)


def bvh_anim(cache):
    target = cache / "bvh_anim"
    manifest = READERS / "bvh_anim" / "Cargo.toml"
    call("cargo", "build", "--quiet", "--locked", "--manifest-path", manifest, "--target-dir", target)
    lock = (READERS / "bvh_anim" / "Cargo.lock").read_text()
    version = lock.split('name = "bvh_anim"\nversion = "')[1].split('"')[0]
    command = [sys.executable, reader("bvh_anim_reader.py")]
    return Peer("bvh_anim", version, command, {"BVH_ANIM_DUMP": str(target / "debug" / "bvh-anim-dump")})


def environment(peer):
    """One thread for every numerical library: the limit of processor time counts all of them."""
    return os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"} | peer.environment
