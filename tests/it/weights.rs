//! The table of weights of the solvers, `docs/weights.md`.

use std::fmt::Write as _;

use mocap::edit::{CleanWeights, FootLockWeights};
use mocap::retarget::robot::Weights;
use mocap::solve::MarkerWeights;

use crate::ROOT;

const INTRODUCTION: &str = "# Weights

The solvers of mocap weigh what a motion should be against each other, and decide what is noise and what is an error. The
tables below have each weight with its unit, its default, and the reason for the default. A weight may be from a thousandth to
a thousand times its default.

Write what differs from the defaults into a JSON file, and pass it with `--weights`:

    {\"robot\": {\"hand\": 1, \"joint-smoothing\": 0.03}, \"foot-lock\": {\"acceleration-ratio\": 1.2}}

    mocap robot walk.bvh --robot g1.urdf -o walk.npz --weights weights.json

`mocap convert`, `solve`, `edit`, `clean`, `retarget`, `robot`, `graph walk` and `verify` take the option. A job has the same
object as `weights`; in Python `convert`, `retarget`, `add_motions` and `Robot.retarget` take it. The steps `foot-lock` and
`clean` take their own, also in Python and JavaScript: `foot-lock:weights=acceleration-ratio:1.2`. In Rust the options of
each solver have a field for its struct. Outputs record the weights of steps, so that `mocap verify` repeats them; pass it
the file of weights where a skeleton was solved from markers.

`tools/weights` halves and doubles each weight, and prints what becomes of the measures of a motion.
`MOCAP_WRITE=1 cargo test -p mocap --test it weights` writes this page, and a test holds it.
";

fn page() -> String {
    let mut text = INTRODUCTION.to_owned();
    let tables = [
        ("Robots", "mocap::retarget::robot::Weights", Weights::ROWS),
        ("Foot lock", "mocap::edit::FootLockWeights", FootLockWeights::ROWS),
        ("Cleaning", "mocap::edit::CleanWeights", CleanWeights::ROWS),
        ("Markers", "mocap::solve::MarkerWeights", MarkerWeights::ROWS),
    ];
    for (title, name, rows) in tables {
        let kind = rows[0].kind;
        write!(
            text,
            "\n## {title}\n\n`{kind}` in a job, `{name}` in Rust.\n\n| weight | default | unit | reason |\n|---|---|---|---|\n"
        )
        .unwrap();
        for row in rows {
            let reason = row.reason.replace('_', "-");
            let default = match row.default < 1e-3 {
                true => format!("{:e}", row.default),
                false => row.default.to_string(),
            };
            writeln!(text, "| `{}` | {default} | {} | {reason} |", row.key(), row.unit).unwrap();
        }
    }
    text
}

#[test]
fn the_table_of_weights_is_that_of_the_types() {
    let path = format!("{ROOT}/docs/weights.md");
    let page = page();
    if std::env::var_os("MOCAP_WRITE").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "MOCAP_WRITE=1 cargo test -p mocap --test it weights writes docs/weights.md"
    );
}

/// Paths of scripts that a reason names are there.
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
