//! Tests of steps as text and as JSON.

use mocap::edit::EditStep;
use mocap::{Code, Error, Result};
use serde_json::json;

/// Texts, and their printed form: every option, in the order of the names.
const TEXTS: &[(&str, &str)] = &[
    (
        "foot-lock",
        "foot-lock:blend=0.2,gap=0.05,height=0.05m,release=1.6,shortest=0.08,speed=0.25",
    ),
    (
        "foot-lock:speed=0.3,largest-change=0.02",
        "foot-lock:blend=0.2,gap=0.05,height=0.05m,largest-change=0.02m,release=1.6,shortest=0.08,speed=0.3",
    ),
    ("mirror", "mirror"),
    (
        "smooth:filter=gaussian",
        "smooth:cut-off=6.0,ease=0.2,filter=gaussian,range=..",
    ),
    (
        "smooth:part=arms,joints=head+LeftHand,range=1..2",
        "smooth:cut-off=6.0,ease=0.2,filter=butterworth,joints=head+LeftHand,part=arms,range=1..2",
    ),
    (
        "smooth:cut_off=8",
        "smooth:cut-off=8.0,ease=0.2,filter=butterworth,range=..",
    ),
    (
        "despike:longest=2",
        "despike:angle=3.0,distance=0.02,longest=2,threshold=8.0",
    ),
    ("fill", "fill:longest=0.5,shortest=0.0"),
    (
        "clean:noise=false",
        "clean:contacts=true,flips=true,floor=true,lengths=true,noise=false,time=true",
    ),
    (
        "loop:frames=10..140,in-place=true",
        "loop:blend=0.3,frames=10..140,in-place=true,longest=4.0,shortest=0.6",
    ),
    ("loop", "loop:blend=0.3,in-place=false,longest=4.0,shortest=0.6"),
    ("concat:align=false", "concat:align=false,blend=0.3,within=0.0"),
    (
        "concat:with=3,within=0.5",
        "concat:align=true,blend=0.3,with=3,within=0.5",
    ),
    ("blend:weight=0.25", "blend:weight=0.25,within=0.0"),
    ("blend:within=1", "blend:weight=0.5,within=1.0"),
    ("blend:weight=0:0+1.5:1", "blend:weight=0:0+1.5:1,within=0.0"),
    (
        "warp:path=0:0/0+2.5:-1/2.25",
        "warp:facing=along,path=0:0/0+2.5:-1/2.25",
    ),
    (
        "warp:path=0/0+1/2+3/-1,facing=kept",
        "warp:facing=kept,path=0/0+1/2+3/-1",
    ),
    ("layer:part=legs", "layer:part=legs"),
    ("warp:0=0,1.5=3", "warp:0=0,1.5=3"),
    ("warp:speed=2", "warp:speed=2.0"),
    (
        "in-between:keys=3+9,every=20,interpolation=slerp",
        "in-between:every=20,interpolation=slerp,keys=3+9",
    ),
    ("trim:range=0..1.5", "trim:range=0..1.5"),
    ("trim:range=20f..", "trim:range=20f.."),
    ("trim", "trim:range=.."),
    ("resample:rate=60", "resample:rate=60.0"),
    ("drop-first-frame", "drop-first-frame:always=false"),
    ("drop-first-frame:always=true", "drop-first-frame:always=true"),
    ("in-place", "in-place"),
    ("root-motion", "root-motion"),
    ("reverse", "reverse"),
    ("rest", "rest:pose=t-pose"),
    ("rest:pose=a-pose", "rest:pose=a-pose"),
    ("t-pose-first", "t-pose-first"),
    ("bone-axis:axis=x", "bone-axis:axis=x"),
    (
        "reach:to=0.5/1/-0.25,range=20f..60f",
        "reach:ease-in=0.4,ease-out=0.4,limb=right-hand,offset=0/0/0,range=20f..60f,to=0.5/1/-0.25",
    ),
    (
        "pin:to=left-hand,range=1..2",
        "pin:blend=0.2,distance=0.3m,limb=right-hand,range=1..2,speed=0.25,to=left-hand",
    ),
    (
        "look-at:at=0/1.5/9,limit=60",
        "look-at:at=0/1.5/9,ease-in=0.4,ease-out=0.4,limit=60.0,neck=0.4,range=..",
    ),
    ("ground", "ground"),
    ("turn:by=90", "turn:by=90.0"),
    ("turn:facing=-x", "turn:facing=-x"),
    (
        "reach:limb=left-foot,to=mixamorig:Head,tip=toe",
        "reach:ease-in=0.4,ease-out=0.4,limb=left-foot,offset=0/0/0,range=..,tip=toe,to=mixamorig:Head",
    ),
];

