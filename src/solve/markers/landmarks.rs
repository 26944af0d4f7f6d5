//! Identifies the landmarks of markers by the names of known marker sets.

use std::collections::HashMap;

use mocap_scene::scene::{HumanoidBone as Bone, Side};

/// The tissue under a marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MarkerSite {
    /// Skin over a bone, which hardly slides.
    Bone,
    /// Muscle, or a place that no protocol states precisely.
    Muscle,
}

use MarkerSite::{Bone as Hard, Muscle as Soft};

/// A landmark, the bone that it moves with, its tissue, and its names. `*` stands for the side, `l` or `r`. Names are
/// compared in lower case, reduced to letters and digits, without the subject prefix.
type Row = (&'static str, Bone, MarkerSite, &'static str);

/// Sources:
/// - the marker placement guides of Carnegie Mellon University (41 markers) and of Vicon's full-body Plug-in Gait
/// - Helen Hayes (Kadaba 1990), the Istituto Ortopedico Rizzoli (Leardini 2007)
/// - OpenSim's gait models, OptiTrack's Baseline, Conventional and Biomech sets (docs.optitrack.com)
/// - the Animation and Sports sets of Qualisys Track Manager
/// - Vicon's 53 markers of Blade and Shogun, the 47 of the Human Body Model (van den Bogert 2013)
/// - OpenCap, whose labels end in `_study`
/// - CGM2.3, whose clusters are `*THAP`, `*THAD`, `*TIAP` and `*TIAD` (pyCGM2's settings)
const ROWS: &[Row] = &[
    ("*ASI", Bone::Hips, Hard, "*asi *fwt *asis waist*front *ias"),
    ("*PSI", Bone::Hips, Hard, "*psi *bwt *psis waist*back *ips"),
    ("SACR", Bone::Hips, Hard, "sacr sacrum vsacral vsacrum waistback"),
    ("*ILC", Bone::Hips, Soft, "*ilc *iliaccrest waist*"),
    ("MFWT", Bone::Hips, Soft, "mfwt waistcfront"),
    ("MBWT", Bone::Hips, Soft, "mbwt waistcback"),
    (
        "*KNE",
        Bone::LeftUpperLeg,
        Hard,
        "*kne *kneelat *kneelateral *kneeout *latknee *fle *lfc *lk *le *lek *knee",
    ),
    (
        "*KNM",
        Bone::LeftUpperLeg,
        Hard,
        "*knm *kneemed *kneemedial *kneein *medknee *mkne *fme *mfc *me *kni *mek *mknee",
    ),
    ("*GTR", Bone::LeftUpperLeg, Soft, "*gtr *gt *gtro *ftc"),
    (
        "*THI",
        Bone::LeftUpperLeg,
        Soft,
        "*thi *thigh *thighupper *th1 *th *thighside *thigh1",
    ),
    (
        "*TH2",
        Bone::LeftUpperLeg,
        Soft,
        "*th2 *thighfront *thighfrontlow f*thi *thigh2 *thap *thiap",
    ),
    ("*TH3", Bone::LeftUpperLeg, Soft, "*th3 *thighrear *thigh3 *thad *thiad"),
    ("*TH4", Bone::LeftUpperLeg, Soft, "*th4"),
    (
        "*ANK",
        Bone::LeftLowerLeg,
        Hard,
        "*ank *anklelat *anklelateral *ankleout *latankle *fal *lmal *lm *ankle",
    ),
    (
        "*ANM",
        Bone::LeftLowerLeg,
        Hard,
        "*anm *anklemed *anklemedial *anklein *medankle *mma *tam *mmal *mm *mankle *med",
    ),
    (
        "*TIB",
        Bone::LeftLowerLeg,
        Soft,
        "*tib *shn *shin *tibia *shank *shankupper *tb1 *sk1 *sk *sh1 *ati",
    ),
    (
        "*TB2",
        Bone::LeftLowerLeg,
        Soft,
        "*tb2 *sk2 *shankfront *shinfronthigh *sh2 *tiap *tibap",
    ),
    (
        "*TB3",
        Bone::LeftLowerLeg,
        Soft,
        "*tb3 *sk3 *shankrear *sh3 *tiad *tibad",
    ),
    ("*TB4", Bone::LeftLowerLeg, Soft, "*tb4 *sk4"),
    ("*FHE", Bone::LeftLowerLeg, Hard, "*hf *fax"),
    ("*TTU", Bone::LeftLowerLeg, Hard, "*tt *ttc"),
    (
        "*HEE",
        Bone::LeftFoot,
        Hard,
        "*hee *heel *heelback *ca *fcc *cal *hel *calc",
    ),
    ("*TOE", Bone::LeftFoot, Hard, "*toe *mt2 *sm *fm2 *smh *forefoot2"),
    ("*TIP", Bone::LeftFoot, Soft, "*toetip *hallux"),
    (
        "*MT5",
        Bone::LeftFoot,
        Hard,
        "*mt5 *toelat *toeout *vm *fm5 *vmh *5meta *forefoot5 *forefootout",
    ),
    (
        "*MT1",
        Bone::LeftFoot,
        Hard,
        "*mt1 *toemed *toein *fm *fm1 *fmh *forefoot1 *forefootin",
    ),
    ("*MFS", Bone::LeftFoot, Soft, "*midfootsup"),
    ("*MFL", Bone::LeftFoot, Soft, "*midfootlat"),
    ("C7", Bone::Chest, Hard, "c7 cv7 backtop spinetop"),
    ("T2", Bone::Chest, Hard, "t2 tv2 spinethoracic2"),
    ("T10", Bone::Chest, Hard, "t10 t8 tv10 tv8 tv7 mai spinethoracic12"),
    ("CLAV", Bone::Chest, Hard, "clav sjn ij jn sternum chesttop"),
    ("STRN", Bone::Chest, Hard, "strn sxs px xp chest chestlow"),
    ("XYPH", Bone::Chest, Hard, "xyph"),
    ("RBAC", Bone::Chest, Soft, "rbac rbak rback backright backr"),
    ("LBAC", Bone::Chest, Soft, "lbac lbak lback backleft backl"),
    ("BBAC", Bone::Chest, Soft, "bbac"),
    ("NAVE", Bone::Spine, Soft, "nave navel"),
    (
        "*SHO",
        Bone::LeftShoulder,
        Hard,
        "*sho *acromium *acromion *acr *shouldertop *sae *caj *shoulder",
    ),
    ("*SHF", Bone::LeftShoulder, Soft, "*fsh *ash *shoulderfront"),
    ("*SHB", Bone::LeftShoulder, Soft, "*bsh *psh *shoulderback"),
    (
        "*UPA",
        Bone::LeftUpperArm,
        Soft,
        "*upa *bicep *biceps *uarmhigh *upperarm *ua *delt *arm",
    ),
    (
        "*ELB",
        Bone::LeftUpperArm,
        Hard,
        "*elb *elbow *elbowlat *elbowlateral *elbowout *hle *lel *lee *lelbow",
    ),
    (
        "*ELM",
        Bone::LeftUpperArm,
        Hard,
        "*elm *elbowmed *elbowmedial *elbowin *hme *melb *mel *iel *mee *melbow",
    ),
    ("*FRM", Bone::LeftLowerArm, Soft, "*frm *fra *forearm *farm"),
    (
        "*WRA",
        Bone::LeftLowerArm,
        Hard,
        "*wra *wristlat *wristin *rsp *wrr *iwr *lw *lwrist",
    ),
    (
        "*WRB",
        Bone::LeftLowerArm,
        Hard,
        "*wrb *wristmed *wristout *usp *wru *owr *mw *mwrist",
    ),
    ("*FIN", Bone::LeftHand, Hard, "*fin *hl2 *handout *hand2 *hm2 *ohand"),
    ("*HNI", Bone::LeftHand, Hard, "*handin *ihand"),
    ("*FHD", Bone::Head, Hard, "*fhd *temple head* *ah"),
    ("*BHD", Bone::Head, Hard, "*bhd *ph"),
    ("HEAD", Bone::Head, Hard, "ariel tophead headtop thead"),
    ("HEDF", Bone::Head, Hard, "headfront fhead"),
    ("HEDS", Bone::Head, Hard, "headside"),
    ("*EAR", Bone::Head, Hard, "*head"),
];

