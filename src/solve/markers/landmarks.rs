//! Which marker is which landmark of the body, by the names that sets of markers have for it.

use std::collections::HashMap;

use crate::scene::{HumanoidBone as Bone, Side};

/// What a marker is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum On {
    /// Skin over a bone, which hardly slides.
    Bone,
    /// Muscle, or a place that nobody measures.
    Muscle,
}

use On::{Bone as Hard, Muscle as Soft};

/// A landmark, the bone that it moves with, what it is on, and its names: `*` is the side, `l` or `r`. Names are
/// compared in lower case without what is no letter and no digit, and without the name of the subject before a colon.
type Row = (&'static str, Bone, On, &'static str);

/// Sources: the marker placement guides of Carnegie Mellon University (41 markers), of Vicon's Plug-in Gait full body,
/// of Helen Hayes (Kadaba 1990), the marker set of OpenSim's gait models, OptiTrack's Baseline and Conventional sets,
/// and the Istituto Ortopedico Rizzoli (Leardini 2007).
const ROWS: &[Row] = &[
    ("*ASI", Bone::Hips, Hard, "*asi *fwt *asis waist*front *ias"),
    ("*PSI", Bone::Hips, Hard, "*psi *bwt *psis waist*back *ips"),
    ("SACR", Bone::Hips, Hard, "sacr sacrum vsacral vsacrum"),
    ("*ILC", Bone::Hips, Soft, "*ilc *iliaccrest *gtr *gt"),
    (
        "*KNE",
        Bone::LeftUpperLeg,
        Hard,
        "*kne *kneelat *kneelateral *kneeout *latknee *fle *lk *le",
    ),
    (
        "*KNM",
        Bone::LeftUpperLeg,
        Hard,
        "*knm *kneemed *kneemedial *kneein *medknee *mkne *fme *me",
    ),
    ("*THI", Bone::LeftUpperLeg, Soft, "*thi *thigh *thighupper *th1"),
    ("*TH2", Bone::LeftUpperLeg, Soft, "*th2 *thighfront"),
    ("*TH3", Bone::LeftUpperLeg, Soft, "*th3 *thighrear"),
    ("*TH4", Bone::LeftUpperLeg, Soft, "*th4"),
    (
        "*ANK",
        Bone::LeftLowerLeg,
        Hard,
        "*ank *anklelat *anklelateral *ankleout *latankle *fal *lm",
    ),
    (
        "*ANM",
        Bone::LeftLowerLeg,
        Hard,
        "*anm *anklemed *anklemedial *anklein *medankle *mma *tam *mm",
    ),
    (
        "*TIB",
        Bone::LeftLowerLeg,
        Soft,
        "*tib *shn *shin *tibia *shank *shankupper *tb1 *sk1",
    ),
    ("*TB2", Bone::LeftLowerLeg, Soft, "*tb2 *sk2 *shankfront"),
    ("*TB3", Bone::LeftLowerLeg, Soft, "*tb3 *sk3 *shankrear"),
    ("*TB4", Bone::LeftLowerLeg, Soft, "*tb4 *sk4"),
    ("*FHE", Bone::LeftLowerLeg, Hard, "*hf *fax"),
    ("*TTU", Bone::LeftLowerLeg, Hard, "*tt *ttc"),
    ("*HEE", Bone::LeftFoot, Hard, "*hee *heel *ca *fcc *cal"),
    ("*TOE", Bone::LeftFoot, Hard, "*toe *mt2 *sm *fm2 *smh"),
    ("*TIP", Bone::LeftFoot, Soft, "*toetip *hallux"),
    ("*MT5", Bone::LeftFoot, Hard, "*mt5 *toelat *toeout *vm *fm5 *vmh"),
    ("*MT1", Bone::LeftFoot, Hard, "*mt1 *toemed *toein *fm *fm1 *fmh"),
    ("*MFS", Bone::LeftFoot, Soft, "*midfootsup"),
    ("*MFL", Bone::LeftFoot, Soft, "*midfootlat"),
    ("C7", Bone::Chest, Hard, "c7 cv7 backtop spinetop"),
    ("T10", Bone::Chest, Hard, "t10 t8 tv10 tv8 mai spinethoracic12"),
    ("CLAV", Bone::Chest, Hard, "clav sjn ij jn sternum chesttop"),
    ("STRN", Bone::Chest, Hard, "strn sxs px xp chest"),
    ("RBAC", Bone::Chest, Soft, "rbac rback backright"),
    ("LBAC", Bone::Chest, Soft, "lbac lback backleft"),
    (
        "*SHO",
        Bone::LeftShoulder,
        Hard,
        "*sho *acromium *acromion *acr *shouldertop *sae",
    ),
    ("*SHB", Bone::LeftShoulder, Soft, "*shoulderback"),
    (
        "*UPA",
        Bone::LeftUpperArm,
        Soft,
        "*upa *bicep *biceps *uarmhigh *upperarm",
    ),
    (
        "*ELB",
        Bone::LeftUpperArm,
        Hard,
        "*elb *elbow *elbowlat *elbowlateral *elbowout *hle",
    ),
    (
        "*ELM",
        Bone::LeftUpperArm,
        Hard,
        "*elm *elbowmed *elbowmedial *elbowin *hme *melb",
    ),
    ("*FRM", Bone::LeftLowerArm, Soft, "*frm *fra *forearm"),
    ("*WRA", Bone::LeftLowerArm, Hard, "*wra *wristlat *wristin *rsp *wrr"),
    ("*WRB", Bone::LeftLowerArm, Hard, "*wrb *wristmed *wristout *usp *wru"),
    ("*FIN", Bone::LeftHand, Hard, "*fin *hl2 *handout *hm2"),
    ("*FHD", Bone::Head, Hard, "*fhd *temple head*"),
    ("*BHD", Bone::Head, Hard, "*bhd"),
    ("HEAD", Bone::Head, Hard, "ariel tophead headtop"),
    ("HEDF", Bone::Head, Hard, "headfront"),
    ("HEDS", Bone::Head, Hard, "headside"),
];

