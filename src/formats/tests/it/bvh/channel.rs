//! Tests the names of channels in BVH.

use mocap_formats::internals::bvh::{ChannelKind, NAMES};
use mocap_scene::math::rotation::Axis;

#[test]
fn names_are_read_in_any_case() {
    assert_eq!(
        ChannelKind::from_name(b"ZROTATION"),
        Some(ChannelKind::Rotation(Axis::Z))
    );
    assert_eq!(
        ChannelKind::from_name(b"xposition"),
        Some(ChannelKind::Position(Axis::X))
    );
    assert_eq!(ChannelKind::from_name(b"Wrotation"), None);
}

#[test]
fn the_table_is_in_the_order_of_the_index() {
    for (index, (_, kind)) in NAMES.into_iter().enumerate() {
        assert_eq!(kind.index(), index);
    }
}
