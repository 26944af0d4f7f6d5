//! Morph targets of a skin for a page.
//!
//! Targets of one name are one slider, over all meshes. For all sliders together the block has the vertices that they
//! move (32 bits). Then come the offsets of their positions (3 of 16 bits, signed, in steps of the slider). After the
//! skin's normals follow the offsets of the normals (3 signed bytes, 63 for 1).

use std::collections::HashMap;

use serde::Serialize;

use mocap_scene::error::visible;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Keys, Mesh, MorphTarget, Scene};

/// A slider; its bytes stand apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Morph {
    pub name: String,
    /// The weight that the skin has already.
    weight: f32,
    /// How many vertices it moves.
    pub count: usize,
    /// What one step adds, in the unit of the skin.
    pub step: f32,
}

/// The weights of the sliders that the motion of the file moves. Their block has 16 bits for each frame, slider after
/// slider.
#[derive(Debug, Serialize)]
pub(super) struct MorphMotion {
    /// The id of the element that holds the block.
    pub(super) id: String,
    frames: usize,
    sliders: Vec<SliderState>,
}

/// Its weight is `least`, and so many times `step` above it.
#[derive(Debug, Serialize)]
struct SliderState {
    slider: usize,
    least: f32,
    step: f32,
}

/// The largest size in bytes of the weights of all sliders.
const LARGEST_MOTION: usize = 16 << 20;

impl MorphMotion {
    /// The motion of these sliders with its bytes; a note where it cannot be shown.
    pub(super) fn new(
        scene: &Scene,
        frames: usize,
        moves: &[(usize, Keys<f32>)],
        id: String,
    ) -> Result<Option<(Self, Vec<u8>)>, String> {
        let is_other = |step: &AppliedStep| matches!(step, AppliedStep::Edit { .. } | AppliedStep::Retarget { .. });
        if moves.is_empty() {
            return Ok(None);
        }
        if scene.metadata.steps.iter().any(is_other) {
            return Err("the morph targets stay still, because steps changed the motion".to_owned());
        }
        if 2 * frames * moves.len() > LARGEST_MOTION {
            return Err(format!(
                "the morph targets stay still: {} of them move in {frames} frames, and at most {} MB of it are put in a page",
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

/// What a vertex of the skin is moved by.
struct VertexOffset {
    vertex: u32,
    offset: [f32; 3],
    normal: [f32; 3],
}

/// The sliders of a skin, as its meshes come.
#[derive(Default)]
pub struct Morphs {
    are_left_out: bool,
    /// By the name and the bits of the weight at rest.
    known: HashMap<(String, u32), usize>,
    sliders: Vec<Slider>,
}

/// One slider, and the weights that the first animation gives it.
struct Slider {
    name: String,
    weight: f32,
    moved: Vec<VertexOffset>,
    keys: Keys<f32>,
}

/// The sliders, and the parts of the block.
#[derive(Default)]
pub struct PackedMorphs {
    pub morphs: Vec<Morph>,
    /// Vertices and what is added to their positions.
    pub moved: Vec<u8>,
    pub normals: Vec<u8>,
    /// The sliders that the motion moves.
    pub motion: Vec<(usize, Keys<f32>)>,
}

/// Steps of 1 in what is added to a normal, which is between -2 and 2.
const NORMAL_STEPS: f32 = 63.0;

/// Bytes of a vertex that a slider moves.
pub const MOVED_BYTES: usize = 4 + 3 * 2 + 3;

impl Morphs {
    /// Sliders for these meshes; none, with a note, where they have more than `room` bytes.
    pub fn new(meshes: &[&Mesh], room: usize, notes: &mut Vec<String>) -> Self {
        let targets = meshes.iter().flat_map(|mesh| &mesh.morph_targets);
        let bytes = MOVED_BYTES * targets.map(|target| target.vertex_ids.len()).sum::<usize>();
        if bytes > room {
            let (size, most) = (bytes >> 20, room >> 20);
            notes.push(format!(
                "the morph targets have {size} MB, and at most {most} MB are put in a page beside the skin; they have no sliders"
            ));
        }
        Self {
            are_left_out: bytes > room,
            ..Self::default()
        }
    }

    /// Adds the sliders of a mesh whose vertices begin at `first`.
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
