//! The textures of a material, by the name of the quantity they modulate.

use crate::{
    brdf::{BrdfModel, Parameter},
    texture::{ColorSpace, TextureSlot},
};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error as _, MapAccess, Visitor},
};
use std::{borrow::Cow, collections::BTreeMap, fmt, marker::PhantomData};

/// The map of tangent-space normals, +Y up (OpenGL); `strength` scales x and y.
pub const NORMAL: &str = "normal";
/// The map of heights; `strength` is the height in meters of a texel of value one.
pub const BUMP: &str = "bump";

/// Names of the maps a material of a model can have: one per parameter, rendered or stored, and two for the normal.
pub fn map_names(model: BrdfModel) -> impl Iterator<Item = &'static str> {
    model.parameters().iter().chain(model.stored_parameters()).map(|p| p.name).chain([NORMAL, BUMP])
}

/// Display name of a map.
pub fn map_label(name: &'static str) -> &'static str {
    match name {
        NORMAL => "Normal map",
        BUMP => "Bump map",
        _ => BrdfModel::declared(name).map_or(name, |p| p.label),
    }
}

/// Default color space of the 8-bit texels of a map: colors are sRGB encoded.
pub fn map_color_space(name: &str) -> ColorSpace {
    if BrdfModel::declared(name).is_some_and(Parameter::is_color) { ColorSpace::Srgb } else { ColorSpace::Linear }
}

/// Textures that modulate a material.
pub type MaterialMaps = Maps<TextureSlot>;

/// The slots of a material's maps, named by parameter, [`NORMAL`] or [`BUMP`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Maps<T>(BTreeMap<Cow<'static, str>, T>);

impl<T> Maps<T> {
    /// The slot of a map, if there is one.
    #[inline]
    pub fn get(&self, name: &str) -> Option<&T> {
        self.0.get(name)
    }

    /// The slot of a map, mutable.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut T> {
        self.0.get_mut(name)
    }

    /// Fills or empties the slot of a map.
    pub fn set(&mut self, name: impl Into<Cow<'static, str>>, slot: Option<T>) {
        let name = name.into();
        match slot {
            Some(slot) => drop(self.0.insert(name, slot)),
            None => drop(self.0.remove(&name)),
        }
    }

    /// All slots with their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &T)> {
        self.0.iter().map(|(name, slot)| (name.as_ref(), slot))
    }

    /// All slots.
    pub fn slots(&self) -> impl Iterator<Item = &T> {
        self.0.values()
    }

    /// All slots, mutable.
    pub fn slots_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.values_mut()
    }

    /// Keeps the slots for which `condition` holds.
    pub fn retain(&mut self, mut condition: impl FnMut(&str, &mut T) -> bool) {
        self.0.retain(|name, slot| condition(name, slot));
    }

    /// Converts the slots by `convert` and drops those for which it returns `None`.
    pub fn filter_map<U>(&self, mut convert: impl FnMut(&T) -> Option<U>) -> Maps<U> {
        Maps(self.0.iter().filter_map(|(name, slot)| Some((name.clone(), convert(slot)?))).collect())
    }

    /// Converts the slots by `convert`, which may fail.
    ///
    /// # Errors
    /// The first error of `convert`.
    pub fn try_map<U, E>(&self, mut convert: impl FnMut(&str, &T) -> Result<U, E>) -> Result<Maps<U>, E> {
        let converted = self.0.iter().map(|(name, slot)| Ok((name.clone(), convert(name, slot)?)));
        Ok(Maps(converted.collect::<Result<_, E>>()?))
    }
}

impl<T> Default for Maps<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T, const N: usize> From<[(&'static str, T); N]> for Maps<T> {
    fn from(slots: [(&'static str, T); N]) -> Self {
        Self(slots.into_iter().map(|(name, slot)| (Cow::Borrowed(name), slot)).collect())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Maps<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MapsVisitor(PhantomData))
    }
}

/// Reads an object whose keys are names of maps, each at most once. `null` means no map.
struct MapsVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for MapsVisitor<T> {
    type Value = Maps<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of material maps")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Maps<T>, A::Error> {
        let mut read = BTreeMap::new();
        while let Some((name, slot)) = entries.next_entry::<String, Option<T>>()? {
            if read.insert(Cow::from(name.clone()), slot).is_some() {
                return Err(A::Error::custom(format!("duplicate field `{name}`")));
            }
        }
        Ok(Maps(read.into_iter().filter_map(|(name, slot)| Some((name, slot?))).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_the_maps_that_are_there_and_may_say_null() {
        let maps = Maps::from([(BUMP, 3), ("roughness", 4)]);
        assert_eq!(serde_json::to_string(&maps).unwrap(), r#"{"bump":3,"roughness":4}"#);
        assert_eq!(serde_json::from_str::<Maps<i32>>(r#"{"roughness":4,"bump":3,"ior":null}"#).unwrap(), maps);
        let twice = serde_json::from_str::<Maps<i32>>(r#"{"ior": null, "ior": null}"#).unwrap_err().to_string();
        assert!(twice.starts_with("duplicate field `ior`"), "{twice}");
    }

    #[test]
    fn slots_are_converted_where_they_are_and_the_first_error_is_told() {
        let maps = Maps::from([(BUMP, 3), ("roughness", 4)]);
        assert_eq!(maps.filter_map(|&n| (n > 3).then_some(10 * n)), Maps::from([("roughness", 40)]));
        let order = |name: &str, &n: &i32| if n > 3 { Ok((name.to_owned(), n)) } else { Err(n) };
        assert_eq!(maps.try_map(order), Err(3));
        assert_eq!(maps.slots().copied().collect::<Vec<_>>(), [3, 4], "in the order of their names");
    }

    #[test]
    fn every_parameter_has_a_map_and_colours_are_encoded() {
        let names =
            ["base_color", "emission_luminance", "emission_color", "geometry_opacity", "opacity_cutoff", NORMAL, BUMP];
        assert_eq!(map_names(BrdfModel::Lambert).collect::<Vec<_>>(), names);
        assert_eq!(
            (map_color_space("base_color"), map_color_space("roughness")),
            (ColorSpace::Srgb, ColorSpace::Linear)
        );
        let labels = ["ior", BUMP, "coat_ior", "coat_roughness"].map(map_label);
        assert_eq!(labels, ["IOR", "Bump map", "Coat IOR", "Coat roughness"]);
    }
}
