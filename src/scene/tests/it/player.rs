//! Tests which tick a player shows at a given time.

use mocap::scene::Animation;
use mocap::{Binding, LoopMode, Player, Pose, Scene, Updater};

/// A player for four ticks, at two ticks per second.
fn player(loop_mode: LoopMode, speed: f64) -> Player {
    let animation = Animation {
        ticks_per_second: 2.0,
        duration: 4.0,
        ..Animation::default()
    };
    let mut player = Player::new(&animation);
    player.loop_mode = loop_mode;
    player.speed = speed;
    player
}

fn ticks(mut player: Player, seconds: f64, count: usize) -> Vec<f64> {
    (0..count).map(|_| player.advance(seconds)).collect()
}

#[test]
fn once_stops_at_the_end_it_plays_towards() {
    assert_eq!(ticks(player(LoopMode::Once, 1.0), 0.75, 4), [1.5, 3.0, 4.0, 4.0]);
    let mut backwards = player(LoopMode::Once, -1.0);
    backwards.tick = 2.0;
    assert!(!backwards.is_finished());
    assert_eq!(backwards.advance(0.5), 1.0);
    assert_eq!(backwards.advance(5.0), 0.0);
    assert!(backwards.is_finished());
}

#[test]
fn loop_takes_the_duration_for_a_round() {
    assert_eq!(ticks(player(LoopMode::Loop, 1.0), 0.75, 4), [1.5, 3.0, 0.5, 2.0]);
    assert_eq!(ticks(player(LoopMode::Loop, -1.0), 0.75, 4), [2.5, 1.0, 3.5, 2.0]);
    assert_eq!(ticks(player(LoopMode::Loop, 1.0), 21.0, 1), [2.0]);
    assert!(!player(LoopMode::Loop, 1.0).is_finished());
}

#[test]
fn ping_pong_turns_at_both_ends() {
    let expected = [1.5, 3.0, 3.5, 2.0, 0.5, 1.0, 2.5, 4.0, 2.5];
    assert_eq!(ticks(player(LoopMode::PingPong, 1.0), 0.75, 9), expected);
    assert_eq!(ticks(player(LoopMode::PingPong, -1.0), 0.75, 9), expected);
    assert_eq!(ticks(player(LoopMode::PingPong, 1.0), 21.0, 2), [2.0, 4.0]);
}

#[test]
fn ping_pong_forgets_its_way_back_when_the_mode_changes() {
    let mut player = player(LoopMode::PingPong, 1.0);
    assert_eq!(player.advance_ticks(5.0), 3.0);
    player.loop_mode = LoopMode::Loop;
    assert_eq!(player.advance_ticks(0.5), 3.5);
    player.loop_mode = LoopMode::PingPong;
    assert_eq!(player.advance_ticks(0.25), 3.75);
}

#[test]
fn speed_scales_time() {
    assert_eq!(ticks(player(LoopMode::Loop, 0.25), 1.0, 3), [0.5, 1.0, 1.5]);
    assert_eq!(ticks(player(LoopMode::Loop, 0.0), 1.0, 2), [0.0, 0.0]);
}

#[test]
fn numbers_without_sense_keep_the_tick_in_range() {
    for loop_mode in [LoopMode::Once, LoopMode::Loop, LoopMode::PingPong] {
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN] {
            let mut player = player(loop_mode, 1.0);
            player.advance_ticks(odd);
            assert!(
                (0.0..=4.0).contains(&player.tick),
                "{loop_mode:?} {odd}: {}",
                player.tick
            );
            player.tick = odd;
            player.advance_ticks(1.0);
            assert!(
                (0.0..=4.0).contains(&player.tick),
                "{loop_mode:?} from {odd}: {}",
                player.tick
            );

            let animation = Animation {
                ticks_per_second: odd,
                duration: f64::NAN,
                ..Animation::default()
            };
            let mut player = Player::new(&animation);
            player.loop_mode = loop_mode;
            assert_eq!(player.advance(1.0), 0.0);
            assert_eq!(player.is_finished(), loop_mode == LoopMode::Once);
        }
    }
}

#[test]
fn everything_that_plays_can_be_shared_between_threads() {
    const fn assert_send_sync<T: Send + Sync>() {}
    const {
        assert_send_sync::<Scene>();
        assert_send_sync::<Animation>();
        assert_send_sync::<Pose>();
        assert_send_sync::<Player>();
        assert_send_sync::<Binding>();
        assert_send_sync::<Updater>();
    }
}
