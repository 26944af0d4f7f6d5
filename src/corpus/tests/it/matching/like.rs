//! Tests the distance of two samples of a search.

use mocap_corpus::internals::{LIMBS, WIDTH, cost, limbs_of_both};

/// A neck that one body lacks does not increase the distance. The sum over the nine other limbs is scaled to ten limbs.
#[test]
fn limbs_that_a_body_lacks_are_not_compared() {
    let mut whole = [10; WIDTH];
    let mut without = whole;
    without[3..6].fill(0);
    let limbs = limbs_of_both(&whole, &without);
    assert_eq!(limbs.iter().filter(|has| **has).count(), LIMBS - 1);
    assert_eq!(cost(&whole, &without, &limbs), 0);
    whole[..3].fill(13);
    assert_eq!(cost(&whole, &without, &limbs), 3 * 9 * 10 / 9);
    assert_eq!(limbs_of_both(&whole, &whole), [true; LIMBS]);
}
