//! The JSON Schema of the output of `--json`.

use crate::commands::{angles, chain, check, doctor, formats, info, matching, pose, series, skeleton, verify};
use crate::printed::{
    AnglesReport, ArraysReport, BridgeReport, CompletionsReport, FilesReport, IndexReport, ManualPage, PageReport,
    PictureReport, PlayReport, RecordingReport,
};
use mocap::dump::SceneView;
use mocap::edit::report::{EditReport, WalkReport};
use mocap::job::report::JobReport;
use mocap::matching::report::Match;
use mocap::retarget::report::RetargetReport;
use mocap::retarget::robot::report::RobotReport;
use mocap::survey::report::ClipRow;
use schemars::Schema;

/// The JSON Schema of an object with the output of each command, under the words of the command. `check` prints one
/// line for each file.
pub fn schema() -> serde_json::Value {
    let mut generator = schemars::generate::SchemaSettings::draft2020_12()
        .for_serialize()
        .into_generator();
    let mut commands = serde_json::Map::new();
    let mut add = |words: &[&str], schema: Schema| {
        for words in words {
            commands.insert((*words).to_owned(), schema.clone().to_value());
        }
    };
    let generator = &mut generator;
    add(
        &["convert", "solve", "clean", "run", "graph"],
        generator.subschema_for::<JobReport>(),
    );
    add(&["retarget"], generator.subschema_for::<Vec<RetargetReport>>());
    add(&["robot", "score"], generator.subschema_for::<RobotReport>());
    add(&["edit"], generator.subschema_for::<Vec<EditReport>>());
    add(&["graph walk"], generator.subschema_for::<WalkReport>());
    add(&["info"], generator.subschema_for::<info::InfoView<'_>>());
    add(&["fk"], generator.subschema_for::<ArraysReport>());
    add(&["angles"], generator.subschema_for::<AnglesReport<'_>>());
    add(&["gait"], generator.subschema_for::<angles::GaitReport<'_>>());
    add(
        &["forces", "analog"],
        generator.subschema_for::<series::SeriesReport<'_>>(),
    );
    add(&["pack", "merge-manifest"], generator.subschema_for::<FilesReport>());
    add(&["chain"], generator.subschema_for::<chain::ChainView<'_>>());
    add(&["pose"], generator.subschema_for::<pose::PoseView<'_>>());
    add(&["skeleton"], generator.subschema_for::<skeleton::SkeletonReport>());
    add(&["check"], generator.subschema_for::<check::FileCheck>());
    add(&["survey"], generator.subschema_for::<Vec<ClipRow>>());
    add(&["index"], generator.subschema_for::<IndexReport>());
    add(&["find"], generator.subschema_for::<Vec<Match>>());
    add(&["match"], generator.subschema_for::<matching::MatchOutcome>());
    add(&["dump"], generator.subschema_for::<SceneView<'_>>());
    add(&["verify"], generator.subschema_for::<verify::VerifyReport<'_>>());
    add(&["record"], generator.subschema_for::<RecordingReport>());
    add(&["play"], generator.subschema_for::<PlayReport>());
    add(&["bridge"], generator.subschema_for::<BridgeReport>());
    add(&["view"], generator.subschema_for::<PageReport>());
    add(&["sheet", "gif", "plot"], generator.subschema_for::<PictureReport>());
    add(&["formats"], generator.subschema_for::<Vec<formats::Row>>());
    add(&["doctor"], generator.subschema_for::<doctor::DoctorReport>());
    add(&["completions"], generator.subschema_for::<CompletionsReport>());
    add(&["man"], generator.subschema_for::<Vec<ManualPage>>());
    serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "What each command of mocap prints with --json, under the words of the command",
        "type": "object",
        "properties": commands,
        "additionalProperties": false,
        "$defs": generator.take_definitions(true),
    })
}
