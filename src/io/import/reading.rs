//! Reads a scene from the bytes of a file: detects the format, reads, and runs the steps after every reader.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::thread;

use mocap_formats::{FormatInfo, Sidecar, Source, bvh, numbers};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::limits;
use mocap_scene::pose::Binding;
use mocap_scene::process::KeyTolerance;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::report::Origin;
use mocap_scene::scene::{Format, Scene};

use super::Importer;
use super::contents::{LARGE, check_size, format_of_extension};
use super::large::LargeFile;
use super::sha256::Sha256Sum;

impl Importer {
    /// Reads a file. `source` has the beginning of the file.
    #[doc(hidden)]
    pub fn read_large(&self, file: &LargeFile, source: &Source<'_>) -> Result<Scene> {
        let io_error = |error| Error::io(source.name, error);
        let format = self.find_format(source.bytes, source.name);
        let Some(format) = format.ok().filter(|format| format.reads_blocks) else {
            return self.read_source(&Source {
                bytes: file.read_whole().map_err(io_error)?,
                ..*source
            });
        };
        self.check_rates(source)?;
        if self.hash {
            file.start_hash();
        }
        let blocks = Source {
            blocks: Some(file),
            ..*source
        };
        let scene = format
            .read(&blocks, &self.read)
            .map_err(|error| match file.take_failure() {
                Some(failure) => io_error(failure),
                None => error,
            });
        let scene = scene.map_err(|error| error.with_path(source.name))?;
        let sha256 = file.finish_hash().map_err(io_error)?;
        self.finish(scene, source, sha256)
            .map_err(|error| error.with_path(source.name))
    }

