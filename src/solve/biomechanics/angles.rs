//! Joint angles.

use glam::DQuat;
use mocap_figure::Figure;
use mocap_figure::joint_angles::{Joint, Part, Rotations, Segment, ending};
use mocap_scene::error::Result;
use mocap_scene::scene::report::FilledJoint;
use mocap_scene::scene::{Scene, Side};

use super::segments::Segments;

/// The joint angles of a humanoid, and the position of its pelvis, in every frame. The columns have the names of
/// OpenSim's models where OpenSim has the angle.
///
/// An angle is the rotation of the distal segment's axes relative to the proximal segment's axes. The axes follow the
/// International Society of Biomechanics (Wu and others, 2002 and 2005): +X forward, +Y up, +Z to the right. All angles
/// are 0 for a body that stands with hanging arms and palms forward. They are in degrees, and continuous, without jumps
/// of 360. Angles of the left side have the signs of the right side.
///
/// | columns | rotations, in order, about the rotated axes | positive |
/// |---|---|---|
/// | `pelvis_tilt`, `_list`, `_rotation` | Z, X, Y, from the laboratory | backward, to the right, to the left |
/// | `pelvis_tx`, `_ty`, `_tz` | position in metres | forward, up, to the right |
/// | `hip_flexion`, `_adduction`, `_rotation` | Z, X, Y | flexion, adduction, internal |
/// | `knee_angle`, `_adduction`, `_rotation` | Z, X, Y: Grood and Suntay (1983) | flexion, adduction, internal |
/// | `ankle_angle`, `_inversion`, `_rotation` | Z, X, Y | dorsiflexion, inversion, internal |
/// | `lumbar_extension`, `_bending`, `_rotation` | Z, X, Y: chest against pelvis | back, to the right, to the left |
/// | `neck_extension`, `_bending`, `_rotation` | Z, X, Y: head against chest | back, to the right, to the left |
/// | `arm_flex`, `_add`, `_rot` | Z, X, Y, as OpenSim defines shoulders | flexion, adduction, internal |
/// | `shoulder_plane`, `_elevation`, `_rotation` | Y, X, Y | 0 sideways and 90 forward, up, internal |
/// | `elbow_flex`, `elbow_carrying`, `pro_sup` | Z, X, Y | flexion, varus, pronation |
/// | `wrist_flex`, `_deviation`, `_rotation` | Z, X, Y | flexion, to the little finger, pronation |
///
/// A body that was solved from markers with gaps has a last column, `filled_joints`. It counts the joints that too few
/// markers determine in the frame.
///
/// The column names of sides end in `_r` and `_l`. Upper arm angles are relative to the chest. A plane of elevation has
/// no meaning while the arm hangs, and `arm_flex` has none while the arm is abducted by 90 degrees. The T-pose of the
/// figure is the neutral pose. A laboratory measures the tilt of the pelvis by its iliac spines, so a pelvis that is
/// tilted there can have a tilt of 0 here.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::biomechanics::JointAngles;
///
/// let angles = JointAngles::of(&mocap::import("fixtures/real/cmu_12_01_walk.bvh")?)?;
/// let knee = angles.column("knee_angle_r").expect("the body has a right knee");
/// let most = knee.fold(0.0, f64::max);
/// assert!((50.0..80.0).contains(&most), "{most}"); // knees of a walk bend by about 60 degrees
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct JointAngles {
    /// Frames per second.
    pub frame_rate: f64,
    /// The names of the columns.
    pub columns: Vec<String>,
    /// The values, frame by frame, in the order of the columns: degrees, and metres for the pelvis position.
    pub values: Vec<f64>,
}

/// The columns with the pelvis position in metres; all other columns are angles.
pub(super) const POSITION: [&str; 3] = ["pelvis_tx", "pelvis_ty", "pelvis_tz"];

/// The column with the number of joints that too few markers determine.
const FILLED: &str = "filled_joints";

/// A column: its name, and its value in every frame.
type Column = (String, Vec<f64>);

