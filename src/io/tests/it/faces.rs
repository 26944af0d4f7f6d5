//! Curves of morph targets through readers, steps and writers. The weights of the fixtures are known: the weight of
//! `arm_and_face.gltf` and `smile` of `face_alone.gltf` equal the time in seconds. `frown` falls from 1 to 0.25 at 0.5
//! s, and to 0 at 1 s. The crate `gltf` reads the outputs independently.

use mocap::edit::{Blend, BlendWeight, Concat, Loop, Resample, Reverse, Step, StepInput, Trim, Warp};
use mocap::glam::Vec3;
use mocap::scene::MorphTarget;
use mocap::scene::report::DataKind;
use mocap::{Clips, Code, Exporter, Format, Importer, Pose, Scene};

const ARM: &str = "../../fixtures/made/arm_and_face.gltf";
const FACE: &str = "../../fixtures/made/face_alone.gltf";

fn import(path: &str) -> Scene {
    Importer::new().import(path).unwrap()
}

/// The weights of the face's targets in an animation of the written file, at a time in seconds.
struct Written {
    times: Vec<f32>,
    weights: Vec<Vec<f32>>,
}

impl Written {
    fn of(scene: &Scene, animation: usize) -> Self {
        Self::of_node(scene, animation, Some("face"))
    }

    /// The channels of the node with a name, or of the first node.
    fn of_node(scene: &Scene, animation: usize, name: Option<&str>) -> Self {
        let written = Exporter::new().write(scene, Format::Gltf).unwrap();
        assert!(written.warnings.is_empty(), "{:?}", written.warnings);
        let file = gltf::Gltf::from_slice(&written.into_bytes().unwrap()).unwrap();
        let buffers: Vec<Vec<u8>> = file.buffers().map(|buffer| contents(&file, &buffer)).collect();
        let clip = file.animations().nth(animation).unwrap();
        let is_it = |channel: &gltf::animation::Channel<'_>| {
            let target = channel.target();
            let is_named = name.is_none() || target.node().name() == name;
            target.property() == gltf::animation::Property::MorphTargetWeights && is_named
        };
        let mut channels = clip.channels().filter(is_it);
        let channel = channels.next().expect("a channel of the face");
        let reader = channel.reader(|buffer| Some(&buffers[buffer.index()]));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else {
            panic!("no weights");
        };
        let weights: Vec<f32> = weights.into_f32().collect();
        let columns = weights.len() / times.len();
        Self {
            weights: weights.chunks(columns).map(<[f32]>::to_vec).collect(),
            times,
        }
    }

    /// Every sampler of an output has LINEAR interpolation.
    fn at(&self, seconds: f32, target: usize) -> f32 {
        let after = self.times.partition_point(|time| *time <= seconds);
        let weight = |key: usize| self.weights[key][target];
        match (after.checked_sub(1), after < self.times.len()) {
            (None, _) => weight(0),
            (Some(before), false) => weight(before),
            (Some(before), true) => {
                let part = (seconds - self.times[before]) / (self.times[after] - self.times[before]);
                weight(before) + part * (weight(after) - weight(before))
            }
        }
    }

    #[track_caller]
    fn assert_is(&self, what: &str, expected: &[(f32, &[f32])]) {
        for (seconds, weights) in expected {
            for (target, weight) in weights.iter().enumerate() {
                let found = self.at(*seconds, target);
                assert!(
                    (found - weight).abs() < 2e-4,
                    "{what}, {seconds} s: {found}, not {weight}"
                );
            }
        }
    }
}

fn contents(file: &gltf::Gltf, buffer: &gltf::Buffer<'_>) -> Vec<u8> {
    use base64::Engine;
    match buffer.source() {
        gltf::buffer::Source::Bin => file.blob.clone().unwrap(),
        gltf::buffer::Source::Uri(uri) => {
            let (_, data) = uri.split_once(',').unwrap();
            base64::engine::general_purpose::STANDARD.decode(data).unwrap()
        }
    }
}

