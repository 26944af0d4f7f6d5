//! A table of the reports of motions on a robot.

use std::sync::Arc;

use arrow_array::builder::{Float64Builder, ListBuilder, StringBuilder, StructBuilder};
use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field};
use mocap_retarget::robot::report::{Feasibility, RobotReport, RobotScores};

use super::batch;

/// A motion that was retargeted to a robot, or failed.
///
/// [`robot_reports`](super::robot_reports()) has an example.
#[derive(Clone, Copy, Debug)]
pub struct RobotClip<'a> {
    /// The name of the clip.
    pub clip: &'a str,
    /// The file with the motion of the robot, if there is one.
    pub output: Option<&'a str>,
    /// The report, or the error message of a failed motion.
    pub report: Result<&'a RobotReport, &'a str>,
}

/// The table with one row for each clip: the columns are the fields of [`RobotReport`], of its [`Feasibility`] and of
/// its [`RobotScores`], with their names.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::arrays::table::{self, RobotClip};
/// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let (_, report) = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?.clip(&walk, 0)?;
/// let clip = |clip, report| RobotClip { clip, output: None, report };
/// let rows = table::robot_reports(&[clip("walk.bvh", Ok(&report)), clip("broken.bvh", Err("empty file"))]);
/// assert_eq!(rows.num_rows(), 2);
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn robot_reports(clips: &[RobotClip<'_>]) -> RecordBatch {
    let reports: Vec<Option<&RobotReport>> = clips.iter().map(|clip| clip.report.ok()).collect();
    let texts = |value: &dyn Fn(&RobotReport) -> String| -> ArrayRef {
        Arc::new(reports.iter().map(|report| report.map(value)).collect::<StringArray>())
    };
    let counts = |value: &dyn Fn(&RobotReport) -> usize| -> ArrayRef {
        let count = |report: &RobotReport| value(report) as i64;
        Arc::new(reports.iter().map(|report| report.map(count)).collect::<Int64Array>())
    };
    let numbers = |value: &dyn Fn(&RobotReport) -> Option<f64>| -> ArrayRef {
        let number = |report: &Option<&RobotReport>| report.and_then(value);
        Arc::new(reports.iter().map(number).collect::<Float64Array>())
    };
    let dynamics = |value: &dyn Fn(&Feasibility) -> Option<f64>| numbers(&|report| value(report.dynamics.as_ref()?));
    let most_loaded = reports.iter().map(|report| {
        let dynamics = report.as_ref()?.dynamics.as_ref()?;
        Some(dynamics.most_loaded_joint.as_str())
    });
    let main_causes = reports.iter().map(|report| {
        let cause = report.as_ref()?.dynamics.as_ref()?.main_cause?;
        Some(cause.as_str())
    });
    let score = |value: &dyn Fn(&RobotScores) -> Option<f64>| numbers(&|report| value(report.scores.as_ref()?));
    let limb_texts = ["bone"];
    let limb_numbers = ["mean_degrees", "max_degrees", "tick"];
    let limbs = structs(&reports, &limb_texts, &limb_numbers, &|report, add| {
        for limb in &report.limbs {
            add(&[limb.bone.as_str()], &[limb.mean_degrees, limb.max_degrees, limb.tick]);
        }
    });
    let clamped = structs(&reports, &["joint"], &["fraction"], &|report, add| {
        for joint in &report.clamped {
            add(&[&joint.joint], &[joint.fraction]);
        }
    });
    let numbers_of_pair = ["fraction", "deepest"];
    let self_collisions = structs(&reports, &["link", "other"], &numbers_of_pair, &|report, add| {
        for pair in &report.self_collisions {
            add(&[&pair.link, &pair.other], &[pair.fraction, pair.deepest]);
        }
    });
    let bounds = ["value", "good", "fair"];
    let criteria = structs(&reports, &["name", "verdict"], &bounds, &|report, add| {
        for criterion in &report.criteria {
            let fair = criterion.fair.unwrap_or(f64::INFINITY);
            let texts = [criterion.name.as_str(), criterion.verdict.as_str()];
            add(&texts, &[criterion.value, criterion.good, fair]);
        }
    });
    let names = clips.iter().map(|clip| clip.clip);
    let errors = clips.iter().map(|clip| clip.report.err());
    let columns: Vec<(&str, ArrayRef)> = vec![
        ("clip", Arc::new(StringArray::from_iter_values(names))),
        ("error", Arc::new(errors.collect::<StringArray>())),
        (
            "output",
            Arc::new(clips.iter().map(|clip| clip.output).collect::<StringArray>()),
        ),
        ("verdict", texts(&|report| report.verdict.as_str().to_owned())),
        ("frames", counts(&|report| report.frames)),
        ("fps", numbers(&|report| Some(report.fps))),
        ("scale", numbers(&|report| Some(report.scale))),
        ("time_scale", numbers(&|report| Some(report.time_scale))),
        (
            "slowed_by",
            texts(&|report| report.slowed_by.clone().unwrap_or_default()),
        ),
        ("lagging", texts(&|report| report.lagging.join("; "))),
        ("mean_degrees", numbers(&|report| Some(report.mean_degrees))),
        ("limbs", limbs),
        ("clamped", clamped),
        ("limit_violations", counts(&|report| report.limit_violations)),
        ("skate", numbers(&|report| report.skate)),
        ("source_skate", numbers(&|report| report.source_skate)),
        ("fraction_scraping", numbers(&|report| report.fraction_scraping)),
        (
            "fraction_below_floor",
            numbers(&|report| Some(report.fraction_below_floor)),
        ),
        ("deepest", numbers(&|report| Some(report.deepest))),
        (
            "fraction_in_self_collision",
            numbers(&|report| Some(report.fraction_in_self_collision)),
        ),
        ("self_collisions", self_collisions),
        ("max_velocity", numbers(&|report| Some(report.max_velocity))),
        ("fastest_joint", texts(&|report| report.fastest_joint.clone())),
        ("fraction_too_fast", numbers(&|report| Some(report.fraction_too_fast))),
        ("max_acceleration", numbers(&|report| Some(report.max_acceleration))),
        ("roll_degrees", numbers(&|report| report.roll_degrees)),
        ("trunk_degrees", numbers(&|report| report.trunk_degrees)),
        ("fraction_of_jumps", numbers(&|report| Some(report.fraction_of_jumps))),
        ("fraction_floating", numbers(&|report| report.fraction_floating)),
        ("fraction_lying", numbers(&|report| Some(report.fraction_lying))),
        ("passes", numbers(&|report| Some(f64::from(report.passes)))),
        ("mass", dynamics(&|found| Some(found.mass))),
        ("fraction_feasible", dynamics(&|found| Some(found.fraction_feasible))),
        ("main_cause", Arc::new(main_causes.collect::<StringArray>())),
        ("residual_force", dynamics(&|found| Some(found.residual_force))),
        ("residual_lever", dynamics(&|found| Some(found.residual_lever))),
        (
            "fraction_pressure_outside",
            dynamics(&|found| found.fraction_pressure_outside),
        ),
        ("fraction_over_effort", dynamics(&|found| found.fraction_over_effort)),
        ("max_effort", dynamics(&|found| Some(found.max_effort))),
        ("most_loaded_joint", Arc::new(most_loaded.collect::<StringArray>())),
        ("bodies", score(&|scores| Some(scores.bodies as f64))),
        ("mpbpe_global", score(&|scores| Some(scores.mpbpe_global))),
        ("mpbpe_local", score(&|scores| Some(scores.mpbpe_local))),
        ("palm_error", score(&|scores| scores.palm_error)),
        ("foot_sliding", score(&|scores| scores.foot_sliding)),
        ("foot_skating_duration", score(&|scores| scores.foot_skating_duration)),
        ("foot_skating_velocity", score(&|scores| scores.foot_skating_velocity)),
        ("contact_preservation", score(&|scores| scores.contact_preservation)),
        (
            "penetration_duration",
            score(&|scores| Some(scores.penetration_duration)),
        ),
        ("penetration_depth", score(&|scores| Some(scores.penetration_depth))),
        (
            "self_collision_duration",
            score(&|scores| Some(scores.self_collision_duration)),
        ),
        (
            "self_collision_depth",
            score(&|scores| Some(scores.self_collision_depth)),
        ),
        ("joint_jerk", score(&|scores| Some(scores.joint_jerk))),
        ("limit_violation", score(&|scores| Some(scores.limit_violation))),
        ("at_limit", score(&|scores| Some(scores.at_limit))),
        ("guessed", texts(&|report| report.guessed.join("; "))),
        ("left_out", texts(&|report| report.left_out.join("; "))),
        ("criteria", criteria),
    ];
    let columns = columns.into_iter().map(|(name, column)| (name.to_owned(), column));
    batch(columns.collect(), true)
}

/// Adds an element to a list: its strings and its numbers.
type Add<'a> = dyn FnMut(&[&str], &[f64]) + 'a;

/// A column of struct lists, one list for each report. A struct has these text fields, then these number fields. `fill`
/// adds the elements.
fn structs(
    reports: &[Option<&RobotReport>],
    texts: &[&str],
    numbers: &[&str],
    fill: &dyn Fn(&RobotReport, &mut Add<'_>),
) -> ArrayRef {
    let field = |name: &&str, kind: &DataType| Field::new(*name, kind.clone(), false);
    let text_fields = texts.iter().map(|name| field(name, &DataType::Utf8));
    let number_fields = numbers.iter().map(|name| field(name, &DataType::Float64));
    let fields: Vec<Field> = text_fields.chain(number_fields).collect();
    let mut lists = ListBuilder::new(StructBuilder::from_fields(fields, 0));
    for report in reports {
        if let Some(report) = report {
            let elements = lists.values();
            fill(report, &mut |texts, numbers| {
                for (index, text) in texts.iter().enumerate() {
                    let column = elements.field_builder::<StringBuilder>(index);
                    column.expect("the first fields are text").append_value(text);
                }
                for (index, number) in numbers.iter().enumerate() {
                    let column = elements.field_builder::<Float64Builder>(texts.len() + index);
                    column.expect("the other fields are numbers").append_value(*number);
                }
                elements.append(true);
            });
        }
        lists.append(report.is_some());
    }
    Arc::new(lists.finish())
}
