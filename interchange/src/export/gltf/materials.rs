//! Materials in glTF 2.0: metallic-roughness with `KHR_materials_anisotropy`, `_clearcoat`, `_emissive_strength`,
//! `_ior`, `_sheen` and `_specular`, and pictures placed by `KHR_texture_transform`.

use super::compose::{Component, Picture, Textures, mean};
use crate::{
    image::PictureFormat,
    materialx::{Surface, nearest, stretch},
};
use glam::Vec3;
use lapidary_core::{
    material::{BUMP, Material, NORMAL},
    texture::{Channel, ColorSpace, Texture, TextureSlot, UvSet},
};
use serde_json::{Map, Value, json};
use std::{collections::BTreeSet, f32::consts::FRAC_PI_2, sync::Arc};

/// A number with the fewest digits that identify its 32-bit value.
fn number(x: f32) -> Value {
    json!(x.to_string().parse::<f64>().unwrap_or_default())
}

fn triple(Vec3 { x, y, z }: Vec3) -> Value {
    json!([number(x), number(y), number(z)])
}

/// Writes materials in sequence.
pub(super) struct MaterialWriter<'a> {
    pub scene: &'a [Arc<Texture>],
    pub textures: Textures,
    /// Extensions that materials use.
    pub used: BTreeSet<&'static str>,
    pub remarks: Vec<String>,
}

/// Whether two pictures are placed equally.
fn lies_like(a: &TextureSlot, b: &TextureSlot) -> bool {
    (a.scale, a.offset, a.rotation, a.wrap, a.uv_set) == (b.scale, b.offset, b.rotation, b.wrap, b.uv_set)
}

impl<'a> MaterialWriter<'a> {
    pub fn new(scene: &'a [Arc<Texture>], textures: Textures) -> Self {
        Self { scene, textures, used: BTreeSet::new(), remarks: Vec::new() }
    }

    /// The JSON of a material, based on `before`; members unknown to this program stay.
    pub fn material(&mut self, material: &Material, before: Value) -> Value {
        let mut remarks = Vec::new();
        let (mut said, rotation) = turned(material);
        self.leave_out_missing(&mut said, &mut remarks);
        let said = nearest(&said, Surface::GltfPbr, &mut remarks);
        let mut writer = OneMaterial {
            said: self.stretched_at_mean(said, material),
            rotation,
            json: if let Value::Object(map) = before { map } else { Map::new() },
            all: self,
            lost: remarks,
        };
        writer.write();
        let OneMaterial { json, lost, .. } = writer;
        self.remarks.extend(lost.into_iter().map(|lost| format!("material \"{}\": {lost}", material.name)));
        Value::Object(json)
    }

    /// Removes maps whose pictures were missing on import, unless the file already refers to them.
    fn leave_out_missing(&self, material: &mut Material, remarks: &mut Vec<String>) {
        material.maps.retain(|name, slot| {
            let missing = self.scene.get(slot.texture as usize).filter(|texture| texture.encoded.is_empty());
            let Some(missing) = missing.filter(|_| self.textures.known(slot).is_none()) else {
                return true;
            };
            let (name, picture) = (name.replace('_', " "), &missing.name);
            remarks.push(format!("the picture \"{picture}\" was missing, and the map of its {name} is left out"));
            false
        });
    }

    /// For a roughness with a map, takes the stretch of the lobe at the map's mean; constants were converted before.
    fn stretched_at_mean(&self, mut said: Material, material: &Material) -> Material {
        let anisotropy = said.parameters.number("specular_roughness_anisotropy");
        let Some(slot) = said.maps.get("specular_roughness").filter(|_| anisotropy > 0.0) else { return said };
        let factor = said.parameters.number("specular_roughness");
        let at_mean = factor * self.scene.get(slot.texture as usize).map_or(1.0, |texture| mean(texture, slot));
        if at_mean > 0.0 && material.maps.get("specular_roughness_anisotropy").is_none() {
            let [roughness, strength] = stretch::to_gltf(stretch::of_openpbr(at_mean, anisotropy));
            said.parameters.set("specular_roughness", factor * roughness / at_mean);
            said.parameters.set("specular_roughness_anisotropy", strength);
        }
        said
    }
}

/// The material stretched along the tangent, and the rotation of its stretch in radians.
fn turned(material: &Material) -> (Material, f32) {
    let mut turned = material.clone();
    let name = material.model.parameter_for("anisotropy").map_or("", |p| p.name);
    let amount = material.parameters.get(name).map_or(0.0, |value| value.number());
    if amount < 0.0 {
        turned.parameters.set(name, -amount);
        return (turned, FRAC_PI_2);
    }
    (turned, 0.0)
}