#[test]
fn curves_of_morph_targets_are_written_as_they_were_read() {
    let arm = import(ARM);
    assert_eq!(arm.warnings, []);
    Written::of(&arm, 0).assert_is("arm", &[(0.0, &[0.0]), (0.25, &[0.25]), (1.0, &[1.0])]);
    let face = import(FACE);
    assert_eq!(face.warnings, []);
    assert_eq!(
        (
            face.animations[0].frame_count(),
            face.animations[0].ticks_per_second.round()
        ),
        (31, 30.0)
    );
    let even: [(f32, &[f32]); 4] = [
        (0.0, &[0.0, 1.0]),
        (0.25, &[0.25, 0.625]),
        (0.5, &[0.5, 0.25]),
        (1.0, &[1.0, 0.0]),
    ];
    Written::of(&face, 0).assert_is("even", &even);
    let stepped: [(f32, &[f32]); 4] = [
        (0.0, &[0.0, 0.0]),
        (0.49, &[0.0, 0.0]),
        (0.51, &[1.0, 0.0]),
        (1.0, &[0.0, 1.0]),
    ];
    Written::of(&face, 1).assert_is("stepped", &stepped);
    let second = Importer::new().clips(Clips::Index(1)).import(FACE).unwrap();
    Written::of(&second, 0).assert_is("the second clip", &stepped);
}

#[test]
fn curves_of_morph_targets_go_with_the_time() {
    let after = |change: &dyn Fn(&mut Scene)| {
        let mut scene = import(ARM);
        change(&mut scene);
        Written::of(&scene, 0)
    };
    let input = StepInput::new;
    let trim = |scene: &mut Scene| {
        Trim::new()
            .range("0.2..0.8".parse().unwrap())
            .apply(scene, &input())
            .unwrap();
    };
    after(&trim).assert_is("trim", &[(0.0, &[0.2]), (0.3, &[0.5]), (0.6, &[0.8])]);
    let resample = |scene: &mut Scene| {
        Resample::new().rate(10.0).apply(scene, &input()).unwrap();
    };
    after(&resample).assert_is("resample", &[(0.0, &[0.0]), (0.3, &[0.3]), (1.0, &[1.0])]);
    let reverse = |scene: &mut Scene| {
        Reverse::new().apply(scene, &input()).unwrap();
    };
    after(&reverse).assert_is("reverse", &[(0.0, &[1.0]), (0.3, &[0.7]), (1.0, &[0.0])]);
    let slower = |scene: &mut Scene| {
        Warp::Moments(vec![(0.5, 1.5)]).apply(scene, &input()).unwrap();
    };
    after(&slower).assert_is("warp", &[(0.0, &[0.0]), (0.75, &[0.25]), (1.5, &[0.5]), (2.0, &[1.0])]);
    let faster = |scene: &mut Scene| {
        Warp::Speed(2.0).apply(scene, &input()).unwrap();
    };
    after(&faster).assert_is("speed", &[(0.0, &[0.0]), (0.25, &[0.5]), (0.5, &[1.0])]);
    let looped = |scene: &mut Scene| {
        Loop::new()
            .frames(Some([6, 24]))
            .blend(0.3)
            .apply(scene, &input())
            .unwrap();
    };
    // The end equals the start. After half of the blend, half of the difference of 0.6 remains.
    after(&looped).assert_is("loop", &[(0.0, &[0.8]), (0.15, &[0.65]), (0.3, &[0.5]), (0.6, &[0.8])]);
    let joined = |scene: &mut Scene| {
        let again = scene.clone();
        Concat::new().blend(0.2).apply(scene, &input().other(&again)).unwrap();
    };
    after(&joined).assert_is(
        "concat",
        &[
            (0.5, &[0.5]),
            (1.0, &[1.0]),
            (1.1, &[0.6]),
            (1.2, &[0.2]),
            (2.0, &[1.0]),
        ],
    );
    let mixed = |scene: &mut Scene| {
        let mut half = scene.clone();
        for keys in half.weight_keys().flatten() {
            keys.values.iter_mut().for_each(|weight| *weight *= 0.5);
        }
        let blend = Blend::new().weight(BlendWeight::Constant(0.5));
        blend.apply(scene, &input().other(&half)).unwrap();
    };
    after(&mixed).assert_is("blend", &[(0.0, &[0.0]), (0.4, &[0.3]), (1.0, &[0.75])]);
    let posed = |scene: &mut Scene| mocap_scene::process::put_first(scene, 0, &Pose::rest(scene));
    after(&posed).assert_is("a pose first", &[(0.0, &[0.0]), (0.5 + 1.0 / 30.0, &[0.5])]);
    let slow = Importer::new().retime(15.0).import(ARM).unwrap();
    Written::of(&slow, 0).assert_is("another rate", &[(0.0, &[0.0]), (1.0, &[0.5]), (2.0, &[1.0])]);
}

