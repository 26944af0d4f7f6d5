//! The colours of all pictures. Nearly everyone can distinguish blue, orange and grey.

use super::drawing::Color;

pub const PAPER: Color = Color::hex(0xFFFFFF);
pub const INK: Color = Color::hex(0x1B2130);
pub(super) const FADED: Color = Color::hex(0x5C667A);
pub const RULE: Color = Color::hex(0xDDE2EA);
pub(super) const GROUND: Color = Color::hex(0xF1F4F8);
/// Opaque, so that overlapping shadows are not darker.
pub const SHADOW: Color = Color::hex(0xDFE4EC);
/// The colour of a root's path.
pub(super) const PATH: Color = Color::hex(0x9AA8C4);
pub const LEFT: Color = Color::hex(0x2D6BD8);
pub(super) const RIGHT: Color = Color::hex(0xE0661F);
pub(super) const MIDDLE: Color = Color::hex(0x76829A);
/// The colours of the curves of x, y and z, and of a fourth value, w.
pub(super) const CURVES: [Color; 4] = [
    Color::hex(0xC8323C),
    Color::hex(0x2E8B3D),
    Color::hex(0x2D6BD8),
    Color::hex(0x8A4FBF),
];