/// The extension whose numbers import converts.
const GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// Writes one material.
struct OneMaterial<'w, 'a> {
    all: &'w mut MaterialWriter<'a>,
    /// The material in glTF's numbers under the names of OpenPBR.
    said: Material,
    rotation: f32,
    json: Map<String, Value>,
    lost: Vec<String>,
}

impl OneMaterial<'_, '_> {
    fn number(&self, name: &str) -> f32 {
        self.said.parameters.number(name)
    }

    fn color(&self, name: &str) -> Vec3 {
        self.said.parameters.color(name)
    }

    fn slot(&self, name: &str) -> Option<TextureSlot> {
        self.said.maps.get(name).filter(|slot| (slot.texture as usize) < self.all.scene.len()).cloned()
    }

    fn write(&mut self) {
        if !self.said.name.is_empty() {
            self.json.insert("name".into(), self.said.name.clone().into());
        }
        if self.said.double_sided || self.json.contains_key("doubleSided") {
            self.json.insert("doubleSided".into(), self.said.double_sided.into());
        }
        self.write_base();
        self.write_normal();
        self.write_specular();
        self.write_anisotropy();
        self.write_coat();
        self.write_sheen();
        self.write_emission();
        self.write_alpha();
        // It would show the look of before.
        self.extension(GLOSSINESS, None);
        self.tell_lost_maps();
    }

    /// Sets or removes a key of an object within the material.
    fn set(object: &mut Map<String, Value>, key: &str, value: Option<Value>) {
        match value {
            Some(value) => drop(object.insert(key.into(), value)),
            None => drop(object.remove(key)),
        }
    }

    /// Changes an object within the material; creates it if missing and removes it if empty.
    fn within(&mut self, keys: &[&str], change: impl FnOnce(&mut Map<String, Value>)) {
        within(&mut self.json, keys, change);
    }

    /// Writes or removes an extension.
    fn extension(&mut self, name: &'static str, values: Option<Vec<(&str, Option<Value>)>>) {
        if values.is_some() {
            self.all.used.insert(name);
        }
        self.within(&["extensions"], |extensions| match values {
            None => drop(extensions.remove(name)),
            Some(values) => {
                let extension = extensions.entry(name).or_insert_with(|| json!({}));
                if !extension.is_object() {
                    *extension = json!({});
                }
                let Some(object) = extension.as_object_mut() else { return };
                values.into_iter().for_each(|(key, value)| Self::set(object, key, value));
            }
        });
    }

    fn write_base(&mut self) {
        let alpha = number(self.number("geometry_opacity"));
        let [r, g, b] = self.color("base_color").to_array().map(number);
        let (roughness, metalness) = (self.number("specular_roughness"), self.number("base_metalness"));
        let color = self.base_color_texture();
        let roughness_texture = self.metallic_roughness_texture();
        self.within(&["pbrMetallicRoughness"], |pbr| {
            pbr.insert("baseColorFactor".into(), json!([r, g, b, alpha]));
            pbr.insert("metallicFactor".into(), number(metalness));
            pbr.insert("roughnessFactor".into(), number(roughness));
            Self::set(pbr, "baseColorTexture", color);
            Self::set(pbr, "metallicRoughnessTexture", roughness_texture);
        });
    }

    fn base_color_texture(&mut self) -> Option<Value> {
        let opacity = self.slot("geometry_opacity");
        let color = self.slot("base_color");
        let Some(opacity) = opacity else { return self.colors("base_color") };
        let alpha = Component::of(&opacity, opacity.channel);
        let Some(color) = color else {
            return Some(self.composed([Component::ONE, Component::ONE, Component::ONE, alpha], true, &opacity));
        };
        if color.texture == opacity.texture && opacity.channel == Channel::A && lies_like(&color, &opacity) {
            return self.colors("base_color");
        }
        if !lies_like(&color, &opacity) {
            self.lost.push("the map of its opacity lies otherwise than that of its color, and is left out".into());
            return self.colors("base_color");
        }
        let [r, g, b] = [Channel::R, Channel::G, Channel::B].map(|channel| Component::of(&color, channel));
        Some(self.composed([r, g, b, alpha], true, &color))
    }

    /// A color picture.
    fn colors(&mut self, name: &str) -> Option<Value> {
        let slot = self.slot(name)?;
        if slot.color_space == ColorSpace::Srgb && self.is_readable(&slot) {
            return Some(self.as_it_is(&slot));
        }
        let [r, g, b] = [Channel::R, Channel::G, Channel::B].map(|channel| Component::of(&slot, channel));
        Some(self.composed([r, g, b, Component::ONE], true, &slot))
    }

