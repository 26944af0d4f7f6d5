//! Numbers with their units, as reports print them.

pub(super) use mocap_scene::report::counted;

/// Formats a length, which is given in metres, as text in centimetres.
pub(super) fn centimetres(metres: impl Into<f64>) -> String {
    format!("{:.1} cm", 100.0 * metres.into())
}

pub(super) fn metres(metres: impl Into<f64>) -> String {
    format!("{:.2} m", metres.into())
}

pub(super) fn degrees(degrees: impl Into<f64>) -> String {
    format!("{:.1} degrees", degrees.into())
}
