//! Tests of marker sets by their guides.

use mocap_solve::internals::{by_key, keys, set_name};

/// The labels of each set as its guide lists them, and the number of labels that are no landmark here. `*` stands for
/// both sides.
pub(super) const GUIDES: &[(&str, &str, usize)] = &[
    (
        "CMU's set",
        "*FHD *BHD C7 T10 CLAV STRN *SHO *UPA *ELB *FRM *WRA *WRB *FIN *FWT *BWT *THI *KNE *SHN *ANK *HEE *MT5 *TOE RBAC",
        0,
    ),
    (
        "Plug-in Gait",
        "*FHD *BHD C7 T10 CLAV STRN RBAK *SHO *UPA *ELB *FRM *WRA *WRB *FIN *ASI *PSI *THI *KNE *TIB *ANK *HEE *TOE",
        0,
    ),
    ("Helen Hayes' set", "*ASI SACR *THI *KNE *TIB *ANK *HEE *TOE", 0),
    (
        "CGM2's set",
        "*ASI *PSI *THI *THAP *THAD *KNE *KNM *TIB *TIAP *TIAD *ANK *MED *HEE *TOE",
        0,
    ),
    (
        "the set of OpenSim's gait models",
        "Sternum *.Acromium Top.Head *.Bicep *.Elbow *.Wrist.Med *.Wrist.Lat *.ASIS V.Sacral *.Thigh.Upper \
         *.Thigh.Front *.Thigh.Rear *.Knee.Lat *.Knee.Med *.Shank.Upper *.Shank.Front *.Shank.Rear *.Ankle.Lat \
         *.Ankle.Med *.Heel *.Midfoot.Sup *.Midfoot.Lat *.Toe.Tip *.Toe.Lat *.Toe.Med",
        0,
    ),
    (
        "Vicon's set of 53",
        "ARIEL C7 CLAV STRN T10 MFWT MBWT *FHD *BHD *FSH *BSH *UPA *ELB *IEL *FRM *IWR *OWR *IHAND *OHAND *FWT *BWT \
         *THI *KNE *KNI *SHN *ANK *HEL *MT1 *MT5 *TOE",
        0,
    ),
    (
        "OptiTrack's set",
        "HeadTop HeadFront HeadSide BackTop BackLeft BackRight Chest Waist*Front Waist*Back *ShoulderTop \
         *ShoulderBack *UArmHigh *ElbowOut *WristOut *WristIn *HandOut *ThighFront *KneeOut *Shin *AnkleOut *ToeOut \
         *ToeIn",
        0,
    ),
    (
        "OptiTrack's set",
        "HeadTop HeadFront HeadRight HeadLeft ChestTop ChestLow BackTop BackLeft BackRight WaistCBack Waist*Front \
         Waist*Back *ShoulderTop *ShoulderBack *UArmHigh *ElbowOut *FArm *WristOut *WristIn *HandIn *HandOut *ThighFront \
         *ThighSide *KneeOut *Shin *AnkleOut *Heel *ToeOut *ToeIn *ToeTip",
        0,
    ),
    (
        "Qualisys' animation set",
        "HeadL HeadTop HeadR HeadFront *ShoulderTop *ShoulderBack *Arm *ElbowOut *WristOut *WristIn *HandOut Chest \
         SpineTop BackL BackR Waist*Front Waist*Back *Thigh *KneeOut *Shin *AnkleOut *HeelBack *ForefootOut *ToeTip \
         *ForefootIn",
        0,
    ),
    (
        "Qualisys' sports set",
        "HeadL HeadR HeadFront Chest SpineThoracic2 SpineThoracic12 *ShoulderTop *Arm *ElbowOut *ElbowIn *WristOut \
         *WristIn *Hand2 Waist*Front Waist* WaistBack *ThighFrontLow *KneeOut *KneeIn *ShinFrontHigh *AnkleOut \
         *HeelBack *Forefoot5 *Forefoot2",
        0,
    ),
    // This guide has a front and a back of the glenohumeral joint, which no other guide distinguishes.
    (
        "OptiTrack's biomechanical set",
        "*AH *PH SJN SXS CV7 TV2 TV7 *HGT *IAS *IPS *CAJ *HLE *HME *UA *HM2 *USP *RSP *FTC *FLE *FME *TH *SK *TTC *FAX \
         *FAL *TAM *FM5 *FM1 *FM2 *FCC",
        2,
    ),
    (
        "the set of the Istituto Rizzoli",
        "*ASIS *PSIS *GT *LE *ME *HF *TT *LM *MM *CA *FM *SM *VM",
        0,
    ),
    (
        "the Human Body Model's set",
        "*ASIS *PSIS *GTRO *LEK *LM *TOE *SHO *LEE *MEE *LW *MW XYPH C7 THEAD *HEAD SACR T10 NAVE STRN *DELT *FIN BBAC \
         F*THI *ATI *HEE *MT5 *FRM FHEAD",
        0,
    ),
    // This guide computes the hips.
    (
        "OpenCap's set",
        "r.ASIS_study L.ASIS_study r.PSIS_study L.PSIS_study *_knee_study *_mknee_study *_ankle_study *_mankle_study \
         *_toe_study *_5meta_study *_calc_study *_shoulder_study C7_study *_lelbow_study *_melbow_study *_lwrist_study \
         *_mwrist_study *_thigh1_study *_thigh2_study *_thigh3_study *_sh1_study *_sh2_study *_sh3_study *HJC_study",
        2,
    ),
];

pub(super) fn labels(guide: &str) -> Vec<String> {
    let of = |name: &str| match name.contains('*') {
        true => vec![name.replace('*', "L"), name.replace('*', "R")],
        false => vec![name.to_owned()],
    };
    guide.split_whitespace().flat_map(of).collect()
}

#[test]
fn every_set_is_known_by_its_guide_and_each_marker_is_a_landmark_of_its_own() {
    let known = by_key();
    for (set, guide, strange) in GUIDES {
        let labels = labels(guide);
        for subject in ["", "Anna:", "Subject 7_", "Skeleton2"] {
            let named: Vec<String> = labels.iter().map(|label| format!("{subject}{label}")).collect();
            let keys = keys(&named, &known);
            assert_eq!(set_name(&keys), Some(*set), "{subject}");
            let mut found: Vec<&str> = keys
                .iter()
                .filter_map(|key| Some(known.get(key)?.name.as_str()))
                .collect();
            assert_eq!(found.len() + strange, labels.len(), "{set} {subject}: {found:?}");
            found.sort_unstable();
            let count = found.len();
            found.dedup();
            assert_eq!(found.len(), count, "{set}: {found:?}");
        }
    }
}