    /// A picture with a number in the component `at`.
    fn component(&mut self, name: &str, at: Channel) -> Option<Value> {
        let slot = self.slot(name)?;
        if slot.channel == at && self.is_linear(&slot) {
            return Some(self.as_it_is(&slot));
        }
        let mut components = [Component::ONE; 4];
        components[at as usize] = Component::of(&slot, slot.channel);
        Some(self.composed(components, false, &slot))
    }

    fn metallic_roughness_texture(&mut self) -> Option<Value> {
        let (roughness, metalness) = (self.slot("specular_roughness"), self.slot("base_metalness"));
        let place = roughness.clone().or(metalness.clone())?;
        let metalness = metalness.filter(|slot| lies_like(slot, &place)).or_else(|| {
            if self.said.maps.get("base_metalness").is_some() {
                self.lost
                    .push("the map of its metalness lies otherwise than that of its roughness, and is left out".into());
            }
            None
        });
        let fits = |slot: &Option<TextureSlot>, channel, factor: f32| match slot {
            Some(slot) => slot.channel == channel && slot.texture == place.texture && self.is_linear(slot),
            None => factor == 0.0,
        };
        if fits(&roughness, Channel::G, self.number("specular_roughness"))
            && fits(&metalness, Channel::B, self.number("base_metalness"))
        {
            return Some(self.as_it_is(&place));
        }
        let of =
            |slot: &Option<TextureSlot>| slot.as_ref().map_or(Component::ONE, |slot| Component::of(slot, slot.channel));
        Some(self.composed([Component::ONE, of(&roughness), of(&metalness), Component::ONE], false, &place))
    }

    fn write_normal(&mut self) {
        let normal = self.slot(NORMAL).map(|slot| {
            let is_as_it_is = !slot.flip_y && self.is_linear(&slot);
            let [r, g, b] = [Channel::R, Channel::G, Channel::B].map(|channel| Component::of(&slot, channel));
            let green = if slot.flip_y { g.inverted() } else { g };
            let mut texture = match is_as_it_is {
                true => self.as_it_is(&slot),
                false => self.composed([r, green, b, Component::ONE], false, &slot),
            };
            if slot.strength != 1.0 {
                texture["scale"] = number(slot.strength);
            }
            texture
        });
        Self::set(&mut self.json, "normalTexture", normal);
    }

    fn write_specular(&mut self) {
        let ior = self.number("specular_ior");
        self.extension("KHR_materials_ior", (ior != 1.5).then(|| vec![("ior", Some(number(ior)))]));
        let (weight, color) = (self.number("specular_weight"), self.color("specular_color"));
        let (weights, colors) = (self.component("specular_weight", Channel::A), self.colors("specular_color"));
        let is_there = weight != 1.0 || color != Vec3::ONE || weights.is_some() || colors.is_some();
        let values = vec![
            ("specularFactor", Some(number(weight))),
            ("specularColorFactor", Some(triple(color))),
            ("specularTexture", weights),
            ("specularColorTexture", colors),
        ];
        self.extension("KHR_materials_specular", is_there.then_some(values));
    }

    fn write_anisotropy(&mut self) {
        let strength = self.number("specular_roughness_anisotropy");
        let values =
            vec![("anisotropyStrength", Some(number(strength))), ("anisotropyRotation", Some(number(self.rotation)))];
        self.extension("KHR_materials_anisotropy", (strength > 0.0).then_some(values));
    }

    fn write_coat(&mut self) {
        let (weight, roughness) = (self.number("coat_weight"), self.number("coat_roughness"));
        if weight <= 0.0 {
            return self.extension("KHR_materials_clearcoat", None);
        }
        let values = vec![
            ("clearcoatFactor", Some(number(weight))),
            ("clearcoatRoughnessFactor", Some(number(roughness))),
            ("clearcoatTexture", self.component("coat_weight", Channel::R)),
            ("clearcoatRoughnessTexture", self.component("coat_roughness", Channel::G)),
        ];
        self.extension("KHR_materials_clearcoat", Some(values));
    }

    fn write_sheen(&mut self) {
        let color = self.color("fuzz_color");
        // The color already includes the weight.
        if color == Vec3::ZERO {
            return self.extension("KHR_materials_sheen", None);
        }
        let values = vec![
            ("sheenColorFactor", Some(triple(color))),
            ("sheenRoughnessFactor", Some(number(self.number("fuzz_roughness").sqrt()))),
            ("sheenColorTexture", self.colors("fuzz_color")),
            ("sheenRoughnessTexture", self.component("fuzz_roughness", Channel::A)),
        ];
        self.extension("KHR_materials_sheen", Some(values));
    }

