//! The transforms of a skeleton and its ancestor prims, which may be animated.

use glam::{DMat4, DQuat, DVec3, DVec4, Mat4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FrameBudget, is_plausible};

use crate::usd::parse::{Attribute, Layer};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The transform operations from the outermost prim to the skeleton.
pub(super) struct Placement<'l> {
    operations: Vec<(&'l str, &'l Attribute)>,
}

impl<'l> Placement<'l> {
    /// The known operations. A warning lists the unknown operations.
    pub(super) fn of(layer: &'l Layer<'_>, skeleton: usize, warnings: &mut Warnings) -> Self {
        let mut prims = Vec::new();
        let mut next = Some(skeleton);
        while let Some(index) = next {
            let prim = &layer.prims[index];
            next = prim.parent;
            let mut own = Vec::new();
            for name in prim.texts("xformOpOrder") {
                if name == "!resetXformStack!" {
                    // This operation resets the transform, so the ancestors do not move the prim.
                    next = None;
                    continue;
                }
                let stated = name.strip_prefix("!invert!").unwrap_or(name);
                let found = prim.attributes.get(name).or_else(|| prim.attributes.get(stated));
                let known = found
                    .filter(|found| value_at(found, None).is_some_and(|numbers| operation(name, &numbers).is_some()));
                match known {
                    Some(attribute) => own.push((name.as_str(), attribute)),
                    None => warnings.push(Code::IgnoredChannel, || {
                        let message = format!("{}: {name} was not read", layer.path(index));
                        Diagnostic::new(Code::IgnoredChannel, message)
                    }),
                }
            }
            prims.push(own);
        }
        Self {
            operations: prims.into_iter().rev().flatten().collect(),
        }
    }

    /// The time codes of the keys, if the transform is animated. Whole time codes between rotation keys become keys
    /// too, because USD interpolates the angles and a scene interpolates the rotations.
    pub(super) fn times(&self, options: &ReadOptions, bytes: usize) -> Result<Vec<f64>, Failure> {
        let is_moving = |(_, attribute): &&(&str, &Attribute)| {
            let mut values = attribute.samples.windows(2);
            values.any(|pair| pair[0].1.numbers != pair[1].1.numbers)
        };
        let moving: Vec<_> = self.operations.iter().filter(is_moving).collect();
        let samples = moving.iter().flat_map(|(_, attribute)| &attribute.samples);
        let mut times: Vec<f64> = samples.map(|(time, _)| *time).collect();
        times.sort_unstable_by(f64::total_cmp);
        if let (Some(first), Some(last)) = (times.first().copied(), times.last().copied())
            && moving.iter().any(|(name, _)| !name.starts_with("xformOp:translate"))
        {
            let mut budget = FrameBudget::stated_by(&options.limits, bytes as u64);
            let frames = budget.frames((last - first).round(), 1)?;
            let whole = (0..frames).map(|frame| first.floor() + frame as f64);
            times.extend(whole.filter(|time| (first..=last).contains(time)));
            times.sort_unstable_by(f64::total_cmp);
        }
        times.dedup();
        Ok(times)
    }

    /// The transform at a time code. If no time is given, the first transform.
    pub(super) fn at(&self, time: Option<f64>) -> Result<Mat4, Failure> {
        let matrices = self.operations.iter().filter_map(|(name, attribute)| {
            let numbers = value_at(attribute, time)?;
            operation(name, &numbers)
        });
        let whole: DMat4 = matrices.fold(DMat4::IDENTITY, |whole, own| whole * own);
        if !whole.to_cols_array().into_iter().all(is_plausible) {
            let message = "the transform of the skeleton's ancestors has a number that is too large to compute with";
            return Err(Diagnostic::new(Code::NumberRange, message).into());
        }
        transform(whole).ok_or_else(|| {
            let message = "the matrix of the skeleton's ancestors is not a transform: its last column must be 0 0 0 1";
            Diagnostic::new(Code::InvalidUsd, message).into()
        })
    }
}

