//! Materials: a BRDF model, the values of its parameters, and the textures that modulate them.
//!
//! Nothing about the BRDF is precomputed (paper, 4.2): each pixel has its own parameters, all modulated by textures.

mod attributes;
mod check;
mod maps;
mod part;
mod presets;
mod resolved;

pub use crate::brdf::BrdfModel;
pub use attributes::SurfaceAttributes;
pub use check::{MOST_MATERIAL_NUMBER, MaterialProblem, UnknownName};
pub use maps::{BUMP, Maps, MaterialMaps, NORMAL, map_color_space, map_label, map_names};
pub use part::MaterialPart;
pub use presets::{PRESETS, Preset};
pub use resolved::{MaterialPoint, ResolvedMaterial};

use crate::{
    brdf::{BrdfFile, Content, FilePart, Parameter, Parameters, SurfaceBrdf, SurfaceParameters, Values},
    texture::{TextureSlot, UvSet},
};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A material of a scene.
pub type Material = MaterialOf<TextureSlot>;

/// A material whose maps are identified by slots `S`: of a scene, a material file or a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MaterialFields<S>", bound(deserialize = "S: Deserialize<'de>"))]
pub struct MaterialOf<S> {
    /// Name from the source file.
    pub name: String,
    /// Reflectance model.
    pub model: BrdfModel,
    /// The BRDF file, for a model read from one. It stays when the model changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<BrdfFile>,
    /// Values that the maps modulate.
    pub parameters: Parameters,
    /// Textures.
    pub maps: Maps<S>,
    /// Both sides reflect: light reaches the back, and cameras see it.
    pub double_sided: bool,
    /// The base color is multiplied by the colors of the vertices.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub vertex_colors: bool,
}

impl<S> Default for MaterialOf<S> {
    fn default() -> Self {
        Self {
            name: String::new(),
            model: BrdfModel::default(),
            file: None,
            parameters: Parameters::default(),
            maps: Maps::default(),
            double_sided: false,
            vertex_colors: false,
        }
    }
}

/// A material as stored in files, before its names are checked.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields, bound = "S: Deserialize<'de>")]
struct MaterialFields<S> {
    name: String,
    model: BrdfModel,
    file: Option<BrdfFile>,
    parameters: Parameters,
    maps: Maps<S>,
    double_sided: bool,
    vertex_colors: bool,
}

impl<S> Default for MaterialFields<S> {
    fn default() -> Self {
        let MaterialOf { name, model, file, parameters, maps, double_sided, vertex_colors } = MaterialOf::default();
        Self { name, model, file, parameters, maps, double_sided, vertex_colors }
    }
}

impl<S> TryFrom<MaterialFields<S>> for MaterialOf<S> {
    type Error = UnknownName;

    fn try_from(fields: MaterialFields<S>) -> Result<Self, UnknownName> {
        let MaterialFields { name, model, file, parameters, maps, double_sided, vertex_colors } = fields;
        check::check_names(model, file.as_ref(), &parameters, &maps)?;
        Ok(Self { name, model, file, parameters, maps, double_sided, vertex_colors })
    }
}

impl<S> MaterialOf<S> {
    /// The same material with other maps.
    pub fn with_maps<T>(&self, maps: Maps<T>) -> MaterialOf<T> {
        let Self { name, model, file, parameters, double_sided, vertex_colors, .. } = self;
        MaterialOf {
            name: name.clone(),
            model: *model,
            file: file.clone(),
            parameters: parameters.clone(),
            maps,
            double_sided: *double_sided,
            vertex_colors: *vertex_colors,
        }
    }
}

impl<S> MaterialOf<S> {
    /// Converts a material from a file older than the change of the name `ward`, which then meant the Ward-Dür model.
    pub fn with_ward_of_before(&mut self) {
        if self.model == BrdfModel::Ward {
            self.model = BrdfModel::WardDuer;
        }
    }
}