/// The name of a set, and some marker names that only this set uses.
const SETS: &[(&str, &str)] = &[
    ("CMU's set", "lfwt rfwt lbwt rbwt lshn rshn lmt5 rmt5 lupa lfrm"),
    ("Plug-in Gait", "lasi rasi lpsi rpsi lthi rthi ltib rtib"),
    ("Helen Hayes' set", "lasi rasi sacr lthi rthi ltib rtib"),
    (
        "CGM2's set",
        "lasi rasi lpsi rpsi lthi rthi lthap rthap lthad rthad ltib rtib ltiap rtiap ltiad rtiad",
    ),
    (
        "the set of OpenSim's gait models",
        "rasis lasis vsacral rthighupper lthighupper rshankupper lshankupper",
    ),
    (
        "OptiTrack's set",
        "waistlfront waistrfront waistlback waistrback lkneeout rkneeout lankleout rankleout",
    ),
    (
        "Qualisys' animation set",
        "waistlfront waistrfront lheelback rheelback lforefootin rforefootin lforefootout rforefootout larm rarm",
    ),
    (
        "Qualisys' sports set",
        "waistlfront waistrfront lheelback rheelback lforefoot2 rforefoot2 lforefoot5 rforefoot5 larm rarm",
    ),
    (
        "the set of the Istituto Rizzoli",
        "lasis rasis lpsis rpsis lgt rgt lle rle lhf rhf ltt rtt",
    ),
    (
        "OptiTrack's biomechanical set",
        "lias rias lips rips lfle rfle lfme rfme lfal rfal ltam rtam lfcc rfcc lcaj rcaj",
    ),
    (
        "Vicon's set of 53",
        "lfwt rfwt mfwt lbwt rbwt mbwt lfsh rfsh lbsh rbsh liel riel liwr riwr lkni rkni",
    ),
    (
        "the Human Body Model's set",
        "lasis rasis lgtro rgtro llek rlek llm rlm llee rlee lmee rmee xyph",
    ),
    (
        "OpenCap's set",
        "rasis lasis rmknee lmknee rmankle lmankle rcalc lcalc r5meta l5meta",
    ),
];

