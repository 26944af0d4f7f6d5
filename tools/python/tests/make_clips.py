"""Makes invented motion files: a short chain whose joints turn by a seed."""

from __future__ import annotations

import random
from pathlib import Path

HEADER = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Knee
  {
    OFFSET 0 -0.5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -0.5 0.1
    }
  }
}
MOTION
Frames: 20
Frame Time: 0.0166667
"""


def make_clips(folder: Path, count: int) -> list[Path]:
    """Writes `count` different files of 20 frames, and returns their paths in the order of their names."""
    paths = []
    for number in range(count):
        values = random.Random(number)
        rows = (" ".join(f"{values.uniform(-90, 90):.4f}" for _ in range(9)) for _ in range(20))
        path = folder / f"clip_{number:05}.bvh"
        path.write_text(HEADER + "\n".join(rows) + "\n")
        paths.append(path)
    return paths