impl<S> MaterialOf<S> {
    /// Its parameters: the model's, or those its file declares.
    pub fn declared(&self) -> &'static [Parameter] {
        let content = self.file.as_ref().and_then(|file| file.content.as_ref());
        match content.and_then(Content::written).filter(|_| self.model == BrdfModel::Wgsl) {
            Some(written) => written.material_parameters(),
            None => self.model.parameters(),
        }
    }

    /// Parameters kept for other programs and never rendered; in none of the other lists.
    pub fn stored_parameters(&self) -> &'static [Parameter] {
        self.model.stored_parameters()
    }

    /// [`Self::stored_parameters`] that have a map or a value other than the default.
    pub fn stored(&self) -> impl Iterator<Item = &'static Parameter> {
        let is_said =
            |p: &Parameter| self.maps.get(p.name).is_some() || p.sanitized(self.parameters.value(p)) != p.default;
        self.stored_parameters().iter().filter(move |p| is_said(p))
    }

    /// Parameters of the reflectance, which come first.
    pub fn own_parameters(&self) -> &'static [Parameter] {
        let declared = self.declared();
        &declared[..declared.len() - SurfaceParameters::LIST.len()]
    }

    /// The parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.declared().iter().find(|p| p.name == name)
    }

    /// Its parameter for a quantity, such as `base_color` or `roughness`.
    pub fn parameter_for(&self, quantity: &str) -> Option<&'static Parameter> {
        self.declared().iter().find(|p| p.quantity == quantity)
    }

    /// The parameter that the colors of the vertices multiply, if any.
    pub fn vertex_colored(&self) -> Option<&'static Parameter> {
        self.vertex_colors.then(|| self.parameter_for("base_color")).flatten()
    }

    /// The reflectance of its parameters without maps.
    pub fn plain_brdf(&self) -> SurfaceBrdf {
        self.brdf(&self.plain_values())
    }

    /// The reflectance of values in the order of the model's parameters, clamped to their ranges.
    #[inline]
    pub fn brdf(&self, values: &Values) -> SurfaceBrdf {
        let content = self.file.as_ref().and_then(|file| file.content.as_ref());
        let Some(content) = content.filter(|_| self.model.has_file()) else {
            return SurfaceBrdf::new(self.model, values, None);
        };
        SurfaceBrdf::new(self.model, values, Some(FilePart { content, plain: &self.plain_values() }))
    }

    /// Values of its parameters without maps, clamped to their ranges.
    pub fn plain_values(&self) -> Values {
        Values::of(self.declared(), &self.parameters)
    }
}

impl<S: Clone> MaterialOf<S> {
    /// The same material without leftovers of its earlier models.
    #[must_use]
    pub fn own(&self) -> Self {
        let mut own = Self { parameters: Parameters::default(), ..self.clone() };
        let is_own = |name: &str| self.parameter(name).or_else(|| self.model.stored_parameter(name)).is_some();
        own.maps.retain(|name, _| [NORMAL, BUMP].contains(&name) || is_own(name));
        for parameter in self.declared().iter().chain(self.stored_parameters()) {
            if let Some(value) = self.parameters.get(parameter.name) {
                own.parameters.set(parameter.name, value);
            }
        }
        own
    }

    /// Changes the model and carries over the values and maps of the quantities that both models have.
    pub fn change_model(&mut self, model: BrdfModel) {
        for to in model.parameters() {
            let Some(from) = self.parameter_for(to.quantity).filter(|from| from.name != to.name) else {
                continue;
            };
            let value = self.parameters.value(from);
            // An equal value may hold more: a stretch across the tangent, which the other model lacks.
            let says_the_same = self.parameters.get(to.name).is_some_and(|old| from.sanitized(old) == value);
            if !says_the_same {
                self.parameters.set(to.name, to.sanitized(value));
            }
            self.maps.set(to.name, self.maps.get(from.name).cloned());
        }
        self.model = model;
    }
}

impl Material {
    /// Whether a map uses the second set of texture coordinates.
    pub fn reads_second_uvs(&self) -> bool {
        self.maps.slots().any(|slot| slot.uv_set == UvSet::Second)
    }

    /// The same material with only the path of its file.
    pub fn without_content(&self) -> Self {
        Self { file: self.file.as_ref().map(BrdfFile::without_content), ..self.clone() }
    }

    /// Clamps parameters and placements of maps to their ranges; see [`Parameters::sanitized`] and [`TextureSlot::sanitized`].
    pub fn sanitized(mut self) -> Self {
        let declared = self.declared();
        self.parameters = self.parameters.sanitized().sanitized_by(declared);
        for slot in self.maps.slots_mut() {
            *slot = std::mem::take(slot).sanitized();
        }
        self
    }

