//! The weights of the foot lock, from one table.

use mocap_scene::options::weights;

weights! {
    /// The weights of [`foot_lock()`](crate::foot_lock()), also where a retargeted motion follows the feet of its
    /// source.
    ///
    /// ```
    /// use mocap::edit::{FootLockOptions, FootLockWeights};
    ///
    /// let options = FootLockOptions::new().weights(FootLockWeights::new().acceleration_ratio(1.2));
    /// assert_eq!(options.weights.speed_ratio, 1.2);
    /// ```
    FootLockWeights in "foot-lock" {
        speed_ratio = 1.2, "1",
            "Largest ratio of the speed of a foot joint to its speed without the lock. Above it the lock is relaxed. A \
            speed that is a fifth higher is not visible. `tools/feet/check` measures it on every motion.";
        acceleration_ratio = 1.5, "1",
            "Largest ratio of accelerations, as `speed_ratio`. A foot that is released has to catch up with its swing. \
            `tools/feet/check` measures it on every motion.";
        aim = 0.97, "1",
            "Fraction of both ratios at which relaxing aims. The margin allows for the rounding of keys, and for \
            changes of the next frame.";
        around = 0.25, "s",
            "Time before and after a frame in which the largest speed and acceleration without the lock are taken. The \
            lock may move an acceleration to another frame. It is a quarter of a footstep in a walk.";
        moving = 0.25, "1",
            "Fraction of the highest speed and of the largest acceleration of the motion that a foot may always have. \
            A quarter is not visible as a jerk.";
        still_speed = 0.1, "m/s",
            "Speed that a foot may always have. A slower movement is not visible.";
        still_acceleration = 2.0, "m/s^2",
            "Acceleration that a foot may always have: a fifth of gravity, less than a shift of the weight causes.";
        ease = 0.15, "s",
            "Time in which a lock is relaxed before a frame, and returns after it. It is below the 0.2 s in which \
            shifts ease out.";
        least_step = 0.2, "1",
            "Least fraction by which a round of relaxing changes a lock, so that few rounds are enough.";
        stretch = 0.9995, "1",
            "Fraction of its full length to which a leg may be stretched, unless the motion stretches it more. The \
            knee of a leg of 0.84 m is then 13 mm off the straight line, which is not visible.";
        knee_height = 10.0, "1",
            "Cost of a change of the height of a foot, relative to a change of its knee. If a foot moves by a \
            millimetre, the knee of a nearly straight leg moves by centimetres, so the foot gives way.";
        on_the_ground = 0.04, "leg",
            "Height, in lengths of the leg, below which the source's foot is on the ground, for a retargeted motion. \
            It is 3 cm for an adult, below the 5 cm of contacts. Above three times this height, the foot is in the \
            air.";
        slack = 0.01, "leg",
            "Height, in lengths of the leg, by which a foot may stay above its goal before the hips are lowered: 8 mm \
            for an adult.";
        largest_turn = 0.6, "rad",
            "Largest angle by which a foot rotates to follow the source's foot. It is 34 degrees, within the range of \
            an ankle: 20 and 50 degrees (American Academy of Orthopaedic Surgeons, Joint Motion, 1965).";
        gives_way = 2.0, "s",
            "Time constant in which a locked foot follows a source that slides in contact. It is two footsteps of a \
            walk. So a body whose feet always slide does not leave its feet behind.";
    }
}