/// The numbers of an attribute at a time, linear between samples. If no time is given, the first numbers.
fn value_at(attribute: &Attribute, time: Option<f64>) -> Option<Vec<f64>> {
    let samples = attribute.samples.as_slice();
    let (Some(time), [_, _, ..]) = (time, samples) else {
        let first = attribute.value.as_ref().filter(|_| samples.len() < 2);
        return first
            .or(samples.first().map(|(_, value)| value))
            .map(|value| value.numbers.clone());
    };
    let after = samples.partition_point(|(at, _)| *at < time);
    let (from, before) = &samples[after.saturating_sub(1)];
    let Some((to, next)) = samples.get(after) else {
        return Some(before.numbers.clone());
    };
    if before.numbers.len() != next.numbers.len() || to <= from {
        return Some(next.numbers.clone());
    }
    let fraction = ((time - from) / (to - from)).clamp(0.0, 1.0);
    if let (Some([w, x, y, z]), Some(end)) = (before.numbers.first_chunk(), next.numbers.first_chunk::<4>())
        && before.numbers.len() == 4
    {
        let from = DQuat::from_xyzw(*x, *y, *z, *w).normalize();
        let to = DQuat::from_xyzw(end[1], end[2], end[3], end[0]).normalize();
        // The shorter arc: a rotation and its negative are the same, so take the nearer one.
        let between = from.slerp(to, fraction);
        return Some(vec![between.w, between.x, between.y, between.z]);
    }
    let pairs = before.numbers.iter().zip(&next.numbers);
    Some(pairs.map(|(from, to)| from + (to - from) * fraction).collect())
}

/// The matrix of a transform operation; `None` if it is unknown.
fn operation(name: &str, numbers: &[f64]) -> Option<DMat4> {
    let (name, is_inverse) = match name.strip_prefix("!invert!") {
        Some(name) => (name, true),
        None => (name, false),
    };
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let vector = || numbers.first_chunk::<3>().map(|numbers| DVec3::from_array(*numbers));
    let about = |axis: u8, degrees: f64| match axis {
        b'X' => Some(DMat4::from_rotation_x(degrees.to_radians())),
        b'Y' => Some(DMat4::from_rotation_y(degrees.to_radians())),
        b'Z' => Some(DMat4::from_rotation_z(degrees.to_radians())),
        _ => None,
    };
    // The axes are fixed. The first named axis rotates first.
    let turned = |axes: &str| {
        let mut matrix = DMat4::IDENTITY;
        for axis in axes.bytes() {
            // One angle for one axis; otherwise the angles of X, Y and Z.
            let index = if axes.len() == 1 {
                0
            } else {
                usize::from(axis.checked_sub(b'X')?)
            };
            matrix = about(axis, *numbers.get(index)?)? * matrix;
        }
        Some(matrix)
    };
    let matrix = match kind {
        "transform" => DMat4::from_cols_array(numbers.first_chunk::<16>()?),
        "translate" => DMat4::from_translation(vector()?),
        "scale" => DMat4::from_scale(vector()?),
        "orient" => {
            let [w, x, y, z] = *numbers.first_chunk::<4>()?;
            let rotation = DQuat::from_xyzw(x, y, z, w);
            (rotation.length_squared() > f64::EPSILON).then(|| DMat4::from_quat(rotation.normalize()))?
        }
        _ => turned(kind.strip_prefix("rotate")?)?,
    };
    Some(if is_inverse { matrix.inverse() } else { matrix })
}

/// A 32-bit matrix, if its last row is 0 0 0 1 except for rounding.
pub(super) fn transform(matrix: DMat4) -> Option<Mat4> {
    /// The relative error of products and inverses in 64 bits.
    const ROUNDING: f64 = 1e-9;
    let is_affine = matrix.row(3).abs_diff_eq(DVec4::W, ROUNDING);
    is_affine.then(|| {
        let mut matrix = matrix.as_mat4();
        for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
            matrix.col_mut(column).w = last;
        }
        matrix
    })
}