#[test]
fn a_step_is_the_same_as_text_and_as_a_value() {
    for &(text, printed) in TEXTS {
        let step: EditStep = text.parse().unwrap();
        assert_eq!(step.to_string(), printed);
        assert_eq!(printed.parse::<EditStep>().unwrap(), step, "{text}");
        let value = serde_json::to_value(&step).unwrap();
        assert_eq!(value["step"], step.name());
        assert_eq!(serde_json::from_value::<EditStep>(value).unwrap(), step, "{text}");
        assert_eq!(serde_json::from_value::<EditStep>(json!(text)).unwrap(), step, "{text}");
    }
    // The texts contain every step.
    for step in EditStep::ALL {
        assert!(
            TEXTS.iter().any(|(text, _)| text.starts_with(step.name)),
            "{}",
            step.name
        );
    }
    assert_eq!("blend:with=3".parse::<EditStep>().unwrap().with(), Some(3));
}

#[test]
fn values_have_the_types_of_their_options() {
    for (text, value) in [
        ("smooth:cut-off=8", json!({"step": "smooth", "cut-off": 8})),
        (
            "loop:frames=10..140",
            json!({"step": "loop", "frames": [10, 140], "in_place": false}),
        ),
        (
            "blend:weight=0:0+1.5:1",
            json!({"step": "blend", "weight": [[0, 0], [1.5, 1]]}),
        ),
        ("warp:0=0,1.5=3", json!({"step": "warp", "moments": [[0, 0], [1.5, 3]]})),
        (
            "warp:path=0/0+1/2",
            json!({"step": "warp", "path": [{"at": [0, 0]}, {"at": [1, 2]}]}),
        ),
        ("in-between:keys=3", json!({"step": "in-between", "keys": [3]})),
    ] {
        assert_eq!(EditStep::from_value(&value).unwrap(), text.parse().unwrap(), "{text}");
    }
}

fn refused(result: Result<EditStep>) -> (Code, String, Option<String>) {
    let error: Error = result.unwrap_err();
    let diagnostic = error.diagnostic();
    (diagnostic.code, diagnostic.message.clone(), diagnostic.help.clone())
}

#[test]
fn names_that_do_not_exist_find_their_neighbour() {
    for (text, message, help) in [
        (
            "smoth",
            "there is no step \"smoth\"",
            "did you mean smooth? the steps are foot-lock, mirror, smooth, ",
        ),
        (
            "smooth:cutoff=8",
            "the step smooth has no key \"cutoff\"",
            "did you mean cut-off? smooth takes filter=butterworth|gaussian, cut-off=HZ, ",
        ),
        (
            "foot-lock:heigth=5cm",
            "the step foot-lock has no key \"heigth\"",
            "did you mean height? foot-lock takes ",
        ),
        (
            "smooth:with=2",
            "the step smooth has no key \"with\"",
            "smooth takes filter=butterworth|gaussian, cut-off=HZ, ",
        ),
        (
            "mirror:axis=x",
            "the step mirror has no key \"axis\"",
            "mirror takes no options",
        ),
    ] {
        let (code, found, hint) = refused(text.parse());
        assert_eq!((code, found.as_str()), (Code::UnknownOption, message));
        let hint = hint.unwrap();
        assert!(hint.starts_with(help), "{text}: {hint}");
        // Every example in a message is valid.
        if let Some((_, example)) = hint.split_once("; such as ") {
            assert!(example.parse::<EditStep>().is_ok(), "{text}: {hint}");
        }
    }
    let (_, _, help) = refused("shake".parse());
    assert!(help.unwrap().starts_with("the steps are foot-lock, mirror, smooth"));
    let value = json!({"step": "smooth", "cutoff": 8});
    let hint = refused(EditStep::from_value(&value)).2.unwrap();
    assert!(hint.starts_with("did you mean cut-off?"), "{hint}");
}

