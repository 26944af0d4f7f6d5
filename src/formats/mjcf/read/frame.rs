//! `<frame>`: a transform for its contents, which is not a body.

use mocap_scene::error::Code;
use mocap_scene::limits::Limits;
use mocap_scene::scene::robot::Placement;

use super::attributes::Settings;
use crate::Failure;
use crate::xml::Element;

/// An element of a body, possibly within frames.
#[derive(Clone, Copy)]
pub(super) struct BodyElement<'a, 'input> {
    pub(super) element: Element<'a, 'input>,
    /// The transform from the surrounding frames to the body.
    pub(super) frame: Placement,
    /// The class of elements without a stated class.
    pub(super) child_class: Option<&'a str>,
}

/// The elements of a body, in the order of the file.
pub(super) fn within<'a, 'input>(
    body: Element<'a, 'input>,
    child_class: Option<&'a str>,
    settings: &Settings,
    limits: &Limits,
) -> Result<Vec<BodyElement<'a, 'input>>, Failure> {
    let own = |element: Element<'a, 'input>, frame: Placement, child_class: Option<&'a str>| {
        let inner = element.children().map(|element| BodyElement {
            element,
            frame,
            child_class,
        });
        inner.collect::<Vec<_>>().into_iter()
    };
    let mut found = Vec::new();
    let mut open = vec![own(body, Placement::IDENTITY, child_class)];
    while let Some(around) = open.last_mut() {
        let Some(next) = around.next() else {
            open.pop();
            continue;
        };
        match next.element.name() {
            "frame" if open.len() > limits.max_depth => {
                let message = format!("frames are nested more than {} deep", limits.max_depth);
                return Err(Box::new(next.element.diagnostic(Code::LimitExceeded, message)));
            }
            "frame" => {
                let frame = next.frame.then(&settings.of(next.element, None)?.origin()?);
                let child_class = next.element.attribute("childclass").or(next.child_class);
                open.push(own(next.element, frame, child_class));
            }
            "attach" => {
                let message = "the model attaches another model, which mocap cannot read";
                return Err(Box::new(
                    next.element
                        .diagnostic(Code::UnreadExtension, message)
                        .help("save the model as one file (mj_saveLastXML)"),
                ));
            }
            "replicate" if next.element.descendants().any(|inner| is_of_robot(inner.name())) => {
                let message = "the model repeats a part with <replicate>, which is not read";
                return Err(Box::new(next.element.diagnostic(Code::UnreadExtension, message).help(
                    "save the model as one file (mj_saveLastXML), which writes each copy out",
                )));
            }
            _ => found.push(next),
        }
    }
    Ok(found)
}

/// Whether an element of a body is read.
fn is_of_robot(name: &str) -> bool {
    matches!(name, "body" | "joint" | "freejoint" | "geom" | "inertial")
}
