//! The channels that columns of the motion drive.

use mocap_scene::math::rotation::Axis;

/// What one column of the motion drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelKind {
    Position(Axis),
    Rotation(Axis),
    Scale(Axis),
}

/// Every name that CHANNELS may list, as Biovision spells it.
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
    /// How many there are.
    pub(super) const COUNT: usize = NAMES.len();

    /// Its index among them.
    pub fn index(self) -> usize {
        match self {
            Self::Position(axis) => axis as usize,
            Self::Rotation(axis) => 3 + axis as usize,
            Self::Scale(axis) => 6 + axis as usize,
        }
    }

    /// The channel of this name, in any case.
    pub fn from_name(name: &[u8]) -> Option<Self> {
        NAMES
            .iter()
            .find(|(spelling, _)| spelling.as_bytes().eq_ignore_ascii_case(name))
            .map(|&(_, kind)| kind)
    }

    /// Its name as Biovision spells it.
    pub(super) fn name(self) -> &'static str {
        NAMES[self.index()].0
    }

    /// Every name, as Biovision spells it.
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        NAMES.iter().map(|(name, _)| *name)
    }
}
