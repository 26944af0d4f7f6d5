//! Generated skeletons and motions, which the tests write as BVH text and the library reads.

use std::fmt::Write;

use crate::kinematics::{Capture, Root, distance};
use mocap::process::SkeletonMesh;
use mocap::scene::{NodeId, RootOffset};
use mocap::{Binding, Importer, Limits, Pose};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

/// A joint: its parent, its OFFSET, its channels, and the OFFSETs of its end sites.
#[derive(Clone, Debug)]
struct Joint {
    parent: Index,
    offset: [f32; 3],
    channels: Vec<&'static str>,
    end_sites: Vec<[f32; 3]>,
}

/// The contents of a file before they are text.
#[derive(Clone, Debug)]
struct File {
    joints: Vec<Joint>,
    /// Rows with more values than any file here has channels. A file uses the first values of each row.
    rows: Vec<Vec<f32>>,
}

const CHANNELS: [&str; 6] = [
    "Xposition",
    "Yposition",
    "Zposition",
    "Xrotation",
    "Yrotation",
    "Zrotation",
];
const MOST_JOINTS: usize = 12;

fn number() -> impl Strategy<Value = f32> {
    // Mostly thousandths, as in real files, and sometimes a value that needs every digit of a float.
    prop_oneof![4 => (-400_000..400_000).prop_map(|n| n as f32 / 1000.0), 1 => -400.0_f32..400.0, 1 => Just(0.0)]
}

fn offset() -> impl Strategy<Value = [f32; 3]> {
    [number(), number(), number()].prop_map(|offset| offset.map(|component| component / 10.0))
}

fn joint() -> impl Strategy<Value = Joint> {
    let channels = Just(CHANNELS.to_vec()).prop_shuffle();
    (any::<Index>(), offset(), channels, 0..=6_usize, vec(offset(), 0..=2)).prop_map(
        |(parent, offset, mut channels, count, end_sites)| {
            channels.truncate(count);
            Joint {
                parent,
                offset,
                channels,
                end_sites,
            }
        },
    )
}

fn file() -> impl Strategy<Value = File> {
    let rows = vec(vec(number(), MOST_JOINTS * CHANNELS.len()), 1..5);
    (vec(joint(), 1..=MOST_JOINTS), rows).prop_map(|(joints, rows)| File { joints, rows })
}

impl File {
    fn children(&self, joint: usize) -> impl Iterator<Item = usize> {
        // The parent of joint n is one of the joints before it.
        (joint + 1..self.joints.len()).filter(move |&child| self.joints[child].parent.index(child) == joint)
    }

    /// The file in plain spelling: each keyword and each row on a separate line.
    fn text(&self) -> String {
        let mut text = "HIERARCHY\n".to_owned();
        self.write_joint(0, &mut text);
        let width: usize = self.joints.iter().map(|joint| joint.channels.len()).sum();
        write!(text, "MOTION\nFrames: {}\nFrame Time: 0.025\n", self.rows.len()).unwrap();
        for row in &self.rows {
            let values: Vec<String> = row[..width].iter().map(f32::to_string).collect();
            writeln!(text, "{}", values.join(" ")).unwrap();
        }
        text
    }

    fn write_joint(&self, index: usize, text: &mut String) {
        let Joint {
            offset: [x, y, z],
            channels,
            end_sites,
            ..
        } = &self.joints[index];
        let keyword = if index == 0 { "ROOT" } else { "JOINT" };
        write!(text, "{keyword} joint{index}\n{{\nOFFSET {x} {y} {z}\n").unwrap();
        writeln!(text, "CHANNELS {} {}", channels.len(), channels.join(" ")).unwrap();
        for [x, y, z] in end_sites {
            write!(text, "End Site\n{{\nOFFSET {x} {y} {z}\n}}\n").unwrap();
        }
        for child in self.children(index) {
            self.write_joint(child, text);
        }
        text.push_str("}\n");
    }

    /// Whether the file has a motion. Without a channel there are no values, and so no rows.
    fn moves(&self) -> bool {
        self.joints.iter().any(|joint| !joint.channels.is_empty())
    }
}

/// The spelling of a file, as choices that are used in turn and then repeated.
#[derive(Clone, Debug)]
struct Spelling {
    choices: Vec<usize>,
    line_end: &'static str,
    wrap: bool,
}

fn spelling() -> impl Strategy<Value = Spelling> {
    (
        vec(0..1000_usize, 50),
        prop_oneof![Just("\n"), Just("\r\n"), Just("\r")],
        any::<bool>(),
    )
        .prop_map(|(choices, line_end, wrap)| Spelling {
            choices,
            line_end,
            wrap,
        })
}

