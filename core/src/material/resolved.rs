//! Materials resolved for shading: everything equal at all points is computed once per edit.

use super::{BUMP, Material, NORMAL};
use crate::{
    brdf::{BrdfModel, Content, FilePart, Parameter, SurfaceBrdf, SurfaceParameters, Value, Values},
    texture::TextureSlot,
};
use glam::{Vec3, Vec4};

/// A material without names: its constants, clamped to their ranges, and the mapped parameters.
#[derive(Clone, Debug)]
pub struct ResolvedMaterial {
    model: BrdfModel,
    content: Option<Content>,
    /// Values without maps.
    plain: Values,
    mapped: Vec<MappedParameter>,
    base_color: Option<Place>,
    roughness: Option<Place>,
    normal: Option<TextureSlot>,
    bump: Option<TextureSlot>,
    reads_second_uvs: bool,
    /// The point of a material without mapped parameters.
    constant: Option<MaterialPoint>,
}

/// A parameter whose value varies from point to point.
#[derive(Clone, Debug)]
struct MappedParameter {
    place: Place,
    /// The value that the map modulates; may be out of range.
    value: Value,
    slot: Option<TextureSlot>,
    /// Whether it is multiplied by the colors of the vertices.
    has_vertex_color: bool,
}

/// The position of a parameter's first number among all values.
type Place = (usize, &'static Parameter);

/// A material at one point.
#[derive(Clone, Debug)]
pub struct MaterialPoint {
    /// Reflectance.
    pub brdf: SurfaceBrdf,
    /// Base color; black in models without one.
    pub base_color: Vec3,
    /// Perceptual roughness; 1 in models without one.
    pub roughness: f32,
    /// Emitted radiance, in W/(m² sr).
    pub emission: Vec3,
}

impl From<&Material> for ResolvedMaterial {
    fn from(material: &Material) -> Self {
        let declared = material.declared();
        let firsts = declared.iter().scan(0, |next, parameter| {
            let first = *next;
            *next += parameter.numbers();
            Some((first, parameter))
        });
        let places: Vec<Place> = firsts.collect();
        let of_quantity = |quantity| places.iter().copied().find(|(_, parameter)| parameter.quantity == quantity);
        let colored = material.vertex_colored().map(|parameter| parameter.name);
        let mapped = |&(first, parameter): &Place| {
            let slot = material.maps.get(parameter.name).cloned();
            let has_vertex_color = colored == Some(parameter.name);
            let value = material.parameters.value(parameter);
            let varies = slot.is_some() || has_vertex_color;
            varies.then_some(MappedParameter { place: (first, parameter), value, slot, has_vertex_color })
        };
        let content = material.file.as_ref().and_then(|file| file.content.clone());
        let mut resolved = Self {
            model: material.model,
            content: content.filter(|_| material.model.has_file()),
            plain: material.plain_values(),
            mapped: places.iter().filter_map(mapped).collect(),
            base_color: of_quantity("base_color"),
            roughness: of_quantity("roughness"),
            normal: material.maps.get(NORMAL).cloned(),
            bump: material.maps.get(BUMP).cloned(),
            reads_second_uvs: material.reads_second_uvs(),
            constant: None,
        };
        resolved.constant = resolved.mapped.is_empty().then(|| resolved.with_values(&resolved.plain));
        resolved
    }
}

impl ResolvedMaterial {
    /// Resolves all `materials`.
    pub fn all(materials: &[Material]) -> Vec<Self> {
        materials.iter().map(Self::from).collect()
    }

    /// The material at a point of the color that the vertices give, where `sample` looks up the texels of maps.
    #[inline]
    pub fn at(&self, color: Vec3, sample: impl Fn(&TextureSlot) -> Vec4) -> MaterialPoint {
        self.constant.clone().unwrap_or_else(|| self.with_values(&self.values(color, sample)))
    }

    /// Values of all parameters after their maps, clamped to their ranges.
    ///
    /// Values are clamped only here. Twin of `material_color` and `material_number` in `shaders/materials.wgsl`.
    pub fn values(&self, color: Vec3, sample: impl Fn(&TextureSlot) -> Vec4) -> Values {
        let mut values = self.plain;
        for MappedParameter { place: (first, parameter), value, slot, has_vertex_color } in &self.mapped {
            let read = |slot: &TextureSlot| match (sample(slot), parameter.is_color()) {
                (texel, true) => texel.truncate(),
                (texel, false) => Vec3::splat(texel[slot.channel as usize]),
            };
            let mut factor = slot.as_ref().map_or(Vec3::ONE, read);
            if *has_vertex_color {
                factor *= color;
            }
            values.replace(*first, parameter.sanitized(parameter.modulated(*value, factor)));
        }
        values
    }

    fn with_values(&self, values: &Values) -> MaterialPoint {
        let file = self.content.as_ref().map(|content| FilePart { content, plain: &self.plain });
        let at = |place: Option<Place>| place.map(|(first, parameter)| values.at(first, parameter));
        MaterialPoint {
            brdf: SurfaceBrdf::new(self.model, values, file),
            base_color: at(self.base_color).map_or(Vec3::ZERO, Value::color),
            roughness: at(self.roughness).map_or(1.0, Value::number),
            emission: SurfaceParameters::of(values).emission(),
        }
    }

    /// Its model.
    pub fn model(&self) -> BrdfModel {
        self.model
    }

    /// Values of all parameters without maps, clamped to their ranges.
    pub fn plain_values(&self) -> &Values {
        &self.plain
    }

    /// Whether its parameters have the same values everywhere.
    pub fn is_constant(&self) -> bool {
        self.constant.is_some()
    }

    /// Whether anything of it varies from point to point.
    #[inline]
    pub fn varies(&self) -> bool {
        !self.mapped.is_empty() || self.normal.is_some() || self.bump.is_some()
    }

    /// Whether a map uses the second set of texture coordinates.
    #[inline]
    pub fn reads_second_uvs(&self) -> bool {
        self.reads_second_uvs
    }

    /// Whether it is multiplied by the colors of the vertices.
    #[inline]
    pub fn reads_vertex_colors(&self) -> bool {
        self.mapped.iter().any(|mapped| mapped.has_vertex_color)
    }

    /// The slot of the normal map.
    #[inline]
    pub fn normal_map(&self) -> Option<&TextureSlot> {
        self.normal.as_ref()
    }

    /// The slot of the bump map.
    #[inline]
    pub fn bump_map(&self) -> Option<&TextureSlot> {
        self.bump.as_ref()
    }
}
