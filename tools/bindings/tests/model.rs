//! Compares the model with the library.

use mocap::edit::{EditStep, StepKey};
use mocap::scene::RotationOrder;
use mocap_bindings::model::{Kind, Model, Shape};
use serde_json::json;

#[test]
fn defaults_are_those_of_the_types() {
    let model = Model::new();
    let default = |record: &str, name: &str| {
        let field = model.fields(record).iter().find(|field| field.name == name);
        field
            .unwrap_or_else(|| panic!("{record} has no {name}"))
            .default
            .clone()
    };
    for (record, name, value) in [
        ("InputOptions", "root-offset", json!("auto")),
        ("InputOptions", "strict", json!(false)),
        ("SourceFrames", "drop-first-frame", json!("no")),
        ("SourceFrames", "root", json!("keep")),
        ("FbxOutputOptions", "fbx-version", json!("7.5")),
        ("RobotTarget", "floor", json!("auto")),
        ("CharacterTarget", "feet", json!("lock")),
        ("GraphJobOptions", "threshold", json!("0.06m")),
    ] {
        assert_eq!(default(record, name), Some(value), "{record}: {name}");
    }
    assert_eq!(default("SizeOptions", "compress"), None);
}

#[test]
fn every_step_and_every_option_is_there_with_its_documentation() {
    let model = Model::new();
    assert_eq!(model.steps.len(), EditStep::ALL.len());
    for (step, info) in model.steps.iter().zip(EditStep::ALL) {
        assert_eq!(step.name, info.name);
        let options = info.keys.iter().map(StepKey::name).filter(|name| name != "with");
        assert_eq!(
            Vec::from_iter(options),
            Vec::from_iter(step.options.iter().map(|option| option.name.clone()))
        );
    }
    let smooth = model.steps.iter().find(|step| step.name == "smooth").unwrap();
    let cut_off = smooth.options.iter().find(|option| option.name == "cut-off").unwrap();
    assert_eq!(cut_off.default, Some(json!(6.0)));
    assert_eq!(
        cut_off.docs,
        "The cut-off frequency in Hz: the filter keeps slower changes, and removes faster ones. Default: 6, which is \
         above the frequencies of a walk."
    );
    let required: Vec<&str> = model
        .steps
        .iter()
        .filter(|step| step.options.iter().any(|option| option.is_required))
        .map(|step| step.name)
        .collect();
    assert_eq!(required, ["reach", "look-at"]);
}

#[test]
fn words_are_those_of_the_types() {
    let model = Model::new();
    let words = model.words(&Kind::Named("RotationOrder".to_owned())).unwrap();
    let orders = RotationOrder::ALL.map(|order| format!("{order:?}").to_uppercase());
    assert_eq!(Vec::from_iter(words.iter().map(|word| word.word.clone())), orders);
}

#[test]
fn documentation_has_no_marks_of_rust_and_ends() {
    let model = Model::new();
    let mut docs: Vec<(String, &str)> = Vec::new();
    for definition in &model.definitions {
        docs.push((definition.name.clone(), &definition.docs));
        match &definition.shape {
            Shape::Record(fields) => docs.extend(fields.iter().map(|field| (field.name.clone(), &*field.docs))),
            Shape::Words(words) => docs.extend(words.iter().map(|word| (word.word.clone(), &*word.docs))),
            Shape::Alias(_) => {}
        }
    }
    for step in &model.steps {
        docs.push((step.name.to_owned(), &step.docs));
        docs.extend(
            step.options
                .iter()
                .map(|option| (format!("{}: {}", step.name, option.name), &*option.docs)),
        );
    }
    for (name, docs) in docs {
        let marks = ["](", "[`", "::", "[default", "\n", "  "];
        assert!(!marks.iter().any(|mark| docs.contains(mark)), "{name}: {docs}");
        assert!(docs.is_empty() || docs.ends_with(['.', '?', '!']), "{name}: {docs}");
    }
}
