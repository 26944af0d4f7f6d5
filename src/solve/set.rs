//! The joints of a skeleton, and the points from which the position of each is known.

use serde::{Deserialize, Serialize};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::HumanoidBone as Bone;
use mocap_scene::scene::joint_tables;

use super::mhr70::{MHR70, Table, hand_rows};

/// The joints of a skeleton that is solved from points.
///
/// The [module](crate) describes the result; [`JointSet::solve`](crate::JointSet::solve) has an example.
///
/// ```
/// use mocap::solve::JointSet;
///
/// assert!(JointSet::named("h36m").is_some() && JointSet::named("nosuch").is_none());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointSet {
    pub(super) name: String,
    /// The names of the points, in the order of a file without names.
    pub(super) points: Vec<String>,
    pub(super) joints: Vec<SetJoint>,
    /// Directions that determine the roll of a bone.
    pub(super) marks: Vec<Mark>,
    pub(super) lengths: Lengths,
}

/// The bone lengths of a skeleton that is solved from points.
///
/// `Importer::lengths` has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Lengths {
    /// The median of each length over the frames: bones keep their lengths, and joints are near their points.
    #[default]
    Median,
    /// The lengths of each frame: joints are at their points, and bones change their lengths.
    Moving,
}

/// A joint at the centroid of its points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SetJoint {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) bone: Option<Bone>,
    /// Indices into the points.
    pub(super) of: Vec<usize>,
}

/// The line between two points, which has a known direction in the T-pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) joint: usize,
    pub(super) from: usize,
    pub(super) to: usize,
}

/// The names of the built-in sets.
const NAMES: [&str; 8] = [
    "smpl22",
    "smpl24",
    "coco17",
    "h36m",
    "mediapipe33",
    "openpose25",
    "mhr70",
    "mhr127",
];

const COCO: Table = (
    "nose left_eye right_eye left_ear right_ear left_shoulder right_shoulder left_elbow right_elbow left_wrist \
     right_wrist left_hip right_hip left_knee right_knee left_ankle right_ankle",
    &[
        "hips - hips left_hip+right_hip",
        "left_hip hips leftUpperLeg left_hip",
        "left_knee left_hip leftLowerLeg left_knee",
        "left_ankle left_knee leftFoot left_ankle",
        "right_hip hips rightUpperLeg right_hip",
        "right_knee right_hip rightLowerLeg right_knee",
        "right_ankle right_knee rightFoot right_ankle",
        "chest hips chest left_shoulder+right_shoulder",
        "neck chest neck left_shoulder+right_shoulder",
        "head neck head left_ear+right_ear",
        "left_shoulder chest leftUpperArm left_shoulder",
        "left_elbow left_shoulder leftLowerArm left_elbow",
        "left_wrist left_elbow leftHand left_wrist",
        "right_shoulder chest rightUpperArm right_shoulder",
        "right_elbow right_shoulder rightLowerArm right_elbow",
        "right_wrist right_elbow rightHand right_wrist",
    ],
    &[["head", "right_ear", "left_ear"]],
);

const H36M: Table = (
    "hip right_hip right_knee right_foot left_hip left_knee left_foot spine thorax neck head left_shoulder left_elbow \
     left_wrist right_shoulder right_elbow right_wrist",
    &[
        "hip - hips hip",
        "left_hip hip leftUpperLeg left_hip",
        "left_knee left_hip leftLowerLeg left_knee",
        "left_foot left_knee leftFoot left_foot",
        "right_hip hip rightUpperLeg right_hip",
        "right_knee right_hip rightLowerLeg right_knee",
        "right_foot right_knee rightFoot right_foot",
        "spine hip spine spine",
        "thorax spine chest thorax",
        "neck thorax neck neck",
        "head neck head head",
        "left_shoulder thorax leftUpperArm left_shoulder",
        "left_elbow left_shoulder leftLowerArm left_elbow",
        "left_wrist left_elbow leftHand left_wrist",
        "right_shoulder thorax rightUpperArm right_shoulder",
        "right_elbow right_shoulder rightLowerArm right_elbow",
        "right_wrist right_elbow rightHand right_wrist",
    ],
    &[],
);

const MEDIAPIPE: Table = (
    "nose left_eye_inner left_eye left_eye_outer right_eye_inner right_eye right_eye_outer left_ear right_ear \
        mouth_left \
     mouth_right left_shoulder right_shoulder left_elbow right_elbow left_wrist right_wrist left_pinky right_pinky \
     left_index right_index left_thumb right_thumb left_hip right_hip left_knee right_knee left_ankle right_ankle \
     left_heel right_heel left_foot_index right_foot_index",
    &[
        "hips - hips left_hip+right_hip",
        "left_hip hips leftUpperLeg left_hip",
        "left_knee left_hip leftLowerLeg left_knee",
        "left_ankle left_knee leftFoot left_ankle",
        "left_foot_index left_ankle leftToes left_foot_index",
        "right_hip hips rightUpperLeg right_hip",
        "right_knee right_hip rightLowerLeg right_knee",
        "right_ankle right_knee rightFoot right_ankle",
        "right_foot_index right_ankle rightToes right_foot_index",
        "chest hips chest left_shoulder+right_shoulder",
        "neck chest neck left_shoulder+right_shoulder",
        "head neck head left_ear+right_ear",
        "left_shoulder chest leftUpperArm left_shoulder",
        "left_elbow left_shoulder leftLowerArm left_elbow",
        "left_wrist left_elbow leftHand left_wrist",
        "left_knuckles left_wrist - left_index+left_pinky",
        "right_shoulder chest rightUpperArm right_shoulder",
        "right_elbow right_shoulder rightLowerArm right_elbow",
        "right_wrist right_elbow rightHand right_wrist",
        "right_knuckles right_wrist - right_index+right_pinky",
    ],
    &[
        ["head", "right_ear", "left_ear"],
        ["left_wrist", "left_pinky", "left_index"],
        ["right_wrist", "right_pinky", "right_index"],
    ],
);

