"""Runs the cells of docs/arrays-in-python.md, and compares their output."""

import doctest
import os
import pathlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.mark.skipif("MOCAP" not in os.environ, reason="a cell runs the program, which MOCAP names")
def test_every_cell_prints_what_the_page_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    page = ROOT / "docs" / "arrays-in-python.md"
    result = doctest.testfile(str(page), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.attempted > 30 and result.failed == 0
