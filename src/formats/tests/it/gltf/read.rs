//! A file as the `gltf` crate reads it, posed by separate kinematics.

use gltf::animation::Interpolation;
use gltf::animation::util::ReadOutputs;
use mocap::glam::{DMat4, DQuat, DVec3, Quat, Vec3};
use mocap::gltf::{Document, GltfOptions};
use mocap::scene::Scene;

/// A file in memory.
pub(crate) struct Read {
    pub(crate) document: gltf::Document,
    pub(crate) bin: Vec<u8>,
    tracks: Vec<Track>,
}

struct Track {
    node: usize,
    times: Vec<f32>,
    values: Values,
}

enum Values {
    Translations(Vec<DVec3>),
    Rotations(Vec<DQuat>),
    Scales(Vec<DVec3>),
}

impl Read {
    pub(crate) fn glb(bytes: &[u8]) -> Self {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).unwrap();
        let bin = blob.unwrap_or_default();
        let tracks = document
            .animations()
            .next()
            .iter()
            .flat_map(|a| a.channels().map(|c| Track::new(&c, &bin)))
            .collect();
        Self { document, bin, tracks }
    }

    pub(crate) fn scene(scene: &Scene) -> Self {
        Self::glb(&GltfOptions::default().write_glb(scene).unwrap())
    }

    /// The numbers of an accessor, without the crate's iterators.
    pub(crate) fn floats(&self, accessor: &gltf::Accessor) -> Vec<f32> {
        let view = accessor.view().unwrap();
        assert_eq!(view.stride(), None);
        let start = view.offset() + accessor.offset();
        let end = start + accessor.count() * accessor.size();
        assert!(end <= view.offset() + view.length());
        let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        self.bin[start..end].chunks_exact(4).map(number).collect()
    }

    pub(crate) fn names(&self) -> Vec<&str> {
        self.document.nodes().map(|node| node.name().unwrap()).collect()
    }

    /// The node-to-world matrix of every node at `seconds`.
    pub(crate) fn world(&self, seconds: f32) -> Vec<DMat4> {
        let rest = |node: gltf::Node| {
            let (t, r, s) = node.transform().decomposed();
            (
                Vec3::from(t).as_dvec3(),
                Quat::from_array(r).as_dquat(),
                Vec3::from(s).as_dvec3(),
            )
        };
        let mut places: Vec<_> = self.document.nodes().map(rest).collect();
        for Track { node, times, values } in &self.tracks {
            let place = &mut places[*node];
            match values {
                Values::Translations(values) => place.0 = blend(times, values, seconds, DVec3::lerp),
                Values::Rotations(values) => place.1 = blend(times, values, seconds, DQuat::slerp),
                Values::Scales(values) => place.2 = blend(times, values, seconds, DVec3::lerp),
            }
        }
        let mut world = vec![DMat4::NAN; places.len()];
        let roots = self.document.default_scene().unwrap().nodes();
        let mut open: Vec<_> = roots.map(|node| (node, DMat4::IDENTITY)).collect();
        while let Some((node, parent)) = open.pop() {
            let (t, r, s) = places[node.index()];
            world[node.index()] = parent * DMat4::from_scale_rotation_translation(s, r, t);
            open.extend(node.children().map(|child| (child, world[node.index()])));
        }
        world
    }
}

impl Track {
    fn new(channel: &gltf::animation::Channel, bin: &[u8]) -> Self {
        assert_eq!(channel.sampler().interpolation(), Interpolation::Linear);
        let reader = channel.reader(|_| Some(bin));
        let vector = |value: [f32; 3]| Vec3::from(value).as_dvec3();
        Self {
            node: channel.target().node().index(),
            times: reader.read_inputs().unwrap().collect(),
            values: match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(values) => Values::Translations(values.map(vector).collect()),
                ReadOutputs::Rotations(values) => Values::Rotations(
                    values
                        .into_f32()
                        .map(|value| Quat::from_array(value).as_dquat())
                        .collect(),
                ),
                ReadOutputs::Scales(values) => Values::Scales(values.map(vector).collect()),
                ReadOutputs::MorphTargetWeights(_) => panic!("a skeleton has no morph targets"),
            },
        }
    }
}

/// The value at `seconds`: interpolated between the two keys around it, otherwise the value of the nearest key.
fn blend<T: Copy>(times: &[f32], values: &[T], seconds: f32, mix: impl Fn(T, T, f64) -> T) -> T {
    assert_eq!(times.len(), values.len());
    let next = times.partition_point(|&time| time <= seconds);
    if next == 0 || next == times.len() {
        return values[next.saturating_sub(1)];
    }
    let share = f64::from(seconds - times[next - 1]) / f64::from(times[next] - times[next - 1]);
    mix(values[next - 1], values[next], share)
}

/// The JSON of a scene's file.
pub(crate) fn text_of(scene: &Scene) -> String {
    let document = Document::new(scene, &GltfOptions::default()).unwrap();
    String::from_utf8(document.to_text_and_bin("a.bin").unwrap().0).unwrap()
}
