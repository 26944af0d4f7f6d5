//! `mocap dump`: prints the whole scene, in the layout of a computer graphics course or as JSON.

use std::io::{self, BufWriter, Write};

use mocap::SkeletonMesh;
use mocap::dump::{Layout, SceneView, Section};

use crate::args::DumpArgs;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &DumpArgs) -> Result<(), Failure> {
    let importer = args
        .read
        .importer()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .collapse_keys(!args.raw);
    let mut scene = streams::import(&importer, &args.file)?;
    report::warnings(Some(&args.file), &scene.warnings);
    if !args.raw {
        scene.find_degenerates();
        scene.remove_sizeless_meshes();
        scene.join_identical_vertices();
        scene.debone();
    }
    if args.json {
        let mut out = BufWriter::new(report::json());
        // Not indented: otherwise every number would have its own line.
        serde_json::to_writer(&mut out, &SceneView::new(&scene)).map_err(io::Error::from)?;
        writeln!(out)?;
        out.flush()?;
        return Ok(());
    }
    let layout = Layout::from(args.layout);
    let chosen: Vec<Section> = args.sections.iter().map(|&section| section.into()).collect();
    if let Some(absent) = chosen.iter().find(|section| !layout.sections().contains(section)) {
        return Err(Failure::Usage(format!(
            "the layout {layout} does not have the section {absent}"
        )));
    }
    let sections = if chosen.is_empty() { layout.sections() } else { &chosen };
    let mut out = report::data();
    out.write_all(layout.text(&scene, sections).as_bytes())?;
    Ok(())
}
