//! The sections of a file, its objects, and the connections between objects.

use std::collections::BTreeMap;

use mocap_scene::files::PROVENANCE;
use mocap_scene::scene::UpAxis;

use super::encode::{Element, Value};
use super::properties::Properties;
use super::time::Rate;
use super::{CREATOR, FbxVersion};

/// The id of an object.
pub(super) type Id = i64;

/// The id of the implicit root of every file, for which no object is written.
pub(super) const SCENE_ROOT: Id = 0;

/// Objects and their connections, under construction.
pub(super) struct Document<'a> {
    objects: Vec<Element<'a>>,
    connections: Vec<Element<'a>>,
    /// The number of objects of each kind.
    counts: BTreeMap<&'static str, i32>,
    last_id: Id,
}

/// The values of the sections other than the objects.
pub(super) struct Settings {
    pub(super) version: FbxVersion,
    pub(super) up: UpAxis,
    pub(super) metres_per_unit: f64,
    pub(super) rate: Rate,
    /// The end of the longest clip, in FBX's units of time.
    pub(super) end: i64,
    /// The clips, each with the time of its end.
    pub(super) clips: Vec<(String, i64)>,
    /// The provenance, as JSON.
    pub(super) provenance: String,
}

impl<'a> Document<'a> {
    pub(super) fn new() -> Self {
        Self {
            objects: Vec::new(),
            connections: Vec::new(),
            counts: BTreeMap::new(),
            // Smaller ids belong to the other sections.
            last_id: 1_000_000,
        }
    }

    /// An empty document whose ids are above the ids of an existing file.
    pub(super) fn after(last_id: Id) -> Self {
        Self {
            last_id: last_id.max(0),
            ..Self::new()
        }
    }

    /// The objects, the connections, and the number of objects of each kind.
    pub(super) fn into_parts(self) -> (Vec<Element<'a>>, Vec<Element<'a>>, BTreeMap<&'static str, i32>) {
        (self.objects, self.connections, self.counts)
    }

    /// Makes an object of a kind, with name, class and subclass, such as `Hips`, `Model` and `LimbNode`.
    pub(super) fn object(&mut self, kind: &'static str, [name, class, subclass]: [&str; 3]) -> (Id, Element<'a>) {
        self.last_id += 1;
        let element = Element::of(kind, self.last_id)
            .with(named(name, class))
            .with(subclass.to_owned());
        (self.last_id, element)
    }

    pub(super) fn add(&mut self, kind: &'static str, element: Element<'a>) {
        *self.counts.entry(kind).or_default() += 1;
        self.objects.push(element);
    }

    /// Connects an object to its owner.
    pub(super) fn connect(&mut self, object: Id, owner: Id) {
        self.connections.push(Element::of("C", "OO").with(object).with(owner));
    }

    /// Connects an object to a property of its owner.
    pub(super) fn connect_property(&mut self, object: Id, owner: Id, property: &'static str) {
        self.connections
            .push(Element::of("C", "OP").with(object).with(owner).with(property));
    }

    /// The sections of the file, in their order.
    pub(super) fn sections(self, settings: &Settings) -> Vec<Element<'a>> {
        vec![
            header(settings),
            global_settings(settings),
            documents(settings),
            Element::new("References"),
            definitions(&self.counts),
            Element::new("Objects").children(self.objects),
            Element::new("Connections").children(self.connections),
            takes(settings),
        ]
    }
}

/// Joins a name and a class in one text.
pub(super) fn named(name: &str, class: &str) -> String {
    format!("{name}\0\u{1}{class}")
}

