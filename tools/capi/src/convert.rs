//! Converts a copy of a scene to metres with +Y up.

use std::ffi::c_char;
use std::ptr;

use mocap::scene::UpAxis;

use crate::border::{Failure, guard};
use crate::handle::Scene;
use crate::opened;

/// The up axis of the file is unknown; see `mocap_conversion`.
pub const MOCAP_UP_AUTO: u32 = 0;

/// The up axis of the file is +Y.
pub const MOCAP_UP_Y: u32 = 1;

/// The up axis of the file is +Z.
pub const MOCAP_UP_Z: u32 = 2;

/// The up axis of the file is -Y.
pub const MOCAP_UP_NEG_Y: u32 = 3;

/// The up axis of the file is -Z.
pub const MOCAP_UP_NEG_Z: u32 = 4;

/// The known unit and axis of a file, and the wanted frame rate. All zero, `mocap_conversion conversion = {0};`, is the
/// default.
#[repr(C)]
pub struct Conversion {
    /// The unit of length of the file, in metres. 0: the unit that the file states, or else the unit in which the
    /// figure has the size of a person.
    pub metres_per_unit: f64,
    /// Frames per second of the result. 0: the frame rate of the file.
    pub frame_rate: f64,
    /// `MOCAP_UP_Y` or another axis. `MOCAP_UP_AUTO`: the axis that the file states, or else the axis from the feet to
    /// the head.
    pub up: u32,
}

impl Conversion {
    fn to_mocap(&self) -> Result<mocap::Conversion, Failure> {
        let mut conversion = mocap::Conversion::new();
        if self.metres_per_unit != 0.0 {
            conversion = conversion.metres_per_unit(self.metres_per_unit);
        }
        if self.frame_rate != 0.0 {
            conversion = conversion.frame_rate(self.frame_rate);
        }
        match self.up {
            MOCAP_UP_AUTO => Ok(conversion),
            MOCAP_UP_Y => Ok(conversion.up(UpAxis::Y)),
            MOCAP_UP_Z => Ok(conversion.up(UpAxis::Z)),
            MOCAP_UP_NEG_Y => Ok(conversion.up(UpAxis::NegY)),
            MOCAP_UP_NEG_Z => Ok(conversion.up(UpAxis::NegZ)),
            other => Err(Failure::argument(&format!(
                "up must be MOCAP_UP_AUTO or an axis, such as MOCAP_UP_Y, got {other}"
            ))),
        }
    }
}

/// Returns a copy of a scene in metres with +Y up, as `mocap convert` does. `conversion` states the known properties of
/// the file; NULL means the default. `mocap_assumption_text` of the copy lists the inferred properties.
///
/// Returns NULL if a number in `conversion` is invalid. The original scene does not change. Free each scene with
/// `mocap_close`. Converting the copy again does not change its unit and axes.
///
/// # Safety
/// `scene` is an open scene, and `conversion` is NULL or points to a conversion.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_convert(scene: *const Scene, conversion: *const Conversion) -> *mut Scene {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?;
        // SAFETY: the caller passes NULL or a conversion, and any bits are valid numbers.
        let conversion = match unsafe { conversion.as_ref() } {
            Some(conversion) => conversion.to_mocap()?,
            None => mocap::Conversion::new(),
        };
        Ok(scene.converted(&conversion)?.into_raw())
    })
}

/// The number of assumptions about a scene that its file does not state. `mocap_assumption_text` returns each of them.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_assumption_count(scene: *const Scene) -> usize {
    // SAFETY: the caller passes an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.assumptions.len()))
}

/// An assumption about a scene, counted from 0, with its reason, such as "unit: cm, because the skeleton measures ...".
/// NULL beyond the last. The text lives as long as the scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_assumption_text(scene: *const Scene, assumption: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes an open scene.
        let assumptions = &unsafe { opened(scene) }?.assumptions;
        let text = assumptions.get(assumption);
        let text = text.ok_or_else(|| Failure::absent("assumption", assumption as u64, assumptions.len() as u64))?;
        Ok(text.as_ptr())
    })
}
