//! Items for the tests of this package.

pub use crate::clip::CompressedTrack;
pub use crate::compensation::{Compensation, Target};
pub use crate::decode::slerp_weight;
pub use crate::error_metric::{LeverArms, SHELL_DISTANCE};
pub use crate::object_space::ObjectSpaceTrack;
pub use crate::packed::sample::key_in;
pub use crate::quantize::rotation::{INT16_MAX, QuantizedRotation};
pub use crate::quantize::translation::QuantizedTranslation;
pub use crate::raw_clip::RawClip;

pub mod bit_rate {
    pub use crate::bit_rate::{may_suffice, quantize, quantize_after, select};
}
pub mod bits {
    pub use crate::packed::bits::{BitWriter, PADDING, bits_at, lowest, width};
}
pub mod curves {
    pub use crate::curves::reduce;
}
pub mod fitted_keys {
    pub use crate::fitted_keys::{Fit, NLERP_FROM_SLERP, NLERP_SHARE, RotationFit, TranslationFit, fit};
}
pub mod key_frames {
    pub use crate::key_frames::{Insertion, Refine, between, every_frame, for_each_frame, insert, reduce, refine};
}
pub mod measure {
    pub use crate::measure::{FrameErrors, Measurement, measure, measure_lanes};
}
pub mod trellis {
    pub use crate::trellis::{CORNERS, Component, Rates, Trellis, floor, least};
}
