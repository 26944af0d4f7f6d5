//! Compares clips and builds a graph of them.

use mocap_figure::Figure;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::pose::{Trs, have_the_same_joints};
use mocap_scene::scene::Scene;

use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;
use super::network::Network;
use super::{GraphClip, GraphOptions, GraphTransition, MotionGraph, component, minima};

/// Takes clips of one skeleton, compares their windows, and builds a graph.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug)]
pub struct GraphBuilder {
    options: GraphOptions,
    window: Window,
    skeleton: Option<Skeleton>,
    clips: Vec<GraphClip>,
    clouds: Vec<Clouds>,
}

/// The skeleton that all clips share: the skeleton of the first clip.
#[derive(Clone, Debug)]
struct Skeleton {
    scene: Scene,
    file: String,
    space: CloudSpace,
    /// For each node, whether the line from its parent to the node is a bone.
    is_bone: Vec<bool>,
}

/// The largest difference between the lengths of a bone in two clips of one skeleton, as a fraction of the longest
/// bone. Its cause is the rounding of decimal numbers in files.
const SAME_LENGTH: f32 = 1e-3;

/// The distances between all windows of one clip and all windows of another clip, in metres.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::graph::{GraphBuilder, GraphOptions};
///
/// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let mut builder = GraphBuilder::new(&GraphOptions::new())?;
/// builder.add("walk.bvh", &walk)?;
/// let matrix = builder.matrix(0, 0)?;
/// assert!(matrix.at(3, 3) < 1e-6 && matrix.at(0, 5) > 0.01);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DistanceMatrix {
    /// The number of windows of the first clip.
    pub rows: usize,
    /// The number of windows of the second clip.
    pub columns: usize,
    /// The distances, row by row.
    pub values: Vec<f32>,
}

impl DistanceMatrix {
    /// The distance between two windows. One window begins at the frame `row` of the first clip, the other window at
    /// the frame `column` of the second clip.
    ///
    /// # Panics
    /// If one of the windows does not exist.
    pub fn at(&self, row: usize, column: usize) -> f32 {
        assert!(column < self.columns, "column {column} of {}", self.columns);
        self.values[row * self.columns + column]
    }
}

impl GraphBuilder {
    /// A builder without clips.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for options that are not valid.
    pub fn new(options: &GraphOptions) -> Result<Self> {
        options.check()?;
        Ok(Self {
            options: *options,
            window: Window::new(options.frames()),
            skeleton: None,
            clips: Vec::new(),
            clouds: Vec::new(),
        })
    }

    /// Adds every animation of `scene` as a clip. `file` is the file from which the scene was read.
    ///
    /// # Errors
    /// - [`Code::NoMotion`]: the scene has no motion.
    /// - [`Code::InvalidValue`]: the skeleton differs from the skeleton of the earlier clips.
    /// - [`Code::LimitExceeded`]: the motion is too long.
    pub fn add(&mut self, file: &str, scene: &Scene) -> Result<()> {
        if scene.animations.is_empty() {
            return Err(Diagnostic::new(Code::NoMotion, "the file contains no motion").into());
        }
        if let Some(skeleton) = &self.skeleton {
            skeleton.require_same(scene)?;
        }
        let skeleton = match self.skeleton.take() {
            Some(skeleton) => skeleton,
            None => Skeleton::new(file, scene)?,
        };
        let space = &skeleton.space;
        let clouds = scene.animations.iter().enumerate().map(|(index, animation)| {
            let clouds = Clouds::new(space, scene, animation, self.options.rate)?;
            let sha256 = scene.metadata.origin.as_ref().map(|origin| origin.sha256.clone());
            let clip = GraphClip {
                file: file.to_owned(),
                sha256: sha256.unwrap_or_default(),
                animation: index,
                frames: clouds.frames,
                part: None,
            };
            Ok((clip, clouds))
        });
        let clouds: Result<Vec<_>> = clouds.collect();
        self.skeleton = Some(skeleton);
        for (clip, clouds) in clouds? {
            self.clips.push(clip);
            self.clouds.push(clouds);
        }
        Ok(())
    }

    /// The clips that were added.
    pub fn clips(&self) -> &[GraphClip] {
        &self.clips
    }

    /// The distances between all windows of two clips. `first` and `second` are indices of clips.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if one of the clips does not exist.
    pub fn matrix(&self, first: usize, second: usize) -> Result<DistanceMatrix> {
        let clip = |clip: usize| {
            self.clouds.get(clip).ok_or_else(|| {
                let message = format!("there is no clip {clip}: the number of clips is {}", self.clouds.len());
                Error::from(Diagnostic::new(Code::InvalidValue, message))
            })
        };
        let (first, second) = (clip(first)?, clip(second)?);
        if let Some(short) = [first, second].iter().find(|clouds| self.window.count(clouds) == 0) {
            let message = format!(
                "a clip of {} frames at {} per second has no window of {} frames",
                short.frames,
                self.options.rate,
                self.window.frames()
            );
            return Err(Diagnostic::new(Code::InvalidValue, message)
                .help("shorten the window, or raise the rate")
                .into());
        }
        Ok(DistanceMatrix {
            rows: self.window.count(first),
            columns: self.window.count(second),
            values: minima::matrix(self.space()?, &self.window, first, second),
        })
    }

