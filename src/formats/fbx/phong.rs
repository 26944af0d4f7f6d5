//! The values of a Phong material for a surface. Blender's exporter and importer use the same relation, and store the
//! metallic value as the reflection factor.

/// The Phong exponent for a roughness.
pub(super) fn shininess(roughness: f32) -> f64 {
    let smooth = 1.0 - f64::from(roughness).clamp(0.0, 1.0);
    (10.0 * smooth).powi(2)
}

/// The roughness for a Phong exponent.
pub(super) fn roughness(shininess: f64) -> f32 {
    1.0 - (shininess.clamp(0.0, 100.0).sqrt() / 10.0) as f32
}
