"""The errors of the best filter of one joint, chosen with the truth: python oracle.py FOLDERS.. [--count 28] [--seed 1]

Each joint in the world is filtered with 16 cut-offs. The cut-off (or a joint without acceleration) with the least
acceleration error is chosen: for the whole clip, for each joint, and for each joint and tenth of a second. The errors
are fractions of the error of the best Butterworth filter of `judge.py`.
"""

import argparse

import numpy as np
from scipy.ndimage import uniform_filter1d

import judge
import plant

CUT_OFFS = np.geomspace(0.7, 12, 16)  # in Hz
AROUND = 0.1  # seconds over which the error is averaged


def filtered(places, cut_off, rate):
    """Without delay, with the response 1 / (1 + (f / cut-off)^6); continued beyond the ends by point reflection."""
    pad = min(int(rate), len(places) - 1)
    longer = np.concatenate([2 * places[0] - places[pad:0:-1], places, 2 * places[-1] - places[-2 : -pad - 2 : -1]])
    both = np.concatenate([longer, longer[::-1]])
    response = 1 / (1 + (np.fft.rfftfreq(len(both), 1 / rate) / cut_off) ** 6)
    spectrum = np.fft.rfft(both, axis=0) * response[:, None, None]
    return np.fft.irfft(spectrum, len(both), axis=0)[pad : pad + len(places)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--count", type=int, default=28)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rows = []
    for index, (source, clean, _) in enumerate(plant.clips(args.folders, args.count, args.seed)):
        noisy, _, _ = plant.spoil(clean, source, np.random.default_rng([args.seed, index]), ["noise"])
        truth, rate, places = clean.positions(), clean.rate, noisy.positions()
        bank = [judge.accelerations(filtered(places, cut, rate), rate) for cut in CUT_OFFS[CUT_OFFS < 0.45 * rate]]
        bank.append(np.zeros_like(bank[0]))
        error = np.linalg.norm(np.stack(bank) - judge.accelerations(truth, rate), axis=-1)
        around = uniform_filter1d(error, max(1, round(AROUND * rate)), axis=1)
        moment = np.take_along_axis(error, around.argmin(axis=0)[None], axis=0)
        best = judge.peer(noisy, truth, rate)[0]
        found = [error.mean(axis=(1, 2)).min(), error.mean(axis=1).min(axis=0).mean(), moment.mean(), error[-1].mean()]
        rows.append(np.array(found) / best)
    for name, value in zip(("clip", "joint", "joint and moment", "no acceleration"), np.mean(rows, axis=0)):
        print(f"{name:<20}{value:>8.3f}")


if __name__ == "__main__":
    main()