    pub(super) fn read_source(&self, source: &Source<'_>) -> Result<Scene> {
        check_size(source.bytes.len() as u64, source.name, &self.read.limits)?;
        self.check_rates(source)?;
        let bytes = source.bytes;
        #[cfg(feature = "arrays")]
        let options = &self
            .read_options(source)
            .map_err(|error| error.with_path(source.name))?;
        #[cfg(not(feature = "arrays"))]
        let options = &self.read;
        let mut sum = self.hash.then(Sha256Sum::default);
        let read = |source: &Source<'_>| {
            self.find_format(bytes, source.name)
                .and_then(|format| format.read(source, options))
        };
        let scene = if bytes.len() < LARGE || self.read.threads == NonZeroUsize::new(1) {
            // The bytes that were just read are in the processor's caches, so hash them now.
            let shared = Mutex::new(sum.as_mut());
            let release = |range: Range<usize>| {
                if let Some(sum) = &mut *shared.lock().expect("hashing does not panic") {
                    sum.add_up_to(bytes, range.end);
                }
            };
            read(&Source {
                release: &release,
                ..*source
            })
        } else {
            thread::scope(|scope| {
                scope.spawn(|| sum.as_mut().map(|sum| sum.add(bytes)));
                read(source)
            })
        };
        let sha256 = sum.map_or_else(String::new, |mut sum| {
            sum.add_up_to(bytes, bytes.len());
            sum.finish()
        });
        scene
            .and_then(|scene| self.finish(scene, source, sha256))
            .map_err(|error| error.with_path(source.name))
    }

    /// Like [`Importer::read`], for a BVH file. A program that calls only `read_bvh` contains no other reader, so it is
    /// small enough to load over a network.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let bytes = std::fs::read("fixtures/real/lecture_Test.bvh").unwrap();
    /// let scene = mocap::Importer::new().read_bvh(&bytes, "lecture_Test.bvh")?;
    /// assert_eq!(scene.animations[0].frame_count(), 10);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Importer::read`], and an error if the file is not BVH.
    pub fn read_bvh(&self, bytes: &[u8], name: impl AsRef<Path>) -> Result<Scene> {
        let source = Source::of_bytes(bytes, name.as_ref());
        check_size(bytes.len() as u64, source.name, &self.read.limits)?;
        self.check_rates(&source)?;
        let sum = self.hash.then(|| {
            let mut sum = Sha256Sum::default();
            sum.add(bytes);
            sum.finish()
        });
        let sha256 = sum.unwrap_or_default();
        bvh::FORMAT
            .read(&source, &self.read)
            .and_then(|mut scene| {
                // Bytes have no folder, so the readers of companion files and the table of formats are not linked.
                self.select(&mut scene)?;
                scene.metadata.origin = Some(origin(&scene, source.name, sha256));
                self.complete(&mut scene);
                Ok(scene)
            })
            .map_err(|error| error.with_path(source.name))
    }

    pub(super) fn check_rates(&self, source: &Source<'_>) -> Result<()> {
        for rate in [self.read.retime, self.read.sampling_rate].into_iter().flatten() {
            limits::frame_rate(Code::InvalidValue, rate)
                .map_err(|diagnostic| Error::from(diagnostic).with_path(source.name))?;
        }
        Ok(())
    }

    /// The steps after every reader.
    pub(super) fn finish(&self, mut scene: Scene, source: &Source<'_>, sha256: String) -> Result<Scene> {
        self.select(&mut scene)?;
        #[cfg(feature = "arrays")]
        self.check_body(&scene)?;
        #[cfg(feature = "solve")]
        {
            self.solve_points(&mut scene, source)?;
            self.refuse_warnings(&mut scene)?;
        }
        scene.metadata.origin = Some(origin(&scene, source.name, sha256.clone()));
        let has_sidecar = (scene.metadata.format).is_some_and(|format| FormatInfo::of(format).has_sidecar);
        if has_sidecar
            && let Ok(bytes) = (source.open)(&Sidecar::path(source.name))
            && let Some(sidecar) = Sidecar::read(&bytes)
            && (sha256.is_empty() || sidecar.is_about(&sha256))
        {
            sidecar.tell(&mut scene);
        }
        self.complete(&mut scene);
        Ok(scene)
    }

    /// Fails a strict import at the first warning, except for marker gaps: a marker that the cameras lose in some
    /// frames is not a fault of the file.
    fn refuse_warnings(&self, scene: &mut Scene) -> Result<()> {
        let has_points = scene.has_points();
        let is_fault = |warning: &Diagnostic| !(has_points && warning.code == Code::Gap);
        match scene.warnings.iter().position(is_fault).filter(|_| self.strict) {
            None => Ok(()),
            Some(fault) => {
                let fault = scene.warnings.remove(fault);
                Err(Error::from(fault).with_warnings(std::mem::take(&mut scene.warnings)))
            }
        }
    }

    /// The first step after every reader: keeps the requested clips.
    fn select(&self, scene: &mut Scene) -> Result<()> {
        self.refuse_warnings(scene)?;
        if let Some(frames_per_second) = self.read.retime.filter(|_| !scene.animations.is_empty()) {
            scene.metadata.steps.push(AppliedStep::Retime { frames_per_second });
        }
        self.clips.select(scene)?;
        numbers::check(scene)
    }

    /// The last step after every reader: adds the mesh of the skeleton, finds the nodes of channels, and reduces
    /// constant tracks.
    fn complete(&self, scene: &mut Scene) {
        if scene.meshes.is_empty() {
            scene.add_skeleton_mesh(self.skeleton_mesh);
        }
        name_nodes_of_channels(scene);
        if self.collapse_keys {
            scene.collapse_keys(KeyTolerance::default());
        }
        debug_assert_eq!(scene.validate(), [], "a reader made a scene that breaks the rules");
    }

    /// The format that the caller chose, else the format of the contents, else of the extension.
    pub(super) fn find_format(&self, bytes: &[u8], name: &Path) -> Result<&'static FormatInfo> {
        let chosen = FormatInfo::ALL.iter().find(|format| Some(format.format) == self.format);
        let found = chosen.or_else(|| FormatInfo::of_contents(bytes));
        found.or_else(|| format_of_extension(name)).ok_or_else(|| {
            if let Some(unread) = mocap_formats::unread::unread(bytes, name) {
                return unread.into();
            }
            let extension = name.extension().unwrap_or_default().to_string_lossy();
            let message = "neither the contents nor the extension belong to a known format";
            Diagnostic::new(Code::UnknownFormat, message)
                .expected_found(Format::NAMES, format!("the extension \"{extension}\""))
                .into()
        })
    }
}

/// Sets the node of every channel for which the reader set no node. Finds the node by name, as [`Binding::new`] does.
fn name_nodes_of_channels(scene: &mut Scene) {
    for index in 0..scene.animations.len() {
        let animation = &scene.animations[index];
        if animation.channels.iter().all(|channel| channel.node.is_some()) {
            continue;
        }
        let driven: Vec<_> = Binding::new(scene, animation).driven().collect();
        for (node, channel) in driven {
            scene.animations[index].channels[channel].node = Some(node);
        }
    }
}

/// Identifies the source file, and the motion that was read from it.
fn origin(scene: &Scene, name: &Path, sha256: String) -> Origin {
    let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let animation = scene.animations.first();
    Origin {
        name,
        sha256,
        frames: animation.map_or(0, |animation| animation.frame_count() as u64),
        frame_time: animation.map_or(0.0, |animation| animation.ticks_per_second.recip()),
    }
}
