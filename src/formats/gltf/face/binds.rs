//! The effects of a character's expressions.

use std::collections::BTreeMap;

use serde_json::Value;

use mocap_scene::scene::{Face, face_shape};

/// The look expressions, in the order of their weights.
const LOOKS: [&str; 4] = ["lookUp", "lookDown", "lookLeft", "lookRight"];

/// The names of the look expressions in VRM 0.
const LOOKS_OF_VRM0: [(&str, &str); 4] = [
    ("lookup", LOOKS[0]),
    ("lookdown", LOOKS[1]),
    ("lookleft", LOOKS[2]),
    ("lookright", LOOKS[3]),
];

/// The groups of expressions that an expression can override: the property's name, and the expressions.
const OVERRIDES: [(&str, &[&str]); 3] = [
    ("overrideBlink", &["blink", "blinkLeft", "blinkRight"]),
    ("overrideLookAt", &LOOKS),
    ("overrideMouth", &["aa", "ih", "ou", "ee", "oh"]),
];

/// How strongly an expression overrides others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Override {
    #[default]
    No,
    /// In proportion to the weight of the overriding expression.
    Blend,
    /// Completely, whatever the weight of the overriding expression.
    Block,
}

impl Override {
    fn amount(self, weight: f32) -> f32 {
        match self {
            Self::No => 0.0,
            Self::Blend => weight,
            Self::Block => f32::from(weight > 0.0),
        }
    }
}

/// A morph target that an expression moves, with the weight of the target when the expression has weight 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct MorphBind {
    /// The index of the node in the file.
    pub(super) node: usize,
    pub(super) target: usize,
    pub(super) weight: f32,
}

#[derive(Clone, Debug)]
pub(super) struct Expression {
    /// The name of the expression in VRM 1.0.
    name: String,
    is_preset: bool,
    /// The look direction, as an index into the look weights.
    pub(super) look: Option<usize>,
    is_binary: bool,
    overrides: [Override; OVERRIDES.len()],
    pub(super) binds: Vec<MorphBind>,
    /// Whether the expression also changes materials.
    pub(super) has_more: bool,
}

impl Expression {
    /// Whether this is the expression that a VRM animation names. VRM 0 lacks some presets.
    pub(super) fn is_of(&self, face: &Face) -> bool {
        match face {
            Face::Preset(name) if self.is_preset => self.name == *name,
            Face::Preset(name) => self.name.eq_ignore_ascii_case(name),
            Face::Custom(name) => {
                let shape = face_shape(name);
                !self.is_preset && (self.name == *name || shape.is_some() && shape == face_shape(&self.name))
            }
            Face::LookAt { .. } => false,
        }
    }

    /// An expression that only moves the morph targets of a shape.
    pub(super) fn of_shape(name: &str, binds: Vec<MorphBind>) -> Self {
        Self {
            name: name.to_owned(),
            is_preset: false,
            look: None,
            is_binary: false,
            overrides: Default::default(),
            binds,
            has_more: false,
        }
    }

    /// The effective weight of the expression for the weight `said`. A binary expression has weight 0 or 1.
    pub(super) fn weight(&self, said: f32) -> f32 {
        let weight = said.clamp(0.0, 1.0);
        match self.is_binary {
            true => f32::from(weight > 0.5),
            false => weight,
        }
    }
}

/// Reduces the expressions that others override.
pub(super) fn override_weights(expressions: &[Expression], weights: &mut [f32]) {
    for (slot, (_, held)) in OVERRIDES.iter().enumerate() {
        let amount = |(own, weight): (&Expression, &f32)| own.overrides[slot].amount(*weight);
        let amount: f32 = std::iter::zip(expressions, &*weights).map(amount).sum();
        let is_held = |own: &Expression| own.is_preset && held.contains(&own.name.as_str());
        for (own, weight) in std::iter::zip(expressions, &mut *weights).filter(|(own, _)| is_held(own)) {
            // An expression does not override itself.
            let others = amount - own.overrides[slot].amount(*weight);
            *weight *= (1.0 - others).clamp(0.0, 1.0);
        }
    }
}

/// The rest weights of every node whose mesh has morph targets.
pub(in super::super) fn morph_targets(root: &Value) -> BTreeMap<usize, Vec<f32>> {
    let nodes = root["nodes"].as_array().into_iter().flatten().enumerate();
    let weights = |(index, node): (usize, &Value)| {
        let mesh = &root["meshes"][index_of(&node["mesh"])?];
        let count = mesh["primitives"][0]["targets"].as_array()?.len();
        let own = |value: &Value| -> Option<Vec<f32>> { serde_json::from_value(value.clone()).ok() };
        let stated = own(&node["weights"]).or_else(|| own(&mesh["weights"]));
        let stated = stated.filter(|weights| weights.len() == count);
        (count > 0).then(|| (index, stated.unwrap_or_else(|| vec![0.0; count])))
    };
    nodes.filter_map(weights).collect()
}

