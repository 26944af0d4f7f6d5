//! A scene as text: the output of a university course on computer graphics, or JSON.
//!
//! The text is the output of the functions `printSceneInfo`, `printMeshInfo`, `printTreeInfo`, `printBoneInfo` and
//! `printAnimInfo`, which students of the course call for an Assimp scene. The output changed over the years; a
//! [`Layout`] has the name of its first year. The JSON is a [`SceneView`], described by a [JSON
//! Schema](SceneView::SCHEMA).
//!
//! ```
//! use mocap::dump::{Layout, Section};
//! use mocap::scene::{Node, Scene};
//!
//! let shoulder = Node { name: "Shoulder".into(), ..Node::default() };
//! let scene = Scene { nodes: vec![shoulder], ..Scene::default() };
//! assert_eq!(
//!     Layout::default().text(&scene, &[Section::Tree]),
//!     "==================== Node Data ===========================\n\
//!      Node Name: Shoulder  Parent: NO PARENT  nchild = 0  nmesh = 0\n\
//!      Transformation:  1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 \n"
//! );
//! ```

mod json;
pub(crate) mod number;
mod print;
pub mod report;
mod summary;

use std::fmt;

use mocap_scene::scene::Scene;
use serde::Serialize;

#[doc(hidden)]
pub use self::json::SceneView;
use self::print::{print_anim_info, print_bone_info, print_mesh_info, print_scene_info, print_tree_info};

impl SceneView<'_> {
    /// The JSON Schema (draft 2020-12) of a serialised scene.
    pub const SCHEMA: &'static str = include_str!("dump/scene.schema.json");
}

/// A section of the output.
///
/// The [module](crate::dump) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Section {
    /// The numbers of nodes, meshes and other objects.
    Scene,
    /// The meshes.
    Mesh,
    /// The nodes.
    Tree,
    /// The bones.
    Bone,
    /// The animations, with every position and rotation key.
    Anim,
}

/// The year of the course whose output is printed.
///
/// The [module](crate::dump) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[non_exhaustive]
pub enum Layout {
    /// 2017: materials in the scene section, bones with every weight in the mesh section, nodes without their parents.
    #[serde(rename = "2017")]
    Y2017,
    /// 2018: no mesh section, and a short bone section.
    #[serde(rename = "2018")]
    Y2018,
    /// The layout of 2019 and 2020.
    #[default]
    #[serde(rename = "2019")]
    Y2019,
    /// 2021 to 2024: like 2019, with the first and last weight of each bone.
    #[serde(rename = "2021")]
    Y2021,
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scene => "scene",
            Self::Mesh => "mesh",
            Self::Tree => "tree",
            Self::Bone => "bone",
            Self::Anim => "anim",
        })
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Y2017 => "2017",
            Self::Y2018 => "2018",
            Self::Y2019 => "2019",
            Self::Y2021 => "2021",
        })
    }
}

impl Layout {
    /// The sections of this layout, in the course's order.
    pub const fn sections(self) -> &'static [Section] {
        match self {
            Self::Y2017 => &[Section::Scene, Section::Tree, Section::Mesh, Section::Anim],
            Self::Y2018 => &[Section::Scene, Section::Tree, Section::Bone, Section::Anim],
            Self::Y2019 | Self::Y2021 => &[
                Section::Scene,
                Section::Mesh,
                Section::Tree,
                Section::Bone,
                Section::Anim,
            ],
        }
    }
}

impl Layout {
    /// The sections of a scene, in the order given. Sections that the layout lacks are skipped.
    pub fn text(self, scene: &Scene, sections: &[Section]) -> String {
        let mut text = String::new();
        for section in sections.iter().filter(|section| self.sections().contains(section)) {
            let print = match section {
                Section::Scene => print_scene_info,
                Section::Mesh => print_mesh_info,
                Section::Tree => print_tree_info,
                Section::Bone => print_bone_info,
                Section::Anim => print_anim_info,
            };
            print(&mut text, scene, self).expect("writing to a string cannot fail");
        }
        text
    }
}
