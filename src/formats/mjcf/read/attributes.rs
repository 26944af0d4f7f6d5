//! Compiler settings, default classes, and the attributes of an element with its class applied.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::error::Code;
use mocap_scene::limits::Limits;
use mocap_scene::scene::robot::Placement;

use crate::Failure;
use crate::text::quote;
use crate::xml::Element;

/// The class of everything without a stated class.
const MAIN: &str = "main";

/// The largest nesting depth of classes.
const DEEPEST_CLASS: usize = 64;

/// The kinds of elements whose defaults the reader uses. The defaults of other kinds are dropped.
const KINDS: [&str; 2] = ["joint", "geom"];
const USED: [&str; 20] = [
    "actuatorfrcrange",
    "armature",
    "axis",
    "axisangle",
    "conaffinity",
    "contype",
    "density",
    "euler",
    "fromto",
    "group",
    "limited",
    "mass",
    "mesh",
    "pos",
    "quat",
    "range",
    "size",
    "type",
    "xyaxes",
    "zaxis",
];

/// The source of masses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InertiaFromGeoms {
    Auto,
    Always,
    Never,
}

/// The attributes of a kind of element.
type Values = HashMap<String, String>;

/// A class: the attributes for each kind of element. A nested class shares the attributes of the surrounding class
/// until it changes one.
type Class = HashMap<String, Rc<Values>>;

/// A mesh asset.
pub(super) struct MeshAsset {
    pub(super) file: String,
    pub(super) scale: DVec3,
}

/// The settings outside the bodies.
pub(super) struct Settings {
    /// The factor from an angle in the file to radians.
    pub(super) angle: f64,
    euler: [DVec3; 3],
    /// Whether Euler angles rotate about the parent's axes, not about the body's axes.
    euler_is_extrinsic: bool,
    pub(super) auto_limits: bool,
    /// When masses come from geoms: always, never, or only if `<inertial>` is missing.
    pub(super) inertia_from_geoms: InertiaFromGeoms,
    /// The first and the last group of geoms that count for the mass.
    pub(super) inertia_groups: [f64; 2],
    pub(super) total_mass: Option<f64>,
    pub(super) mesh_folder: String,
    pub(super) meshes: HashMap<String, MeshAsset>,
    classes: HashMap<String, Class>,
}

impl Settings {
    pub(super) fn read(root: &Element<'_, '_>, limits: &Limits) -> Result<Self, Failure> {
        let mut settings = Self {
            angle: 1_f64.to_radians(),
            euler: [DVec3::X, DVec3::Y, DVec3::Z],
            euler_is_extrinsic: false,
            auto_limits: true,
            inertia_from_geoms: InertiaFromGeoms::Auto,
            inertia_groups: [0.0, 5.0],
            total_mass: None,
            mesh_folder: String::new(),
            meshes: HashMap::new(),
            classes: HashMap::from([(MAIN.to_owned(), Class::new())]),
        };
        for compiler in root.all("compiler") {
            settings.read_compiler(&compiler)?;
        }
        for defaults in root.all("default") {
            settings.read_class(&defaults, MAIN, 0, limits)?;
        }
        for mesh in root.all("asset").flat_map(|asset| asset.all("mesh")) {
            let Some(file) = mesh.attribute("file") else { continue };
            let stem = || file.rsplit(['/', '\\']).next()?.rsplit_once('.').map(|(stem, _)| stem);
            let name = mesh.attribute("name").or_else(stem).unwrap_or(file);
            let asset = MeshAsset {
                file: file.to_owned(),
                scale: mesh.vector("scale")?.unwrap_or(DVec3::ONE),
            };
            settings.meshes.insert(name.to_owned(), asset);
        }
        Ok(settings)
    }