/// The example that a message gives for an option has a valid value.
#[test]
fn every_example_is_taken() {
    for step in EditStep::ALL {
        for key in step.keys {
            // Some options need another option.
            let others = step.keys.iter().map(|other| format!(",{}", other.example()));
            let mut texts = std::iter::once(String::new())
                .chain(others)
                .map(|other| format!("{}:{}{other}", step.name, key.example()));
            assert!(
                texts.any(|text| text.parse::<EditStep>().is_ok()),
                "{} {}",
                step.name,
                key.field
            );
        }
    }
    let height = |text: &str| text.parse::<EditStep>().unwrap().to_string();
    assert_eq!(height("foot-lock:height=7cm"), height("foot-lock:height=0.07"));
    assert_eq!(height("foot-lock:height=70 mm"), height("foot-lock:height=0.07"));
}

#[test]
fn a_bad_value_says_what_its_option_takes() {
    for (text, message) in [
        ("smooth:8", "\"8\" in the step \"smooth:8\" is not key=value"),
        (
            "fill:longest=soon",
            "longest takes a time in seconds such as 0.5, got \"soon\"",
        ),
        ("foot-lock:floor=nan", "floor takes a length such as 5cm, got \"nan\""),
        (
            "smooth:filter=mean",
            "filter takes butterworth or gaussian, got \"mean\"",
        ),
        ("loop:frames=3", "frames takes two frames such as 20..140, got \"3\""),
        (
            "in-between:every=2.5",
            "every takes a whole number of frames such as 20, got \"2.5\"",
        ),
        (
            "blend:weight=0:0+1",
            "weight takes a weight from 0 to 1 such as 0.5, or a curve",
        ),
        ("warp:path=1/2+3", "path takes points M/M+... such as 0/0+1/2"),
        (
            "trim:range=early..",
            "range takes a part A..B in seconds such as 0..1.5, or in frames",
        ),
        (
            "warp:0=soon",
            "moments takes pairs of times in seconds such as 0=0,1.5=3, got \"0=soon\"",
        ),
        (
            "blend:with=b.bvh",
            "with takes the number of a motion among the inputs, 2 or more, got \"b.bvh\"",
        ),
        (
            "blend:with=1",
            "with takes the number of a motion among the inputs, 2 or more, got \"1\"",
        ),
        ("warp:speed=0", "the step \"warp:speed=0\": speed must be above 0"),
        ("warp", "the step \"warp\": a warp has either"),
        ("warp:path=1/1,0=0", "the step \"warp:path=1/1,0=0\": a warp has either"),
        ("warp:0=0,speed=2", "the step \"warp:0=0,speed=2\": a warp has either"),
        ("warp:facing=kept", "the step \"warp:facing=kept\": a warp has either"),
    ] {
        let (code, found, _) = refused(text.parse());
        assert_eq!(code, Code::InvalidValue, "{text}");
        assert!(found.starts_with(message), "{text}: {found}");
    }
    for value in [json!({"cut-off": 8}), json!(8), json!(null), json!({"step": 3})] {
        let (code, found, _) = refused(EditStep::from_value(&value));
        assert_eq!(code, Code::InvalidValue);
        assert!(
            found.starts_with("a step is an object with its name in \"step\""),
            "{found}"
        );
    }
    let (_, found, _) = refused(EditStep::from_value(&json!({"step": "loop", "frames": [20]})));
    assert!(
        found.starts_with("frames takes two frames such as 20..140, got \"20\""),
        "{found}"
    );
}
