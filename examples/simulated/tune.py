"""Looks for the gains of the balance controller: the cross-entropy method (Rubinstein 1999) over seconds upright.

python tune.py [--rounds 20] [--seed 1] [-o gains.json]"""

import argparse
import json

import numpy as np
from body import GAINS, Body, Disturbances, load_gains
from simulate import CLIPS, HELP, reference

# Candidates of a round, those of which the next round is made, and the deviation of the first: parts of a gain, and a
# gain.
CANDIDATES, BEST, DEVIATION = 32, 6, (0.3, 0.03)
# Seconds upright that a watt of the standing robot costs: it is not to tremble.
POWER_WEIGHT = 0.1
# Pushes of the standing robot that count too, in N s and degrees, and seconds of each.
PUSHES, PUSHED = ((15.0, 0.0), (10.0, 90.0), (10.0, 180.0)), 3.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", default=GAINS)
    args = parser.parse_args()
    random = np.random.default_rng(args.seed)
    first = load_gains()
    tried_on = [(Body(), reference(*CLIPS[name]), most) for name in ("walk", "turn", "dance") for most in (0.0, HELP)]
    still = reference(None, seconds=PUSHED)
    tried_on += [(Body(Disturbances(push=(0.5, impulse, degrees))), still, 0.0) for impulse, degrees in PUSHES]
    named = lambda values: dict(zip(first, values.reshape(-1, 2)))

    def score(values):
        gains = named(values)
        seconds = [body.simulate(motion, most, gains, measure=False).seconds for body, motion, most in tried_on]
        return sum(seconds) - POWER_WEIGHT * Body().simulate(still, 0.0, gains).row()["watts"]

    mean, spread = (
        np.array(list(first.values())).ravel(),
        DEVIATION[0] * np.abs(np.array(list(first.values())).ravel()) + DEVIATION[1],
    )
    best, most = mean, score(mean)
    print(f"begin: {most:.2f}")
    for turn in range(args.rounds):
        tried = mean + spread * random.standard_normal((CANDIDATES, len(mean)))
        tried[0] = best
        scores = np.array([score(values) for values in tried])
        order = np.argsort(-scores)[:BEST]
        mean, spread = tried[order].mean(0), tried[order].std(0) + 0.3 * DEVIATION[1]
        if scores[order[0]] > most:
            best, most = tried[order[0]], scores[order[0]]
        print(f"round {turn + 1}: {scores[order[0]]:.2f}, best {most:.2f}", flush=True)
        with open(args.output, "w", encoding="utf-8") as file:
            json.dump({name: np.round(pair, 3).tolist() for name, pair in named(best).items()}, file, indent=2)
            file.write("\n")


if __name__ == "__main__":
    main()
