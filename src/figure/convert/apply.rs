//! The steps of a [`Conversion`], in their order.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::FrameBudget;
use mocap_scene::process;
use mocap_scene::scene::{Animation, Assumption, FileSpace, NodeId, Scene, Topic, UpAxis};

use super::{Conversion, FirstFrame, Needs, RestPoseSource, RootMotion, Space, moment, part_ticks};
use crate::{Figure, TPose};

impl Conversion {
    /// Converts `scene`. Returns the assumptions, each with its reason: the values that the file does not state.
    ///
    /// The guesses of unit, up axis and first frame are added to
    /// [`Metadata::assumptions`](mocap_scene::scene::Metadata::assumptions), so they become part of the output. Guesses
    /// about the figure are also added, unless [`keep_units`](Self::keep_units) is set, but do not affect the
    /// conversion. They state whether the figure is a humanoid, and for a humanoid its facing at rest in the axes of
    /// the file, its rest pose and its sides. Of the guesses about the figure, `apply` returns only two: names of the
    /// wrong side, and the source of a requested T-pose. `apply` returns the exact rate of a rounded frame time, but
    /// does not add the rate to the assumptions of the scene.
    ///
    /// A converted scene states its unit and its up axis; converting it again changes neither.
    ///
    /// # Errors
    /// The errors of [`Conversion::check`]. [`Code::InvalidValue`] if [`trim`](Self::trim) or [`rest`](Self::rest) name
    /// frames that the motion lacks, or [`bones`](Self::bones) a joint that the scene lacks; `scene` is then unchanged.
    /// [`Code::NotHumanoid`] if a T-pose is requested, but no humanoid is found. [`Code::LimitExceeded`] if
    /// [`frame_rate`](Self::frame_rate) gives more values than [`limits`](Self::limits) allow; `scene` then keeps its
    /// frames.
    pub fn apply(&self, scene: &mut Scene) -> Result<Vec<Assumption>> {
        self.check()?;
        let figure = Figure::mapped(scene, &self.bones)?;
        let guesses = self.convert(scene, &figure)?.0;
        scene.metadata.keeps_unknown_unit = self.keep_units;
        Ok(guesses)
    }

    /// Converts `scene` with a known figure. Returns the figure of the converted scene, so that bones are searched for
    /// only once.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::figure::{Figure, Unit};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let figure = Figure::new(&scene);
    /// assert_eq!(figure.survey.unit.value, Unit::Cmu);
    /// let (figure, _) = Conversion::new().apply_to(&mut scene, &figure)?;
    /// assert!(figure.survey.unit_is_stated && figure.survey.metres_per_unit == 1.0);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`apply`](Self::apply). [`bones`](Self::bones) has no effect here, but is recorded.
    pub fn apply_to(&self, scene: &mut Scene, figure: &Figure) -> Result<(Figure, Vec<Assumption>)> {
        let (guesses, inserted) = self.convert(scene, figure)?;
        scene.metadata.keeps_unknown_unit = self.keep_units;
        let humanoid = figure.humanoid.clone().after(inserted);
        Ok((Figure::with_bones(scene, humanoid), guesses))
    }

    /// Like [`apply_to`](Self::apply_to), but returns the guesses, and the node that root motion has inserted.
    #[doc(hidden)]
    pub fn convert(&self, scene: &mut Scene, figure: &Figure) -> Result<(Vec<Assumption>, Option<NodeId>)> {
        self.check()?;
        FrameBudget::of_scene(&self.limits).check(scene)?;
        let survey = &figure.survey;
        let parts = self.parts(scene, survey)?;
        let animation = scene.animations.first();
        if let RestPoseSource::Frame(frame) = self.rest {
            let message = "the frame of the rest pose is after the last frame";
            moment::check_within(animation, frame as f64, message)?;
        }
        if self.t_pose_first && animation.is_none() {
            let message = "a T-pose before the motion needs a motion, and the file has none";
            return Err(Diagnostic::new(Code::NoMotion, message).into());
        }
        if self.root != RootMotion::Keep && scene.has_points() {
            let message = "root motion needs a skeleton, and the motion has only points without a skeleton";
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("for markers, solve a skeleton by {markers} auto or mocap solve")
                .into());
        }
        if self.bone_axis.is_some() {
            process::can_zero_rest_rotations(scene)?;
        }
        let standing = self.standing(scene, figure)?;

        let mut guesses = Vec::from_iter(survey.assumption(Topic::FirstFrame));
        if self.frame_rate.is_some_and(|rate| takes_meant_rate(animation, rate)) {
            guesses.extend(survey.assumption(Topic::FrameRate));
        }
        let needs = self.needs();
        let topics = [(needs.unit, Topic::Unit), (needs.up, Topic::Up)];
        let needed = topics.into_iter().filter(|(is_needed, _)| *is_needed);
        guesses.extend(needed.filter_map(|(_, topic)| self.source.guess(topic, survey)));
        let of_figure = figure.assumptions_of_figure();
        if figure.humanoid.sides == crate::report::Sides::Opposite {
            guesses.extend(of_figure.iter().filter(|guess| guess.topic == Topic::Sides).cloned());
        }
        if standing.is_some() || self.t_pose_first {
            guesses.extend(figure.t_pose(scene).map(TPose::assumption));
        }
        let recorded = guesses.iter().filter(|guess| guess.topic != Topic::FrameRate);
        scene.metadata.assumptions.extend(recorded.cloned());
        if !self.keep_units {
            let rest = of_figure.into_iter().filter(|guess| !guesses.contains(guess));
            scene.metadata.assumptions.extend(rest);
        }

