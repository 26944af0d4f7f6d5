//! The weights of the cleaning, which one table declares with their defaults.

use mocap_scene::options::weights;

weights! {
    /// The weights of [`Clean`](crate::Clean). They decide which changes are noise or errors, and how strongly the step
    /// removes them.
    ///
    /// ```
    /// use mocap::edit::{Clean, CleanWeights};
    ///
    /// let clean = Clean::new().weights(Some(CleanWeights::new().least_angle(1.0)));
    /// assert_eq!(serde_json::to_string(&clean.weights).unwrap(), r#"{"least-angle":1.0}"#);
    /// ```
    CleanWeights in "clean" {
        smoothing = 0.5, "1",
            "Jerk that the smoother allows, as a fraction of the jerk that predicts the motion best. The smoother \
            needs less jerk than a prediction, because it also uses the frames after each frame. The value was chosen \
            on seed 1 of `tools/clean`. If the smoother cuts the peaks of the motion, mocap tries twice and eight \
            times this value.";
        least_angle = 0.5, "degrees",
            "Least standard deviation of the noise of a rotation that mocap removes. Marker systems have less noise. \
            Estimates from video have 1 to 3 degrees. `tools/clean/check` tests this value.";
        least_distance = 0.0015, "m",
            "Least standard deviation of position noise. It also applies to the displacement of the farthest joint by \
            the noise of an angle. Marker systems have less than 1 mm.";
        joint_length = 0.03, "m",
            "Distance that counts as much as a radian, if mocap smooths positions and rotations together. The \
            direction of a bone that is shorter than this distance is less precise than its rotation.";
        world = 0.8, "1",
            "Mixing factor of two positions of a joint: 0 is the position that its smoothed rotations give, 1 is its \
            smoothed position. The errors of both positions are almost independent, so a mean is better than either. \
            The value was chosen on seed 1 of `tools/clean`.";
        largest_turn = 15.0, "degrees",
            "Largest angle by which a joint rotates towards its smoothed position: five times the noise of an estimate \
            from video.";
        longest_held = 0.5, "s",
            "Longest run of held frames that mocap fills. A longer run is a frozen pose, and may be intended.";
        least_evidence = 0.23, "1",
            "Mean logarithm of the residuals above which a frame was certainly dropped. Of 42 clean cuts of 3 to 8 s \
            at 30 and 60 Hz, none has more than 0.22. In a test, 144 frames were removed while a joint rotated by 60 \
            degrees per second: 142 have more than 0.24.";
        least_evidence_of_doubled = 0.02, "1",
            "As `least_evidence`, for a doubled frame. This value is lower, because the doubled frame itself is \
            visible.";
        least_speed = 0.35, "rad/s",
            "Least speed of a joint, or of the body in body lengths, at which a dropped frame is inserted. Below 20 \
            degrees per second, changes between frames show only the rounding of a file.";
        exchange = 4.0, "degrees",
            "Cost of an exchange of left and right limbs, added to the median change from frame to frame. It is twice \
            the noise of an estimate from video, so that noise does not cause an exchange.";
        length_noise = 0.001, "m",
            "Mean change of a bone length from frame to frame above which the bone gets a constant length. Rounding of \
            positions in files causes smaller changes.";
        largest_length_change = 0.15, "1",
            "Mean change of a bone, as a fraction of its length, above which the change is intended, as in a cartoon.";
        least_skate = 0.2, "m/s",
            "Mean speed of feet in contact below which mocap does not lock them, if `clean` found little noise. Takes of \
            marker systems reach 0.18 m/s in runs, because contacts begin and end in motion.";
        contact_speed = 0.4, "m/s",
            "Largest speed of a foot in contact after noise was removed. The residual of 2 degrees of noise moves a \
            foot in stance by about 0.2 m/s.";
        contact_distance = 0.03, "m",
            "Largest distance over the ground from the resting place of a foot at which the foot still counts as in \
            contact. Smoothing makes a foot come to rest slowly.";
        contact_gap = 0.15, "s",
            "Longest gap between two contacts at one place at which mocap joins the contacts. A foot does not leave \
            its place and return \
            in less than half a swing.";
        contact_height = 0.08, "m",
            "Largest height of a foot above its resting level in a contact. It includes a heel that rolls off, but not \
            a swing.";
        hand_distance = 0.13, "m",
            "Distance between the centres of two hands that touch, for a body of 1.7 m: half of the thickness of each \
            hand, and some noise.";
        hand_fade = 1.4, "1",
            "Factor of `hand_distance` and `hand_speed` at which the weight of a hand contact is 0. Up to \
            `hand_distance`, the weight is 1. In between, the weight decreases, so that no joint jumps.";
        hand_speed = 0.15, "m/s",
            "Speed of a hand relative to the body below which the hand counts as resting on the body. A hand that \
            passes by is faster.";
        hand_blend = 0.1, "s",
            "Time in which the weight of a hand contact rises and falls: three frames of video, so that arms do not \
            jerk.";
        hand_noise = 0.1, "m",
            "Largest distance by which mocap moves an arm to restore a hand contact, and by which the hand may miss \
            this contact. The noise of an estimate from video is not larger.";
    }
}
