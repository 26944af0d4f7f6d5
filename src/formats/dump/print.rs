//! The course's five functions, in every layout.

use std::fmt;

use glam::{Mat4, Vec3};
use mocap_scene::scene::{Animation, Bone, Channel, Mesh, Scene};

use super::Layout;
use super::number::StreamNumber;

/// Prints the number of objects of each kind, like `printSceneInfo`.
pub(super) fn print_scene_info(out: &mut impl fmt::Write, scene: &Scene, layout: Layout) -> fmt::Result {
    let is_old = matches!(layout, Layout::Y2017 | Layout::Y2018);
    if is_old {
        writeln!(out, "Success! ")?;
        writeln!(out, "---------------- Scene Data -------------------")?;
    } else {
        writeln!(out, "======================= Scene Data ========================")?;
    }
    writeln!(out, "Number of animations = {}", scene.animations.len())?;
    writeln!(out, "Number of cameras = 0")?;
    writeln!(out, "Number of lights = 0")?;
    writeln!(out, "Number of materials = {}", scene.materials.len())?;
    writeln!(out, "Number of meshes = {}", scene.meshes.len())?;
    writeln!(out, "Number of textures = 0")?;
    if is_old {
        writeln!(out, "--------------------------------------")?;
        for (index, mesh) in scene.meshes.iter().enumerate() {
            write!(out, "Mesh {index}: ")?;
            print_mesh_counts(out, mesh)?;
        }
    }
    if layout == Layout::Y2017 {
        // A skeleton's material has no colours. The course prints them as zeros.
        for index in 0..scene.materials.len() {
            writeln!(out, "Material: {index}")?;
            writeln!(out, "   Ambient = 0 0 0 0")?;
            writeln!(out, "   Diffuse = 0 0 0 0")?;
            writeln!(out, "   Specular = 0 0 0 0  Shininess = 0")?;
        }
    }
    Ok(())
}

/// Prints the meshes, like `printMeshInfo`. The layout 2017 also prints their bones with all weights.
pub(super) fn print_mesh_info(out: &mut impl fmt::Write, scene: &Scene, layout: Layout) -> fmt::Result {
    if layout == Layout::Y2017 {
        return print_mesh_info_2017(out, scene);
    }
    writeln!(out, "======================= Mesh Data =============================")?;
    writeln!(out, "Number of meshes = {}", scene.meshes.len())?;
    for (index, mesh) in scene.meshes.iter().enumerate() {
        write!(out, "Mesh index {index}: ")?;
        print_mesh_counts(out, mesh)?;
        writeln!(out, "Mesh does not have texture coordinates.")?;
        writeln!(out, "Mesh does not have vertex colors.")?;
        let has_normals = if mesh.normals.is_empty() {
            "does not have"
        } else {
            "has"
        };
        writeln!(out, "Mesh {has_normals} vertex normals.")?;
    }
    Ok(())
}

fn print_mesh_info_2017(out: &mut impl fmt::Write, scene: &Scene) -> fmt::Result {
    writeln!(out, "---------------- Mesh Data -------------------")?;
    for (index, mesh) in scene.meshes.iter().enumerate() {
        if !mesh.normals.is_empty() {
            writeln!(out, "Mesh {index}: Has Normals.")?;
        }
        if mesh.bones.is_empty() {
            continue;
        }
        let (bones, vertices, faces) = (mesh.bones.len(), mesh.vertices.len(), mesh.faces().len());
        writeln!(
            out,
            "Mesh {index}: nbones = {bones}  nverts = {vertices}  nfaces = {faces}"
        )?;
        for bone in &mesh.bones {
            writeln!(out, " --- Bone Name: {}  nweights = {}", bone.name, bone.weights.len())?;
            print_matrix(out, "     Offset matrix: ", bone.offset_matrix)?;
            for weight in &bone.weights {
                let value = StreamNumber(weight.weight);
                writeln!(out, "      Vertex id: {}  weight = {value}", weight.vertex_id)?;
            }
        }
    }
    Ok(())
}

fn print_mesh_counts(out: &mut impl fmt::Write, mesh: &Mesh) -> fmt::Result {
    let (vertices, faces, bones) = (mesh.vertices.len(), mesh.faces().len(), mesh.bones.len());
    let material = mesh.material_index;
    writeln!(
        out,
        "nverts = {vertices}  nfaces =  {faces}  nbones = {bones}  Material index = {material}"
    )
}

/// Prints the nodes depth-first, like `printTreeInfo`.
pub(super) fn print_tree_info(out: &mut impl fmt::Write, scene: &Scene, layout: Layout) -> fmt::Result {
    let is_old = matches!(layout, Layout::Y2017 | Layout::Y2018);
    let mut child_counts = vec![0; scene.nodes.len()];
    for parent in scene.nodes.iter().filter_map(|node| node.parent) {
        child_counts[parent.index()] += 1;
    }
    for (node, children) in scene.nodes.iter().zip(child_counts) {
        if is_old {
            writeln!(out, "============= Node Data ========================")?;
        } else {
            writeln!(out, "==================== Node Data ===========================")?;
        }
        write!(out, "Node Name: {}", node.name)?;
        if layout != Layout::Y2017 {
            let parent = node
                .parent
                .map_or("NO PARENT", |parent| &scene.nodes[parent.index()].name);
            write!(out, "  Parent: {parent}")?;
        }
        writeln!(out, "  nchild = {children}  nmesh = {}", node.meshes.len())?;
        if layout == Layout::Y2017 || !node.meshes.is_empty() {
            write!(out, "Mesh indices: ")?;
            for mesh in &node.meshes {
                write!(out, "{mesh} ")?;
            }
            writeln!(out)?;
        }
        print_matrix(out, "Transformation:  ", node.transform)?;
    }
    Ok(())
}

