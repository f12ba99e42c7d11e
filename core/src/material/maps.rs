//! The textures of a material, in one list for all that goes through them.

use crate::texture::{ColorSpace, TextureSlot};
use enum_map::{Enum, EnumMap};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error as _, MapAccess, Visitor},
};
use std::{
    fmt,
    marker::PhantomData,
    ops::{Index, IndexMut},
};

/// The parameter of a material that a texture modulates: one map per parameter, and two for the normal. A map
/// multiplies its parameter, as in glTF; for the index of refraction it scales the part above 1, the value of no
/// refraction. The model and the reflecting sides have no map: they are choices, not values, and the sides are baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Enum, Deserialize)]
#[serde(field_identifier, rename_all = "snake_case")]
pub enum MapKind {
    /// Multiplies the base colour.
    BaseColor,
    /// Multiplies the roughness.
    Roughness,
    /// Multiplies the metalness.
    Metalness,
    /// Multiplies the weight of the specular lobe.
    Specular,
    /// Multiplies the anisotropy: a texel of zero is isotropic, and float texels below zero turn the stretch across.
    Anisotropy,
    /// Multiplies the part of the index of refraction above 1: a texel of zero gives 1, a texel of one the parameter.
    Ior,
    /// Tangent-space normals, +Y up (OpenGL); `strength` scales x and y.
    Normal,
    /// Heights; `strength` is the height in metres of a texel of value one.
    Bump,
}

impl MapKind {
    /// All of them, in the order of files.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::LENGTH).map(Self::from_usize)
    }

    /// Its name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color",
            Self::Roughness => "roughness",
            Self::Metalness => "metalness",
            Self::Specular => "specular",
            Self::Anisotropy => "anisotropy",
            Self::Ior => "ior",
            Self::Normal => "normal",
            Self::Bump => "bump",
        }
    }

    /// Its name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::BaseColor => "Base color",
            Self::Roughness => "Roughness",
            Self::Metalness => "Metalness",
            Self::Specular => "Specular",
            Self::Anisotropy => "Anisotropy",
            Self::Ior => "IOR",
            Self::Normal => "Normal map",
            Self::Bump => "Bump map",
        }
    }

    /// How its 8-bit texels are meant unless something says otherwise.
    pub fn color_space(self) -> ColorSpace {
        if self == Self::BaseColor { ColorSpace::Srgb } else { ColorSpace::Linear }
    }
}

impl Serialize for MapKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

/// Textures that modulate a material.
pub type MaterialMaps = Maps<TextureSlot>;

/// The slot of each map of a material, if any. In files an object with a key for each [`MapKind`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Maps<T>(EnumMap<MapKind, Option<T>>);

impl<T> Maps<T> {
    /// All slots that are in use.
    pub fn slots(&self) -> impl Iterator<Item = &T> {
        self.0.values().flatten()
    }

    /// All slots that are in use, to be changed.
    pub fn slots_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.values_mut().flatten()
    }

    /// All slots, to be changed, filled or emptied.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (MapKind, &mut Option<T>)> {
        self.0.iter_mut()
    }

    /// Converts the slots that are in use by `convert`.
    pub fn filter_map<U>(&self, mut convert: impl FnMut(&T) -> Option<U>) -> Maps<U> {
        Maps(EnumMap::from_fn(|kind| self[kind].as_ref().and_then(&mut convert)))
    }

    /// Converts the slots that are in use by `convert`, or returns its first error.
    ///
    /// # Errors
    /// Those of `convert`.
    pub fn try_map<U, E>(&self, mut convert: impl FnMut(MapKind, &T) -> Result<U, E>) -> Result<Maps<U>, E> {
        let mut converted = Maps::default();
        for (kind, slot) in &self.0 {
            converted[kind] = slot.as_ref().map(|slot| convert(kind, slot)).transpose()?;
        }
        Ok(converted)
    }
}

impl<T> Default for Maps<T> {
    fn default() -> Self {
        Self(EnumMap::from_fn(|_| None))
    }
}

impl<T> Index<MapKind> for Maps<T> {
    type Output = Option<T>;

    fn index(&self, kind: MapKind) -> &Option<T> {
        &self.0[kind]
    }
}

impl<T> IndexMut<MapKind> for Maps<T> {
    fn index_mut(&mut self, kind: MapKind) -> &mut Option<T> {
        &mut self.0[kind]
    }
}

impl<T, const N: usize> From<[(MapKind, T); N]> for Maps<T> {
    fn from(slots: [(MapKind, T); N]) -> Self {
        let mut maps = Self::default();
        for (kind, slot) in slots {
            maps[kind] = Some(slot);
        }
        maps
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Maps<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MapsVisitor(PhantomData))
    }
}

/// Reads an object whose keys are kinds of maps, each at most once.
struct MapsVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for MapsVisitor<T> {
    type Value = Maps<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of material maps")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Maps<T>, A::Error> {
        let (mut maps, mut read) = (Maps::default(), Vec::new());
        while let Some((kind, slot)) = entries.next_entry::<MapKind, Option<T>>()? {
            if read.contains(&kind) {
                return Err(A::Error::duplicate_field(kind.key()));
            }
            read.push(kind);
            maps[kind] = slot;
        }
        Ok(maps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_the_keys_in_their_order_and_no_others() {
        let text = serde_json::to_string(&MaterialMaps::default()).unwrap();
        let pairs: Vec<String> = MapKind::all().map(|kind| format!("\"{}\":null", kind.key())).collect();
        assert_eq!(text, format!("{{{}}}", pairs.join(",")));
        assert_eq!(serde_json::from_str::<MaterialMaps>("{}").unwrap(), MaterialMaps::default());
        let misspelt = serde_json::from_str::<MaterialMaps>(r#"{"iro": null}"#).unwrap_err().to_string();
        assert!(misspelt.starts_with("unknown field `iro`, expected one of `base_color`"), "{misspelt}");
        let twice = serde_json::from_str::<MaterialMaps>(r#"{"ior": null, "ior": null}"#).unwrap_err().to_string();
        assert!(twice.starts_with("duplicate field `ior`"), "{twice}");
    }

    #[test]
    fn slots_are_converted_where_they_are_and_the_first_error_is_told() {
        let maps = Maps::from([(MapKind::Bump, 3), (MapKind::Roughness, 4)]);
        assert_eq!(maps.filter_map(|&n| (n > 3).then_some(10 * n)), Maps::from([(MapKind::Roughness, 40)]));
        let order = |kind, &n: &i32| if n > 3 { Ok((kind, n)) } else { Err(n) };
        assert_eq!(maps.try_map(order), Err(3));
        assert_eq!(maps.slots().copied().collect::<Vec<_>>(), [4, 3], "in the order of the kinds");
    }
}
