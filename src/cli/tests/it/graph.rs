//! `mocap graph` and `mocap graph walk`.

use mocap::graph::MotionGraph;
use mocap::job::Job;
use mocap::{Code, MemoryFile};
use serde_json::json;

use crate::program::Folder;

#[test]
fn clips_of_several_skeletons_are_put_on_one_body() {
    let folder = Folder::of_real(&["cmu_12_01_walk.bvh", "motionbuilder_vicon_walk.bvh", "cmu_short.bvh"]);
    let clips = "cmu_12_01_walk.bvh motionbuilder_vicon_walk.bvh";
    folder.refuses(&format!("graph {clips} -o graph.json"), 2, "--character BODY");
    folder.succeeds(&format!(
        "graph {clips} --on cmu_short.bvh --threshold 12cm -o graph.json"
    ));
    let text = String::from_utf8(folder.read("graph.json")).unwrap();
    let graph = MotionGraph::from_json(&text).unwrap();
    assert_eq!(graph.body.as_ref().map(|body| body.0.as_str()), Some("cmu_short.bvh"));
    assert_eq!(graph.to_json(), text);
    // A transition leads from the motion of one skeleton to the motion of the other.
    assert!(
        graph
            .transitions
            .iter()
            .any(|transition| transition.from[0] != transition.to[0])
    );
    folder.succeeds("graph walk graph.json --seconds 8 -o long.bvh");
    let walk = mocap::import(folder.path("long.bvh")).unwrap();
    let body = mocap::import(folder.path("cmu_short.bvh")).unwrap();
    assert_eq!(walk.nodes.len(), body.nodes.len());
    folder.refuses("graph walk graph.json --seconds 8 -o cmu_short.bvh --force", 1, "input");
    let other = String::from_utf8(folder.read("cmu_short.bvh")).unwrap();
    folder.write("cmu_short.bvh", format!("{other}\n").as_bytes());
    folder.refuses(
        "graph walk graph.json --seconds 8 -o again.bvh",
        1,
        "changed since the graph was made",
    );
}

/// The command, its printed job and the job in memory make the same files. A job can make a walk directly from clips.
#[test]
fn graphs_and_walks_are_jobs() {
    let folder = Folder::of_real(&["cmu_12_01_walk.bvh"]);
    let print = |line: &str| {
        let printed = folder.run(&format!("{line} --print-job"));
        assert!(printed.status.success(), "{line}");
        folder.write("job.json", &printed.stdout);
    };
    let graph = "graph cmu_12_01_walk.bvh --threshold 5cm --rate 15 -o graph.json --matrix matrix.png";
    folder.succeeds(graph);
    let (text, picture) = (folder.read("graph.json"), folder.read("matrix.png"));
    print(graph);
    folder.refuses("run job.json --dry-run", 2, "this job makes a graph");
    folder.succeeds("run job.json --force");
    assert!(folder.read("graph.json") == text && folder.read("matrix.png") == picture);

    folder.succeeds("graph walk graph.json --seconds 7 --seed 2 -o long.bvh");
    let long = folder.read("long.bvh");
    print("graph walk graph.json --seconds 7 --seed 2 -o again.bvh");
    folder.succeeds("run job.json");
    assert!(folder.read("again.bvh") == long);
    folder.succeeds("graph walk graph.json --seconds 7 -o dry.bvh --dry-run");
    assert!(!folder.path("dry.bvh").exists());

    let clip = folder.read("cmu_12_01_walk.bvh");
    let files = [("cmu_12_01_walk.bvh", &clip), ("graph.json", &text)];
    let given = files.map(|(name, bytes)| MemoryFile { name, bytes });
    let in_memory = |job: &serde_json::Value| {
        let job = Job::from_json(&job.to_string()).unwrap();
        let (written, report) = job.run_in_memory(&given).unwrap();
        (written.into_bytes().unwrap(), report)
    };
    let walk = json!({"seconds": 7, "seed": 2});
    let of_graph = json!({"source": {"inputs": ["graph.json"]}, "walk": walk, "write": {"output": "long.bvh"}});
    let clips = json!({"inputs": ["cmu_12_01_walk.bvh"]});
    let of_clips = json!({"source": clips, "graph": {"threshold": 0.05, "rate": 15}, "walk": walk, "write": {"output": "long.bvh"}});
    for job in [&of_graph, &of_clips] {
        let (bytes, report) = in_memory(job);
        assert!(bytes == long, "{job}");
        assert!((report.walk.unwrap().seconds - 7.0).abs() < 0.01);
    }
    let job = json!({"source": clips, "graph": {"threshold": 0.05, "rate": 15}, "write": {"output": "graph.json"}});
    let (bytes, report) = in_memory(&job);
    assert!(bytes == text);
    let of_file = MotionGraph::from_json(std::str::from_utf8(&text).unwrap()).unwrap();
    let graph = report.graph.unwrap();
    assert_eq!((graph.clips, graph.transitions), (1, of_file.transitions.len()));
    assert!(graph.left_out.is_empty() && graph.kept_seconds <= graph.seconds);
    let alone = Job::from_json(&of_graph.to_string()).unwrap();
    assert_eq!(alone.run_in_memory(&given[1..]).unwrap_err().code(), Code::MissingFile);
}
