//! A material's parameter values, by name.

use super::{BrdfModel, Parameter, Value};
use glam::Vec3;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, IgnoredAny},
};
use std::{borrow::Cow, collections::BTreeMap, sync::Arc};

/// Values by the names of parameters. A missing value is the default of the material's model.
///
/// It may hold values of parameters that the material's model lacks; they apply again when the model has them.
///
/// Copies share their values until one of them changes, so looks are cheap to copy and compare.
#[derive(Clone, Debug, Default)]
pub struct Parameters(Arc<BTreeMap<Cow<'static, str>, Value>>);

impl Parameters {
    /// The value of a parameter, if set.
    #[inline]
    pub fn get(&self, name: &str) -> Option<Value> {
        self.0.get(name).copied()
    }

    /// The value of a declared parameter, or its default.
    #[inline]
    pub fn value(&self, parameter: &Parameter) -> Value {
        self.get(parameter.name).unwrap_or(parameter.default)
    }

    /// A number, or the default that models declare under this name.
    pub fn number(&self, name: &str) -> f32 {
        self.or_default(name).number()
    }

    /// A color, or the default that models declare under this name.
    pub fn color(&self, name: &str) -> Vec3 {
        self.or_default(name).color()
    }

    fn or_default(&self, name: &str) -> Value {
        let declared = || BrdfModel::declared(name).map_or(Value::Number(0.0), |p| p.default);
        self.get(name).unwrap_or_else(declared)
    }

    /// Sets a value.
    pub fn set(&mut self, name: impl Into<Cow<'static, str>>, value: impl Into<Value>) {
        Arc::make_mut(&mut self.0).insert(name.into(), value.into());
    }

    /// The same with one value set.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.set(name, value);
        self
    }

    /// All values set, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Value)> {
        self.0.iter().map(|(name, value)| (name.as_ref(), *value))
    }

    /// Clamps all values that a model declares to their ranges and converts their kinds; see [`Parameter::sanitized`].
    /// Declarations of files differ, see [`Self::sanitized_by`].
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        for (name, value) in Arc::make_mut(&mut self.0) {
            if let Some(parameter) = BrdfModel::declared_by_models(name) {
                *value = parameter.sanitized(*value);
            }
        }
        self
    }

    /// Clamps all values of these parameters to their ranges and converts their kinds.
    #[must_use]
    pub fn sanitized_by(mut self, declared: &[Parameter]) -> Self {
        for parameter in declared {
            if let Some(value) = Arc::make_mut(&mut self.0).get_mut(parameter.name) {
                *value = parameter.sanitized(*value);
            }
        }
        self
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_ref().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Parameters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// Unknown values are kept until their names are known.
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Read {
            Value(Value),
            Other(IgnoredAny),
        }
        let mut values = BTreeMap::new();
        for (name, read) in BTreeMap::<String, Read>::deserialize(deserializer)? {
            let Read::Value(value) = read else {
                let reason = format!("the parameter `{name}` is neither a number nor a color of three numbers");
                return Err(D::Error::custom(reason));
            };
            values.insert(Cow::Owned(name), value);
        }
        Ok(Self(values.into()))
    }
}

/// Compares all values, defaults included. Parameters declared only by files have no default here: they are set or not.
impl PartialEq for Parameters {
    fn eq(&self, other: &Self) -> bool {
        if Arc::ptr_eq(&self.0, &other.0) {
            return true;
        }
        let same = |name: &Cow<str>| {
            let default = BrdfModel::declared_by_models(name).map(|p| p.default);
            self.get(name).or(default) == other.get(name).or(default)
        };
        self.0.keys().chain(other.0.keys()).all(same)
    }
}

impl<const N: usize> From<[(&'static str, Value); N]> for Parameters {
    fn from(values: [(&'static str, Value); N]) -> Self {
        Self(Arc::new(values.into_iter().map(|(name, value)| (Cow::Borrowed(name), value)).collect()))
    }
}