    /// Sets the emitted radiance in W/(m² sr): a color up to one, and a luminance for the rest.
    pub fn set_emission(&mut self, radiance: Vec3) {
        let largest = radiance.max_element();
        if largest > 0.0 {
            let scale = largest.max(1.0);
            self.parameters.set("emission_color", radiance / scale);
            self.parameters.set("emission_luminance", scale);
        }
    }

    /// Whether the material emits light without its maps.
    pub fn shines(&self) -> bool {
        SurfaceParameters::from(&self.parameters).emission() != Vec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        brdf::{GgxParameters, Lambert, Value},
        texture::Channel,
    };
    use glam::Vec4;

    #[test]
    fn sanitizing_clamps_and_replaces_nan() {
        let bad = GgxParameters { roughness: 7.0, ior: 0.2, metalness: f32::NAN, ..Default::default() };
        let good = Parameters::from(bad).sanitized();
        assert_eq!((good.number("roughness"), good.number("ior"), good.number("metalness")), (1.0, 1.0, 0.0));
    }

    #[test]
    fn a_partial_json_material_takes_defaults_and_a_misspelt_name_is_an_error() {
        let m: Material = serde_json::from_str(r#"{"model": "ward", "parameters": {"roughness": 0.3}}"#).unwrap();
        assert_eq!((m.model, m.parameters.number("ior")), (BrdfModel::Ward, 1.5));
        let error = |json| serde_json::from_str::<Material>(json).unwrap_err().to_string();
        let misspelt = error(r#"{"parameters": {"rougness": 0.3}}"#);
        assert!(misspelt.starts_with("unknown parameter `rougness`, expected one of `base_color`"), "{misspelt}");
        let misspelt = error(r#"{"maps": {"iro": {}}}"#);
        assert!(misspelt.starts_with("unknown map `iro`, expected one of `base_color`"), "{misspelt}");
        assert!(error(r#"{"parameters": {"roughness": "dull"}}"#).contains("`roughness` is neither a number"));
        assert!(error(r#"{"colour": 1}"#).contains("unknown field `colour`"));
    }

    #[test]
    fn a_name_means_the_same_in_all_models() {
        for model in BrdfModel::ALL {
            for p in model.parameters() {
                let declared = BrdfModel::declared(p.name).unwrap();
                assert_eq!(p.in_section(""), declared.in_section(""), "{model:?}");
                assert_eq!(p.default, p.sanitized(p.default), "{model:?} {}", p.name);
                let [low, high] = p.range;
                assert!(low < high && low <= p.slider[0] && p.slider[1] <= high, "{model:?} {}", p.name);
                assert!(p.help.ends_with('.') && !p.label.is_empty(), "{model:?} {}", p.name);
            }
        }
    }

    /// An OpenPBR material with a value and a map for every stored parameter.
    fn storing() -> Material {
        let mut material = Material { model: BrdfModel::OpenPbr, ..Default::default() };
        for p in material.stored_parameters() {
            let value = if p.is_color() { Vec3::splat(0.375).into() } else { Value::Number(1.0) };
            material.parameters.set(p.name, if value == p.default { Value::Number(0.5) } else { value });
            material.maps.set(p.name, Some(TextureSlot::default()));
        }
        material
    }

    #[test]
    fn stored_parameters_are_those_of_openpbr_1_1() {
        // Name, default and range. A quantity unbounded in the specification has a large bound here; the index has the
        // bound of the others.
        let expected = [
            ("transmission_weight", Value::Number(0.0), [0.0, 1.0]),
            ("transmission_color", Value::Color(Vec3::ONE), [0.0, 1.0]),
            ("transmission_depth", Value::Number(0.0), [0.0, 1e6]),
            ("transmission_scatter", Value::Color(Vec3::ZERO), [0.0, 1.0]),
            ("transmission_scatter_anisotropy", Value::Number(0.0), [-1.0, 1.0]),
            ("transmission_dispersion_scale", Value::Number(0.0), [0.0, 1.0]),
            ("transmission_dispersion_abbe_number", Value::Number(20.0), [0.0, 1e6]),
            ("subsurface_weight", Value::Number(0.0), [0.0, 1.0]),
            ("subsurface_color", Value::Color(Vec3::splat(0.8)), [0.0, 1.0]),
            ("subsurface_radius", Value::Number(1.0), [0.0, 1e6]),
            ("subsurface_radius_scale", Value::Color(Vec3::new(1.0, 0.5, 0.25)), [0.0, 1.0]),
            ("subsurface_scatter_anisotropy", Value::Number(0.0), [-1.0, 1.0]),
            ("thin_film_weight", Value::Number(0.0), [0.0, 1.0]),
            ("thin_film_thickness", Value::Number(0.5), [0.0, 1e6]),
            ("thin_film_ior", Value::Number(1.4), [1.0, 10.0]),
        ];
        let stored = BrdfModel::OpenPbr.stored_parameters();
        assert_eq!(stored.iter().map(|p| (p.name, p.default, p.range)).collect::<Vec<_>>(), expected);
        for p in stored {
            assert_eq!((p.default, BrdfModel::declared(p.name)), (p.sanitized(p.default), Some(p)));
            assert!(p.range[0] <= p.slider[0] && p.slider[1] <= p.range[1], "{}", p.name);
            assert!(p.help.ends_with('.') && p.label == p.short_label(), "{}", p.name);
            let rendered = |model: &BrdfModel| model.parameter(p.name).or_else(|| model.parameter_for(p.quantity));
            assert!(BrdfModel::ALL.iter().find_map(rendered).is_none(), "{} is rendered", p.name);
            assert!(BrdfModel::all_declared().all(|swept| swept.name != p.name), "{} is swept", p.name);
        }
        let others = BrdfModel::ALL.iter().filter(|&&model| model != BrdfModel::OpenPbr);
        assert!(others.clone().count() > 5 && others.clone().all(|model| model.stored_parameters().is_empty()));
    }

    #[test]
    fn what_is_stored_changes_no_value_that_is_rendered() {
        let material = storing();
        let plain = Material { model: BrdfModel::OpenPbr, ..Default::default() };
        let values = |material: &Material| {
            ResolvedMaterial::from(material).values(Vec3::ONE, |_| panic!("a map is read")).numbers().to_vec()
        };
        assert_eq!(values(&material), values(&plain));
        assert_eq!(material.plain_values().numbers(), plain.plain_values().numbers());
        assert_ne!(material, plain, "negative control");
        let mut rougher = material;
        rougher.parameters.set("specular_roughness", 0.75);
        assert_ne!(values(&rougher), values(&plain), "negative control");
    }

    #[test]
    fn a_file_keeps_what_is_stored() {
        let material = storing();
        assert_eq!(material.stored().count(), 15);
        let json = serde_json::to_string(&material).unwrap();
        let read: Material = serde_json::from_str(&json).unwrap();
        assert_eq!((&read, read.own()), (&material, material.clone()));
        for p in material.stored_parameters() {
            assert!(json.matches(&format!("\"{}\":", p.name)).count() == 2, "a value and a map: {json}");
            let mut other = material.clone();
            other.parameters.set(p.name, p.default);
            assert_ne!(read, other, "negative control: {}", p.name);
        }
        let mut ggx = material;
        ggx.change_model(BrdfModel::Ggx);
        assert_eq!((ggx.stored().count(), ggx.own().maps.slots().count()), (0, 0), "GGX has nothing of it");
        ggx.change_model(BrdfModel::OpenPbr);
        assert_eq!(ggx.stored().count(), 15, "it counts again");
        let misspelt = r#"{"model": "openpbr", "parameters": {"transmision_weight": 1}}"#;
        let error = serde_json::from_str::<Material>(misspelt).unwrap_err().to_string();
        assert!(
            error.contains("unknown parameter `transmision_weight`") && error.contains("`thin_film_ior`"),
            "{error}"
        );
    }

    #[test]
    fn what_is_stored_is_checked_and_sanitized() {
        let mut material = storing();
        for p in material.stored_parameters() {
            material
                .parameters
                .set(p.name, if p.is_color() { Vec3::new(-1.0, 2.0, f32::NAN).into() } else { Value::Number(1e9) });
            let problem = material.validate().unwrap_err();
            assert_eq!(problem.what, p.name.replace('_', " "));
            material = material.sanitized();
            assert_eq!(material.validate(), Ok(()));
            let expected = match p.default {
                Value::Number(_) => Value::Number(p.range[1]),
                Value::Color(c) => Value::Color(Vec3::new(0.0, 1.0, c.z)),
            };
            assert_eq!(material.parameters.get(p.name), Some(expected), "{}", p.name);
            material.parameters.set(p.name, Value::Number(f32::NAN));
            material = material.sanitized();
            let default = if p.is_color() { p.default.color() } else { Vec3::splat(p.default.number()) };
            assert_eq!(material.parameters.value(p).color(), default, "{}", p.name);
        }
        assert_eq!(Parameters::default().number("subsurface_radius"), 1.0, "a default is known by its name");
    }

    #[test]
    fn another_model_keeps_the_look() {
        let mut material = Material::default();
        material.parameters.set("roughness", 0.25);
        material.parameters.set("anisotropy", -0.5);
        material.maps.set("roughness", Some(TextureSlot::default()));
        let before = material.clone();
        for model in [BrdfModel::Lambert, BrdfModel::OpenPbr] {
            material.change_model(model);
            material.change_model(BrdfModel::Ggx);
            let read = |material: &Material| GgxParameters::from(&material.parameters);
            assert_eq!(read(&material), read(&before), "{model:?}");
            assert!(material.maps.get("roughness").is_some(), "{model:?}");
        }
        material.change_model(BrdfModel::OpenPbr);
        material.parameters.set("specular_roughness", 0.75);
        material.change_model(BrdfModel::Ggx);
        let p = GgxParameters::from(&material.parameters);
        assert_eq!((p.roughness, p.anisotropy), (0.75, -0.5), "what was edited counts, what was not stays");
    }

    /// The Lambertian albedo, or the GGX parameters, of a material after its maps.
    fn read(material: &Material, texel: Vec4) -> GgxParameters {
        GgxParameters::new(&ResolvedMaterial::from(material).values(Vec3::ONE, |_| texel))
    }

    #[test]
    fn maps_scale_what_they_modulate_and_nothing_else() {
        let parameters = GgxParameters {
            base_color: Vec3::new(0.8, 0.4, 0.2),
            roughness: 0.6,
            metalness: 0.9,
            anisotropy: -0.8,
            ior: 2.0,
            specular: 0.5,
            edge_color: Vec3::new(0.9, 0.5, 0.1),
        };
        let plain = Material { parameters: parameters.into(), ..Default::default() };
        let texel = Vec4::new(0.5, 0.25, -1.0, 0.0);
        let with = |name: &'static str, channel| {
            let mut material = plain.clone();
            material.maps.set(name, Some(TextureSlot { channel, ..Default::default() }));
            read(&material, texel)
        };
        assert_eq!(read(&plain, texel), parameters);
        let base_color = Vec3::new(0.4, 0.1, 0.0);
        assert_eq!(with("base_color", Channel::R), GgxParameters { base_color, ..parameters });
        assert_eq!(with("roughness", Channel::R), GgxParameters { roughness: 0.3, ..parameters });
        assert_eq!(with("metalness", Channel::A), GgxParameters { metalness: 0.0, ..parameters });
        assert_eq!(with("specular", Channel::G), GgxParameters { specular: 0.125, ..parameters });
        assert_eq!(with("anisotropy", Channel::G), GgxParameters { anisotropy: -0.2, ..parameters });
        assert_eq!(with("anisotropy", Channel::B), GgxParameters { anisotropy: 0.8, ..parameters });
        for (channel, ior) in [(Channel::R, 1.5), (Channel::G, 1.25), (Channel::A, 1.0), (Channel::B, 1.0)] {
            assert_eq!(with("ior", channel), GgxParameters { ior, ..parameters });
        }
        assert_eq!(with("normal", Channel::R), parameters);
    }

    #[test]
    fn a_brdf_has_the_constants() {
        let mut material = Material { model: BrdfModel::Lambert, ..Default::default() };
        material.parameters.set("base_color", Vec3::new(0.1, 0.2, 2.0));
        let SurfaceBrdf::Lambert(brdf) = material.plain_brdf() else { panic!("another model") };
        use crate::brdf::Brdf;
        assert_eq!(brdf.albedo(), Lambert::new(Vec3::new(0.1, 0.2, 1.0)).albedo());
    }
}
