//! Morph targets of a skin for a page.
//!
//! Morph targets with the same name share one slider, even if they belong to several meshes. The block contains three
//! parts for all sliders together:
//!
//! - the affected vertices (32 bits)
//! - the position offsets (3 signed numbers of 16 bits, in steps of the slider)
//! - after the skin's normals, the normal offsets (3 signed bytes, 63 for 1)

use std::collections::HashMap;

use serde::Serialize;

use mocap_scene::error::visible;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Keys, Mesh, MorphTarget, Scene};

/// A slider. Its bytes are stored separately.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Morph {
    pub name: String,
    /// The weight that the skin already includes.
    weight: f32,
    /// The number of affected vertices.
    pub count: usize,
    /// The offset of one step, in the unit of the skin.
    pub step: f32,
}

/// The weights of the sliders that the file's motion moves. Their block has numbers of 16 bits: all frames of the
/// first slider, then all frames of the next slider.
#[derive(Debug, Serialize)]
pub(super) struct MorphMotion {
    /// The id of the element with the block.
    pub(super) id: String,
    frames: usize,
    sliders: Vec<SliderState>,
}

/// A weight is `least` plus a number of steps of size `step`.
#[derive(Debug, Serialize)]
struct SliderState {
    slider: usize,
    least: f32,
    step: f32,
}

/// The largest size of all slider weights in bytes.
const LARGEST_MOTION: usize = 16 << 20;

impl MorphMotion {
    /// The motion of these sliders with its bytes. If the motion cannot be shown, a note says why.
    pub(super) fn new(
        scene: &Scene,
        frames: usize,
        moves: &[(usize, Keys<f32>)],
        id: String,
    ) -> Result<Option<(Self, Vec<u8>)>, String> {
        let is_other = |step: &AppliedStep| {
            matches!(
                step,
                AppliedStep::Edit { .. } | AppliedStep::OfClip { .. } | AppliedStep::Retarget { .. }
            )
        };
        if moves.is_empty() {
            return Ok(None);
        }
        if scene.metadata.steps.iter().any(is_other) {
            return Err("the page does not move the morph targets, because steps changed the motion".to_owned());
        }
        if 2 * frames * moves.len() > LARGEST_MOTION {
            return Err(format!(
                "the page does not move the morph targets: {} targets move in {frames} frames, which need more than {} \
                    MB, the limit of a page",
                moves.len(),
                LARGEST_MOTION >> 20
            ));
        }
        let mut motion = Self {
            id,
            frames,
            sliders: Vec::new(),
        };
        let mut bytes = Vec::new();
        for (slider, keys) in moves {
            let weights: Vec<f32> = (0..frames).filter_map(|frame| keys.sample(frame as f64)).collect();
            let least = weights.iter().copied().fold(f32::INFINITY, f32::min);
            let most = weights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let step = (most - least) / f32::from(u16::MAX);
            let steps = |weight: f32| {
                if step > 0.0 {
                    ((weight - least) / step).round() as u16
                } else {
                    0
                }
            };
            bytes.extend(weights.iter().flat_map(|weight| steps(*weight).to_le_bytes()));
            motion.sliders.push(SliderState {
                slider: *slider,
                least,
                step,
            });
        }
        Ok(Some((motion, bytes)))
    }
}

/// The offset of a vertex of the skin.
struct VertexOffset {
    vertex: u32,
    offset: [f32; 3],
    normal: [f32; 3],
}

/// Collects the sliders of a skin, mesh by mesh.
#[derive(Default)]
pub struct Morphs {
    are_left_out: bool,
    /// The slider index by name and bits of the rest weight.
    known: HashMap<(String, u32), usize>,
    sliders: Vec<Slider>,
}

/// One slider, and its weights in the first animation.
struct Slider {
    name: String,
    weight: f32,
    moved: Vec<VertexOffset>,
    keys: Keys<f32>,
}

/// The sliders, and the parts of their block.
#[derive(Default)]
pub struct PackedMorphs {
    pub morphs: Vec<Morph>,
    /// Vertices and their position offsets.
    pub moved: Vec<u8>,
    pub normals: Vec<u8>,
    /// The animated sliders.
    pub motion: Vec<(usize, Keys<f32>)>,
}

/// The steps per unit of a normal offset, which is between -2 and 2.
const NORMAL_STEPS: f32 = 63.0;

/// The bytes of a vertex that a slider moves.
pub const MOVED_BYTES: usize = 4 + 3 * 2 + 3;

impl Morphs {
    /// The sliders of these meshes. If they would take more than `room` bytes, there are none, and a note says so.
    pub fn new(meshes: &[&Mesh], room: usize, notes: &mut Vec<String>) -> Self {
        let targets = meshes.iter().flat_map(|mesh| &mesh.morph_targets);
        let bytes = MOVED_BYTES * targets.map(|target| target.vertex_ids.len()).sum::<usize>();
        if bytes > room {
            let (size, most) = (bytes >> 20, room >> 20);
            notes.push(format!(
                "the page has no sliders for morph targets: they need {size} MB, and the page has room for {most} MB \
                    beside the skin"
            ));
        }
        Self {
            are_left_out: bytes > room,
            ..Self::default()
        }
    }

    /// Adds the sliders of a mesh whose vertices start at index `first`.
    pub fn push(&mut self, mesh: &Mesh, first: usize) {
        if self.are_left_out {
            return;
        }
        for target in &mesh.morph_targets {
            let key = (target.name.clone(), target.weight.to_bits());
            let slider = *self.known.entry(key).or_insert_with(|| {
                self.sliders.push(Slider {
                    name: visible(&target.name).into_owned(),
                    weight: target.weight,
                    moved: Vec::new(),
                    keys: target.weight_keys.first().cloned().unwrap_or_default(),
                });
                self.sliders.len() - 1
            });
            self.sliders[slider].moved.extend(moved_by(target, first as u32));
        }
    }

    pub fn pack(self) -> PackedMorphs {
        let mut packed = PackedMorphs::default();
        let mut offsets = Vec::new();
        for (index, slider) in self.sliders.into_iter().enumerate() {
            let Slider {
                name,
                weight,
                moved,
                keys,
            } = slider;
            if !keys.is_empty() {
                packed.motion.push((index, keys));
            }
            let all = moved.iter().flat_map(|moved| moved.offset);
            let largest = all.fold(0.0_f32, |largest, value| largest.max(value.abs()));
            let step = largest / f32::from(i16::MAX);
            let steps = |value: f32| if step > 0.0 { (value / step).round() as i16 } else { 0 };
            for VertexOffset { vertex, offset, normal } in &moved {
                packed.moved.extend(vertex.to_le_bytes());
                offsets.extend(offset.map(steps));
                packed
                    .normals
                    .extend(normal.map(|value| (value * NORMAL_STEPS).round() as i8 as u8));
            }
            packed.morphs.push(Morph {
                name,
                weight,
                count: moved.len(),
                step,
            });
        }
        packed
            .moved
            .extend(offsets.iter().flat_map(|steps| steps.to_le_bytes()));
        packed
    }
}

fn moved_by(target: &MorphTarget, first: u32) -> impl Iterator<Item = VertexOffset> {
    let moved = std::iter::zip(&target.vertex_ids, &target.offsets).enumerate();
    moved.map(move |(at, (vertex, offset))| VertexOffset {
        vertex: first + vertex,
        offset: offset.to_array(),
        normal: target.normal_offsets.get(at).copied().unwrap_or_default().to_array(),
    })
}
