"""Tests the errors that a type checker finds in a program."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

MISTAKES = Path(__file__).parent / "typing" / "mistakes.py"


def test_mypy_finds_the_nine_mistakes_and_no_other(tmp_path: Path) -> None:
    lines = MISTAKES.read_text(encoding="utf-8").splitlines()
    wrong = [number for number, line in enumerate(lines, 1) if "  # wrong: " in line]
    assert len(wrong) == 9
    # Runs in another folder, so that the checker uses the installed package.
    (tmp_path / "mistakes.py").write_text("\n".join(lines) + "\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "mistakes.py"]
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    found = re.findall(r"^mistakes\.py:(\d+): error: ", done.stdout, re.MULTILINE)
    assert sorted({int(number) for number in found}) == wrong, done.stdout + done.stderr
