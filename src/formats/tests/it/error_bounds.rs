//! Error bounds of single joints. Each joint of each written file is within its own bound, by the kinematics of this
//! module.

use mocap::compress::{ErrorBound, PackedClip};
use mocap::fbx::FbxOptions;
use mocap::glam::{DQuat, DVec3, Vec3};
use mocap::gltf::{Compression, Document, GltfOptions};
use mocap::scene::{Channel, Format, Keys, Node, Scene};
use mocap::{Code, Conversion, Importer, SkeletonMesh};

/// The bound of all other joints, in metres.
const BOUND: f64 = 0.005;
/// A joint that needs a smaller bound, and its bound.
const TIGHT: (&str, f64) = ("LeftHand", 0.0004);
/// Joints with a larger bound, beginning with the last moving joint of the chain, and their bound.
const LOOSE: (&[&str], f64) = (&["RightToeBase", "EndSite_RightToeBase"], 0.02);
/// The error in metres that single precision and the times of a file add.
const ROUNDING: f64 = 3e-6;

/// A writer of files within a bound.
#[derive(Clone, Copy, Debug)]
enum Writer {
    Gltf(Compression),
    Fbx,
    Packed,
    ReducedKeys,
}

impl Writer {
    fn all() -> Vec<Self> {
        let mut all = vec![
            Self::Gltf(Compression::None),
            Self::Gltf(Compression::Int16),
            Self::Packed,
            Self::ReducedKeys,
        ];
        if cfg!(feature = "fbx") {
            all.push(Self::Fbx);
        }
        if cfg!(feature = "meshopt") {
            all.extend([Compression::Meshopt, Compression::MeshoptKhr].map(Self::Gltf));
        }
        all
    }

    /// The file in metres, as a reader returns it, and the largest error that the writer states.
    fn write(self, scene: &Scene, bound: &ErrorBound) -> mocap::Result<(Scene, f64)> {
        let read = |bytes: &[u8], name| {
            let mut scene = Importer::new()
                .skeleton_mesh(SkeletonMesh::None)
                .read(bytes, name)
                .unwrap();
            Conversion::new().apply(&mut scene).unwrap();
            scene
        };
        Ok(match self {
            Self::Gltf(compression) => {
                let mut options = GltfOptions::default();
                (options.compression, options.error_bound) = (compression, Some(bound.clone()));
                let document = Document::new(scene, &options)?;
                let achieved = document.report().achieved.clone().unwrap();
                (read(&document.to_glb()?, "a.glb"), achieved.max_error)
            }
            Self::Fbx => {
                let options = FbxOptions::new().error_bound(Some(bound.clone()));
                let (bytes, report) = options.write(scene)?;
                (read(&bytes, "a.fbx"), report.achieved.unwrap().max_error)
            }
            Self::Packed => {
                let clip = PackedClip::encode(scene, 0, bound.clone())?;
                (read(clip.bytes(), "a.mclip"), clip.max_error())
            }
            Self::ReducedKeys => {
                let mut scene = scene.clone();
                let error = mocap::compress::reduce_keys(&mut scene, bound.clone())?;
                (scene, error)
            }
        })
    }
}

fn source() -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let mut scene = importer.import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    scene
}

/// The value at a tick: interpolated between the two keys around it, otherwise the value of the nearest key.
fn sample<T: Copy, V>(keys: &Keys<T>, tick: f64, value: impl Fn(T) -> V, mix: impl Fn(V, V, f64) -> V) -> Option<V> {
    let at = |key: usize| keys.ticks.as_ref().map_or(key as f64, |ticks| ticks[key]);
    let next = (0..keys.len()).find(|key| at(*key) > tick).unwrap_or(keys.len());
    let last = keys.len().checked_sub(1)?;
    if next == 0 || next > last {
        return Some(value(keys.values[next.min(last)]));
    }
    let fraction = (tick - at(next - 1)) / (at(next) - at(next - 1));
    Some(mix(value(keys.values[next - 1]), value(keys.values[next]), fraction))
}

/// The name and the position of every joint and end site, in double precision.
fn positions(scene: &Scene, seconds: f64) -> Vec<(&str, DVec3)> {
    let animation = &scene.animations[0];
    let tick = seconds * animation.ticks_per_second;
    let local = |node: &Node| {
        let (_, rotation, translation) = node.transform.as_dmat4().to_scale_rotation_translation();
        let is_of_node = |channel: &&Channel| channel.node_name == node.name;
        let channel = animation.channels.iter().find(is_of_node);
        let moved = channel.and_then(|channel| sample(&channel.position_keys, tick, Vec3::as_dvec3, DVec3::lerp));
        let turned = channel
            .and_then(|channel| sample(&channel.rotation_keys, tick, |q| q.as_dquat().normalize(), DQuat::slerp));
        (moved.unwrap_or(translation), turned.unwrap_or(rotation))
    };
    let mut world: Vec<(DVec3, DQuat)> = Vec::new();
    for node in &scene.nodes {
        let (translation, rotation) = local(node);
        let parent = node.parent.map(|parent| world[parent.index()]);
        let (position, above) = parent.unwrap_or((DVec3::ZERO, DQuat::IDENTITY));
        world.push((position + above * translation, above * rotation));
    }
    let names = scene.nodes.iter().map(|node| node.name.as_str());
    names.zip(world.into_iter().map(|(position, _)| position)).collect()
}