    fn read_compiler(&mut self, compiler: &Element<'_, '_>) -> Result<(), Failure> {
        let unknown = |name: &str, expected: &str| -> Failure {
            let found = quote(compiler.attribute(name).unwrap_or_default().as_bytes());
            Box::new(
                compiler
                    .at_attribute(
                        name,
                        Code::UnexpectedToken,
                        format!("the value of the compiler attribute {name} is unknown"),
                    )
                    .expected_found(expected, found),
            )
        };
        match compiler.attribute("angle") {
            Some("radian") => self.angle = 1.0,
            Some("degree") => self.angle = 1_f64.to_radians(),
            None => {}
            Some(_) => return Err(unknown("angle", "radian or degree")),
        }
        if let Some(order) = compiler.attribute("eulerseq") {
            let axis = |letter: char| match letter.to_ascii_lowercase() {
                'x' => Some(DVec3::X),
                'y' => Some(DVec3::Y),
                'z' => Some(DVec3::Z),
                _ => None,
            };
            let axes: Vec<DVec3> = order.chars().filter_map(axis).collect();
            let is_upper = order.chars().all(|letter| letter.is_ascii_uppercase());
            let is_lower = order.chars().all(|letter| letter.is_ascii_lowercase());
            match <[DVec3; 3]>::try_from(axes) {
                Ok(axes) if order.len() == 3 && (is_upper || is_lower) => {
                    self.euler = axes;
                    self.euler_is_extrinsic = is_upper;
                }
                _ => return Err(unknown("eulerseq", "three of x, y and z, or of X, Y and Z")),
            }
        }
        match compiler.attribute("inertiafromgeom") {
            Some("true") => self.inertia_from_geoms = InertiaFromGeoms::Always,
            Some("false") => self.inertia_from_geoms = InertiaFromGeoms::Never,
            Some("auto") => self.inertia_from_geoms = InertiaFromGeoms::Auto,
            None => {}
            Some(_) => return Err(unknown("inertiafromgeom", "true, false or auto")),
        }
        if let Some(range) = compiler.attribute("inertiagrouprange") {
            let range = compiler.parse_numbers("inertiagrouprange", range, 2, 2)?;
            self.inertia_groups = [range[0], range[1]];
        }
        self.total_mass = compiler.number("settotalmass")?.or(self.total_mass);
        if let Some(limited) = compiler.attribute("autolimits") {
            self.auto_limits = limited != "false";
        }
        if let Some(folder) = compiler.attribute("meshdir").or(compiler.attribute("assetdir")) {
            self.mesh_folder = folder.to_owned();
        }
        Ok(())
    }

    /// Reads a `<default>`. Its class is the surrounding class with changes.
    fn read_class(
        &mut self,
        element: &Element<'_, '_>,
        around: &str,
        depth: usize,
        limits: &Limits,
    ) -> Result<(), Failure> {
        let name = match element.attribute("class") {
            Some(name) => name,
            None if depth == 0 => MAIN,
            None => {
                let message = "a nested <default> has no class";
                return Err(Box::new(
                    element
                        .diagnostic(Code::MissingKeyword, message)
                        .help("add the attribute class"),
                ));
            }
        };
        if depth > DEEPEST_CLASS || self.classes.len() > limits.max_nodes {
            let message =
                format!("classes of defaults are nested more than {DEEPEST_CLASS} deep, or there are too many classes");
            return Err(Box::new(element.diagnostic(Code::LimitExceeded, message)));
        }
        let mut class = self.classes.get(around).cloned().unwrap_or_default();
        for values in element.children().filter(|child| KINDS.contains(&child.name())) {
            let own = class.entry(values.name().to_owned()).or_default();
            let own = Rc::make_mut(own);
            let used = values.attributes().filter(|(name, _)| USED.contains(name));
            own.extend(used.map(|(name, value)| (name.to_owned(), value.to_owned())));
        }
        self.classes.insert(name.to_owned(), class);
        for inner in element.all("default") {
            self.read_class(&inner, name, depth + 1, limits)?;
        }
        Ok(())
    }