/// A set by its name and how some of its markers are called, which other sets call otherwise.
const SETS: &[(&str, &str)] = &[
    ("CMU's set", "lfwt rfwt lbwt rbwt lshn rshn lmt5 rmt5 lupa lfrm"),
    ("Plug-in Gait", "lasi rasi lpsi rpsi lthi rthi ltib rtib"),
    ("Helen Hayes' set", "lasi rasi sacr lthi rthi ltib rtib"),
    (
        "the set of OpenSim's gait models",
        "rasis lasis vsacral rthighupper lthighupper rshankupper lshankupper",
    ),
    (
        "OptiTrack's set",
        "waistlfront waistrfront waistlback waistrback lkneeout rkneeout lankleout rankleout",
    ),
    (
        "the set of the Istituto Rizzoli",
        "lasis rasis lpsis rpsis lgt rgt lle rle lhf rhf ltt rtt",
    ),
];

/// A landmark as a marker is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Landmark {
    pub(super) name: String,
    pub(super) bone: Bone,
    pub(super) on: On,
}

/// A label without the subject before a colon, in lower case, without what is no letter and no digit.
pub(super) fn key(label: &str) -> String {
    let label = label.rsplit(':').next().unwrap_or(label);
    let letters = label.chars().filter(|letter| letter.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// All landmarks by the keys of their names.
pub(super) fn by_key() -> HashMap<String, Landmark> {
    let mut found = HashMap::new();
    for &(name, bone, on, names) in ROWS {
        for (side, letter, long) in [(Side::Left, "l", "left"), (Side::Right, "r", "right")] {
            let landmark = Landmark {
                name: name.replace('*', &letter.to_uppercase()),
                bone: bone.on(side),
                on,
            };
            let own = landmark.name.to_lowercase();
            for alias in names.split(' ').chain([own.as_str()]) {
                found
                    .entry(alias.replace('*', letter))
                    .or_insert_with(|| landmark.clone());
                found
                    .entry(alias.replace('*', long))
                    .or_insert_with(|| landmark.clone());
            }
        }
    }
    found
}

/// The landmark of this name, as a file of markers states it.
pub(super) fn named(name: &str) -> Option<Landmark> {
    by_key()
        .into_values()
        .find(|landmark| landmark.name.eq_ignore_ascii_case(name))
}

/// The set whose own names are nearly all there, with the most of them.
pub(super) fn set_name(keys: &[String]) -> Option<&'static str> {
    const NEARLY_ALL: f64 = 0.75;
    let count = |names: &str| {
        names
            .split(' ')
            .filter(|name| keys.iter().any(|key| key == name))
            .count()
    };
    let fits = |names: &str| count(names) as f64 >= NEARLY_ALL * names.split(' ').count() as f64;
    let mut fitting: Vec<_> = SETS.iter().filter(|(_, names)| fits(names)).collect();
    fitting.sort_by_key(|(_, names)| count(names));
    fitting.last().map(|(name, _)| *name)
}
