//! The values that a material has for parameters, by name.

use super::{BrdfModel, Parameter, Value};
use glam::Vec3;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, IgnoredAny},
};
use std::{borrow::Cow, collections::BTreeMap, sync::Arc};

/// Values by the names of parameters. Those that a material says nothing of have the defaults of its model.
///
/// It may hold values of parameters that the material's model lacks: they count again when the model does.
///
/// Copies share their values until one of them is changed, so that a look is copied and compared at little cost.
#[derive(Clone, Debug, Default)]
pub struct Parameters(Arc<BTreeMap<Cow<'static, str>, Value>>);

impl Parameters {
    /// The value of a parameter, if it is told.
    #[inline]
    pub fn get(&self, name: &str) -> Option<Value> {
        self.0.get(name).copied()
    }

    /// The value of a declared parameter, told or not.
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

    /// Tells a value.
    pub fn set(&mut self, name: impl Into<Cow<'static, str>>, value: impl Into<Value>) {
        Arc::make_mut(&mut self.0).insert(name.into(), value.into());
    }

    /// With a value told.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.set(name, value);
        self
    }

    /// All that are told, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Value)> {
        self.0.iter().map(|(name, value)| (name.as_ref(), *value))
    }

    /// With all values that a model declares in their ranges, and of their kinds; see [`Parameter::sanitized`]. What files
    /// declare may differ from file to file: see [`Self::sanitized_by`].
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        for (name, value) in Arc::make_mut(&mut self.0) {
            if let Some(parameter) = BrdfModel::declared_by_models(name) {
                *value = parameter.sanitized(*value);
            }
        }
        self
    }

    /// With all values of these parameters in their ranges, and of their kinds.
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
        /// Anything else is kept until its name is known.
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

/// Equal if all values are, told or not. What only files declare has no default here: it is told, or not.
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
