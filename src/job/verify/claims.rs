//! Checks a file's statements: how its source was read, the identity of the source, the number of frames.

use std::path::Path;

use mocap_formats::gltf::report::Provenance;
use mocap_io::import::{Clips, Importer};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::report::Origin;

use super::{Finding, FindingKind};

/// Imports the source with the options of the conversion.
pub(super) fn import_source(provenance: &Provenance, mut importer: Importer, source: &Path) -> Result<Scene> {
    if let Some(used) = &provenance.root_offset {
        importer = importer.root_offset(used.policy);
    }
    let mut is_retimed = false;
    for step in &provenance.steps {
        match step {
            AppliedStep::SelectClip { index } => importer = importer.clips(Clips::Index(*index)),
            AppliedStep::Retime { frames_per_second } => {
                importer = importer.retime(*frames_per_second);
                is_retimed = true;
            }
            _ => {}
        }
    }
    if is_retimed {
        return importer.import(source);
    }
    let Some(recorded) = provenance.source.as_ref().filter(|origin| origin.frame_time > 0.0) else {
        return importer.import(source);
    };
    // Files of earlier versions record only the frame time. A frame time that differs from the source's shows that the
    // user set a frame rate for all clips.
    let found = importer.import(source);
    let has_rate = |origin: &Origin| (origin.frame_time / recorded.frame_time - 1.0).abs() < SAME_RATE;
    match &found {
        Ok(scene) if scene.metadata.origin.as_ref().is_some_and(has_rate) => found,
        _ => importer.retime(recorded.frame_time.recip()).import(source),
    }
}

/// The largest relative difference of equal frame rates.
const SAME_RATE: f64 = 1e-9;

/// Whether two files are the same, by their hashes or else by their names.
pub(super) fn is_same_file(a: &Origin, b: &Origin) -> bool {
    match a.sha256.is_empty() || b.sha256.is_empty() {
        true => a.name == b.name,
        false => a.sha256 == b.sha256,
    }
}

/// Checks a file's statements about its source and its `frames`, if it has any, against the source.
pub(super) fn claims(original: &Scene, provenance: &Provenance, frames: Option<u64>, findings: &mut Vec<Finding>) {
    let mut find = |message: String| findings.push(Finding::new(FindingKind::Provenance, message));
    if let (Some(claimed), Some(found)) = (&provenance.source, &original.metadata.origin)
        && ![claimed, found].iter().any(|origin| origin.sha256.is_empty())
        && !is_same_file(claimed, found)
    {
        let (name, hash) = (&claimed.name, &claimed.sha256);
        find(format!(
            "the file says that it was made from another file, \"{name}\" with the SHA-256 {hash}"
        ));
    }
    let mut claim = |what: &str, claimed: u64, found: u64| {
        if claimed != found {
            find(format!(
                "the file says that {what} {claimed} frames, but there are {found}"
            ));
        }
    };
    let frames_of_source = || original.animations.first().map_or(0, |clip| clip.frame_count() as u64);
    if let Some(claimed) = &provenance.source {
        claim("its source has", claimed.frames, frames_of_source());
    }
    if let Some(found) = frames {
        claim("it has", provenance.frames, found);
    }
}
