//! How far coded tracks are from what they stand for: the proof, in double precision, of what was made in single.

use std::ops::Range;

use super::FittedTrack;
use super::lanes::DOUBLES;
use super::motion::Motion;
use super::play::{Body, CHORD, Clock, Frames, Lanes, Player, WAYS};

/// The largest distance between a joint and its place, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Measured {
    /// In metres.
    pub(crate) max: f64,
    /// The root of the mean square of all distances.
    pub(crate) rms: f64,
    /// The node of the largest.
    pub(crate) node: usize,
    /// Its moment.
    pub(crate) tick: f64,
}

/// What was measured at every frame.
pub(super) struct Errors {
    /// The largest distances.
    pub(super) frames: Vec<f64>,
    /// Their nodes.
    nodes: Vec<usize>,
    /// The sums of the squares of all distances.
    squares: Vec<f64>,
}

impl Errors {
    /// For so many frames, none of them measured.
    pub(super) fn new(frames: usize) -> Self {
        Self {
            frames: vec![0.0; frames],
            nodes: vec![0; frames],
            squares: vec![0.0; frames],
        }
    }

    pub(super) fn summary(&self, motion: &Motion) -> Measured {
        let mut measured = Measured::default();
        for (frame, &error) in self.frames.iter().enumerate() {
            if error > measured.max || error.is_nan() {
                measured = Measured {
                    max: error,
                    node: self.nodes[frame],
                    tick: motion.ticks[frame],
                    rms: 0.0,
                };
            }
        }
        let distances = (motion.joints.len() * self.frames.len()).max(1);
        measured.rms = (self.squares.iter().sum::<f64>() / distances as f64).sqrt();
        measured
    }

    /// How far off every node is, of `nodes`, where it is farther off than all others.
    pub(super) fn of_nodes(&self, nodes: usize) -> Vec<f64> {
        let mut errors = vec![0.0; nodes];
        for (&node, &error) in std::iter::zip(&self.nodes, &self.frames) {
            errors[node] = f64::max(errors[node], error);
        }
        errors
    }
}

/// Forward kinematics of both sides, for every way of reading. Where decoders may differ, the error is the largest that
/// any can have.
pub(super) struct Proof<'a> {
    pub(super) motion: &'a Motion<'a>,
    pub(super) tracks: &'a [FittedTrack],
    /// The 32-bit times of the frames in the file, and the moments of comparison: at a cut the moment before is another
    /// pose.
    pub(super) times: &'a [f32],
    /// How far the source itself may be off, being of 32-bit numbers; it counts as error.
    pub(super) rounding: f64,
}

impl Proof<'_> {
    /// At every frame of some stretches.
    pub(super) fn measure(&self, stretches: &[Range<usize>], errors: &mut Errors) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor was asked, and has these instructions.
            #[allow(
                unsafe_code,
                reason = "a ninth of a conversion, and nothing else differs: `tools/bench/README.md`"
            )]
            return unsafe { self.measure_with_avx2(stretches, errors) };
        }
        self.measure_lanes(stretches, errors);
    }

    /// The same code with vectors of four lanes in place of two. Sums and products are not fused, so that every
    /// processor gives the same bits.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn measure_with_avx2(&self, stretches: &[Range<usize>], errors: &mut Errors) {
        self.measure_lanes(stretches, errors);
    }

    #[inline(always)]
    fn measure_lanes(&self, stretches: &[Range<usize>], errors: &mut Errors) {
        let times = self.times;
        let mut clocks: Vec<Clock> = Vec::new();
        let players: Vec<Player> = std::iter::zip(&self.motion.joints, self.tracks)
            .map(|(joint, track)| Player::new(self.motion, joint, track, &mut clocks))
            .collect();
        // Where every frame has a key nobody goes from one to the next.
        let ways = if clocks.iter().all(|clock| clock.grid.len() == times.len()) {
            CHORD
        } else {
            WAYS
        };
        let mut bodies = vec![Body::default(); players.len()];
        for stretch in stretches {
            for first in stretch.clone().step_by(DOUBLES) {
                let count = (stretch.end - first).min(DOUBLES);
                let frames = Frames { first, count };
                for clock in &mut clocks {
                    clock.set(times, frames);
                }
                let mut worst = Lanes::ZERO;
                let mut nodes = Lanes::ZERO;
                let mut squares = Lanes::ZERO;
                for (index, player) in players.iter().enumerate() {
                    let (above, rest) = bodies.split_at_mut(index);
                    let body = &mut rest[0];
                    player.play(frames, &clocks, ways, above, body);
                    let mut error = body.off(ways).sqrt() + Lanes::all(self.rounding);
                    if let Some(parent) = player.joint.parent.filter(|parent| above[*parent].is_doubtful) {
                        error = error + doubt(&players, above, parent, body);
                    }
                    squares = squares + error * error;
                    nodes = Lanes::of(|lane| {
                        let is_worse = error.0[lane] > worst.0[lane] || error.0[lane].is_nan();
                        if is_worse { index as f64 } else { nodes.0[lane] }
                    });
                    worst = worst.max(error);
                }
                for lane in 0..count {
                    errors.frames[first + lane] = worst.0[lane];
                    errors.nodes[first + lane] = nodes.0[lane] as usize;
                    errors.squares[first + lane] = squares.0[lane];
                }
            }
        }
    }
}

