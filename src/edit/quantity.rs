//! Numbers with their units, as reports print them.

/// A length in metres, in centimetres.
pub(super) fn centimetres(metres: impl Into<f64>) -> String {
    format!("{:.1} cm", 100.0 * metres.into())
}

pub(super) fn metres(metres: impl Into<f64>) -> String {
    format!("{:.2} m", metres.into())
}

pub(super) fn degrees(degrees: impl Into<f64>) -> String {
    format!("{:.1} degrees", degrees.into())
}

/// A count with its noun, which takes an `s` but after 1.
pub(super) fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}
