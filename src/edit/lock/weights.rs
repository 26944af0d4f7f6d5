//! The weights of the foot lock, which one table declares with their defaults.

use mocap_scene::options::weights;

weights! {
    /// The weights of [`foot_lock()`](crate::foot_lock()). A retargeted motion that follows the feet of its source uses
    /// them, too.
    ///
    /// ```
    /// use mocap::edit::{FootLockOptions, FootLockWeights};
    ///
    /// let options = FootLockOptions::new().weights(FootLockWeights::new().acceleration_ratio(1.2));
    /// assert_eq!(options.weights.speed_ratio, 1.2);
    /// ```
    FootLockWeights in "foot-lock" {
        speed_ratio = 1.2, "1",
            "Largest ratio of the speed of a foot joint to its speed without the lock. Above this ratio, mocap \
            relaxes the lock. A speed that is a fifth higher is not visible. `tools/feet/check` measures this ratio \
            on the motions of `fixtures/real`.";
        acceleration_ratio = 1.5, "1",
            "Largest ratio of the acceleration of a foot joint to its acceleration without the lock. Above this \
            ratio, mocap relaxes the lock. A released foot must catch up with its swing. `tools/feet/check` measures \
            this ratio on the motions of `fixtures/real`.";
        aim = 0.97, "1",
            "Goal of relaxing a lock, as a fraction of `speed_ratio` and `acceleration_ratio`. The margin of 3 % is \
            for two effects: keys are rounded, and relaxing the lock in the next frame changes the speed in this \
            frame.";
        around = 0.25, "s",
            "Time before and after a frame in which mocap looks for the largest speed and acceleration without the \
            lock. The lock may move an acceleration to another frame. This time is half of the time of a footstep in a walk.";
        moving = 0.25, "1",
            "Fraction of the highest speed and of the largest acceleration of the motion that a foot may always have. \
            A quarter is not visible as a jerk.";
        still_speed = 0.1, "m/s",
            "Speed that a foot may always have. A slower movement is not visible.";
        still_acceleration = 2.0, "m/s^2",
            "Acceleration that a foot may always have: a fifth of gravity, less than a shift of the weight causes.";
        ease = 0.15, "s",
            "Time in which a lock fades out before a frame that is above a ratio, and fades in after this frame. It \
            is shorter than the default of the option `blend` of `foot-lock` (0.2 s).";
        least_step = 0.2, "1",
            "Least fraction by which one round of relaxing reduces a lock. With this minimum, few rounds are enough.";
        stretch = 0.9995, "1",
            "Fraction of its full length to which a leg may be stretched, unless the motion stretches it more. The \
            knee of a leg of 0.84 m is then 13 mm off the straight line, which is not visible.";
        knee_height = 10.0, "1",
            "Cost of a change of a foot's height, relative to an equal change of its knee. In a nearly straight leg, \
            a millimetre of height moves the knee by centimetres. In such a leg, mocap therefore changes the height \
            of the foot, and spares the knee.";
        on_the_ground = 0.04, "leg",
            "Height, in lengths of the leg, below which the source's foot is on the ground, for a retargeted motion. \
            Above three times this height, the foot is in the air. The height is 3 cm for an adult. The detection of \
            contacts allows more, 5 cm (option `height` of `foot-lock`).";
        slack = 0.01, "leg",
            "Height, in lengths of the leg, by which a foot may stay above its goal before mocap lowers the hips: 8 \
            mm for an adult.";
        largest_turn = 0.6, "rad",
            "Largest angle by which a foot rotates to follow the source's foot: 34 degrees. A person's ankle bends 20 \
            degrees up and 50 degrees down (American Academy of Orthopaedic Surgeons, Joint Motion, 1965).";
        gives_way = 2.0, "s",
            "Time constant with which a locked foot follows a source foot that slides in contact: the time of four \
            footsteps in a walk. A body whose feet always slide therefore does not leave its feet behind.";
    }
}