    fn write_emission(&mut self) {
        let luminance = self.number("emission_luminance");
        let color = self.color("emission_color");
        // Factors in glTF are at most 1.
        let most = color.max_element().max(1.0);
        let (factor, strength) = if luminance > 0.0 { (color / most, luminance * most) } else { (Vec3::ZERO, 1.0) };
        let colors = self.colors("emission_color");
        let was_there = self.json.contains_key("emissiveFactor");
        let shows = factor != Vec3::ZERO;
        Self::set(&mut self.json, "emissiveFactor", (shows || was_there).then(|| triple(factor)));
        Self::set(&mut self.json, "emissiveTexture", colors);
        let values = (strength != 1.0).then(|| vec![("emissiveStrength", Some(number(strength)))]);
        self.extension("KHR_materials_emissive_strength", values);
    }

    fn write_alpha(&mut self) {
        let [opacity, cutoff] = ["geometry_opacity", "opacity_cutoff"].map(|name| self.number(name));
        let mode = if cutoff > 0.0 {
            Some("MASK")
        } else {
            (opacity < 1.0 || self.slot("geometry_opacity").is_some()).then_some("BLEND")
        };
        Self::set(&mut self.json, "alphaMode", mode.map(Into::into));
        Self::set(&mut self.json, "alphaCutoff", (cutoff > 0.0).then(|| number(cutoff)));
    }

    fn tell_lost_maps(&mut self) {
        let lost = [
            (BUMP, "glTF has no map of heights"),
            ("specular_ior", "glTF has no map of the index of refraction"),
            ("specular_roughness_anisotropy", "the map of its anisotropy is left out"),
            ("coat_roughness_anisotropy", "glTF's coat is not stretched"),
            ("emission_luminance", "the map of its luminance is left out"),
        ];
        let said = lost.into_iter().filter(|(name, _)| self.said.maps.get(name).is_some());
        self.lost.extend(said.map(|(_, text)| text.to_owned()));
    }

    fn texture_of(&self, slot: &TextureSlot) -> &Texture {
        &self.all.scene[slot.texture as usize]
    }

    /// Whether glTF supports the format of a picture. A missing picture stays referenced as in the file.
    fn is_readable(&self, slot: &TextureSlot) -> bool {
        let encoded = &self.texture_of(slot).encoded;
        encoded.is_empty() || ["png", "jpg"].contains(&PictureFormat::ending_of(encoded))
    }

    fn is_linear(&self, slot: &TextureSlot) -> bool {
        slot.color_space == ColorSpace::Linear && self.is_readable(slot)
    }

    /// The picture as imported.
    fn as_it_is(&mut self, slot: &TextureSlot) -> Value {
        let encoded = self.texture_of(slot).encoded.clone();
        let known = self.all.textures.known(slot);
        let index = known.unwrap_or_else(|| self.all.textures.of_bytes(encoded, slot.wrap));
        self.info(index, slot)
    }

    /// A new picture from components.
    fn composed(&mut self, components: [Component; 4], encodes: bool, place: &TextureSlot) -> Value {
        let picture = Picture { components, encodes, wrap: place.wrap }.png(self.all.scene);
        let index = self.all.textures.of_bytes(picture.into(), place.wrap);
        self.info(index, place)
    }

    fn info(&mut self, index: usize, slot: &TextureSlot) -> Value {
        let TextureSlot { scale, offset, rotation, .. } = slot;
        let default = TextureSlot::default();
        let mut info = json!({"index": index});
        if slot.uv_set == UvSet::Second {
            info["texCoord"] = 1.into();
        }
        if (*scale, *offset, *rotation) == (default.scale, default.offset, default.rotation) {
            return info;
        }
        self.all.used.insert(TRANSFORM);
        let transform = json!({
            "offset": [number(offset.x), number(offset.y)],
            "rotation": number(*rotation),
            "scale": [number(scale.x), number(scale.y)],
        });
        info["extensions"] = json!({TRANSFORM: transform});
        info
    }
}

/// The extension for the placement of pictures.
const TRANSFORM: &str = "KHR_texture_transform";

/// Changes an object within another; creates it if missing and removes it if empty.
fn within(object: &mut Map<String, Value>, keys: &[&str], change: impl FnOnce(&mut Map<String, Value>)) {
    let [first, rest @ ..] = keys else { return change(object) };
    let mut inner = match object.remove(*first) {
        Some(Value::Object(inner)) => inner,
        _ => Map::new(),
    };
    within(&mut inner, rest, change);
    if !inner.is_empty() {
        object.insert((*first).to_owned(), Value::Object(inner));
    }
}
