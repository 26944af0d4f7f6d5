//! The weights of the robot solver, from one table.

use mocap_scene::options::weights;

weights! {
    /// The weights of the robot solver. They multiply squared residuals. The direction of a limb and the rotation of
    /// the trunk have the weight 1: a radian costs 1.
    ///
    /// ```
    /// use mocap::retarget::robot::{RobotOptions, Weights};
    ///
    /// let options = RobotOptions::new().weights(Weights::new().hand(1.0));
    /// assert_eq!(options.weights.hand, 1.0);
    /// ```
    Weights in "robot" {
        twist = 0.01, "1/rad^2",
            "Roll of a limb, and rotation of a foot about an axis that no ankle joint drives. It is a hundredth of \
            the weight of a limb's direction (1), so that it only decides what directions leave undetermined.";
        hand = 0.2, "1/rad^2",
            "Rotation of a hand. It is below the weight of a limb's direction (1), so that a wrist with few joints \
            does not turn the forearm away from its direction.";
        head = 0.3, "1/rad^2",
            "Rotation of the head. It is below the weight of the trunk's rotation (1), so that a neck with few joints \
            does not bend the trunk.";
        foot = 0.3, "1/rad^2",
            "Rotation of a foot in the air about the axes that the ankle drives. It is below the weight of a limb's \
            direction (1), so that the foot follows the leg.";
        foot_heading = 0.3, "1",
            "Fraction of `foot` about the up axis. The hip turns a foot about this axis, not the ankle.";
        standing = 12.0, "1",
            "Additional weight in contact: a foot in stance has the weight `foot` × (1 + `standing`), so that it is flat. \
            `tools/robot/check` measures the distance of soles from the floor.";
        foot_place = 10000.0, "1/m^2",
            "Position of an ankle, or of the sole of a foot in stance, and depth below the floor. A centimetre costs \
            as much as a radian of a direction, so that feet do not slide. `tools/robot/check` measures the sliding.";
        hips_place = 9.0, "1/m^2",
            "Position of the hips. A third of a metre costs as much as a radian: legs cannot stretch, so the hips \
            give way. The weight also converts the velocity of the base (m/s) to the velocity of a joint (rad/s).";
        air_place = 100.0, "1/m^2",
            "Position of an ankle in the air in the second pass. It is a hundredth of `foot_place`, so that the swing \
            becomes smooth.";
        standing_height = 3000.0, "1/m^2",
            "Largest weight of the height of a foot in the second pass. It is below `foot_place`: if a foot cannot \
            reach its goal, the height deviates before the position over the ground. A separate term keeps feet above \
            the floor.";
        nearing = 0.08, "s",
            "Time constant in which the weight of an ankle changes between air and ground: a fifth of the swing of a \
            walk, which takes 0.4 s.";
        held_distance = 0.1, "m",
            "Largest distance between a foot in stance and the source's foot: less than half a foot. At a larger \
            distance, the source has already left the place of the contact.";
        return_time = 0.12, "s",
            "Time constant in which a foot that leaves the ground returns to the source's foot: a third of the swing \
            of a walk, which takes 0.4 s.";
        hold = 0.0004, "1/rad^2",
            "Change of a joint from the previous frame in the first pass. A radian costs as much as 0.02 rad of a \
            direction, so it only decides between equally good solutions.";
        branch_change = 1.0, "1/rad^2",
            "Change of the joints of a limb from frame to frame at 30 frames per second, when a limb is solved again. \
            A radian costs as much as a radian of a direction.";
        branch_place = 130.0, "1/m^2",
            "Largest weight of a position when a limb is solved again. 3 cm cost as much as 20 degrees. These are the \
            limits from which on a limb is solved again.";
        velocity = 4e-7, "s^2/rad^2",
            "Velocity of a joint in the second pass. 16 rad/s, faster than human limbs, cost as much as 0.01 rad of a \
            direction.";
        acceleration = 3e-6, "s^4/rad^2",
            "Difference between the acceleration of a joint and its acceleration in the first pass without jitter. \
            `tools/robot/check` measures the jitter.";
        base_acceleration = 1e-3, "s^4/m^2",
            "Difference between the acceleration of the base and its acceleration in the first pass without jitter. \
            The base carries the mass of the robot, so the floor cannot provide the force that jitter needs. The \
            angular acceleration of the base has ten times the weight `acceleration`.";
        base_smoothing = 0.06, "s",
            "Standard deviation of the Gaussian that removes the jitter from the accelerations of the base. It halves \
            amplitudes at 3 Hz, because people walk with two footsteps per second.";
        joint_smoothing = 0.04, "s",
            "Standard deviation of the Gaussian that removes the jitter from the accelerations of joints. It halves \
            amplitudes at 5 Hz, because limbs are faster than the base.";
        step_limit = 100.0, "1/rad^2",
            "Part of the change of a joint between two frames that is above the velocity limit of the robot's file. A \
            tenth of a radian costs as much as a radian of a direction. mocap cuts off the part that remains.";
        apart = 1000.0, "1/m^2",
            "Penetration depth of two links. 3 cm cost as much as a radian of a direction. It is a tenth of \
            `foot_place`, so that feet in stance keep their place.";
    }
}
