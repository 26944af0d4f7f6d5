//! The channels of the motion's columns.

use mocap_scene::math::rotation::Axis;

/// The channel of one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelKind {
    Position(Axis),
    Rotation(Axis),
    Scale(Axis),
}

/// All names that CHANNELS may list, in Biovision's spelling.
pub const NAMES: [(&str, ChannelKind); 9] = [
    ("Xposition", ChannelKind::Position(Axis::X)),
    ("Yposition", ChannelKind::Position(Axis::Y)),
    ("Zposition", ChannelKind::Position(Axis::Z)),
    ("Xrotation", ChannelKind::Rotation(Axis::X)),
    ("Yrotation", ChannelKind::Rotation(Axis::Y)),
    ("Zrotation", ChannelKind::Rotation(Axis::Z)),
    ("Xscale", ChannelKind::Scale(Axis::X)),
    ("Yscale", ChannelKind::Scale(Axis::Y)),
    ("Zscale", ChannelKind::Scale(Axis::Z)),
];

impl ChannelKind {
    /// The number of channel names.
    pub(super) const COUNT: usize = NAMES.len();

    /// The index of the channel in the list of names.
    pub fn index(self) -> usize {
        match self {
            Self::Position(axis) => axis as usize,
            Self::Rotation(axis) => 3 + axis as usize,
            Self::Scale(axis) => 6 + axis as usize,
        }
    }

    /// The channel with this name, in any case.
    pub fn from_name(name: &[u8]) -> Option<Self> {
        NAMES
            .iter()
            .find(|(spelling, _)| spelling.as_bytes().eq_ignore_ascii_case(name))
            .map(|&(_, kind)| kind)
    }

    /// The name in Biovision's spelling.
    pub(super) fn name(self) -> &'static str {
        NAMES[self.index()].0
    }

    /// All names in Biovision's spelling.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        NAMES.iter().map(|(name, _)| *name)
    }
}