/// By how much decoders may differ about the place of a body below `above`, one of `bodies`.
#[inline(always)]
fn doubt(players: &[Player], bodies: &[Body], above: usize, body: &Body) -> Lanes {
    let mut sum = Lanes::ZERO;
    let mut place = Some(above);
    while let Some(joint) = place.filter(|place| bodies[*place].is_doubtful) {
        if let Some(doubt) = bodies[joint].doubt {
            sum = sum + doubt * body.here.distance_squared(bodies[joint].here).sqrt();
        }
        place = players[joint].joint.parent;
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::slice;
    use std::sync::Arc;

    use glam::{Mat4, Quat, Vec3};

    use super::*;
    use crate::compress::{CodedRotation, Grid, Rotation, RotationCode, Translation, keys};
    use crate::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, Scene};

    const FRAMES: usize = 14;
    const LAST: usize = FRAMES - 1;

    /// A joint at the origin that turns about z, by so much in all, and its end site one metre away on the x axis.
    fn turning(degrees: f32) -> Scene {
        let node = |index: usize| Node {
            name: ["Joint", "End"][index].into(),
            kind: [NodeKind::Joint, NodeKind::EndSite][index],
            parent: index.checked_sub(1).map(NodeId::new),
            transform: Mat4::from_translation(Vec3::X * index as f32),
            ..Node::default()
        };
        Scene {
            nodes: (0..2).map(node).collect(),
            animations: vec![Animation {
                ticks_per_second: 30.0,
                duration: LAST as f64,
                channels: vec![Channel {
                    node_name: "Joint".into(),
                    node: None,
                    position_keys: Keys::constant(Vec3::ZERO),
                    rotation_keys: Keys::every_tick((0..FRAMES).map(|frame| turn(degrees, frame)).collect()),
                    scaling_keys: Keys::constant(Vec3::ONE),
                }],
                ..Animation::default()
            }],
            ..Scene::default()
        }
    }

    fn turn(degrees: f32, frame: usize) -> Quat {
        Quat::from_rotation_z((degrees * frame as f32 / LAST as f32).to_radians())
    }

    /// The angle of a frame, and the angle of all frames.
    fn angles(degrees: f32, frame: usize) -> (f64, f64) {
        let all = f64::from(degrees).to_radians();
        (all * frame as f64 / LAST as f64, all)
    }

    /// What [`turning`] comes to with keys at the frames of `grid`, each with its value and its doubts.
    fn tracks(grid: Grid, key: impl Fn(usize) -> (Quat, u8)) -> Vec<FittedTrack> {
        let key = |frame: &u32| {
            let (value, doubts) = key(*frame as usize);
            CodedRotation {
                code: [0; 4],
                value,
                doubts,
            }
        };
        let keys = grid.iter().map(key).collect();
        vec![
            FittedTrack {
                translation: Translation::Still(Vec3::ZERO),
                rotation: Rotation::Moving {
                    code: RotationCode::Float,
                    grid: Arc::new(grid),
                    keys,
                },
            },
            FittedTrack {
                translation: Translation::Still(Vec3::X),
                rotation: Rotation::Still(Quat::IDENTITY),
            },
        ]
    }

    /// The largest distances at all frames.
    fn measured(degrees: f32, tracks: &[FittedTrack]) -> Vec<f64> {
        let scene = turning(degrees);
        let motion = Motion::new(&scene, &scene.animations[0]).unwrap();
        let times: Vec<f32> = motion.ticks.iter().map(|tick| (tick / 30.0) as f32).collect();
        let proof = Proof {
            motion: &motion,
            tracks,
            times: &times,
            rounding: 0.0,
        };
        let mut errors = Errors::new(FRAMES);
        proof.measure(slice::from_ref(&(0..FRAMES)), &mut errors);

        // The same bits without wide vectors, and nearly the same in stretches that no number of lanes divides.
        let mut plain = Errors::new(FRAMES);
        proof.measure_lanes(slice::from_ref(&(0..FRAMES)), &mut plain);
        assert_eq!(errors.frames, plain.frames);
        let mut parts = Errors::new(FRAMES);
        proof.measure(&[0..3, 3..4, 4..9, 9..FRAMES], &mut parts);
        for (all, part) in std::iter::zip(&errors.frames, &parts.frames) {
            assert!((all - part).abs() < 1e-15, "{all}, not {part}");
        }
        errors.frames
    }

    /// 32-bit quaternions are off by some 1e-7, and so is what they turn at a distance of a metre.
    fn assert_near(found: &[f64], expected: impl Fn(usize) -> f64) {
        for (frame, found) in found.iter().enumerate() {
            let expected = expected(frame);
            assert!(
                (found - expected).abs() < 3e-7,
                "frame {frame}: {found}, not {expected}"
            );
        }
    }

    /// From key to key the angle of a chord is not that of the arc: `tan a = s sin A / (1 - s + s cos A)`, for half of
    /// what the quaternions turn by.
    #[test]
    fn the_worst_reader_goes_along_the_chord() {
        // On both sides of where the series for small angles ends.
        for degrees in [12.0, 21.0, 24.0, 100.0, 170.0] {
            let found = measured(
                degrees,
                &tracks(vec![0, LAST as u32], |frame| (turn(degrees, frame), 0)),
            );
            assert_near(&found, |frame| {
                let (angle, all) = angles(degrees, frame);
                let (share, half) = (frame as f64 / LAST as f64, all / 2.0);
                let chord = 2.0 * (share * half.sin()).atan2(1.0 - share + share * half.cos());
                2.0 * ((chord - angle) / 2.0).sin().abs()
            });
        }
    }

    /// A quaternion of length l, taken as it is, is the matrix `I + l^2 (R - I)`.
    #[test]
    fn a_length_that_is_not_one_stretches() {
        let length = 1.01;
        let longer = |frame| (turn(60.0, frame) * length, 0);
        let found = measured(60.0, &tracks(keys::all(FRAMES), longer));
        let square = f64::from(length).powi(2);
        assert_near(&found, |frame| {
            let (angle, _) = angles(60.0, frame);
            (square - 1.0) * 2.0 * (angle / 2.0).sin()
        });
    }

    /// By how much decoders may differ, the end site may be off.
    #[test]
    fn doubt_counts_as_error() {
        let doubtful = |frame| (turn(60.0, frame), if frame == 5 { 3 } else { 0 });
        let found = measured(60.0, &tracks(keys::all(FRAMES), doubtful));
        assert_near(
            &found,
            |frame| if frame == 5 { 2.0 * 3f64.sqrt() / 32767.0 } else { 0.0 },
        );
    }

    #[test]
    fn the_worst_frame_is_named() {
        let scene = turning(60.0);
        let motion = Motion::new(&scene, &scene.animations[0]).unwrap();
        let mut errors = Errors::new(FRAMES);
        (errors.frames[4], errors.nodes[4]) = (0.5, 1);
        (errors.frames[7], errors.nodes[7]) = (0.25, 0);
        errors.squares[4] = 0.25 * (2 * FRAMES) as f64;
        let found = errors.summary(&motion);
        assert_eq!((found.max, found.node, found.tick, found.rms), (0.5, 1, 4.0, 0.5));
        assert_eq!(errors.of_nodes(3), [0.25, 0.5, 0.0]);
    }
}
