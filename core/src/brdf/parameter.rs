//! Declarations of model parameters: names, ranges, defaults, units and effects.
//!
//! Panels, material files, the shaders' structures and the tests follow from these declarations. A name means the same
//! in all models, so a material keeps its look when its model changes.

use super::Parameters;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A number.
    Number(f32),
    /// A linear RGB color.
    Color(Vec3),
}

impl Value {
    /// The number, or the mean of the color.
    pub fn number(self) -> f32 {
        match self {
            Self::Number(x) => x,
            Self::Color(c) => c.element_sum() / 3.0,
        }
    }

    /// The color, or the gray of the number.
    pub fn color(self) -> Vec3 {
        match self {
            Self::Number(x) => Vec3::splat(x),
            Self::Color(c) => c,
        }
    }
}

impl From<f32> for Value {
    fn from(x: f32) -> Self {
        Self::Number(x)
    }
}

impl From<Vec3> for Value {
    fn from(c: Vec3) -> Self {
        Self::Color(c)
    }
}

/// Effect of a map's texels on a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapUse {
    /// They multiply it, as in glTF.
    Multiplies,
    /// They scale the part above 1: a texel of zero gives 1, which is no refraction.
    ScalesAboveOne,
}

/// A declared parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in files and shaders, in snake case.
    pub name: &'static str,
    /// Display name.
    pub label: &'static str,
    /// Section of the model, under which panels show it; empty in models of one section.
    pub section: &'static str,
    /// Effect, in one line.
    pub help: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Least and largest value of each component.
    pub range: [f32; 2],
    /// The part of the range that a slider covers.
    pub slider: [f32; 2],
    /// Value of a material without one.
    pub default: Value,
    /// Effect of a map.
    pub map: MapUse,
    /// Name shared by the models that have the quantity; the parameter's own name by default.
    pub quantity: &'static str,
}

impl Parameter {
    /// A number in a range. The declaring field gives its name.
    pub const fn number(label: &'static str, range: [f32; 2], default: f32, help: &'static str) -> Self {
        Self {
            name: "",
            label,
            section: "",
            help,
            unit: "",
            range,
            slider: range,
            default: Value::Number(default),
            map: MapUse::Multiplies,
            quantity: "",
        }
    }

    /// A color from black to white.
    pub const fn color(label: &'static str, default: [f32; 3], help: &'static str) -> Self {
        Self { default: Value::Color(Vec3::from_array(default)), ..Self::number(label, [0.0, 1.0], 0.0, help) }
    }

    /// The parameter with a slider that covers less than the range.
    pub const fn with_slider(self, slider: [f32; 2]) -> Self {
        Self { slider, ..self }
    }

    /// The parameter in a section of the model.
    pub const fn in_section(self, section: &'static str) -> Self {
        Self { section, ..self }
    }

    /// The parameter with a map that scales the part above 1.
    pub const fn above_one(self) -> Self {
        Self { map: MapUse::ScalesAboveOne, ..self }
    }

    /// The parameter with a quantity shared by other models.
    pub const fn known_as(self, quantity: &'static str) -> Self {
        Self { quantity, ..self }
    }

    /// The parameter with the name of its field.
    pub const fn named(self, name: &'static str) -> Self {
        let quantity = if self.quantity.is_empty() { name } else { self.quantity };
        Self { name, quantity, ..self }
    }

    /// Display name under the title of its section.
    pub fn short_label(&self) -> String {
        let rest = self.label.strip_prefix(self.section).unwrap_or(self.label).trim_start();
        let mut letters = rest.chars();
        letters.next().map(|first| first.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
    }

    /// Whether its values are colors.
    pub const fn is_color(&self) -> bool {
        matches!(self.default, Value::Color(_))
    }

    /// Count of numbers in a value.
    pub const fn numbers(&self) -> usize {
        if self.is_color() { 3 } else { 1 }
    }

    /// `value` converted to the parameter's kind and clamped to its range; the default for NaN.
    #[inline]
    pub fn sanitized(&self, value: Value) -> Value {
        let [low, high] = self.range;
        match self.default {
            Value::Number(default) => {
                let x = value.number();
                Value::Number(if x.is_nan() { default } else { x.clamp(low, high) })
            }
            Value::Color(default) => {
                let clamp = |x: f32, default: f32| if x.is_nan() { default } else { x.clamp(low, high) };
                let c = value.color();
                Value::Color(Vec3::new(clamp(c.x, default.x), clamp(c.y, default.y), clamp(c.z, default.z)))
            }
        }
    }

    /// `value` after a texel's `factor`.
    #[inline]
    pub fn modulated(&self, value: Value, factor: Vec3) -> Value {
        match (value, self.map) {
            (Value::Color(c), MapUse::Multiplies) => Value::Color(c * factor),
            (Value::Color(c), MapUse::ScalesAboveOne) => Value::Color(1.0 + (c - 1.0) * factor),
            (Value::Number(x), MapUse::Multiplies) => Value::Number(x * factor.x),
            (Value::Number(x), MapUse::ScalesAboveOne) => Value::Number(1.0 + (x - 1.0) * factor.x),
        }
    }
}

/// Largest count of numbers in the parameters of a model.
pub const MOST_NUMBERS: usize = 56;

/// The values of a model's parameters at one point, in the order of its list.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    numbers: [f32; MOST_NUMBERS],
    len: usize,
}

