//! The body that the caller gives for arrays of rotations: a model of the SMPL family from a file, or the bones of any
//! figure. For arrays of a robot's joint positions, the caller gives the robot.
//!
//! A model states its vertices at rest (`v_template`), the vertices that surround each joint (`J_regressor`), and how
//! shape coefficients move the vertices (`shapedirs`). The joints of a body with the coefficients `b` are `J_regressor
//! (v_template + shapedirs b)` (Loper et al., *SMPL*, 2015, equations 8 and 10). mocap applies `J_regressor` once to
//! `v_template` and to `shapedirs`. Of a file of many megabytes, it keeps only these few products.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use mocap_scene::scene::HumanoidBone as Bone;
use mocap_scene::scene::joint_tables::{Joint, smpl};
use mocap_scene::scene::robot::Robot;

use super::ndarray::{Entries, NdArray};
use super::proportions;
use crate::Failure;

/// The largest number of shape coefficients. Models have 10 to 300; in files, the coefficients of faces follow.
const MOST_COEFFICIENTS: usize = 300;

/// The largest number of vertices of a model; SMPL-X has 10,475.
const MOST_VERTICES: usize = 1 << 20;

/// The body to which rotations of arrays apply, in its T-pose. Positions are in metres, in axes with left +X, up +Y and
/// forward +Z.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub enum Body {
    Model(BodyModel),
    /// The bones of a figure that stands on the ground.
    Bones(BTreeMap<Bone, Vec3>),
    /// A robot whose joint positions are in the arrays, and the positions of its bones as a figure.
    Robot(Box<Robot>, BTreeMap<Bone, Vec3>),
}

/// The joints of a model, and their displacement by the shape coefficients.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub struct BodyModel {
    joints: Vec<Joint>,
    rest: Vec<DVec3>,
    /// For each coefficient, the displacements of all joints.
    shape: Vec<Vec<DVec3>>,
}

impl Body {
    /// The rest positions of `joints`; `betas` are the shape coefficients of a model. The positions are relative to the
    /// origin of the model's template. The positions of a body without a model are relative to the ground. A joint that
    /// the body lacks gets the distance from its parent in the generic body. A missing joint of the spine is half-way
    /// up to the neck.
    pub(super) fn rest(&self, joints: &[Joint], betas: &[f64]) -> Vec<Vec3> {
        let bones = match self {
            Self::Model(model) => model.bones(betas),
            Self::Bones(bones) | Self::Robot(_, bones) => bones.clone(),
        };
        let generic = proportions::rest(joints);
        let neck = bones.get(&Bone::Neck);
        let mut positions: Vec<Vec3> = Vec::with_capacity(joints.len());
        for (index, joint) in joints.iter().enumerate() {
            let own = joint.bone.and_then(|bone| bones.get(&bone)).copied();
            let is_spine = matches!(joint.bone, Some(Bone::Spine | Bone::Chest | Bone::UpperChest));
            let lacking = || match (joint.parent, neck) {
                (Some(parent), Some(neck)) if is_spine => positions[parent].midpoint(*neck),
                (Some(parent), _) => positions[parent] + generic[index] - generic[parent],
                (None, _) => generic[index],
            };
            positions.push(own.unwrap_or_else(lacking));
        }
        positions
    }

    /// Whether the body is a model. The rest positions of a model are relative to the origin of its template.
    pub(super) fn is_model(&self) -> bool {
        matches!(self, Self::Model(_))
    }

    /// The number of the model's shape coefficients.
    pub(super) fn coefficients(&self) -> usize {
        match self {
            Self::Model(model) => model.shape.len(),
            Self::Bones(_) | Self::Robot(..) => 0,
        }
    }
}

impl BodyModel {
    /// The model in the arrays of a file; `None` if the arrays contain no model.
    ///
    /// # Errors
    /// - [`Code::RowLength`]: the shapes of arrays do not match.
    /// - [`Code::LimitExceeded`]: there are too many vertices.
    /// - [`Code::NonFiniteValue`]: a number is not finite.
    pub(super) fn of(entries: &Entries<'_>, limits: &Limits) -> Result<Option<Self>, Failure> {
        let Some(template) = entries.get("v_template") else {
            return Ok(None);
        };
        let &[vertices, 3] = template.shape.as_slice() else {
            return Err(shape("v_template", "(vertices, 3)", template));
        };
        if vertices > MOST_VERTICES.min(limits.max_values as usize / 3) {
            let most = format!("at most {MOST_VERTICES} vertices");
            return Err(Box::new(limit_exceeded(most, vertices.to_string())));
        }
        let regressor = Regressor::of(entries, vertices)?;
        let Some(joints) = smpl(regressor.joints) else {
            let message = format!("the model has {} joints", regressor.joints);
            return Err(Box::new(Diagnostic::new(Code::RowLength, message).expected_found(
                "22, 24, 52 or 55 joints of SMPL's family",
                regressor.joints.to_string(),
            )));
        };
        let rest = regressor.apply(&template.numbers(), 1, 0);
        let shape = match entries.get("shapedirs") {
            Some(directions) => match directions.shape.as_slice() {
                &[own, 3, count] if own == vertices => {
                    let numbers = directions.numbers();
                    let used = count.min(MOST_COEFFICIENTS);
                    (0..used).map(|index| regressor.apply(&numbers, count, index)).collect()
                }
                _ => {
                    return Err(shape(
                        "shapedirs",
                        &format!("({vertices}, 3, coefficients)"),
                        directions,
                    ));
                }
            },
            None => Vec::new(),
        };
        let model = Self { joints, rest, shape };
        let mut all = model.shape.iter().flatten().chain(&model.rest);
        match all.all(|position| position.is_finite() && position.abs().max_element() < 1e3) {
            true => Ok(Some(model)),
            false => {
                let message = "a joint of the model is not at a finite position within 1000 m";
                Err(Box::new(Diagnostic::new(Code::NonFiniteValue, message)))
            }
        }
    }

