//! The list of named properties that most elements have.

use glam::DVec3;

use super::encode::{Element, Value};

/// `Properties70`, under construction.
pub(super) struct Properties<'a>(Vec<Element<'a>>);

impl<'a> Properties<'a> {
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// A property by name, type, label and flags. `A` means that it can be animated, `U` that the user has added it.
    pub(super) fn property<const N: usize>(
        mut self,
        name: &'static str,
        [kind, label, flags]: [&'static str; 3],
        values: [Value<'a>; N],
    ) -> Self {
        let mut element = Element::of("P", name).with(kind).with(label).with(flags);
        for value in values {
            element = element.with(value);
        }
        self.0.push(element);
        self
    }

    pub(super) fn int(self, name: &'static str, value: i32) -> Self {
        self.property(name, ["int", "Integer", ""], [value.into()])
    }

    pub(super) fn choice(self, name: &'static str, value: i32) -> Self {
        self.property(name, ["enum", "", ""], [value.into()])
    }

    pub(super) fn flag(self, name: &'static str, value: bool) -> Self {
        self.property(name, ["bool", "", ""], [i32::from(value).into()])
    }

    pub(super) fn double(self, name: &'static str, value: f64) -> Self {
        self.property(name, ["double", "Number", ""], [value.into()])
    }

    pub(super) fn time(self, name: &'static str, value: i64) -> Self {
        self.property(name, ["KTime", "Time", ""], [value.into()])
    }

    pub(super) fn text(self, name: &'static str, value: impl Into<Value<'a>>) -> Self {
        self.property(name, ["KString", "", ""], [value.into()])
    }

    /// A custom text property, which programs show beside their own properties.
    pub(super) fn user_text(self, name: &'static str, value: impl Into<Value<'a>>) -> Self {
        self.property(name, ["KString", "", "U"], [value.into()])
    }

    pub(super) fn user_flag(self, name: &'static str) -> Self {
        self.property(name, ["bool", "", "U"], [1.into()])
    }

    pub(super) fn vector(self, name: &'static str, value: DVec3) -> Self {
        self.property(name, ["Vector3D", "Vector", ""], value.to_array().map(Value::from))
    }

    /// A colour that can be animated.
    pub(super) fn color(self, name: &'static str, value: DVec3) -> Self {
        self.property(name, ["Color", "", "A"], value.to_array().map(Value::from))
    }

    /// A number that can be animated.
    pub(super) fn number(self, name: &'static str, value: f64) -> Self {
        self.property(name, ["Number", "", "A"], [value.into()])
    }

    /// A property whose type equals its name, such as `Lcl Translation`.
    pub(super) fn own(self, name: &'static str, value: DVec3) -> Self {
        self.property(name, [name, "", "A"], value.to_array().map(Value::from))
    }

    /// The properties without the enclosing element.
    pub(super) fn into_elements(self) -> Vec<Element<'a>> {
        self.0
    }

    pub(super) fn element(self) -> Element<'a> {
        Element::new("Properties70").children(self.0)
    }
}
