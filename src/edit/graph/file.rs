//! Reads and writes graphs as JSON. A file may be wrong, so every index is checked.

use mocap_scene::error::{Code, Diagnostic, Result, pointer};
use mocap_scene::visible_json;

use super::{GraphTransition, MotionGraph};

impl MotionGraph {
    /// The version of the schema that this program writes and reads.
    pub const VERSION: u32 = 1;

    /// The graph as JSON text, with a line for each clip and for each transition.
    pub fn to_json(&self) -> String {
        let text = |value: &dyn Fn() -> serde_json::Result<String>| value().unwrap_or_default();
        let lines = |lines: Vec<String>| match lines.is_empty() {
            true => "[]".to_owned(),
            false => format!("[\n    {}\n  ]", lines.join(",\n    ")),
        };
        let points = self.points.iter().map(|point| text(&|| serde_json::to_string(point)));
        let clips = self.clips.iter().map(|clip| text(&|| serde_json::to_string(clip)));
        let transitions = self.transitions.iter();
        let transitions = transitions.map(|transition| text(&|| serde_json::to_string(transition)));
        let body = self.body.as_ref().map(|body| text(&|| serde_json::to_string(body)));
        let body = body.map(|body| format!("  \"body\": {body},\n")).unwrap_or_default();
        let json = format!(
            "{{\n  \"motion-graph\": {},\n  \"options\": {},\n{body}  \"points\": {},\n  \"clips\": {},\n  \"transitions\": {}\n}}\n",
            self.motion_graph,
            text(&|| serde_json::to_string(&self.options)),
            lines(points.collect()),
            lines(clips.collect()),
            lines(transitions.collect())
        );
        visible_json(&json).into_owned()
    }

    /// Reads a graph from JSON text.
    ///
    /// ```
    /// use mocap::graph::MotionGraph;
    ///
    /// let error = MotionGraph::from_json(r#"{"motion-graph": 7}"#).unwrap_err();
    /// assert!(error.to_string().contains("version 7"), "{error}");
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidGraph`] if the text is no graph, has another version, or contradicts itself.
    pub fn from_json(text: &str) -> Result<Self> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidGraph, message).into());
        let begin: Result<Version, _> = serde_json::from_str(text);
        match begin {
            Ok(begin) if begin.motion_graph != Self::VERSION => {
                return refuse(format!(
                    "the graph has version {}, and this program reads version {}",
                    begin.motion_graph,
                    Self::VERSION
                ));
            }
            Ok(_) => {}
            Err(error) => return refuse(format!("the file is no motion graph: {error}")),
        }
        let graph: Self = match serde_json::from_str(text) {
            Ok(graph) => graph,
            Err(error) => return refuse(format!("the graph is not valid: {}: {error}", pointer(text, &error))),
        };
        graph.check()?;
        Ok(graph)
    }

    /// Checks that every index has a target.
    fn check(&self) -> Result<()> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidGraph, message).into());
        if let Err(error) = self.options.check() {
            return refuse(format!("the options of the graph: {}", error.diagnostic().message));
        }
        for (index, clip) in self.clips.iter().enumerate() {
            if let Some([first, last]) = clip.part
                && (first > last || last >= clip.frames)
            {
                return refuse(format!(
                    "clip {index} has frames 0 to {}, but its part in the graph has frames {first} to {last}",
                    clip.frames.saturating_sub(1)
                ));
            }
        }
        for (index, transition) in self.transitions.iter().enumerate() {
            if let Err(reason) = self.is_possible(transition) {
                return refuse(format!("transition {index} is not possible: {reason}"));
            }
        }
        Ok(())
    }

    /// Checks that both windows of a transition are in its clips.
    fn is_possible(&self, transition: &GraphTransition) -> Result<(), String> {
        let (window, GraphTransition { from, to, distance }) = (self.options.frames(), transition);
        for [clip, frame] in [from, to] {
            let Some(clip) = self.clips.get(*clip) else {
                return Err(format!("there is no clip {clip}"));
            };
            if *frame >= clip.frames {
                return Err(format!(
                    "{} has {} frames, and no frame {frame}",
                    clip.file, clip.frames
                ));
            }
        }
        if self.clips[from[0]].frames - from[1] < window {
            return Err(format!("fewer than {window} frames follow frame {}", from[1]));
        }
        if to[1] + 1 < window {
            return Err(format!(
                "the clip has fewer than {window} frames up to and including frame {}",
                to[1]
            ));
        }
        match distance.is_finite() && *distance >= 0.0 {
            true => Ok(()),
            false => Err(format!("its distance is {distance}")),
        }
    }
}

/// The version field, which every version of the file has.
#[derive(serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Version {
    motion_graph: u32,
}