    fn bones(&self, betas: &[f64]) -> BTreeMap<Bone, Vec3> {
        let position_of = |(index, joint): (usize, &Joint)| {
            let moved = std::iter::zip(&self.shape, betas).map(|(shape, beta)| *beta * shape[index]);
            Some((joint.bone?, (self.rest[index] + moved.sum::<DVec3>()).as_vec3()))
        };
        self.joints.iter().enumerate().filter_map(position_of).collect()
    }
}

/// The weights of vertices. The position of a joint is the weighted sum of its vertices (`J_regressor`).
struct Regressor {
    joints: usize,
    /// The index of the joint, the index of the vertex, and the weight.
    weights: Vec<(usize, usize, f64)>,
}

impl Regressor {
    /// Reads the weights from a dense array (joints, vertices), or from a sparse matrix of SciPy that is compressed by
    /// columns or by rows.
    fn of(entries: &Entries<'_>, vertices: usize) -> Result<Self, Failure> {
        const NAME: &str = "J_regressor";
        if let Some(dense) = entries.get(NAME) {
            let &[joints, columns] = dense.shape.as_slice() else {
                return Err(shape(NAME, "(joints, vertices)", dense));
            };
            if columns != vertices {
                return Err(shape(NAME, &format!("(joints, {vertices})"), dense));
            }
            let numbers = dense.numbers().into_iter().enumerate();
            let weights = numbers.filter(|(_, weight)| *weight != 0.0);
            return Ok(Self {
                joints,
                weights: weights
                    .map(|(index, weight)| (index / vertices, index % vertices, weight))
                    .collect(),
            });
        }
        let part = |own: &str| {
            let name = format!("{NAME}.{own}");
            let array = entries.get(&name);
            array.map(NdArray::numbers).ok_or_else(|| -> Failure {
                let message =
                    format!("the model has neither the array {NAME}, nor the array {name} of a sparse matrix");
                Box::new(
                    Diagnostic::new(Code::MissingKeyword, message)
                        .expected_found("v_template and J_regressor", entries.describe())
                        .help("pass an SMPL, SMPL-H or SMPL-X model, or a file with a humanoid skeleton"),
                )
            })
        };
        let (data, indices, starts) = (part("data")?, part("indices")?, part("indptr")?);
        let size = part("_shape").or_else(|_| part("shape"))?;
        let joints = size.first().map_or(0.0, |joints| *joints);
        let is_ordered = starts.windows(2).all(|pair| pair[0] <= pair[1]);
        if !is_ordered {
            let message = format!("the rows of the sparse matrix {NAME} are not consecutive");
            return Err(Box::new(Diagnostic::new(Code::RowLength, message)));
        }
        let by_columns = starts.len() == vertices + 1;
        let mut weights = Vec::with_capacity(data.len());
        for (major, pair) in starts.windows(2).enumerate() {
            let [begin, end] = [pair[0], pair[1]].map(|at| (at as usize).min(data.len()));
            for (at, weight) in data.iter().enumerate().take(end).skip(begin) {
                let minor = indices.get(at).map_or(usize::MAX, |index| *index as usize);
                let (joint, vertex) = if by_columns { (minor, major) } else { (major, minor) };
                weights.push((joint, vertex, *weight));
            }
        }
        let is_inside = |(joint, vertex, _): &(usize, usize, f64)| *joint < joints as usize && *vertex < vertices;
        if size.len() != 2 || size[1] != vertices as f64 || !weights.iter().all(is_inside) {
            let message = format!("the sparse matrix {NAME} does not fit {vertices} vertices");
            return Err(Box::new(Diagnostic::new(Code::RowLength, message)));
        }
        Ok(Self {
            joints: joints as usize,
            weights,
        })
    }

    /// The joint positions, as weighted sums of vertices. `numbers` has `count` values for each coordinate of a vertex;
    /// `index` selects one of these values.
    fn apply(&self, numbers: &[f64], count: usize, index: usize) -> Vec<DVec3> {
        let mut positions = vec![DVec3::ZERO; self.joints];
        for (joint, vertex, weight) in &self.weights {
            let at = |axis: usize| numbers[(3 * vertex + axis) * count + index];
            positions[*joint] += *weight * DVec3::new(at(0), at(1), at(2));
        }
        positions
    }
}

fn shape(name: &str, expected: &str, found: &NdArray<'_>) -> Failure {
    let message = format!("the array {name} does not have the shape of a model");
    Box::new(Diagnostic::new(Code::RowLength, message).expected_found(expected, found.shape_text()))
}
