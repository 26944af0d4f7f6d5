//! Tests that the published JSON Schema of jobs, `src/job/job.schema.json`, matches the types.

use mocap::job::Job;

use crate::published_schema::shorten;

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
            schema == Job::schema(),
            "MOCAP_WRITE=1 cargo test -p mocap-job --features schema -- schema writes it"
        );
    }
}
