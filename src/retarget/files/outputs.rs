//! The outputs of a [`Retargeter`]: files of a character, and scenes.

use mocap_figure::Figure;
use mocap_figure::convert::Conversion;
use mocap_formats::Export;
use mocap_formats::gltf::{BufferPlace, GltfOptions};
use mocap_scene::error::Result;
use mocap_scene::scene::{Animation, Scene};

use super::{Retargeter, Target};

impl Retargeter {
    /// The file of the character with the clips, each with its provenance. Everything else in the file is unchanged,
    /// byte by byte. `None` for a skeleton and a robot, which have no file. Notes list the parts of a face that the
    /// character cannot show.
    ///
    /// # Errors
    /// The errors of [`Character::with_clips`](mocap_formats::gltf::Character::with_clips).
    pub fn character_file(&self) -> Result<Option<Export>> {
        self.character_files(&GltfOptions::new().buffer(BufferPlace::Embedded), "")
    }

    /// Like [`Self::character_file`] for an output of this name, with the clips stored by `options`.
    #[doc(hidden)]
    pub fn character_files(&self, options: &GltfOptions, name: &str) -> Result<Option<Export>> {
        let Target::Character(character) = &self.target else {
            return Ok(None);
        };
        let clips = self.clips.iter();
        let clips = clips.map(|clip| (&clip.animation, &clip.provenance, &*clip.face, clip.extras.clone()));
        let replace = self.options.replace_animations;
        character.clip_files(clips, replace, options, name).map(Some)
    }

    /// The target as a scene in its own unit and axes, with only the new clips. It has further nodes for the faces of
    /// the sources if the target lacks such nodes. The scene records the motion of the first clip.
    pub fn scene(&self) -> Scene {
        let mut scene = self.with_clips(self.animations());
        self.record(&mut scene);
        self.add_faces(&mut scene);
        scene
    }

    /// The scene of [`Self::scene`] in metres with +Y up, for glTF, FBX and VRM animations.
    ///
    /// # Errors
    /// The errors of [`Conversion::apply`].
    pub fn scene_in_metres(&self) -> Result<Scene> {
        let mut scene = self.converted(self.animations(), &Conversion::new())?;
        self.add_faces(&mut scene);
        Ok(scene)
    }

    fn animations(&self) -> Vec<Animation> {
        self.clips.iter().map(|clip| clip.animation.clone()).collect()
    }

    /// The scene of [`Self::scene`] without nodes for faces, in the unit and the axes of a conversion. The clips are
    /// moved into the scene. The sources are dropped first, because they take more memory than everything else.
    #[doc(hidden)]
    pub fn take_scene(&mut self, conversion: Option<&Conversion>) -> Result<Scene> {
        self.drop_sources();
        let clips = self.clips.iter_mut();
        let animations = clips.map(|clip| std::mem::take(&mut clip.animation)).collect();
        if let Some(conversion) = conversion {
            return self.converted(animations, conversion);
        }
        let mut scene = self.with_clips(animations);
        self.record(&mut scene);
        Ok(scene)
    }

    /// Frees the sources. Afterwards, the limbs of clips can no longer be compared.
    #[doc(hidden)]
    pub fn drop_sources(&mut self) {
        self.sources.clear();
    }

    fn converted(&self, animations: Vec<Animation>, conversion: &Conversion) -> Result<Scene> {
        let mut scene = self.with_clips(animations);
        match &self.figure {
            Some(figure) => {
                let figure = Figure::with_bones(&scene, figure.humanoid.clone());
                conversion.convert(&mut scene, &figure)?;
            }
            None => drop(conversion.apply(&mut scene)?),
        }
        self.record(&mut scene);
        Ok(scene)
    }

    /// Records the clips after the conversion, which is one of the changes of the skeleton.
    fn record(&self, scene: &mut Scene) {
        // A robot's scene does not record the source of its motion.
        let clip = self.clips.first().filter(|clip| clip.robot_motion.is_none());
        if let Some(clip) = clip {
            clip.provenance.record(scene);
        }
    }
}