/// The names of the morph targets of a node's mesh: from the mesh, or from a primitive as UniVRM writes them.
pub(in super::super) fn names_of_targets(root: &Value, node: usize) -> impl Iterator<Item = &Value> {
    let mesh = index_of(&root["nodes"][node]["mesh"]).map(|mesh| &root["meshes"][mesh]);
    let names = mesh.and_then(|mesh| {
        let own = mesh["extras"]["targetNames"].as_array();
        own.or_else(|| mesh["primitives"][0]["extras"]["targetNames"].as_array())
    });
    names.into_iter().flatten()
}

/// The expressions of a VRM file.
pub(super) fn expressions(root: &Value, targets: &BTreeMap<usize, Vec<f32>>) -> Vec<Expression> {
    let of_vrm1 = &root["extensions"]["VRMC_vrm"]["expressions"];
    let of_kind = |kind: &'static str| {
        let all = of_vrm1[kind].as_object().into_iter().flatten();
        all.map(move |(name, value)| of_vrm1_expression(name, kind == "preset", value))
    };
    let of_vrm0 = root["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"].as_array();
    let of_vrm0 = of_vrm0.into_iter().flatten().map(|group| of_vrm0_group(root, group));
    let mut all: Vec<Expression> = of_kind("preset").chain(of_kind("custom")).chain(of_vrm0).collect();
    let exists = |bind: &MorphBind| targets.get(&bind.node).is_some_and(|all| bind.target < all.len());
    all.iter_mut().for_each(|own| own.binds.retain(exists));
    all
}

fn of_vrm1_expression(name: &str, is_preset: bool, value: &Value) -> Expression {
    let binds = value["morphTargetBinds"].as_array().into_iter().flatten();
    let bind = |bind: &Value| {
        Some(MorphBind {
            node: index_of(&bind["node"])?,
            target: index_of(&bind["index"])?,
            weight: number(&bind["weight"]),
        })
    };
    let has = |list: &str| value[list].as_array().is_some_and(|list| !list.is_empty());
    Expression {
        look: is_preset.then(|| LOOKS.iter().position(|look| *look == name)).flatten(),
        name: name.to_owned(),
        is_preset,
        is_binary: value["isBinary"] == true,
        overrides: OVERRIDES.map(|(property, _)| match value[property].as_str() {
            Some("block") => Override::Block,
            Some("blend") => Override::Blend,
            _ => Override::No,
        }),
        binds: binds.filter_map(bind).collect(),
        has_more: has("materialColorBinds") || has("textureTransformBinds"),
    }
}

/// In VRM 0 the morph targets belong to a mesh, and weights are in percent.
fn of_vrm0_group(root: &Value, group: &Value) -> Expression {
    let preset = group["presetName"].as_str().unwrap_or_default();
    let mut names = Face::OF_VRM0.iter().chain(&LOOKS_OF_VRM0);
    let preset = names.find(|(old, _)| *old == preset).map(|(_, name)| *name);
    let nodes_of = |mesh: usize| {
        let nodes = root["nodes"].as_array().into_iter().flatten().enumerate();
        nodes
            .filter(move |(_, node)| index_of(&node["mesh"]) == Some(mesh))
            .map(|(node, _)| node)
    };
    let mut binds = Vec::new();
    for bind in group["binds"].as_array().into_iter().flatten() {
        if let (Some(mesh), Some(target)) = (index_of(&bind["mesh"]), index_of(&bind["index"])) {
            let weight = number(&bind["weight"]) / 100.0;
            binds.extend(nodes_of(mesh).map(|node| MorphBind { node, target, weight }));
        }
    }
    Expression {
        name: preset.or_else(|| group["name"].as_str()).unwrap_or_default().to_owned(),
        is_preset: preset.is_some(),
        look: preset.and_then(|preset| LOOKS.iter().position(|look| *look == preset)),
        is_binary: group["isBinary"] == true,
        overrides: Default::default(),
        binds,
        has_more: group["materialValues"]
            .as_array()
            .is_some_and(|values| !values.is_empty()),
    }
}

pub(super) fn index_of(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// A finite number, or 0.
pub(super) fn number(value: &Value) -> f32 {
    let number = value.as_f64().unwrap_or_default() as f32;
    if number.is_finite() { number } else { 0.0 }
}
