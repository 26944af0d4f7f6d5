//! The page with the player, curves and contact sheets.

use mocap::Conversion;
use mocap::edit::ContactOptions;
use mocap::figure::names::node_named;
use mocap::figure::{Figure, Humanoid, HumanoidMap};
use mocap::render::{Clip, Drawing, Page, PageClip, PlotOptions, SheetOptions};
use mocap::scene::NodeId;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{invalid, to_python};
use crate::scene::Scene;

/// The page that plays scenes side by side, each with its name. The page needs no other files.
#[pyfunction]
pub(crate) fn page(py: Python<'_>, scenes: Vec<(String, Py<Scene>)>) -> PyResult<String> {
    let made = py.detach(|| -> mocap::Result<String> {
        let mut clips = Vec::new();
        for (name, scene) in &scenes {
            let mut scene = scene.get().scene().clone();
            let found = Figure::mapped(&scene, &HumanoidMap::new())?;
            let (figure, _) = Conversion::new().apply_to(&mut scene, &found)?;
            // Only a humanoid with a motion has contacts.
            let contacts = ContactOptions::default().detect(&scene, 0, Some(&figure.humanoid)).ok();
            clips.push((name, scene, figure, contacts));
        }
        let pages = clips.iter().map(|(name, scene, figure, contacts)| {
            let clip = PageClip::new(Clip {
                name: name.as_str(),
                scene,
            });
            clip.figure(figure).contacts(contacts.as_ref())
        });
        Ok(Page::new(&pages.collect::<Vec<_>>()).html)
    });
    made.map_err(|error| to_python(py, &error))
}

/// A picture, as SVG and as PNG.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Picture {
    drawing: Drawing,
}

#[pymethods]
impl Picture {
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.drawing.width, self.drawing.height)
    }

    fn svg(&self, py: Python<'_>) -> String {
        py.detach(|| self.drawing.to_svg())
    }

    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let made = py.detach(|| self.drawing.to_png());
        made.map(|bytes| PyBytes::new(py, &bytes))
            .map_err(|error| to_python(py, &error))
    }
}

/// Draws curves of the named joints.
#[pyfunction]
pub(crate) fn plot(py: Python<'_>, scene: &Scene, name: &str, joints: Vec<String>, width: u32) -> PyResult<Picture> {
    let scene = scene.scene();
    let humanoid = Humanoid::of(scene);
    let find = |joint: &String| {
        node_named(scene, joint, |bone| humanoid.joint(bone)).map_err(|error| invalid(error.to_string()))
    };
    let joints = joints.iter().map(find).collect::<PyResult<Vec<NodeId>>>()?;
    let options = PlotOptions::new().width(width);
    let drawing = py.detach(|| Drawing::plot(&Clip { name, scene }, &joints, &options));
    Ok(Picture { drawing })
}

/// Draws poses over time, a row for each scene.
#[pyfunction]
pub(crate) fn sheet(py: Python<'_>, scenes: Vec<(String, Py<Scene>)>, poses: usize, width: u32) -> Picture {
    let options = SheetOptions::new().poses(poses).width(width);
    let drawing = py.detach(|| {
        let clips = scenes.iter().map(|(name, scene)| Clip {
            name,
            scene: scene.get().scene(),
        });
        Drawing::sheet(&clips.collect::<Vec<_>>(), &options)
    });
    Picture { drawing }
}