/// The largest error of every joint and end site of the source, at any of its frames, in metres.
fn errors(source: &Scene, written: &Scene) -> Vec<(String, f64)> {
    let mut errors: Vec<(String, f64)> = Vec::new();
    for frame in 0..source.animations[0].frame_count() {
        let seconds = frame as f64 / source.animations[0].ticks_per_second;
        let (expected, found) = (positions(source, seconds), positions(written, seconds));
        errors.resize(expected.len(), Default::default());
        for ((name, position), error) in expected.into_iter().zip(&mut errors) {
            let (_, found) = found.iter().find(|(other, _)| *other == name).unwrap();
            *error = (name.to_owned(), error.1.max(found.distance(position)));
        }
    }
    errors
}

fn of(errors: &[(String, f64)], name: &str) -> f64 {
    errors.iter().find(|(other, _)| other == name).unwrap().1
}

#[test]
fn every_joint_keeps_its_own_bound_in_every_format() {
    let source = source();
    let plain = ErrorBound::new(BOUND);
    let tight = plain.clone().joint(TIGHT.0, TIGHT.1);
    let loose = LOOSE
        .0
        .iter()
        .fold(plain.clone(), |bound, name| bound.joint(*name, LOOSE.1));
    let both = LOOSE
        .0
        .iter()
        .fold(tight.clone(), |bound, name| bound.joint(*name, LOOSE.1));
    for writer in Writer::all() {
        let errors = |bound: &ErrorBound| {
            let (written, said) = writer.write(&source, bound).unwrap();
            let errors = errors(&source, &written);
            for (name, error) in &errors {
                let most = bound.of_joint(name) + ROUNDING;
                assert!(*error <= most, "{writer:?}, {name}: {error} m of at most {most} m");
                assert!(
                    *error <= said + ROUNDING,
                    "{writer:?}, {name}: {error} m, and {said} m are said"
                );
            }
            errors
        };
        // Without their own bounds, these joints have a larger error.
        let plain = errors(&plain);
        assert!(of(&plain, TIGHT.0) > 2.0 * TIGHT.1, "{writer:?}: {plain:?}");
        errors(&tight);
        let of_loose = errors(&loose);
        let largest = LOOSE.0.iter().map(|name| of(&of_loose, name)).fold(0.0, f64::max);
        assert!(largest > 1.2 * BOUND, "{writer:?}: {largest}");
        errors(&both);
    }
}

#[test]
fn a_vrm_animation_keeps_the_bound_of_a_joint() {
    let source = source();
    let error = |bound: ErrorBound| {
        let mut options = mocap::gltf::vrma::VrmaOptions::default();
        options.gltf.error_bound = Some(bound);
        let (bytes, report) = options.write(&source).unwrap();
        let written = Importer::new().format(Format::Vrma).read(&bytes, "a.vrma").unwrap();
        let exact = mocap::gltf::vrma::VrmaOptions::default().write(&source).unwrap();
        let exact = Importer::new().format(Format::Vrma).read(&exact.0, "a.vrma").unwrap();
        assert!(report.achieved.is_some());
        of(&errors(&exact, &written), TIGHT.0)
    };
    let (without, with) = (
        error(ErrorBound::new(0.02)),
        error(ErrorBound::new(0.02).joint(TIGHT.0, TIGHT.1)),
    );
    assert!(without > 2.0 * TIGHT.1 && with <= TIGHT.1, "{without}, {with}");
}

#[test]
fn what_is_wrong_with_a_bound_of_a_joint_is_said() {
    let source = source();
    for writer in Writer::all() {
        let refused = |bound: ErrorBound| {
            let error = writer.write(&source, &bound).unwrap_err();
            assert_eq!(error.code(), Code::InvalidValue, "{writer:?}: {error}");
            error.to_string()
        };
        let message = refused(ErrorBound::new(0.001).joint("LeftPaw", 0.01));
        assert!(
            message.contains("the joint \"LeftPaw\", which does not exist"),
            "{message}"
        );
        for bound in [0.0, -0.001, f64::NAN, f64::INFINITY] {
            let message = refused(ErrorBound::new(0.001).joint("LeftHand", bound));
            assert!(
                message.contains("LeftHand") && message.contains(&bound.to_string()),
                "{message}"
            );
        }
        refused(ErrorBound::new(0.0).joint("LeftHand", 0.01));
    }
    // If a bound cannot be kept, the error names the joint and its own bound.
    let bound = ErrorBound::new(1.0).joint("LeftHand", 1e-12);
    let error = Writer::Packed.write(&source, &bound).unwrap_err();
    assert_eq!(error.code(), Code::ErrorBound);
    assert!(error.to_string().contains("LeftHand"), "{error}");
}
