//! The published JSON Schema of jobs: `src/job/job.schema.json` is what the types say.

use mocap::job::Job;
use serde_json::Value;

/// `MOCAP_WRITE=1` writes the file.
#[test]
fn the_published_schema_is_that_of_the_types() {
    let mut schema = serde_json::to_value(schemars::schema_for!(Job)).unwrap();
    shorten(&mut schema);
    let schema = serde_json::to_string_pretty(&schema).unwrap() + "\n";
    if std::env::var_os("MOCAP_WRITE").is_some() {
        std::fs::write("job.schema.json", &schema).unwrap();
    } else {
        assert!(
            schema == Job::SCHEMA,
            "MOCAP_WRITE=1 cargo test -p mocap-job --features schema -- schema writes it"
        );
    }
}

/// Descriptions are the documentation of the types; a schema needs the first paragraph of each, without examples.
fn shorten(value: &mut Value) {
    match value {
        Value::Object(entries) => {
            for (name, entry) in entries {
                match entry {
                    Value::String(text) if name == "description" => {
                        *text = text.split("\n\n").next().unwrap_or_default().replace('\n', " ");
                    }
                    entry => shorten(entry),
                }
            }
        }
        Value::Array(values) => values.iter_mut().for_each(shorten),
        _ => {}
    }
}