    /// The attributes of an element in a body whose children have a class.
    pub(super) fn of<'a, 'input>(
        &'a self,
        element: Element<'a, 'input>,
        child_class: Option<&str>,
    ) -> Result<Attributes<'a, 'input>, Failure> {
        let named = element.attribute("class");
        let name = named.or(child_class).unwrap_or(MAIN);
        let Some(class) = self.classes.get(name) else {
            let message = format!("no <default> has the class {}", quote(name.as_bytes()));
            return Err(Box::new(element.at_attribute("class", Code::InvalidRobot, message)));
        };
        Ok(Attributes {
            settings: self,
            defaults: class.get(element.name()).map(|values| &**values),
            element,
        })
    }
}

/// An element with the attributes of its class.
pub(super) struct Attributes<'a, 'input> {
    settings: &'a Settings,
    defaults: Option<&'a Values>,
    pub(super) element: Element<'a, 'input>,
}

impl<'a> Attributes<'a, '_> {
    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let default = || self.defaults?.get(name).map(String::as_str);
        self.element.attribute(name).or_else(default)
    }

    /// The numbers of an attribute: at least `least` and at most `most` numbers.
    pub(super) fn numbers(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, Failure> {
        let Some(value) = self.get(name) else { return Ok(None) };
        self.element.parse_numbers(name, value, least, most).map(Some)
    }

    pub(super) fn vector(&self, name: &str) -> Result<Option<DVec3>, Failure> {
        let numbers = self.numbers(name, 3, 3)?;
        Ok(numbers.map(|numbers| DVec3::from_slice(&numbers)))
    }

    /// `pos`, and the rotation from whichever attribute states it.
    pub(super) fn origin(&self) -> Result<Placement, Failure> {
        Ok(Placement {
            rotation: self.rotation()?.unwrap_or(DQuat::IDENTITY),
            translation: self.vector("pos")?.unwrap_or_default(),
        })
    }

    fn rotation(&self) -> Result<Option<DQuat>, Failure> {
        let no_length = |name: &str| -> Failure {
            let message = format!("{name} has no direction: its length is 0");
            Box::new(self.element.at_attribute(name, Code::InvalidRobot, message))
        };
        // MuJoCo allows only one attribute with a rotation.
        if let Some(quat) = self.numbers("quat", 4, 4)? {
            let quat = DQuat::from_xyzw(quat[1], quat[2], quat[3], quat[0]);
            return match quat.length() > 1e-12 {
                true => Ok(Some(quat.normalize())),
                false => Err(no_length("quat")),
            };
        }
        if let Some(euler) = self.vector("euler")? {
            let turns = std::iter::zip(self.settings.euler, (euler * self.settings.angle).to_array());
            let product = turns.fold(DQuat::IDENTITY, |product, (axis, angle)| {
                let turn = DQuat::from_axis_angle(axis, angle);
                match self.settings.euler_is_extrinsic {
                    true => turn * product,
                    false => product * turn,
                }
            });
            return Ok(Some(product.normalize()));
        }
        if let Some(values) = self.numbers("axisangle", 4, 4)? {
            let axis = DVec3::from_slice(&values).try_normalize();
            let axis = axis.ok_or_else(|| no_length("axisangle"))?;
            return Ok(Some(DQuat::from_axis_angle(axis, values[3] * self.settings.angle)));
        }
        if let Some(values) = self.numbers("xyaxes", 6, 6)? {
            let x = DVec3::from_slice(&values).try_normalize();
            let x = x.ok_or_else(|| no_length("xyaxes"))?;
            let y = DVec3::from_slice(&values[3..]);
            let y = (y - x * x.dot(y)).try_normalize().ok_or_else(|| no_length("xyaxes"))?;
            return Ok(Some(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()));
        }
        if let Some(z) = self.vector("zaxis")? {
            let z = z.try_normalize().ok_or_else(|| no_length("zaxis"))?;
            return Ok(Some(DQuat::from_rotation_arc(DVec3::Z, z)));
        }
        Ok(None)
    }
}