impl Spelling {
    /// `plain` with another case, other blanks, other line ends, and rows that continue on the next line.
    fn apply(&self, plain: &str) -> String {
        let mut choices = self.choices.iter().copied().cycle();
        let mut choose = move |from: &[&'static str]| from[choices.next().unwrap() % from.len()];
        let mut text = String::new();
        let mut in_motion = false;
        for line in plain.lines() {
            in_motion |= line.starts_with("Frame Time:");
            let is_row = in_motion && !line.starts_with("Frame");
            text += choose(&["", " ", "\t", "    "]);
            for (index, word) in line.split(' ').enumerate() {
                if index > 0 {
                    // "Frame Time:" and "End Site" are single keywords.
                    let glued = word == "Time:" || word == "Site";
                    text += match (glued, is_row && self.wrap) {
                        (true, _) => " ",
                        (false, true) => choose(&[" ", "\t", "   ", self.line_end]),
                        (false, false) => choose(&[" ", "\t", "   "]),
                    };
                }
                let is_name = index > 0 && (line.starts_with("ROOT") || line.starts_with("JOINT"));
                text += &match choose(&["same", "lower", "upper"]) {
                    "lower" if !is_name => word.to_lowercase(),
                    "upper" if !is_name => word.to_uppercase(),
                    _ => word.to_owned(),
                };
            }
            text += choose(&["", " ", "\t"]);
            text += self.line_end;
            text += if is_row { "" } else { choose(&["", self.line_end]) };
        }
        text
    }
}

fn importer() -> Importer {
    Importer::new().skeleton_mesh(SkeletonMesh::None)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1024, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_node_stands_where_the_kinematics_puts_it(file in file(), add in any::<bool>()) {
        prop_assume!(file.moves());
        let text = file.text();
        let capture = Capture::parse(text.as_bytes());
        let (policy, root) = if add { (RootOffset::Add, Root::Add) } else { (RootOffset::Replace, Root::Replace) };
        let scene = importer().root_offset(policy).read(text.as_bytes(), "generated.bvh").unwrap();
        // Sometimes all positions are zero. The reader then adds them to the OFFSETs.
        prop_assume!(scene.metadata.assumptions.is_empty());
        prop_assert_eq!(scene.nodes.len(), capture.nodes.len());

        let animation = &scene.animations[0];
        let binding = Binding::new(&scene, animation);
        let mut pose = Pose::rest(&scene);
        for frame in 0..capture.rows.len() {
            pose.sample(&binding, animation, frame as f64);
            let placements = capture.placements(frame, root);
            // Rounding grows with the added numbers: the links of the chain, and the path of its root.
            let reach = placements.iter().flat_map(|placement| placement.position).fold(1.0, |a: f64, b| a.max(b.abs()));
            for (index, placement) in placements.iter().enumerate() {
                let position = pose.position(NodeId::new(index)).to_array().map(f64::from);
                let error = distance(position, placement.position);
                prop_assert!(error <= 1e-5 * reach, "frame {}, {}: {} of {}", frame, capture.nodes[index].name, error, reach);
            }
        }
    }

    #[test]
    fn every_scene_keeps_the_rules(file in file()) {
        for mesh in [SkeletonMesh::None, SkeletonMesh::Skinned, SkeletonMesh::Segmented] {
            for collapse in [false, true] {
                let importer = Importer::new().skeleton_mesh(mesh).collapse_keys(collapse);
                let scene = importer.read(file.text().as_bytes(), "generated.bvh").unwrap();
                prop_assert_eq!(scene.validate(), []);
            }
        }
    }

    #[test]
    fn spelling_is_not_meaning(file in file(), spelling in spelling()) {
        let plain = file.text();
        let spelled = spelling.apply(&plain);
        let read = |text: &str| {
            let mut scene = importer().read(text.as_bytes(), "generated.bvh").unwrap();
            // The bytes differ, and so do their checksum and line numbers.
            scene.metadata.origin.as_mut().unwrap().sha256.clear();
            for node in &mut scene.nodes {
                node.source = None;
            }
            scene
        };
        prop_assert_eq!(read(&spelled), read(&plain), "{}", spelled);
    }

    #[test]
    fn any_bytes_are_an_error_or_a_valid_scene(bytes in vec(any::<u8>(), 0..400)) {
        if let Ok(scene) = importer().format(mocap::Format::Bvh).read(&bytes, "generated.bvh") {
            prop_assert_eq!(scene.validate(), []);
        }
    }

    #[test]
    fn any_words_are_an_error_or_a_valid_scene(words in vec(word(), 0..60), header in any::<bool>()) {
        let text = format!("{}{}", if header { "HIERARCHY ROOT a { OFFSET 0 1 0 " } else { "" }, words.join(" "));
        let limits = Limits::new().max_values(10_000);
        if let Ok(scene) = Importer::new().limits(limits).format(mocap::Format::Bvh).read(text.as_bytes(), "generated.bvh") {
            prop_assert_eq!(scene.validate(), []);
        }
    }
}

/// A word of the format, or a number.
fn word() -> impl Strategy<Value = String> {
    const WORDS: [&str; 26] = [
        "HIERARCHY",
        "ROOT a",
        "JOINT b",
        "End Site",
        "{",
        "{",
        "{",
        "}",
        "}",
        "}",
        "OFFSET",
        "OFFSET 1 2 3",
        "CHANNELS",
        "CHANNELS 3 Zrotation Xrotation Yrotation",
        "CHANNELS 1 Xposition",
        "MOTION",
        "Frames:",
        "Frame Time:",
        "0.1",
        "Xscale",
        "nan",
        "1e40",
        "\n",
        "\n",
        "#",
        "4000000000",
    ];
    prop_oneof![3 => proptest::sample::select(&WORDS[..]).prop_map(str::to_owned), 1 => number().prop_map(|n| n.to_string())]
}
