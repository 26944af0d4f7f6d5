//! The options of a job with many motions, for the manifest.

use std::path::PathBuf;

use mocap::job::{JointNames, MotionJob};

use crate::Failure;
use crate::batch::hash::sha256;

/// Everything that an output depends on except the motion: the job, with each file replaced by its SHA-256.
pub(super) fn options(job: &MotionJob) -> Result<String, Failure> {
    let mut job = job.clone();
    job.source.inputs.clear();
    job.write.output.clear();
    job.write.force = false;
    // This option changes no output.
    job.verify = false;
    let hash = |file: &mut PathBuf| {
        let found = sha256(file).map_err(|error| Failure::Folder(file.clone(), error))?;
        *file = PathBuf::from(format!("sha256:{found}"));
        Ok::<_, Failure>(())
    };
    job.source.with.iter_mut().try_for_each(hash)?;
    let read = &mut job.read;
    let files = [&mut read.skeleton, &mut read.static_trial, &mut read.body];
    files.into_iter().flatten().try_for_each(hash)?;
    for set in [&mut read.joints, &mut read.markers].into_iter().flatten() {
        // Names of joint sets are not files.
        let mut file = PathBuf::from(&*set);
        if file.is_file() {
            hash(&mut file)?;
            *set = file.to_string_lossy().into_owned();
        }
    }
    if let Some(target) = &mut job.target {
        target.forget_verdict();
        target.files_mut().try_for_each(hash)?;
    }
    if let Some(JointNames::File(file)) = &mut job.write.names {
        hash(file)?;
    }
    if let Some(mocap::job::BoneMap::File(file)) = &mut job.source.map.map {
        hash(file)?;
    }
    Ok(serde_json::to_string(&job).unwrap_or_default())
}