        if let RestPoseSource::Frame(frame) = self.rest {
            scene.set_rest_pose_at(frame as f64);
            self.record_rest(scene);
        }
        if standing.is_some() && !self.t_pose_first {
            self.record_rest(scene);
        }
        trim(scene, &parts);
        if let Some(rate) = self.frame_rate {
            scene.resample(rate, &self.limits)?;
        }
        let stands = standing.is_some();
        self.stand(scene, standing, figure)?;
        let stated = self.source.or_stated(&scene.metadata).metres_per_unit;
        let inserted = self.convert_space(scene, survey);
        scene
            .warnings
            .extend(stated.and_then(|metres| figure.implausible_size(metres)));
        if stands {
            process::zero_rest_rotations(scene)?;
        }
        if let Some(axis) = self.bone_axis {
            let humanoid = figure.humanoid.clone().after(inserted);
            axis.turn_frames(scene, humanoid, &self.bones)?;
        }
        Ok((guesses, inserted))
    }

    /// Drops a rest pose before the motion; returns `true` if there was one. Lengths and axes do not change. `figure`
    /// is the figure of `scene`.
    ///
    /// Create a `PoseRetargeter` before this call, because it finds the T-pose from the rest pose in this frame.
    ///
    /// # Errors
    /// The errors of [`apply`](Self::apply).
    pub fn leave_out_rest_pose(scene: &mut Scene, figure: &Figure) -> Result<bool> {
        let steps = scene.metadata.steps.len();
        let conversion = Self::new().first_frame(FirstFrame::DropRestPose).keep_units(true);
        conversion.convert(scene, figure)?;
        Ok(scene.metadata.steps.len() > steps)
    }

    /// Whether the output has other frames than the file.
    #[doc(hidden)]
    pub fn takes_other_frames(&self) -> bool {
        let of_file = self.clone().all_frames();
        *self != of_file
    }

    /// This conversion without the options that change the frames.
    #[doc(hidden)]
    pub fn all_frames(self) -> Self {
        Self {
            first: None,
            last: None,
            frame_rate: None,
            first_frame: FirstFrame::Keep,
            ..self
        }
    }

    /// The first and the last tick to keep of each animation.
    fn parts(&self, scene: &Scene, survey: &crate::Survey) -> Result<Vec<(f64, f64)>> {
        if scene.animations.is_empty() {
            part_ticks(None, self.first, self.last, 0.0)?;
        }
        let drops = |index: usize| match self.first_frame {
            FirstFrame::Keep => false,
            FirstFrame::Drop => true,
            FirstFrame::DropRestPose if index == 0 => survey.first_frame_is_rest_pose,
            FirstFrame::DropRestPose => process::first_frame_is_rest_pose(scene, index),
        };
        let part = |(index, animation): (usize, &Animation)| {
            let start = if drops(index) { 1.0 } else { 0.0 };
            let part = part_ticks(Some(animation), self.first, self.last, start);
            part.map_err(|error| scene.in_clip(index, error))
        };
        scene.animations.iter().enumerate().map(part).collect()
    }

    /// Whether the conversion needs the unit and the up axis of the source. Root motion is horizontal, so it needs the
    /// up axis.
    fn needs(&self) -> Needs {
        Needs {
            unit: !self.keep_units || self.output.metres_per_unit.is_some(),
            up: !self.keep_units || self.output.up.is_some() || self.root != RootMotion::Keep,
        }
    }

    /// Converts the unit, the axes and the root motion, with +Y up. Returns an inserted node.
    fn convert_space(&self, scene: &mut Scene, survey: &crate::Survey) -> Option<NodeId> {
        self.source.state(scene);
        let source = Space::default().or_found(&scene.metadata, survey, self.needs());
        let kept = if self.keep_units { source } else { Space::METRES };
        let output = self.output.or(kept);
        // An unknown unit or axis is not converted, so any value works.
        let values = |space: Space| (space.metres_per_unit.unwrap_or(1.0), space.up.unwrap_or_default());
        let (from, to) = (values(source), values(output));
        let upright = match self.root {
            RootMotion::Keep => to,
            RootMotion::InPlace | RootMotion::Extract => (to.0, UpAxis::Y),
        };
        if !self.keep_units || from != upright {
            process::convert_units_to(scene, from, upright);
        }
        let inserted = match self.root {
            RootMotion::Keep => None,
            RootMotion::InPlace => {
                scene.put_in_place();
                None
            }
            RootMotion::Extract => scene.extract_root_motion(),
        };
        if upright != to {
            process::convert_units_to(scene, upright, to);
        }
        if !self.keep_units || from != to {
            // The values of the scene are no longer those of the file.
            scene.metadata.file_space = FileSpace::default();
        }
        // A value that was neither stated nor guessed is still unknown.
        scene.metadata.metres_per_unit = output.metres_per_unit;
        scene.metadata.up = output.up;
        inserted
    }
}

/// Keeps a part of each animation.
fn trim(scene: &mut Scene, parts: &[(f64, f64)]) {
    let cuts = |(first, last): (f64, f64)| first > 0.0 || last.is_finite();
    let Some(common) = parts.first().filter(|common| parts.iter().all(|part| part == *common)) else {
        for (index, part) in parts.iter().enumerate().filter(|(_, part)| cuts(**part)) {
            scene.change_clip(index, |scene| scene.trim(part.0, part.1));
        }
        return;
    };
    if cuts(*common) {
        scene.trim(common.0, common.1);
    }
}

/// Whether resampling uses the exact rate of a rounded frame time.
fn takes_meant_rate(animation: Option<&Animation>, rate: f64) -> bool {
    animation.is_some_and(|animation| {
        let stated = animation.ticks_per_second;
        process::rate_before(stated, rate) != stated
    })
}