/// The landmark at which a marker sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// The name of the landmark, with the side.
    pub name: String,
    pub(super) bone: Bone,
    pub(super) on: MarkerSite,
}

/// The number of known labels below which the labels are not used.
pub(super) const KNOWN: usize = 8;

/// The caller's statements about labels.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// The landmark of each label in the caller's JSON, by the key of the label.
    pub(super) named: HashMap<String, Landmark>,
    /// The subject to solve.
    pub(super) subject: Option<String>,
}

impl Labels {
    /// The landmark that the caller assigns to a label, with or without the subject.
    pub(super) fn landmark(&self, label: &str) -> Option<&Landmark> {
        let whole = self.named.get(&whole_key(label));
        whole.or_else(|| self.named.get(&key(label)))
    }
}

/// The label in lower case, reduced to letters and digits, without the subject prefix (`subject:`) and without
/// OpenCap's suffix.
pub(super) fn key(label: &str) -> String {
    whole_key(label.rsplit(':').next().unwrap_or(label))
}

/// Like [`key`], with the subject.
pub(super) fn whole_key(label: &str) -> String {
    let letters = label.chars().filter(|letter| letter.is_alphanumeric());
    let letters: String = letters.flat_map(char::to_lowercase).collect();
    letters
        .strip_suffix("study")
        .map_or_else(|| letters.clone(), str::to_owned)
}

/// The keys of labels. If labels have a subject prefix without a colon, removes the prefix. Of all possible prefixes,
/// the removed prefix makes the most labels known.
pub fn keys(labels: &[String], known: &HashMap<String, Landmark>) -> Vec<String> {
    let keys: Vec<String> = labels.iter().map(|label| key(label)).collect();
    let plain = keys.iter().filter(|key| known.contains_key(*key)).count();
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for key in &keys {
        let ends = key.char_indices().skip(1).map(|(at, _)| key.split_at(at));
        for (subject, _) in ends.filter(|(_, end)| known.contains_key(*end)) {
            *counts.entry(subject).or_default() += 1;
        }
    }
    // On a tie, the first prefix by name: the order of a map is not the order of the file.
    let most = counts.into_iter().max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(a.0)));
    match most {
        Some((subject, count)) if count > plain => keys
            .iter()
            .map(|key| key.strip_prefix(subject).unwrap_or(key).to_owned())
            .collect(),
        _ => keys,
    }
}

/// Whether a key names a point that Plug-in Gait computes, not a marker: the origin of a bone or the tip of one of its
/// axes. A file has all four: `LTIO`, `LTIA`, `LTIL` and `LTIP`.
pub(super) fn is_axis(key: &str, keys: &[String]) -> bool {
    const ENDS: [char; 4] = ['o', 'a', 'l', 'p'];
    let is_there = |bone: &str, end: char| {
        keys.iter()
            .any(|own| own.strip_prefix(bone).is_some_and(|own| own.chars().eq([end])))
    };
    key.strip_suffix(ENDS)
        .is_some_and(|bone| ENDS.into_iter().all(|end| is_there(bone, end)))
}

/// All landmarks by the keys of their names.
pub fn by_key() -> HashMap<String, Landmark> {
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

/// The landmark with this name.
pub(super) fn named(name: &str) -> Option<Landmark> {
    by_key()
        .into_values()
        .find(|landmark| landmark.name.eq_ignore_ascii_case(name))
}

/// The set with nearly all of its own names in `keys`. If several sets fit, the set with the most names in `keys`.
pub fn set_name(keys: &[String]) -> Option<&'static str> {
    /// The smallest fraction of a set's names that a file of that set has, because some markers are always missing.
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