impl Default for Values {
    fn default() -> Self {
        Self { numbers: [0.0; MOST_NUMBERS], len: 0 }
    }
}

impl Values {
    /// Adds the value of the next parameter.
    #[inline]
    pub fn push(&mut self, value: Value) {
        match value {
            Value::Number(x) => {
                self.numbers[self.len] = x;
                self.len += 1;
            }
            Value::Color(c) => {
                self.numbers[self.len..self.len + 3].copy_from_slice(&c.to_array());
                self.len += 3;
            }
        }
    }

    /// The last `count` numbers, as separate values.
    #[inline]
    pub(super) fn last(&self, count: usize) -> Self {
        let mut last = Self { len: count, ..Self::default() };
        last.numbers[..count].copy_from_slice(&self.numbers[self.len - count..self.len]);
        last
    }

    /// Values of a list from a material, clamped to their ranges; the defaults where the material has none.
    pub fn of(list: &[Parameter], told: &Parameters) -> Self {
        let mut values = Self::default();
        list.iter().for_each(|p| values.push(p.sanitized(told.value(p))));
        values
    }

    /// Replaces the value of the parameter whose numbers begin at `first`.
    #[inline]
    pub(crate) fn replace(&mut self, first: usize, value: Value) {
        match value {
            Value::Number(x) => self.numbers[first] = x,
            Value::Color(c) => self.numbers[first..first + 3].copy_from_slice(&c.to_array()),
        }
    }

    /// All numbers.
    pub fn numbers(&self) -> &[f32] {
        &self.numbers[..self.len]
    }

    /// The values of the parameters of a list, with which these values begin.
    pub fn each(&self, list: &'static [Parameter]) -> impl Iterator<Item = Value> {
        let mut next = 0;
        list.iter().map(move |parameter| {
            let first = next;
            next += parameter.numbers();
            self.at(first, parameter)
        })
    }

    /// The value of a parameter whose numbers begin at `first`.
    #[inline]
    pub(crate) fn at(&self, first: usize, parameter: &Parameter) -> Value {
        match parameter.is_color() {
            true => Value::Color(Vec3::from_slice(&self.numbers[first..first + 3])),
            false => Value::Number(self.numbers[first]),
        }
    }
}

/// Takes the values of successive parameters.
pub struct Taken<'a> {
    values: &'a Values,
    next: usize,
}

impl<'a> Taken<'a> {
    /// Starts at the first value.
    pub fn new(values: &'a Values) -> Self {
        Self { values, next: 0 }
    }
}

/// A Rust type of a parameter's values.
pub trait OfParameter: Copy + Into<Value> {
    /// Takes the next value.
    fn take(from: &mut Taken) -> Self;
    /// Converts a value.
    fn of(value: Value) -> Self;
}

impl OfParameter for f32 {
    #[inline]
    fn take(from: &mut Taken) -> Self {
        from.next += 1;
        from.values.numbers[from.next - 1]
    }

    fn of(value: Value) -> Self {
        value.number()
    }
}

impl OfParameter for Vec3 {
    #[inline]
    fn take(from: &mut Taken) -> Self {
        from.next += 3;
        Self::from_slice(&from.values.numbers[from.next - 3..from.next])
    }

    fn of(value: Value) -> Self {
        value.color()
    }
}

/// Declares the parameters of a model: a structure with a field for each, and their list.
macro_rules! parameters {
    ($(#[$doc:meta])* pub struct $name:ident { $($field:ident: $ty:ty = $declared:expr,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $(#[doc = concat!("The parameter `", stringify!($field), "` of the list.")] pub $field: $ty,)*
        }

        impl $name {
            /// The declarations, in the order of panels, files and shaders.
            pub const LIST: &'static [$crate::brdf::Parameter] = &[$($declared.named(stringify!($field)),)*];

            /// Takes the values in the order of the list.
            #[inline]
            pub fn new(values: &$crate::brdf::Values) -> Self {
                let mut taken = $crate::brdf::parameter::Taken::new(values);
                Self { $($field: $crate::brdf::parameter::OfParameter::take(&mut taken),)* }
            }
        }

        impl From<&$crate::brdf::Parameters> for $name {
            fn from(told: &$crate::brdf::Parameters) -> Self {
                Self { $($field: $crate::brdf::parameter::OfParameter::of(told.value(&$declared.named(stringify!($field)))),)* }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $crate::brdf::parameter::OfParameter::of($declared.default),)* }
            }
        }

        impl From<$name> for $crate::brdf::Parameters {
            fn from(p: $name) -> Self {
                Self::from([$((stringify!($field), $crate::brdf::Value::from(p.$field)),)*])
            }
        }
    };
}
pub(crate) use parameters;