fn header<'a>(settings: &Settings) -> Element<'a> {
    let stamp = [
        ("Version", 1000),
        ("Year", 1970),
        ("Month", 1),
        ("Day", 1),
        ("Hour", 10),
        ("Minute", 0),
        ("Second", 0),
        ("Millisecond", 0),
    ];
    let stamp = stamp.map(|(name, value)| Element::of(name, value));
    let texts = ["Title", "Subject", "Author", "Keywords", "Revision", "Comment"];
    let about = Properties::new()
        .property("DocumentUrl", ["KString", "Url", ""], ["".into()])
        .property("SrcDocumentUrl", ["KString", "Url", ""], ["".into()])
        .property("Original", ["Compound", "", ""], [])
        .text("Original|ApplicationVendor", "mocap")
        .text("Original|ApplicationName", "mocap")
        .text("Original|ApplicationVersion", env!("CARGO_PKG_VERSION"))
        .property("LastSaved", ["Compound", "", ""], [])
        .text("LastSaved|ApplicationVendor", "mocap")
        .text("LastSaved|ApplicationName", "mocap")
        .text("LastSaved|ApplicationVersion", env!("CARGO_PKG_VERSION"))
        .user_text(PROVENANCE, settings.provenance.clone());
    Element::new("FBXHeaderExtension")
        .child(Element::of("FBXHeaderVersion", 1003))
        .child(Element::of("FBXVersion", settings.version.number() as i32))
        .child(Element::of("EncryptionType", 0))
        .child(Element::new("CreationTimeStamp").children(stamp))
        .child(Element::of("Creator", CREATOR))
        .child(
            Element::of("SceneInfo", named("GlobalInfo", "SceneInfo"))
                .with("UserData")
                .child(Element::of("Type", "UserData"))
                .child(Element::of("Version", 100))
                .child(
                    Element::new("MetaData")
                        .child(Element::of("Version", 100))
                        .children(texts.map(|name| Element::of(name, ""))),
                )
                .child(about.element()),
        )
}

/// An axis, 0 for x, and its sign.
type Axis = (i32, i32);

/// The up axis and the front axis. The side axis is always +X.
fn axes(up: UpAxis) -> (Axis, Axis) {
    match up {
        UpAxis::Y => ((1, 1), (2, 1)),
        UpAxis::Z => ((2, 1), (1, -1)),
        UpAxis::NegY => ((1, -1), (2, -1)),
        UpAxis::NegZ => ((2, -1), (1, 1)),
    }
}

fn global_settings<'a>(settings: &Settings) -> Element<'a> {
    let (up, front) = axes(settings.up);
    // FBX states the unit in centimetres.
    let unit = 100.0 * settings.metres_per_unit;
    let properties = Properties::new()
        .int("UpAxis", up.0)
        .int("UpAxisSign", up.1)
        .int("FrontAxis", front.0)
        .int("FrontAxisSign", front.1)
        .int("CoordAxis", 0)
        .int("CoordAxisSign", 1)
        .int("OriginalUpAxis", up.0)
        .int("OriginalUpAxisSign", up.1)
        .double("UnitScaleFactor", unit)
        .double("OriginalUnitScaleFactor", unit)
        .property("AmbientColor", ["ColorRGB", "Color", ""], [0.0; 3].map(Value::from))
        .text("DefaultCamera", "Producer Perspective")
        .choice("TimeMode", settings.rate.mode())
        .time("TimeSpanStart", 0)
        .time("TimeSpanStop", settings.end)
        .double("CustomFrameRate", settings.rate.frames_per_second());
    Element::new("GlobalSettings")
        .child(Element::of("Version", 1000))
        .child(properties.element())
}

fn documents<'a>(settings: &Settings) -> Element<'a> {
    let active = settings.clips.first().map_or("", |clip| clip.0.as_str());
    let properties = Properties::new()
        .property("SourceObject", ["object", "", ""], [])
        .text("ActiveAnimStackName", active.to_owned());
    let document = Element::of("Document", 1_000_000_i64)
        .with("Scene")
        .with("Scene")
        .child(properties.element())
        .child(Element::of("RootNode", SCENE_ROOT));
    Element::new("Documents").child(Element::of("Count", 1)).child(document)
}

fn definitions<'a>(counts: &BTreeMap<&'static str, i32>) -> Element<'a> {
    let kind = |kind: &'static str, count: i32| Element::of("ObjectType", kind).child(Element::of("Count", count));
    Element::new("Definitions")
        .child(Element::of("Version", 100))
        .child(Element::of("Count", 1 + counts.values().sum::<i32>()))
        .child(kind("GlobalSettings", 1))
        .children(counts.iter().map(|(name, count)| kind(name, *count)))
}

/// The list of clips in the form of versions before 7, which some programs still read.
fn takes<'a>(settings: &Settings) -> Element<'a> {
    let active = settings.clips.first().map_or("", |clip| clip.0.as_str());
    Element::new("Takes")
        .child(Element::of("Current", active.to_owned()))
        .children(settings.clips.iter().map(|(name, end)| take(name, *end)))
}

/// A clip with its end, in the form of versions before 7.
pub(super) fn take<'a>(name: &str, end: i64) -> Element<'a> {
    let span = |name: &'static str| Element::of(name, 0_i64).with(end);
    Element::of("Take", name.to_owned())
        .child(Element::of("FileName", format!("{name}.tak")))
        .child(span("LocalTime"))
        .child(span("ReferenceTime"))
}
