//! Applies requested motions to the transforms of entities.

use std::sync::Arc;
use std::time::Duration;

use bevy::asset::LoadState;
use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::{Animation, Scene};
use mocap::{Binding, LoopMode, Player, Trs};

use crate::body::{figure_of, to_bevy, to_mocap};
use crate::loader::Motion;
use crate::player::{Clip, MotionFailed, MotionFinished, MotionLooped, MotionPlayer, MotionStarted};

/// The largest distance between corresponding nodes of equal skeletons, relative to the length of the bone. Rounding in
/// files and engines causes it.
const SAME: f32 = 1e-3;

/// The figure that a player animates.
pub(crate) struct Body {
    scene: Arc<Scene>,
    /// The entity of each node.
    entities: Vec<Entity>,
    rest: Vec<Trs>,
    /// Whether a motion has moved the node. A later motion that does not animate the node resets it to the rest pose.
    moved: Vec<bool>,
}

/// A requested motion.
pub(crate) struct Coming {
    motion: Handle<Motion>,
    clip: Clip,
    fade: Duration,
    /// The task that fits the motion to the figure. It starts when the file and the figure are loaded.
    fitting: Option<Task<Result<Fitted, String>>>,
}

/// A motion on the figure.
struct Fitted {
    animation: Arc<Animation>,
    index: usize,
    mean_degrees: f64,
}

/// A motion that plays, or fades out.
pub(crate) struct Track {
    pub(crate) player: Player,
    animation: Arc<Animation>,
    binding: Binding,
    fade: Duration,
    since: Duration,
    /// Whether its first pose was shown.
    has_begun: bool,
    has_finished: bool,
}

impl Coming {
    pub(crate) fn new(motion: Handle<Motion>, clip: Clip, fade: Duration) -> Self {
        Self {
            motion,
            clip,
            fade,
            fitting: None,
        }
    }
}

impl Track {
    /// Smooth at both ends of the fade.
    pub(crate) fn weight(&self) -> f32 {
        if self.since >= self.fade {
            return 1.0;
        }
        let part = self.since.as_secs_f32() / self.fade.as_secs_f32();
        part * part * (3.0 - 2.0 * part)
    }
}

/// Starts requested motions when they are loaded and fitted.
pub(crate) fn begin(
    mut commands: Commands,
    motions: Res<Assets<Motion>>,
    server: Res<AssetServer>,
    mut players: Query<(Entity, &mut MotionPlayer)>,
    parts: Query<(Option<&Name>, Option<&Children>, &Transform)>,
) {
    for (entity, mut player) in &mut players {
        if player.coming.is_none() {
            continue;
        }
        let player = &mut *player;
        if player.body.is_none() {
            player.body = figure_of(entity, &parts).map(|(scene, entities)| Body::new(scene, entities));
            player.tracks.clear();
        }
        let (Some(body), Some(coming)) = (&player.body, &mut player.coming) else {
            continue;
        };
        let outcome = match &mut coming.fitting {
            Some(task) => check_ready(task),
            None => match motions.get(&coming.motion) {
                Some(motion) => {
                    coming.fitting = Some(fit(motion, &coming.clip, body, player.lock_feet));
                    None
                }
                None => match server.get_load_state(&coming.motion) {
                    Some(LoadState::Failed(error)) => Some(Err(error.to_string())),
                    _ => None,
                },
            },
        };
        let Some(outcome) = outcome else {
            continue;
        };
        let Some(coming) = player.coming.take() else {
            continue;
        };
        match outcome {
            Err(reason) => commands.trigger(MotionFailed { entity, reason }),
            Ok(fitted) => {
                commands.trigger(MotionStarted {
                    entity,
                    motion: coming.motion,
                    index: fitted.index,
                    mean_degrees: fitted.mean_degrees,
                });
                player.start(fitted, coming.fade);
            }
        }
    }
}

/// Advances all clocks, and writes the transforms of all figures.
pub(crate) fn advance(
    mut commands: Commands,
    time: Res<Time>,
    mut players: Query<(Entity, &mut MotionPlayer)>,
    mut transforms: Query<&mut Transform>,
) {
    for (entity, mut player) in &mut players {
        if player.tracks.is_empty() {
            continue;
        }
        let player = &mut *player;
        let newest = player.tracks.len() - 1;
        for (index, track) in player.tracks.iter_mut().enumerate() {
            track.player.speed = player.speed;
            if index == newest {
                track.player.loop_mode = player.loop_mode;
            }
            let has_looped = track.advance(time.delta());
            if index == newest && has_looped {
                commands.trigger(MotionLooped { entity });
            }
            let ends = track.player.is_finished() && !track.has_finished;
            track.has_finished = track.player.is_finished();
            if index == newest && ends {
                commands.trigger(MotionFinished { entity });
            }
        }
        // A motion at full weight hides the motions before it.
        let seen = player
            .tracks
            .iter()
            .rposition(|track| track.weight() >= 1.0)
            .unwrap_or(0);
        player.tracks.drain(..seen);
        if let Some(body) = &mut player.body {
            body.write(&player.tracks, &mut transforms);
        }
    }
}

