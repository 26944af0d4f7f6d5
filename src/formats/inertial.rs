//! Checks the mass of a link that a file states, and drops impossible values.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::robot::Inertial;

use super::text::quote;
use super::warnings::Warnings;
use super::xml::Element;

/// The largest violation of the conditions for moments of inertia, as a fraction of their sum: files round moments to a
/// few digits.
const ROUNDING: f64 = 1e-3;

/// A warning about the mass of a link.
fn warning(element: &Element<'_, '_>, link: &str, message: &str, expected: &str, found: String) -> Diagnostic {
    let message = format!("the link {} {message}", quote(link.as_bytes()));
    element
        .diagnostic(Code::InvalidRobot, message)
        .expected_found(expected, found)
}

/// Checks the mass of a link, which `element` states, and returns the usable values, with warnings. A negative mass is
/// dropped. If a moment is negative, all moments become 0. Other impossible moments are kept.
pub(super) fn possible(
    mut stated: Inertial,
    link: &str,
    element: &Element<'_, '_>,
    warnings: &mut Warnings,
) -> Option<Inertial> {
    if is_negative("mass", stated.mass, link, element, warnings) {
        return None;
    }
    let mut moments = stated.moments().to_array();
    moments.sort_unstable_by(f64::total_cmp);
    let [least, middle, most] = moments;
    let printed = || format!("moments of {least:.3e}, {middle:.3e} and {most:.3e}");
    let slack = ROUNDING * moments.iter().map(|moment| moment.abs()).sum::<f64>();
    if least < -slack {
        warnings.push(Code::InvalidRobot, || {
            let message = "has a negative moment of inertia, which is ignored";
            let help = "correct the inertia of the link; until then the link counts as a point mass";
            warning(element, link, message, "moments of at least 0", printed()).help(help)
        });
        stated.inertia = [0.0; 6];
    } else if most > least + middle + slack {
        warnings.push(Code::InvalidRobot, || {
            let message = "has an inertia that is impossible for a body";
            let expected = "each moment at most the sum of the other two";
            let help = "correct the inertia; until then mocap computes torques with the value of the file";
            warning(element, link, message, expected, printed()).help(help)
        });
    }
    Some(stated)
}

/// Whether the mass or density of a link is negative. Warns about a negative value.
pub(super) fn is_negative(
    quantity: &str,
    value: f64,
    link: &str,
    element: &Element<'_, '_>,
    warnings: &mut Warnings,
) -> bool {
    if value < 0.0 {
        warnings.push(Code::InvalidRobot, || {
            let message = format!("has a negative {quantity}, which is ignored");
            let expected = format!("a {quantity} of at least 0");
            let help = "correct this value; until then this part weighs nothing";
            warning(element, link, &message, &expected, value.to_string()).help(help)
        });
    }
    value < 0.0
}