    /// Compares all clips and builds their graph.
    ///
    /// # Errors
    /// [`Code::NoMotion`] without a clip. [`Code::InvalidValue`] if too few windows are similar, so that no walk can go
    /// on for ever.
    pub fn build(&self) -> Result<MotionGraph> {
        let space = self.space()?;
        let threshold = self.options.threshold as f32;
        let minima = minima::minima(space, &self.window, &self.clouds, threshold);
        let last = self.window.frames() - 1;
        let mut transitions = Vec::with_capacity(2 * minima.len());
        for minimum in minima {
            let [first, second] = [0, 1].map(|side| [minimum.clips[side], minimum.starts[side]]);
            for (from, to) in [(first, second), (second, first)] {
                transitions.push(GraphTransition {
                    from,
                    to: [to[0], to[1] + last],
                    distance: minimum.distance,
                });
            }
        }
        transitions.sort_by_key(|transition| (transition.from, transition.to));
        let mut graph = MotionGraph {
            motion_graph: MotionGraph::VERSION,
            options: self.options,
            body: None,
            points: self.points(),
            clips: self.clips.clone(),
            transitions,
        };
        let parts = component::largest(&graph);
        if parts.iter().all(Option::is_none) {
            let message = format!(
                "no endless path through the clips exists: no transition of at most {} m leads back to an earlier \
                 moment",
                self.options.threshold
            );
            let diagnostic = Diagnostic::new(Code::InvalidValue, message);
            return Err(diagnostic.help("raise the threshold, or add clips").into());
        }
        for (clip, part) in graph.clips.iter_mut().zip(&parts) {
            clip.part = *part;
        }
        if !self.options.whole {
            let is_inside = |[clip, frame]: [usize; 2]| {
                let within = |part: [usize; 2]| (part[0]..=part[1]).contains(&frame);
                parts[clip].is_some_and(within)
            };
            let kept = |transition: &GraphTransition| is_inside(transition.from) && is_inside(transition.to);
            graph.transitions.retain(kept);
        }
        Ok(graph)
    }

    /// A network of `graph` and the clips of this builder, in which walks are searched.
    ///
    /// # Errors
    /// [`Code::InvalidGraph`] if the graph was built from other clips.
    pub fn network(&self, graph: &MotionGraph) -> Result<Network<'_>> {
        let names = |points: &[(String, f32)]| Vec::from_iter(points.iter().map(|(name, _)| name.clone()));
        if names(&graph.points) != names(&self.points()) {
            let message = "the clips have other joints than the graph";
            return Err(Diagnostic::new(Code::InvalidGraph, message).into());
        }
        Network::new(self.space()?, &self.window, (&self.clips, &self.clouds), graph)
    }

    /// The names of the points, each with its weight.
    fn points(&self) -> Vec<(String, f32)> {
        let of = |skeleton: &Skeleton| skeleton.space.points(&skeleton.scene).collect();
        self.skeleton.as_ref().map(of).unwrap_or_default()
    }

    fn space(&self) -> Result<&CloudSpace> {
        let space = self.skeleton.as_ref().map(|skeleton| &skeleton.space);
        space.ok_or_else(|| Diagnostic::new(Code::NoMotion, "there is no clip").into())
    }
}

impl Skeleton {
    fn new(file: &str, scene: &Scene) -> Result<Self> {
        let figure = Figure::new(scene);
        let places = figure.placing(scene);
        let parents = scene.nodes.iter().map(|node| node.parent);
        Ok(Self {
            space: CloudSpace::new(scene, &figure)?,
            is_bone: parents
                .map(|parent| parent.is_some_and(|parent| !places[parent.index()]))
                .collect(),
            scene: without_motion(scene),
            file: file.to_owned(),
        })
    }

    /// Refuses a scene with other joints, or with bones of another length.
    fn require_same(&self, scene: &Scene) -> Result<()> {
        let refuse = |difference: String| {
            let message = format!("its skeleton differs from {}: {difference}", self.file);
            let diagnostic = Diagnostic::new(Code::InvalidValue, message);
            Err(diagnostic
                .help("retarget all clips to one character: {character} BODY")
                .into())
        };
        if let Err(difference) = have_the_same_joints(&self.scene, scene) {
            return refuse(difference);
        }
        let offset = |scene: &Scene, node: usize| Trs::from_matrix(scene.nodes[node].transform).translation;
        // Ignores the rest position of the root. If a joint above the hips only places the figure, also ignores the
        // rest position of the hips.
        let nodes = (0..scene.nodes.len()).filter(|node| self.is_bone[*node]);
        let longest = nodes.clone().map(|node| offset(&self.scene, node).length());
        let most = SAME_LENGTH * longest.fold(0.0, f32::max);
        for node in nodes {
            let [own, other] = [&self.scene, scene].map(|scene| offset(scene, node));
            if own.distance(other) > most {
                let name = &scene.nodes[node].name;
                return refuse(format!("the offset of {name:?} is {other} instead of {own}"));
            }
        }
        Ok(())
    }
}

/// A copy of a scene without its animations: the nodes, and the metadata that does not belong to a motion.
fn without_motion(scene: &Scene) -> Scene {
    Scene {
        nodes: scene.nodes.clone(),
        ..Scene::default()
    }
}