impl JointAngles {
    /// Computes the angles of a scene's first animation, in any unit and with any up axis.
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid): no humanoid is found.
    /// - [`Code::NoMotion`](mocap_scene::Code::NoMotion): there is no motion.
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::of_figure(scene, &Figure::new(scene))
    }

    /// Like [`of`](Self::of), with the figure that was found in the scene, such as [`Figure::mapped`].
    ///
    /// # Errors
    /// The errors of [`of`](Self::of).
    pub fn of_figure(scene: &Scene, figure: &Figure) -> Result<Self> {
        let mut angles = Self::of_segments(&Segments::of(scene, figure)?);
        angles.mark_filled(scene);
        Ok(angles)
    }

    /// Adds a column with the number of filled joints in each frame, if the scene was solved from markers with such
    /// gaps. Adds nothing if the number of frames has changed since, by a cut or by resampling.
    fn mark_filled(&mut self, scene: &Scene) {
        let Some(solved) = scene
            .metadata
            .solved
            .as_deref()
            .filter(|solved| !solved.filled.is_empty())
        else {
            return;
        };
        let (frames, columns) = (self.frames(), self.columns.len());
        if solved.frames != frames {
            return;
        }
        let count = |frame: usize| {
            let is_filled = |joint: &&FilledJoint| (joint.first..=joint.last).contains(&frame);
            solved.filled.iter().filter(is_filled).count() as f64
        };
        self.columns.push(FILLED.to_owned());
        let rows = self.values.chunks_exact(columns).enumerate();
        self.values = rows
            .flat_map(|(frame, row)| row.iter().copied().chain([count(frame)]))
            .collect();
    }

    pub(super) fn of_segments(segments: &Segments) -> Self {
        let mut columns = pelvis(segments);
        for joint in &Joint::OF_TRUNK {
            columns.extend(angles(segments, joint, None));
        }
        for side in [Side::Right, Side::Left] {
            for joint in &Joint::OF_SIDES {
                columns.extend(angles(segments, joint, Some(side)));
            }
        }
        let values = (0..segments.frames).flat_map(|frame| columns.iter().map(move |(_, values)| values[frame]));
        Self {
            frame_rate: segments.frame_rate,
            values: values.collect(),
            columns: columns.into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.values.len() / self.columns.len().max(1)
    }

    /// The values of a column, frame by frame; `None` if the body lacks the joint.
    pub fn column(&self, name: &str) -> Option<impl Iterator<Item = f64>> {
        let column = self.columns.iter().position(|own| own == name)?;
        Some(self.values.chunks(self.columns.len()).map(move |row| row[column]))
    }
}

/// The angles and the position of the pelvis relative to the laboratory.
fn pelvis(segments: &Segments) -> Vec<Column> {
    let rotations = segments.to_world(Segment::Pelvis).unwrap_or_default();
    let names = ["pelvis_tilt", "pelvis_list", "pelvis_rotation"];
    let mut columns = taken_apart(rotations.iter().copied(), Rotations::PLAIN, names.map(str::to_owned));
    for (axis, name) in POSITION.into_iter().enumerate() {
        let values = segments.pelvis.iter().map(|position| position[axis]);
        columns.push((name.to_owned(), values.collect()));
    }
    columns
}

/// The three columns of a joint; none if the body lacks one of its segments.
fn angles(segments: &Segments, joint: &Joint, side: Option<Side>) -> Vec<Column> {
    let part = |segment: Segment| -> Part {
        let is_of_trunk = matches!(segment, Segment::Pelvis | Segment::Trunk | Segment::Head);
        (segment, side.filter(|_| !is_of_trunk))
    };
    let names = joint.names.map(|name| format!("{name}{}", ending(side)));
    match segments.between(part(joint.above), part(joint.below)) {
        Some(rotations) => taken_apart(rotations, joint.rotations, names),
        None => Vec::new(),
    }
}

fn taken_apart(rotations: impl Iterator<Item = DQuat>, into: Rotations, names: [String; 3]) -> Vec<Column> {
    let mut columns: Vec<Column> = names.into_iter().map(|name| (name, Vec::new())).collect();
    let mut before = None;
    for rotation in rotations {
        let angles = into.of(rotation, before);
        for ((_, values), angle) in columns.iter_mut().zip(angles) {
            values.push(angle);
        }
        before = Some(angles);
    }
    columns
}
