//! The USD outputs that the program replaces.

use std::fs;

use crate::at_root;
use crate::program::Folder;

const ARM: &str = "fixtures/made/arm.usda";

#[test]
fn an_output_is_replaced_and_somebodys_stage_is_not() {
    let folder = Folder::of_real(&["lecture_Test.bvh", "blender_two_joints.bvh"]);
    folder.write("scene.usda", &fs::read(at_root(ARM)).unwrap());
    for output in ["take.usda", "take.usdz"] {
        folder.succeeds(&format!("convert lecture_Test.bvh {output}"));
        let first = folder.read(output);
        folder.succeeds(&format!("convert lecture_Test.bvh {output}"));
        assert_eq!(folder.read(output), first);
        folder.succeeds(&format!("verify lecture_Test.bvh {output}"));
        // The other output also contains a motion that was read from a USD file. It is refused nevertheless, because
        // its input is another file.
        folder.succeeds(&format!("convert blender_two_joints.bvh other_{output}"));
        folder.refuses(
            &format!("convert {output} other_{output}"),
            1,
            "would replace a file that mocap did not write from these inputs",
        );
    }
    folder.refuses("convert lecture_Test.bvh scene.usda", 1, "would replace a file");
}