const OPENPOSE: Table = (
    "nose neck right_shoulder right_elbow right_wrist left_shoulder left_elbow left_wrist mid_hip right_hip right_knee \
     right_ankle left_hip left_knee left_ankle right_eye left_eye right_ear left_ear left_big_toe left_small_toe \
     left_heel right_big_toe right_small_toe right_heel",
    &[
        "mid_hip - hips mid_hip",
        "left_hip mid_hip leftUpperLeg left_hip",
        "left_knee left_hip leftLowerLeg left_knee",
        "left_ankle left_knee leftFoot left_ankle",
        "left_toes left_ankle leftToes left_big_toe+left_small_toe",
        "right_hip mid_hip rightUpperLeg right_hip",
        "right_knee right_hip rightLowerLeg right_knee",
        "right_ankle right_knee rightFoot right_ankle",
        "right_toes right_ankle rightToes right_big_toe+right_small_toe",
        "chest mid_hip chest neck",
        "neck chest neck neck",
        "head neck head left_ear+right_ear",
        "left_shoulder chest leftUpperArm left_shoulder",
        "left_elbow left_shoulder leftLowerArm left_elbow",
        "left_wrist left_elbow leftHand left_wrist",
        "right_shoulder chest rightUpperArm right_shoulder",
        "right_elbow right_shoulder rightLowerArm right_elbow",
        "right_wrist right_elbow rightHand right_wrist",
    ],
    &[
        ["head", "right_ear", "left_ear"],
        ["left_ankle", "left_big_toe", "left_small_toe"],
        ["right_ankle", "right_small_toe", "right_big_toe"],
    ],
);

/// A joint of a JSON file of joints.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    name: String,
    #[serde(default)]
    parent: Option<String>,
    #[serde(default)]
    bone: Option<String>,
    /// Default: the point with the joint's name.
    #[serde(default)]
    points: Vec<String>,
}

