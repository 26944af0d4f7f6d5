//! Items for the tests of this package.

pub use crate::dump::number::StreamNumber;
pub use crate::ledger::states_unit;

#[cfg(feature = "arrays")]
pub mod arrays {
    pub use crate::array_files::read::ndarray::{Bytes, Kind, NdArray, half};
}
#[cfg(feature = "bvh")]
pub mod bvh {
    pub use crate::bvh::read::channel::{ChannelKind, NAMES};
    pub use crate::bvh::read::rows::block::Block;
    pub use crate::bvh::read::rows::layout::{Layout, count_numbers, find};
    pub use crate::bvh::read::rows::pieces::{LENGTH, Piece, Pieces, count_lines};
    #[cfg(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128")))]
    pub use crate::bvh::read::rows::short::parse;
    pub use crate::bvh::write::angles::{Angles, unit_within};
    pub use crate::bvh::write::number::{push, shortest};
}
#[cfg(feature = "c3d")]
pub mod c3d {
    pub use crate::c3d::read::bytes::Processor;
    pub use crate::c3d::read::recorded::si;
}
#[cfg(feature = "fbx")]
pub mod fbx {
    pub use crate::fbx::write::time::{SECOND, end, key_times};
}
#[cfg(feature = "gltf")]
pub mod gltf {
    pub use crate::gltf::write::text::{Animation, Channel, Sampler, ShortNumbers, Target, write};
    pub use crate::gltf::write::values::with_middles;
}
#[cfg(any(feature = "mjcf", feature = "urdf"))]
pub mod mesh_bounds {
    pub use crate::mesh_bounds::{candidates, obj, stl};
}
#[cfg(any(feature = "mjcf", feature = "urdf"))]
pub mod mesh_surface {
    pub use crate::mesh_surface::{corners, mesh_of, push_polygon};
}
#[cfg(feature = "mmd")]
pub mod mmd {
    pub use crate::mmd::bezier::ease;
    pub use crate::mmd::generic::{ARMS, model};
    pub use crate::mmd::model::{Bone, Model};
    pub use crate::mmd::names::{NAME_BYTES, bone, decode, encode, in_ascii, key, until_nul};
}
pub mod number {
    pub use crate::text::number::{Number, parse};
}
pub mod text {
    pub use crate::text::{Cursor, LineIndex, Word, decode};
}
#[cfg(feature = "usd")]
pub mod usd {
    pub use crate::usd::archive::{ALIGNMENT, stage, write};
    pub use crate::usd::write::animation::{STEP, half, half_of_scale};
    pub use crate::usd::write::names::Names;
}
#[cfg(any(feature = "fbx", feature = "gltf", feature = "mjcf", feature = "urdf"))]
pub mod named_file {
    pub use crate::named_file::{below, near};
}