/// Prints the bones, each with its first and last vertex, like `printBoneInfo`.
pub(super) fn print_bone_info(out: &mut impl fmt::Write, scene: &Scene, layout: Layout) -> fmt::Result {
    if matches!(layout, Layout::Y2017 | Layout::Y2018) {
        writeln!(out, "---------------- Bone Data -------------------")?;
    } else {
        writeln!(out, "==================== Bone Data ===========================")?;
    }
    for (index, mesh) in scene.meshes.iter().enumerate() {
        for bone in &mesh.bones {
            print_bone(out, index, bone, layout)?;
        }
    }
    Ok(())
}

fn print_bone(out: &mut impl fmt::Write, mesh: usize, bone: &Bone, layout: Layout) -> fmt::Result {
    let Bone { name, weights, .. } = bone;
    writeln!(out, "Bone Name: {name}   Mesh: {mesh}  nweights = {}", weights.len())?;
    print_matrix(out, "     Offset matrix: ", bone.offset_matrix)?;
    if let [first, .., last] | [first @ last] = weights.as_slice() {
        writeln!(out, "      Vertex ids: {}  {}", first.vertex_id, last.vertex_id)?;
        if layout == Layout::Y2021 {
            let (first, last) = (StreamNumber(first.weight), StreamNumber(last.weight));
            writeln!(out, "      Vertex weights: {first}  {last}")?;
        }
    }
    Ok(())
}

/// Prints the animations with every position and rotation key, quaternions w first, like `printAnimInfo`.
///
/// The course's function of 2021 prints one chosen animation. Here all layouts print all animations.
pub(super) fn print_anim_info(out: &mut impl fmt::Write, scene: &Scene, layout: Layout) -> fmt::Result {
    if matches!(layout, Layout::Y2017 | Layout::Y2018) {
        writeln!(out, "---------------- Animation Data -------------------")?;
    } else {
        writeln!(out, "==================== Animation Data ===========================")?;
    }
    writeln!(out, "Number of animations = {}", scene.animations.len())?;
    for (index, animation) in scene.animations.iter().enumerate() {
        print_animation(out, index, animation, layout)?;
    }
    Ok(())
}

fn print_animation(out: &mut impl fmt::Write, index: usize, animation: &Animation, layout: Layout) -> fmt::Result {
    let rate_label = if layout == Layout::Y2021 {
        "nticks per sec"
    } else {
        "nticks"
    };
    let (name, channels) = (&animation.name, &animation.channels);
    let (rate, duration) = (
        StreamNumber(animation.ticks_per_second),
        StreamNumber(animation.duration),
    );
    write!(out, " --- Anim {index}:  Name = {name}  nchanls = {} ", channels.len())?;
    writeln!(out, "{rate_label} = {rate}  duration (ticks) = {duration}")?;
    for (index, channel) in channels.iter().enumerate() {
        print_channel(out, index, channel)?;
    }
    Ok(())
}

fn print_channel(out: &mut impl fmt::Write, index: usize, channel: &Channel) -> fmt::Result {
    let Channel {
        node_name,
        node: _,
        position_keys: positions,
        rotation_keys: rotations,
        scaling_keys: scales,
    } = channel;
    write!(
        out,
        "     Channel {index}: nodeName = {node_name} nposkeys = {}",
        positions.len()
    )?;
    writeln!(out, "  nrotKeys = {} nsclKeys = {}", rotations.len(), scales.len())?;
    for (key, Vec3 { x, y, z }) in positions.values.iter().enumerate() {
        let tick = StreamNumber(positions.tick(key));
        let [x, y, z] = [x, y, z].map(|number| StreamNumber(*number));
        writeln!(out, "        posKey {key}:  Time = {tick} Value = {x} {y} {z}")?;
    }
    for (key, rotation) in rotations.values.iter().enumerate() {
        let tick = StreamNumber(rotations.tick(key));
        let [x, y, z, w] = rotation.to_array().map(StreamNumber);
        writeln!(out, "        rotnKey {key}:  Time = {tick} Value = {w} {x} {y} {z}")?;
    }
    Ok(())
}

/// Prints a label and the matrix, row by row, with a space after every number.
fn print_matrix(out: &mut impl fmt::Write, label: &str, matrix: Mat4) -> fmt::Result {
    out.write_str(label)?;
    for number in matrix.transpose().to_cols_array() {
        write!(out, "{} ", StreamNumber(number))?;
    }
    writeln!(out)
}
