//! The tables of solver weights: `docs/weights.md`, and a page for each solver with many weights.

use std::fmt::Write as _;

use mocap::edit::{CleanWeights, FootLockWeights};
use mocap::retarget::robot::Weights;
use mocap::solve::MarkerWeights;

use crate::ROOT;

const INTRODUCTION: &str = "# Weights

The solvers of mocap balance several goals, and separate noise from motion. A weight sets the balance between goals, or
a threshold between noise and motion. The tables have each weight with its unit, its default, and the reason for the
default:

- foot lock and markers: below
- [robots](weights-robots.md)
- [cleaning](weights-cleaning.md)

A weight may be from a thousandth to a thousand times its default. Write the weights that differ from their defaults
into a JSON file, and pass it with `--weights`:

    {\"robot\": {\"hand\": 1, \"joint-smoothing\": 0.03}, \"foot-lock\": {\"acceleration-ratio\": 1.2}}

    mocap robot walk.bvh --robot g1.urdf -o walk.npz --weights weights.json

| where | how |
|---|---|
| command line | `--weights` of `convert`, `solve`, `edit`, `clean`, `retarget`, `robot`, `graph walk` and `verify` |
| job | the key `weights`; its value is the JSON object above |
| Python | `convert`, `retarget`, `add_motions` and `Robot.retarget` |
| Rust | the options of each solver have a field for the struct of its weights |
| steps `foot-lock` and `clean` | the option `weights` of the step, also in Python and JavaScript: `foot-lock:weights=acceleration-ratio:1.2` |

Outputs record the weights of steps, and `mocap verify` repeats the steps with these weights. If a skeleton was solved
from markers with your weights, also pass the file of weights to `verify`.

`tools/weights` halves and doubles each weight, and prints how the measures of a motion change.
`MOCAP_WRITE=1 cargo test -p mocap --test it weights` writes these pages. Without
`MOCAP_WRITE`, the test checks that the pages agree with the code.
";

/// The pages and their texts.
fn pages() -> [(&'static str, String); 3] {
    let [robots, foot_lock, cleaning, markers] = [
        ("Robots", "mocap::retarget::robot::Weights", Weights::ROWS),
        ("Foot lock", "mocap::edit::FootLockWeights", FootLockWeights::ROWS),
        ("Cleaning", "mocap::edit::CleanWeights", CleanWeights::ROWS),
        ("Markers", "mocap::solve::MarkerWeights", MarkerWeights::ROWS),
    ]
    .map(|(title, name, rows)| {
        let mut text = format!("\n## {title}\n\n`{}` in a job, `{name}` in Rust.\n\n", rows[0].kind);
        text += "| weight | default | unit | reason |\n|---|---|---|---|\n";
        for row in rows {
            let reason = row.reason.replace('_', "-");
            let default = match row.default < 1e-3 {
                true => format!("{:e}", row.default),
                false => row.default.to_string(),
            };
            writeln!(text, "| `{}` | {default} | {} | {reason} |", row.key(), row.unit).unwrap();
        }
        text
    });
    let own = |solver: &str, table: &str| {
        format!("# Weights of {solver}\n\n[Weights](weights.md) describes how to change the weights.\n{table}")
    };
    [
        ("weights", format!("{INTRODUCTION}{foot_lock}{markers}")),
        ("weights-robots", own("robots", &robots)),
        ("weights-cleaning", own("cleaning", &cleaning)),
    ]
}

#[test]
fn the_tables_of_weights_are_those_of_the_types() {
    for (name, page) in pages() {
        let path = format!("{ROOT}/docs/{name}.md");
        if std::env::var_os("MOCAP_WRITE").is_some() {
            std::fs::write(&path, &page).unwrap();
        }
        let written = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            written == page,
            "MOCAP_WRITE=1 cargo test -p mocap --test it weights writes docs/{name}.md"
        );
    }
}

/// The reasons of weights name scripts, and these scripts exist.
#[test]
fn scripts_that_justify_weights_exist() {
    let rows = [
        Weights::ROWS,
        FootLockWeights::ROWS,
        CleanWeights::ROWS,
        MarkerWeights::ROWS,
    ];
    let mut named = 0;
    for row in rows.into_iter().flatten() {
        for path in row.reason.split('`').filter(|part| part.starts_with("tools/")) {
            named += 1;
            assert!(std::path::Path::new(ROOT).join(path).exists(), "{}: {path}", row.field);
        }
    }
    assert!(named > 5, "{named}");
}