impl MotionPlayer {
    fn start(&mut self, fitted: Fitted, fade: Duration) {
        let Some(body) = &self.body else {
            return;
        };
        let mut player = Player::new(&fitted.animation);
        if self.speed < 0.0 {
            player.tick = fitted.animation.duration;
        }
        player.speed = self.speed;
        player.loop_mode = self.loop_mode;
        // The first motion has no previous motion to fade from.
        let fade = if self.tracks.is_empty() { Duration::ZERO } else { fade };
        self.tracks.push(Track {
            binding: Binding::new(&body.scene, &fitted.animation),
            animation: fitted.animation,
            player,
            fade,
            since: Duration::ZERO,
            has_begun: false,
            has_finished: false,
        });
    }
}

impl Track {
    /// Advances the clock. Returns whether the motion has started again. The first call shows the first pose.
    fn advance(&mut self, passed: Duration) -> bool {
        if !std::mem::replace(&mut self.has_begun, true) {
            return false;
        }
        self.since += passed;
        let before = self.player.tick;
        let after = self.player.advance(passed.as_secs_f64());
        self.player.loop_mode == LoopMode::Loop && (after - before) * self.player.speed < 0.0
    }
}

impl Body {
    fn new(scene: Scene, entities: Vec<Entity>) -> Self {
        Self {
            rest: scene
                .nodes
                .iter()
                .map(|node| Trs::from_matrix(node.transform))
                .collect(),
            moved: vec![false; entities.len()],
            scene: Arc::new(scene),
            entities,
        }
    }

    fn write(&mut self, tracks: &[Track], transforms: &mut Query<&mut Transform>) {
        let mut pose = self.rest.clone();
        for track in tracks {
            let weight = track.weight();
            let mut own = self.rest.clone();
            track.binding.sample(&track.animation, track.player.tick, |node, trs| {
                own[node.index()] = trs;
                self.moved[node.index()] = true;
            });
            for (below, own) in pose.iter_mut().zip(&own) {
                *below = if weight >= 1.0 { *own } else { mixed(below, own, weight) };
            }
        }
        for ((&entity, trs), &is_moved) in self.entities.iter().zip(&pose).zip(&self.moved) {
            // The app may have despawned the entity.
            if is_moved && let Ok(mut place) = transforms.get_mut(entity) {
                *place = to_bevy(*trs);
            }
        }
    }
}

fn mixed(from: &Trs, to: &Trs, weight: f32) -> Trs {
    let (from, to) = (to_bevy(*from), to_bevy(*to));
    to_mocap(&Transform {
        translation: from.translation.lerp(to.translation, weight),
        // The shorter arc.
        rotation: from.rotation.slerp(to.rotation, weight),
        scale: from.scale.lerp(to.scale, weight),
    })
}

/// Fits a motion to a figure in the background, because retargeting examines every frame.
fn fit(motion: &Motion, clip: &Clip, body: &Body, lock_feet: bool) -> Task<Result<Fitted, String>> {
    let (source, target, clip) = (motion.scene.clone(), body.scene.clone(), clip.clone());
    AsyncComputeTaskPool::get_or_init(Default::default).spawn(async move {
        let index = clip.find(&source)?;
        let animation = &source.animations[index];
        if let Some(animation) = of_same_skeleton(&source, animation, &target) {
            return Ok(Fitted {
                animation: Arc::new(animation),
                index,
                mean_degrees: 0.0,
            });
        }
        let moved = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default())
            .and_then(|mut retargeter| retargeter.clip(&source, index, &target, lock_feet));
        let (animation, report) = moved.map_err(|error| error.to_string())?;
        Ok(Fitted {
            animation: Arc::new(animation),
            index,
            mean_degrees: report.mean_degrees,
        })
    })
}

/// The animation for the target's nodes, if the nodes with the same names have the same rest pose.
fn of_same_skeleton(source: &Scene, animation: &Animation, target: &Scene) -> Option<Animation> {
    let from = Binding::new(source, animation);
    let mut own = animation.clone();
    for (node, channel) in from.driven() {
        let node = &source.nodes[node.index()];
        let id = target.find_node(&node.name)?;
        let other = &target.nodes[id.index()];
        let name = |scene: &Scene, parent: Option<mocap::scene::NodeId>| {
            parent.map(|parent| scene.nodes[parent.index()].name.clone())
        };
        let parents = (name(source, node.parent), name(target, other.parent));
        let is_alike = is_near(&Trs::from_matrix(node.transform), &Trs::from_matrix(other.transform));
        // The app may attach the root to any entity.
        if !is_alike || (node.parent.is_some() && parents.0 != parents.1) {
            return None;
        }
        own.channels[channel].node = Some(id);
    }
    Some(own)
}

fn is_near(some: &Trs, other: &Trs) -> bool {
    let length = some.translation.length().max(other.translation.length());
    let turned = some.rotation.dot(other.rotation).abs();
    some.translation.distance(other.translation) <= SAME * length.max(f32::EPSILON)
        && turned >= 1.0 - SAME * SAME
        && some.scale.distance(other.scale) <= SAME * some.scale.length()
}