impl JointSet {
    /// A built-in set: smpl22, smpl24, coco17, h36m, mediapipe33, openpose25, mhr70 or mhr127.
    ///
    /// ```
    /// assert!(mocap::solve::JointSet::named("coco17").is_some());
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        let table = match name {
            "smpl22" => return Some(Self::of_table(name, joint_tables::smpl(22)?, |_| true)),
            "smpl24" => return Some(Self::of_table(name, joint_tables::smpl(24)?, |_| true)),
            // The first joint of the rig is the origin. Twist helpers have no position of their own. Both are left out.
            "mhr127" => {
                let is_joint = |name: &str| name != "body_world" && !name.ends_with("_proc");
                return Some(Self::of_table(name, joint_tables::mhr(), is_joint));
            }
            "mhr70" => MHR70,
            "coco17" => COCO,
            "h36m" => H36M,
            "mediapipe33" => MEDIAPIPE,
            "openpose25" => OPENPOSE,
            _ => return None,
        };
        let points: Vec<String> = match name {
            "mhr70" => joint_tables::mhr70(),
            _ => table.0.split_whitespace().map(str::to_owned).collect(),
        };
        let rows = table.1.iter().flat_map(|row| match row.strip_suffix("_hand") {
            Some(side) => hand_rows(side),
            None => vec![(*row).to_owned()],
        });
        let joints = rows.filter_map(|row| {
            let mut words = row.split(' ');
            let mut word = || words.next().filter(|word| *word != "-").map(str::to_owned);
            let (name, parent, bone, of) = (word()?, word(), word(), word()?);
            let of = of.split('+').map(str::to_owned).collect();
            Some(Stated {
                name,
                parent,
                bone,
                points: of,
            })
        });
        let mut set = Self::of_stated(name, points, joints.collect()).ok()?;
        for [joint, from, to] in table.2 {
            let point = |name: &str| set.points.iter().position(|point| point == name);
            let mark = Mark {
                joint: set.joints.iter().position(|own| own.name == *joint)?,
                from: point(from)?,
                to: point(to)?,
            };
            set.marks.push(mark);
        }
        Some(set)
    }

    /// Parses the set from a JSON list of joints, parents first. Each joint has `name`, `parent`, `bone` (a VRM name)
    /// and `points`. The joint is at the centroid of its points. Without `points`, the joint is at the point with its
    /// name.
    ///
    /// ```
    /// use mocap::solve::JointSet;
    ///
    /// let set = JointSet::from_json("my joints", r#"[{"name": "hips", "bone": "hips", "points": ["LASI", "RASI"]}]"#);
    /// assert!(set.is_ok());
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the text is not such a list.
    pub fn from_json(name: &str, text: &str) -> Result<Self> {
        let invalid = |message: String| {
            Diagnostic::new(Code::InvalidValue, format!("the joints of {name}: {message}"))
                .help("a list of {\"name\": ..., \"parent\": ..., \"bone\": ..., \"points\": [...]}, parents first")
        };
        let stated: Vec<Stated> = serde_json::from_str(text).map_err(|error| invalid(error.to_string()))?;
        let mut points: Vec<String> = Vec::new();
        for joint in &stated {
            let own = std::slice::from_ref(&joint.name);
            let of = if joint.points.is_empty() { own } else { &joint.points };
            points.extend(
                of.iter()
                    .filter(|point| !points.contains(*point))
                    .cloned()
                    .collect::<Vec<_>>(),
            );
        }
        Ok(Self::of_stated(name, points, stated).map_err(invalid)?)
    }

    /// The bone lengths of the skeleton. Default: medians.
    #[must_use]
    pub fn lengths(mut self, lengths: Lengths) -> Self {
        self.lengths = lengths;
        self
    }

    fn of_stated(name: &str, points: Vec<String>, stated: Vec<Stated>) -> Result<Self, String> {
        let mut joints: Vec<SetJoint> = Vec::with_capacity(stated.len());
        for joint in stated {
            let parent = match &joint.parent {
                None => None,
                Some(parent) => Some(
                    (joints.iter().position(|own| own.name == *parent))
                        .ok_or_else(|| format!("the parent {parent} of {} does not precede it", joint.name))?,
                ),
            };
            let bone = match &joint.bone {
                None => None,
                Some(bone) => Some(Bone::from_name(bone).ok_or_else(|| format!("{bone} is not a VRM bone"))?),
            };
            let of = if joint.points.is_empty() {
                vec![joint.name.clone()]
            } else {
                joint.points
            };
            let of = of
                .iter()
                .filter_map(|point| points.iter().position(|own| own == point))
                .collect();
            joints.push(SetJoint {
                name: joint.name,
                parent,
                bone,
                of,
            });
        }
        match joints.iter().filter(|joint| joint.parent.is_none()).count() {
            1 => Ok(Self {
                name: name.to_owned(),
                points,
                joints,
                marks: Vec::new(),
                lengths: Lengths::Median,
            }),
            count => Err(format!("exactly one joint must have no parent, but {count} have none")),
        }
    }

    /// The joints of a table for which `is_joint` holds, each at the point with its name.
    fn of_table(name: &str, table: Vec<joint_tables::Joint>, is_joint: impl Fn(&str) -> bool) -> Self {
        let points: Vec<String> = table.iter().map(|joint| joint.name.clone()).collect();
        let places: Vec<usize> = (0..table.len()).filter(|index| is_joint(&points[*index])).collect();
        let place_of = |index: usize| places.iter().position(|place| *place == index);
        let joints = places.iter().map(|index| SetJoint {
            name: points[*index].clone(),
            parent: table[*index].parent.and_then(place_of),
            bone: table[*index].bone,
            of: vec![*index],
        });
        Self {
            name: name.to_owned(),
            joints: joints.collect(),
            points,
            marks: Vec::new(),
            lengths: Lengths::Median,
        }
    }

    /// The names of the sets with this number of points.
    #[doc(hidden)]
    pub fn of_count(count: usize) -> Vec<&'static str> {
        let has_count = |name: &&str| Self::named(name).is_some_and(|set| set.points.len() == count);
        NAMES.into_iter().filter(has_count).collect()
    }

    /// The names of the built-in sets, for a sentence.
    #[doc(hidden)]
    pub fn names() -> String {
        NAMES.join(", ")
    }

    /// Whether these are the names of the set's points.
    #[doc(hidden)]
    pub fn has_points(&self, names: &[&str]) -> bool {
        self.points.iter().map(String::as_str).eq(names.iter().copied())
    }

    pub(super) fn joint(&self, bone: Bone) -> Option<usize> {
        self.joints.iter().position(|joint| joint.bone == Some(bone))
    }

    pub(super) fn children(&self, parent: usize) -> Vec<usize> {
        (0..self.joints.len())
            .filter(|joint| self.joints[*joint].parent == Some(parent))
            .collect()
    }

    /// The joints in depth-first order: each joint before its descendants, and these before its siblings.
    pub(super) fn depth_first(&self) -> Vec<usize> {
        let mut order = Vec::with_capacity(self.joints.len());
        let mut open: Vec<usize> = (0..self.joints.len())
            .filter(|joint| self.joints[*joint].parent.is_none())
            .collect();
        while let Some(joint) = open.pop() {
            order.push(joint);
            open.extend(self.children(joint).into_iter().rev());
        }
        order
    }
}
