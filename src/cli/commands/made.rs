//! Makes one output of a job, for all commands.

use std::num::NonZeroUsize;
use std::path::Path;

use mocap::edit::report::WalkReport;
use mocap::files::ReplacePolicy;
use mocap::gltf::report::Deviation;
use mocap::job::{JobOutput, Maker, MotionJob, Notice, WalkJob};
use mocap::{Code, Error, Export, Importer};

use super::verify::millimetres;
use crate::args::{ArgumentSources, refuse_options};
use crate::report::Voice;
use crate::{Failure, kinds, streams};

/// The receiver of the notices of a job.
pub(super) type Listener<'a> = &'a mut dyn FnMut(Notice<'_>);

/// The options that check a written output, or write a further file.
const BESIDE: [&str; 6] = ["verify", "view", "contacts-file", "curves", "report", "resume"];

/// The maker of a job, for one output or many.
pub(super) fn maker(job: &MotionJob, given: &ArgumentSources, hear: Listener<'_>) -> Result<Maker<'static>, Failure> {
    if given.is_dry_run() {
        given.refuse(&BESIDE, "--dry-run writes nothing")?;
    }
    let motions = job.source.inputs.iter().chain(&job.source.with);
    let given_files = streams::given(&job.read, motions)?;
    let maker = Maker::new(job, given_files, hear).map_err(|error| match error.code() {
        Code::UnknownFormat if error.path().is_none() => unknown_output(&error, &job.write.output),
        _ => refused(error),
    })?;
    refuse_options(given, |option| maker.refusal(option))?;
    Ok(maker)
}

/// Makes the output of a job, without writing it.
pub(super) fn make(
    job: &MotionJob,
    given: &ArgumentSources,
    threads: Option<NonZeroUsize>,
    policy: &ReplacePolicy,
    hear: Listener<'_>,
) -> Result<(Maker<'static>, JobOutput), Failure> {
    let mut maker = ready(job, given, policy, hear)?;
    if let Some(threads) = threads {
        maker = maker.threads(threads.get());
    }
    let made = maker.make(&job.source.inputs, &job.write.output, hear);
    Ok((maker, made.map_err(refused)?))
}

/// The maker of a job with one output, after checks that the output may be written.
fn ready(
    job: &MotionJob,
    given: &ArgumentSources,
    policy: &ReplacePolicy,
    hear: Listener<'_>,
) -> Result<Maker<'static>, Failure> {
    let output = job.write.output.as_path();
    if !streams::is_standard(output) {
        policy.check_inputs(output)?;
    }
    let mut inputs = job.source.inputs.iter();
    if let Some(folder) = inputs.find(|input| Importer::is_of_many(input)) {
        let message = "is a folder, and each of its motions gets one file: name an output folder, -o FOLDER/";
        return Err(Failure::Usage(format!("{} {message}", folder.display())));
    }
    let maker = maker(job, given, hear)?;
    maker.check(policy, output)?;
    Ok(maker)
}

/// Makes the output of a job, prints its notices, and writes it.
pub(super) fn save(job: &MotionJob, given: &ArgumentSources) -> Result<(Maker<'static>, JobOutput), Failure> {
    let policy = job.policy();
    let (maker, made) = make(job, given, None, &policy, &mut |said| Voice::Aloud.hear(said))?;
    tell_and_write(&made, &job.write.output, &policy, given)?;
    Ok((maker, made))
}

/// Makes, reports and writes the output as [`save`] does, for a walk over a motion graph.
pub(super) fn save_walk(job: &WalkJob, given: &ArgumentSources) -> Result<WalkReport, Failure> {
    let (motion, policy) = (job.motion().map_err(refused)?, job.policy());
    let mut hear = |said: Notice<'_>| Voice::Aloud.hear(said);
    let maker = ready(&motion, given, &policy, &mut hear)?;
    let (made, walk) = job.make_by(&maker, &mut hear).map_err(refused)?;
    tell_and_write(&made, &job.write.output, &policy, given)?;
    Ok(walk)
}

fn tell_and_write(
    made: &JobOutput,
    output: &Path,
    policy: &ReplacePolicy,
    given: &ArgumentSources,
) -> Result<(), Failure> {
    tell(&made.written, output, &mut Voice::Aloud);
    streams::save(&made.written, output, &[], policy, given.is_dry_run())
}

/// Converts an error of a job to a usage error, if the arguments are at fault and not a file.
pub(super) fn refused(error: Error) -> Failure {
    match (error.code(), error.path()) {
        (Code::InvalidValue | Code::UnknownFormat, None) => Failure::Usage(error.diagnostic().message.clone()),
        _ => error.into(),
    }
}

/// The error of an output whose name has no format that the job supports.
fn unknown_output(error: &Error, output: &Path) -> Failure {
    let message = &error.diagnostic().message;
    Failure::Usage(format!("{message}{}", kinds::other_output(output, message)))
}

/// Prints the notices of an output.
pub(super) fn tell(written: &Export, output: &Path, voice: &mut Voice<'_>) {
    voice.warnings(output, &written.warnings);
    written.notes.iter().for_each(|note| voice.say(note));
    written
        .renamed
        .iter()
        .filter(|renamed| !renamed.is_asked_for)
        .for_each(|renamed| voice.say(&renamed.to_string()));
}

/// The number of keys in the file, and the error of the file.
pub(super) fn smaller(achieved: &Deviation) -> String {
    let (most, rms) = (millimetres(achieved.max_error), millimetres(achieved.rms_error));
    format!(
        "{} keys; error {most} mm at most, {rms} mm RMS; largest at \"{}\", frame {}",
        achieved.keys, achieved.joint, achieved.tick
    )
}
