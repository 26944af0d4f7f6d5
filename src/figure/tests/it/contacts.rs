//! Tests the rule by which a contact begins and ends.

use mocap_figure::contacts::ContactRule;

#[test]
fn it_takes_more_to_leave_than_to_stay_away() {
    let rule = ContactRule {
        height: 1.0,
        speed: 10.0,
        release: 2.0,
        shortest: 0.0,
        gap: 0.0,
    };
    let heights = [1.5, 0.9, 1.5, 2.1, 1.5, 1.0];
    let found = rule.at_rest(heights.into_iter().map(|height| (height, 0.0)), 1.0);
    assert_eq!(found, [false, true, true, false, false, true]);
    let speeds = [15.0, 9.0, 19.0, 21.0];
    let found = rule.at_rest(speeds.into_iter().map(|speed| (0.0, speed)), 1.0);
    assert_eq!(found, [false, true, true, false]);
}

#[test]
fn short_gaps_close_and_short_contacts_go() {
    let parse = |text: &str| text.chars().map(|c| c == '#').collect::<Vec<_>>();
    // At one frame per second, the rule closes gaps below 3 frames, and drops contacts below 4 frames.
    let rule = ContactRule {
        gap: 3.0,
        shortest: 4.0,
        ..ContactRule::default()
    };
    for (before, after) in [
        ("..###.###..", "..#######.."),
        ("..##....##..", "............"),
        (".#.#.#......", ".#####......"),
        ("##......####", "##......####"),
        ("####......#.", "####........"),
    ] {
        let height = |is_low: bool| if is_low { 0.0 } else { 1.0 };
        let samples = parse(before).into_iter().map(|is_low| (height(is_low), 0.0));
        assert_eq!(rule.at_rest(samples, 1.0), parse(after), "{before}");
    }
}
