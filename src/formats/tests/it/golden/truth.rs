//! Reads Assimp's results from `fixtures/assimp`.

use serde::Deserialize;

/// The post-processing that Assimp applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Flags {
    None,
    MaxQualityDebone,
}

impl Flags {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::MaxQualityDebone => "MaxQuality+Debone",
        }
    }
}

/// A scene as Assimp returned it.
#[derive(Deserialize)]
pub(crate) struct Truth {
    pub(crate) nodes: Vec<TruthNode>,
    pub(crate) meshes: Vec<TruthMesh>,
    pub(crate) materials: Vec<serde_json::Value>,
    pub(crate) animations: Vec<TruthAnimation>,
}

#[derive(Deserialize)]
pub(crate) struct TruthNode {
    pub(crate) name: String,
    pub(crate) parent: Option<String>,
    pub(crate) matrix: [f64; 16],
    pub(crate) meshes: Vec<usize>,
}

#[derive(Deserialize)]
pub(crate) struct TruthMesh {
    pub(crate) name: String,
    pub(crate) material: usize,
    pub(crate) primitive_types: u32,
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) normals: Vec<[f64; 3]>,
    pub(crate) faces: Vec<Vec<u32>>,
    pub(crate) bones: Vec<TruthBone>,
}

#[derive(Deserialize)]
pub(crate) struct TruthBone {
    pub(crate) name: String,
    pub(crate) offset: [f64; 16],
    pub(crate) weights: Vec<(u32, f64)>,
}

#[derive(Deserialize)]
pub(crate) struct TruthAnimation {
    pub(crate) name: String,
    pub(crate) ticks_per_second: f64,
    pub(crate) duration: f64,
    pub(crate) channels: Vec<TruthChannel>,
}

/// Each key is a tick and a value.
#[derive(Deserialize)]
pub(crate) struct TruthChannel {
    pub(crate) node: String,
    pub(crate) pos: Vec<Vec<Number>>,
    pub(crate) rot_wxyz: Vec<Vec<Number>>,
    pub(crate) scl: Vec<Vec<Number>>,
}

/// A number, or the text `nan`.
#[derive(Deserialize)]
#[serde(untagged)]
pub(crate) enum Number {
    Finite(f64),
    NotANumber(serde::de::IgnoredAny),
}

impl Number {
    pub(crate) fn value(&self) -> f64 {
        match self {
            Self::Finite(number) => *number,
            Self::NotANumber(_) => f64::NAN,
        }
    }
}

impl Truth {
    pub(crate) fn read(file: &str, flags: Flags) -> Self {
        let name = format!("assimp/{file}.{}.json", flags.name());
        serde_json::from_slice(&fixture(&name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }
}

pub(crate) fn path(name: &str) -> String {
    format!("../../fixtures/{name}")
}

pub(crate) fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Every available result: the name of the BVH file, and the post-processing.
pub(crate) fn answers() -> Vec<(String, Flags)> {
    let mut answers = Vec::new();
    for entry in std::fs::read_dir(path("assimp")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        for flags in [Flags::None, Flags::MaxQualityDebone] {
            if let Some(file) = name.strip_suffix(&format!(".{}.json", flags.name())) {
                answers.push((file.to_owned(), flags));
            }
        }
    }
    answers.sort_by_key(|(file, flags)| (file.clone(), flags.name()));
    answers
}
