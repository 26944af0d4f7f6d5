//! Tests the verdict on a motion of a robot.

use mocap::retarget::report::Verdict;
use mocap_retarget::internals::Measures;

#[test]
fn the_worst_measure_decides() {
    let good = Measures {
        mean_degrees: Some(2.0),
        ..Measures::default()
    };
    assert_eq!(good.verdict().1, Verdict::Good);
    let floats = Measures {
        floating: Some(0.9),
        ..good.clone()
    };
    let (criteria, verdict) = floats.verdict();
    assert_eq!(verdict, Verdict::Poor);
    let poor = criteria.iter().filter(|criterion| criterion.verdict == Verdict::Poor);
    assert_eq!(
        poor.map(|criterion| criterion.name.as_str()).collect::<Vec<_>>(),
        ["fraction_floating"]
    );
    // In three of a hundred frames of a swing, the heel may still roll off the floor.
    for (scraping, wanted) in [(0.03, Verdict::Good), (0.031, Verdict::Fair), (1.0, Verdict::Fair)] {
        let scrapes = Measures {
            scraping: Some(scraping),
            ..good.clone()
        };
        assert_eq!(scrapes.verdict().1, wanted);
    }
    let guessed = Measures {
        guessed_parts: 1,
        ..good.clone()
    };
    // A robot without masses lacks this value, and gets its verdict from the other values.
    for (infeasible, wanted) in [(Some(0.04), Verdict::Good), (Some(0.9), Verdict::Fair)] {
        let measured = Measures {
            infeasible,
            ..good.clone()
        };
        assert_eq!(measured.verdict().1, wanted);
    }
    assert_eq!(guessed.verdict().1, Verdict::Fair);
    assert_eq!(Measures::default().verdict().1, Verdict::Poor);
}