/// The curves of another face on the same skeleton cannot be used.
#[test]
fn curves_of_another_face_are_counted() {
    let (mut arm, mut other) = (import(ARM), import(ARM));
    let curves = &mut other.original.as_mut().unwrap().morphs[0];
    curves.targets.push(curves.targets[0].clone());
    curves.at_rest.push(0.0);
    Concat::new()
        .blend(0.0)
        .apply(&mut arm, &StepInput::new().other(&other))
        .unwrap();
    let warning = arm.warnings.last().unwrap();
    assert!(warning.message.ends_with("dropped curves: 2"), "{warning}");
    arm.warnings.clear();
    Written::of(&arm, 0).assert_is("concat", &[(0.5, &[0.5]), (1.0, &[1.0]), (1.5, &[0.0])]);
}

/// The known weights of a fixture: for each clip, some times in seconds with the weight of each target.
type Stated<'a> = &'a [&'a [(f64, &'a [f32])]];

const OF_ARM: Stated<'_> = &[&[(0.0, &[0.0]), (0.5, &[0.5]), (1.0, &[1.0])]];
const OF_FACE: Stated<'_> = &[
    &[
        (0.0, &[0.0, 1.0]),
        (0.25, &[0.25, 0.625]),
        (0.5, &[0.5, 0.25]),
        (1.0, &[1.0, 0.0]),
    ],
    &[
        (0.0, &[0.0, 0.0]),
        (0.4, &[0.0, 0.0]),
        (0.6, &[1.0, 0.0]),
        (1.0, &[0.0, 1.0]),
    ],
];

fn with_targets(path: &str) -> Scene {
    let importer = Importer::new().gltf_meshes(true).morph_targets(true);
    importer.import(path).unwrap()
}

/// ufbx evaluates the curves of the written file.
#[test]
fn fbx_keeps_morph_targets_and_their_curves() {
    for (path, stated) in [(ARM, OF_ARM), (FACE, OF_FACE)] {
        let scene = with_targets(path);
        let written = Exporter::new().write(&scene, Format::Fbx).unwrap();
        assert_eq!(written.losses, [], "{path}");
        let importer = Importer::new().morph_targets(true);
        let again = importer.read(&written.into_bytes().unwrap(), "face.fbx").unwrap();
        assert_eq!(again.validate(), []);
        let targets = |scene: &Scene| -> Vec<_> {
            let targets = scene.meshes.iter().flat_map(|mesh| mesh.morph_targets.clone());
            targets.collect()
        };
        let (before, after) = (targets(&scene), targets(&again));
        assert_eq!(before.len(), after.len(), "{path}");
        for (target, (before, after)) in std::iter::zip(&before, &after).enumerate() {
            assert_eq!(before.name, after.name);
            let moved = |target: &MorphTarget| target.offsets.iter().copied().sum::<Vec3>();
            assert!(moved(before).distance(moved(after)) < 1e-5, "{path}");
            for (clip, stated) in stated.iter().enumerate() {
                for (seconds, weights) in *stated {
                    let tick = seconds * again.animations[clip].ticks_per_second;
                    let found = after.weight_keys[clip].sample(tick).unwrap_or(after.weight);
                    let far = (found - weights[target]).abs();
                    assert!(far < 1e-3, "{path}, clip {clip}, {seconds} s: {found}");
                }
            }
        }
    }
}

