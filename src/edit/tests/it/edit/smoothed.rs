//! What the filters of `smooth` leave of an oscillation.

use mocap::edit::SmoothFilter;

/// How much of an oscillation of `frequency` the filter leaves, from its weights.
fn response(filter: SmoothFilter, frequency: f64) -> f64 {
    let kernel = filter.kernel(6.0, 240.0);
    let phase = |frame: usize| (std::f64::consts::TAU * frequency * frame as f64 / 240.0).cos();
    let terms = kernel.iter().enumerate().skip(1);
    f64::from(kernel[0])
        + 2.0
            * terms
                .map(|(frame, weight)| f64::from(*weight) * phase(frame))
                .sum::<f64>()
}

#[test]
fn the_filters_have_the_responses_that_define_them() {
    for (frequency, butterworth) in [
        (0.0, 1.0),
        (1.0, 1.0 / (1.0 + 1.0 / 1296.0)),
        (6.0, 0.5),
        (18.0, 1.0 / 82.0),
    ] {
        assert!(
            (response(SmoothFilter::Butterworth, frequency) - butterworth).abs() < 4e-3,
            "{frequency}"
        );
    }
    for (frequency, gaussian) in [(0.0, 1.0), (6.0, 0.5), (12.0, 0.0625), (24.0, 0.0)] {
        assert!(
            (response(SmoothFilter::Gaussian, frequency) - gaussian).abs() < 1e-3,
            "{frequency}"
        );
    }
}
