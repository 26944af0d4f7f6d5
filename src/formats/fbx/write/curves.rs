//! Curves, and the reduction of their keys within an error bound.

use std::rc::Rc;

use glam::DVec3;
use mocap_compress::{
    self, CompressedClip, Encoding, ErrorBound, EulerAngles, KeyFrameChoice, RotationFormat, Track, TranslationFormat,
    compress,
};
use mocap_scene::error::Result;
use mocap_scene::scene::{Animation, Scene};

use super::skeleton::Placed;
use super::space::Space;
use crate::report::Deviation;

/// The property that a track animates.
#[derive(Clone, Copy)]
pub(super) enum Part {
    Translation,
    Rotation,
    Scaling,
}

impl Part {
    pub(super) fn curve_node(self) -> &'static str {
        match self {
            Self::Translation => "T",
            Self::Rotation => "R",
            Self::Scaling => "S",
        }
    }

    pub(super) fn property(self) -> &'static str {
        match self {
            Self::Translation => "Lcl Translation",
            Self::Rotation => "Lcl Rotation",
            Self::Scaling => "Lcl Scaling",
        }
    }
}

/// The keys of one axis.
pub(super) struct Curve {
    /// The tick of each key; `None` for 0, 1, 2, ...
    pub(super) ticks: Option<Rc<[f64]>>,
    #[doc(hidden)]
    pub values: Vec<f64>,
}

impl Curve {
    pub(super) fn is_constant(&self) -> bool {
        self.values.iter().all(|value| *value == self.values[0])
    }

    /// The three curves of a track of vectors. Their keys are at the same ticks.
    pub(super) fn of_vectors(ticks: Option<&Vec<f64>>, values: &[DVec3]) -> [Self; 3] {
        let ticks: Option<Rc<[f64]>> = ticks.map(|ticks| ticks.as_slice().into());
        std::array::from_fn(|axis| Self {
            ticks: ticks.clone(),
            values: values.iter().map(|value| value[axis]).collect(),
        })
    }
}

/// The least distance of the shell that represents the skin of a joint, in metres: the default of ACL.
const SKIN: f64 = 0.03;

/// FBX curves for the key reduction: 32-bit floats, one curve for each axis, with separate keys.
struct Curves {
    /// The Euler angles of each node in the file.
    euler: Vec<EulerAngles>,
}

impl Encoding for Curves {
    fn rotations(&self, _steps: f32) -> RotationFormat {
        RotationFormat::Float32
    }

    fn translations(&self, _step: f32, _largest: f32) -> TranslationFormat {
        TranslationFormat::Float32
    }

    fn key_frames(&self) -> KeyFrameChoice {
        KeyFrameChoice::Own
    }

    fn size(&self, clip: &CompressedClip) -> usize {
        clip.size()
    }

    /// FBX stores times as integers of a very fine resolution. So the tick itself represents the time.
    fn time(&self, tick: f64, _ticks_per_second: f64) -> f32 {
        tick as f32
    }

    /// A reader evaluates three curves and computes the rotation from these angles in single precision.
    fn roundings(&self) -> f64 {
        3.0
    }

    fn euler_angles(&self, node: usize) -> Option<EulerAngles> {
        self.euler.get(node).copied()
    }

    fn help(&self) -> &'static str {
        "allow a larger error, or keep every key"
    }
}

/// A clip with reduced keys.
pub(super) struct ReducedClip<'a> {
    clip: CompressedClip,
    /// Metres per unit of the scene.
    metres: f64,
    space: &'a Space,
}

impl<'a> ReducedClip<'a> {
    /// `bound` is in metres.
    ///
    /// # Errors
    /// The errors of [`compress()`].
    pub(super) fn new(
        scene: &Scene,
        animation: &Animation,
        space: &'a Space,
        placed: &[Placed],
        bound: &ErrorBound,
    ) -> Result<Self> {
        let metres = scene.metadata.metres_per_unit.unwrap_or(1.0);
        let shell_distance = bound.shell_distance.max(SKIN);
        let bound = bound.clone().shell_distance(shell_distance).in_units_of(metres);
        let euler = placed.iter().map(|node_at_rest| EulerAngles {
            order: space.order_in_scene(node_at_rest.order),
            pre_rotation: space.rotation_in_scene(node_at_rest.pre_rotation),
            rest: space.direction_in_scene(node_at_rest.angles_at_rest()),
        });
        let encoding = Curves { euler: euler.collect() };
        Ok(Self {
            clip: compress(scene, animation, &bound, &encoding)?,
            metres,
            space,
        })
    }

    /// Adds the error of the clip to `sum`, in metres.
    pub(super) fn add_error(&self, scene: &Scene, sum: &mut Option<Deviation>) {
        Deviation::add(sum, scene, &self.clip, self.metres);
    }

    /// The reduced curves of a part of a node; `None` if every key remains.
    pub(super) fn curves(&self, node: usize, node_at_rest: &Placed, part: Part) -> Option<[Curve; 3]> {
        let track = &self.clip.tracks[node];
        let curves = track.curves.as_ref();
        let (constant, animated, factor) = match part {
            Part::Translation => {
                let constant = match &track.translation {
                    Track::Constant(value) => Some(self.space.point(*value)),
                    Track::Animated { .. } => None,
                };
                (
                    constant,
                    curves.and_then(|curves| curves.translation.as_ref()),
                    self.space.factor(),
                )
            }
            Part::Rotation => {
                let constant = match &track.rotation {
                    Track::Constant(value) => {
                        let rotation = self.space.rotation(*value);
                        rotation.map(|rotation| node_at_rest.angles(rotation, node_at_rest.angles_at_rest()))
                    }
                    Track::Animated { .. } => None,
                };
                (constant, curves.and_then(|curves| curves.rotation.as_ref()), 1.0)
            }
            Part::Scaling => return None,
        };
        match (constant, animated) {
            (Some(value), _) => Some(Curve::of_vectors(None, &[value])),
            (None, Some(curves)) => Some(std::array::from_fn(|axis| {
                let (source, sign) = self.space.axis_in_scene(axis);
                self.curve(&curves[source], sign * factor)
            })),
            (None, None) => None,
        }
    }

    fn curve(&self, curve: &mocap_compress::Curve, factor: f64) -> Curve {
        let ticks: Rc<[f64]> = curve
            .key_frames
            .iter()
            .map(|frame| self.clip.ticks[*frame as usize])
            .collect();
        Curve {
            ticks: Some(ticks),
            values: curve.values.iter().map(|value| f64::from(*value) * factor).collect(),
        }
    }
}