/// The writer makes a new FBX file, with the mesh, its targets and their curves.
#[test]
fn morph_targets_go_from_fbx_to_gltf() {
    let fbx = Exporter::new().write(&with_targets(FACE), Format::Fbx).unwrap();
    let importer = Importer::new().morph_targets(true);
    let scene = importer.read(&fbx.into_bytes().unwrap(), "face.fbx").unwrap();
    let written = Exporter::new().write(&scene, Format::Gltf).unwrap();
    assert_eq!(written.losses, []);
    let file = gltf::Gltf::from_slice(&written.into_bytes().unwrap()).unwrap();
    let mesh = file.meshes().next().unwrap();
    assert_eq!(mesh.weights(), Some(&[0.0, 0.5][..]));
    let targets = mesh.primitives().map(|primitive| primitive.morph_targets().count());
    assert_eq!(targets.collect::<Vec<_>>(), [2]);
    for (clip, stated) in OF_FACE.iter().enumerate() {
        let found = Written::of_node(&scene, clip, None);
        for (seconds, weights) in *stated {
            for (target, weight) in weights.iter().enumerate() {
                let far = (found.at(*seconds as f32, target) - weight).abs();
                assert!(far < 1e-3, "clip {clip}, {seconds} s");
            }
        }
    }
}

/// For a mesh with a rest weight above 0, the writer subtracts the weighted offsets from the vertices, because readers
/// add them again.
#[test]
fn weights_at_rest_are_no_part_of_the_written_mesh() {
    let mut scene = with_targets(FACE);
    scene.original = None;
    let moved = scene.meshes[0].morph_targets[0].vertex_ids[0] as usize;
    let offset = scene.meshes[0].morph_targets[0].offsets[0];
    let plain = scene.meshes[0].vertices[moved];
    for target in &mut scene.meshes[0].morph_targets {
        target.weight_keys.clear();
    }
    scene.meshes[0].morph_targets[0].weight = 0.5;
    scene.meshes[0].vertices[moved] += 0.5 * offset;
    let written = Exporter::new()
        .write(&scene, Format::Fbx)
        .unwrap()
        .into_bytes()
        .unwrap();
    let near = |scene: &Scene, expected: Vec3| {
        let vertices = scene.meshes[0].vertices.iter();
        vertices
            .map(|vertex| vertex.distance(expected))
            .fold(f32::MAX, f32::min)
            < 1e-5
    };
    let read = |targets: bool| {
        Importer::new()
            .morph_targets(targets)
            .read(&written, "face.fbx")
            .unwrap()
    };
    let (with, without) = (read(true), read(false));
    assert!(near(&without, plain) && near(&with, plain + 0.5 * offset));
    assert_eq!(with.meshes[0].morph_targets[0].weight, 0.5);
}

/// The weights of an animation in the text of a file: for each time code, the weight of each shape.
fn blend_shape_weights(text: &str, clip: usize) -> Vec<(f64, Vec<f32>)> {
    let mut clips = text.split("float[] blendShapeWeights.timeSamples = {").skip(1);
    let samples = clips.nth(clip).unwrap().split('}').next().unwrap();
    let sample = |line: &str| {
        let (time, weights) = line.trim().trim_end_matches(',').split_once(": [")?;
        let weights = weights
            .trim_end_matches(']')
            .split(", ")
            .map(|weight| weight.parse().unwrap());
        Some((time.parse().unwrap(), weights.collect()))
    };
    samples.lines().filter_map(sample).collect()
}

