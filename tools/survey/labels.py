"""Compares the verdicts of `mocap survey` with labels of clips, which a person made by looking at them.

    labels.py MOCAP FOLDER... [--half fit|held|all] [--list]

FOLDER has the clips of `labels.tsv`, at any depth; the SHA-256 of its bytes identifies a clip. Thresholds are fitted on
the clips with an even hash, and tested on the others. The exit code is 1 if too many clips with the label clean get the
verdict bad or suspect.
"""

import argparse
import collections
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

LABELS = pathlib.Path(__file__).with_name("labels.tsv")
# The fractions of clips with the label clean that may get the verdicts bad and suspect.
BAD, SUSPECT = 0.03, 0.10


def is_fitted(label):
    return int(label["sha256"][0], 16) % 2 == 0


def labels(half):
    rows = csv.DictReader(LABELS.open(), delimiter="\t")
    wanted = {"fit": is_fitted, "held": lambda row: not is_fitted(row), "all": lambda row: True}[half]
    return {row["sha256"]: row for row in rows if wanted(row)}


def survey(mocap, folders):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "rows.jsonl"
        run = subprocess.run([mocap, "survey", *folders, "-o", out, "-q"], capture_output=True, text=True)
        if run.returncode not in (0, 3):
            sys.exit(run.stderr)
        return [json.loads(line) for line in out.read_text().splitlines()]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("mocap")
    arguments.add_argument("folders", nargs="+")
    arguments.add_argument("--half", choices=["fit", "held", "all"], default="held")
    arguments.add_argument("--list", action="store_true", help="name the clips whose verdict differs from the label")
    options = arguments.parse_args()
    known = labels(options.half)
    verdicts, differ = collections.Counter(), []
    for row in survey(options.mocap, options.folders):
        # An unreadable file has no row with a hash; two copies of a clip have one label.
        label = known.pop(row["sha256"][:16], None) if row["sha256"] else None
        if label is None or label["verdict"] in ("unsure", "unreadable"):
            continue
        verdicts[label["verdict"], row["verdict"]] += 1
        if label["verdict"] != row["verdict"]:
            differ.append((label, row))
    print(f"{'label':10}{'clips':>7}{'good':>7}{'suspect':>9}{'bad':>7}")
    counts = {}
    for label in ("clean", "suspect", "bad"):
        counts[label] = [verdicts[label, verdict] for verdict in ("good", "suspect", "bad")]
        print(f"{label:10}{sum(counts[label]):7}{counts[label][0]:7}{counts[label][1]:9}{counts[label][2]:7}")
    if options.list:
        for label, row in sorted(differ, key=lambda pair: (pair[0]["verdict"], pair[0]["maker"])):
            amounts = " ".join(f"{kind}={row[kind]:.4g}" for kind in row["reasons"].split())
            print(f"{label['verdict']:8}{row['verdict']:8} {label['maker']}/{label['file']} [{label['defects']}] {amounts}")
    clean = max(sum(counts["clean"]), 1)
    bad, suspect = counts["clean"][2] / clean, counts["clean"][1] / clean
    print(f"of clips labelled clean, {100 * bad:.1f} % are called bad and {100 * suspect:.1f} % suspect")
    sys.exit(bad > BAD or suspect > SUSPECT)


if __name__ == "__main__":
    main()
