//! Tests that `mocap retarget` and `mocap robot` give the bytes of the library's `Retargeter`.

use mocap::Importer;
use mocap::gltf::Character;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::Scene;

use crate::at_root;

const SHORT: &str = "fixtures/real/cmu_short.bvh";

const CHARACTER: &str = "fixtures/skeletons/human_vrm1.gltf";

const ROBOT: &str = "fixtures/robots/h1.urdf";

fn import(file: &str) -> Scene {
    mocap::import(at_root(file)).unwrap()
}

fn character() -> Character {
    Importer::new()
        .gltf_meshes(true)
        .import_character(at_root(CHARACTER))
        .unwrap()
}

/// The program reports the library's results, for a character and for a robot.
#[test]
fn the_program_and_the_library_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str], name: &str| {
        let output = folder.path().join(name);
        let mut command = crate::program::command(arguments);
        let done = command.arg("-o").arg(&output).output().unwrap();
        assert!(done.status.success(), "{}", crate::program::words(&done));
        std::fs::read(output).unwrap()
    };
    let retargeting = Retargeter::new(import(SHORT), character(), RetargetOptions::new()).unwrap();
    let program = run(&["retarget", SHORT, CHARACTER, "--embed"], "out.gltf");
    assert!(retargeting.character_file().unwrap().unwrap().into_bytes().unwrap() == program);

    let robot = Importer::new().import_robot(at_root(ROBOT)).unwrap();
    let retargeting = Retargeter::new(import(SHORT), robot, RetargetOptions::new()).unwrap();
    let motion = retargeting.clips()[0].robot_motion.as_ref().unwrap();
    let program = run(&["robot", SHORT, "--robot", ROBOT, "--to", "pkl"], "out.pkl");
    assert!(mocap::arrays::robot_pickle(motion) == program);
}