#[test]
fn usd_keeps_morph_targets_and_their_curves() {
    for (path, stated) in [(ARM, OF_ARM), (FACE, OF_FACE)] {
        let scene = with_targets(path);
        let written = Exporter::new().write(&scene, Format::Usd).unwrap();
        assert_eq!(written.losses, [], "{path}");
        let bytes = written.into_bytes().unwrap();
        let text = std::str::from_utf8(&bytes).unwrap();
        let names: Vec<String> = scene.meshes[0]
            .morph_targets
            .iter()
            .map(|target| format!("{:?}", target.name))
            .collect();
        let names = names.join(", ");
        for attribute in ["skel:blendShapes", "blendShapes"] {
            assert!(
                text.contains(&format!("uniform token[] {attribute} = [{names}]")),
                "{text}"
            );
        }
        let rate = scene.animations[0].ticks_per_second;
        for (clip, stated) in stated.iter().enumerate() {
            let samples = blend_shape_weights(text, clip);
            for (seconds, weights) in *stated {
                let code = seconds * rate;
                let after = samples.iter().position(|(time, _)| *time >= code - 1e-6);
                let after = after.unwrap_or(samples.len() - 1);
                let before = after.saturating_sub(1);
                let ((from, first), (to, last)) = (&samples[before], &samples[after]);
                let part = if to > from {
                    ((code - from) / (to - from)) as f32
                } else {
                    0.0
                };
                for (target, weight) in weights.iter().enumerate() {
                    let found = first[target] + part * (last[target] - first[target]);
                    assert!(
                        (found - weight).abs() < 1e-3,
                        "{path}, clip {clip}, {seconds} s: {found}"
                    );
                }
            }
        }
        // A reader that skips the targets reports it.
        let again = Importer::new().read(&bytes, "face.usda").unwrap();
        let curves = again
            .metadata
            .lost
            .iter()
            .find(|loss| loss.kind == DataKind::FaceCurves);
        assert_eq!(
            curves.map(|loss| loss.count),
            Some(scene.meshes[0].morph_targets.len() as u64)
        );
        let again = Importer::new().morph_targets(true).read(&bytes, "face.usda").unwrap();
        assert_eq!(again.metadata.lost, []);
        for (before, after) in std::iter::zip(&scene.meshes[0].morph_targets, &again.meshes[0].morph_targets) {
            assert_eq!((&after.name, &after.vertex_ids), (&before.name, &before.vertex_ids));
            assert_eq!(
                (&after.offsets, &after.normal_offsets),
                (&before.offsets, &before.normal_offsets)
            );
        }
        for (clip, stated) in stated.iter().enumerate() {
            for (seconds, weights) in *stated {
                for (target, weight) in std::iter::zip(&again.meshes[0].morph_targets, *weights) {
                    let keys = &target.weight_keys[clip];
                    let found = keys.sample(seconds * again.animations[clip].ticks_per_second);
                    let far = (found.unwrap_or(target.weight) - weight).abs();
                    assert!(far < 1e-3, "{path}, clip {clip}, {seconds} s");
                }
            }
        }
    }
}

#[test]
fn a_clip_of_a_face_alone_is_said() {
    for (scene, count) in [(import(FACE), Some(2)), (import(ARM), None)] {
        let alone = scene.face_curves_alone(0);
        assert_eq!(alone.map(|curves| curves.count), count);
    }
}

#[test]
fn formats_without_curves_of_morph_targets_say_so() {
    let (arm, face) = (import(ARM), import(FACE));
    for format in [Format::Bvh, Format::Mclip] {
        let written = Exporter::new().write(&arm, format).unwrap();
        let lost = written
            .warnings
            .iter()
            .find(|warning| warning.code == Code::NotCarriedOver && warning.message.contains("face curve"));
        assert!(
            lost.unwrap().message.starts_with("1 face curve is not in the output"),
            "{:?}",
            written.warnings
        );
        // With meshes, the scene has the same curves.
        let with_meshes = Importer::new()
            .gltf_meshes(true)
            .morph_targets(true)
            .import(FACE)
            .unwrap();
        for face in [&face, &with_meshes] {
            let refused = Exporter::new().write(face, format).unwrap_err();
            assert_eq!(refused.code(), Code::Unrepresentable);
            assert!(
                refused.to_string().contains("the output would have no motion")
                    && refused.to_string().contains("4 face curves"),
                "{refused}"
            );
        }
    }
}

#[test]
fn curves_of_morph_targets_that_are_not_valid_are_left_out() {
    let text = std::fs::read_to_string(FACE).unwrap();
    // Corrupt the sampler: its weights are its times, three numbers for three keys of two targets.
    let wrong = text.replacen("\"output\": 5", "\"output\": 4", 1);
    assert!(wrong != text);
    let scene = Importer::new().read(wrong.as_bytes(), "face.gltf").unwrap();
    let said: Vec<_> = scene.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert!(said[0].starts_with("morph target curves were dropped: "), "{said:?}");
}
