"""Finds the nearest frames with a full search, for comparison with `nearest_frames`. The folder has the three files of
that example."""

import sys

import numpy as np

FEATURES = 27


def read(name, numbers, width):
    return np.fromfile(f"{sys.argv[1]}/{name}", numbers).reshape(-1, width).astype(np.float64)


frames, queries = (read(f"{name}.f32", "<f4", FEATURES) for name in ("frames", "queries"))
answers = read("answers.f64", "<f8", 2)
if len(answers) != len(queries):
    sys.exit(f"matching: {len(answers)} answers to {len(queries)} queries")
squares = (frames * frames).sum(axis=1)
wrong = 0
for query, (frame, distance) in zip(queries, answers):
    # Products select candidates, and differences find the nearest of them.
    near = np.argpartition(squares - 2 * (frames @ query), 8)[:8]
    nearest = ((frames[near] - query) ** 2).sum(axis=1).min()
    own = ((frames[int(frame)] - query) ** 2).sum()
    is_right = own <= nearest * (1 + 1e-6) and abs(distance - own) <= 1e-5 * own + 1e-9
    wrong += not is_right
print(f"matching: {len(queries)} queries on {len(frames)} frames, {wrong} unlike NumPy's")
sys.exit(wrong > 0)
