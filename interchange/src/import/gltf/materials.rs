//! Metallic-roughness materials of a glTF file and their textures.

use super::{
    super::{
        files::Trouble,
        textures::{TextureLibrary, Unread, read_picture},
    },
    buffers::{Buffers, percent_decoded, read_uri},
    glossiness::{self, Glossiness, Metallic},
    layers::{Layers, TextureInfo, Transform},
};
use crate::{
    import::{gltf::json::document_with, source::Source},
    names::listed,
};
use glam::{Vec3, Vec4};
use gltf::{buffer::View, material::AlphaMode, texture::WrappingMode};
use lapidary_core::{
    brdf::GgxParameters,
    material::Material,
    texture::{Channel, ColorSpace, TextureSlot, UvSet, Wrap},
};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    path::Path,
};

/// Adds all materials in the order of the file.
///
/// # Errors
/// [`Trouble::Memory`].
pub(super) fn add_materials(
    source: &mut Source,
    gltf: &gltf::Gltf,
    json: &[u8],
    buffers: &Buffers,
    other_pictures: &HashMap<usize, usize>,
    library: &mut TextureLibrary,
) -> Result<(), Trouble> {
    let normal_transforms = normal_transforms(json);
    let views = gltf.views().collect();
    let layers = layers_of(json);
    let glossiness = document_with(json, glossiness::EXTENSION).map(|document| Glossiness::of_all(&document));
    let glossiness = glossiness.unwrap_or_default();
    let ignored = Ignored::default();
    let mut reader = MaterialReader {
        gltf,
        views,
        buffers,
        other_pictures,
        library,
        normal_transforms,
        layers,
        glossiness,
        ignored,
    };
    source.materials = gltf.materials().map(|m| reader.material(&m)).collect::<Result<_, _>>()?;
    reader.ignored.warn(&mut source.warnings);
    Ok(())
}

/// The material of a primitive. The format's default is added when a primitive first needs it.
///
/// `chosen` is a variant's material, which may be missing.
pub(super) fn index_of(
    source: &mut Source,
    gltf: &gltf::Document,
    primitive: &gltf::Primitive,
    chosen: Option<usize>,
) -> u32 {
    let default = gltf.materials().count();
    let chosen = chosen.filter(|index| *index < default);
    let index = chosen.or(primitive.material().index()).unwrap_or(default);
    if index == source.materials.len() {
        source.push_default_material();
    }
    index as u32
}

/// Unsupported features of materials.
#[derive(Default)]
struct Ignored {
    further_uvs: Vec<String>,
    /// Remarks on extensions, and the materials they apply to.
    told: BTreeSet<(String, String)>,
}

impl Ignored {
    fn warn(&self, warnings: &mut Vec<String>) {
        if !self.further_uvs.is_empty() {
            warnings.push(format!(
                "the materials {} use a third set of texture coordinates or a further one, and show with the first; \
                 unwrap them to two sets",
                listed(&self.further_uvs)
            ));
        }
        let mut by_text: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        self.told.iter().for_each(|(text, name)| by_text.entry(text).or_default().push(name.clone()));
        warnings.extend(by_text.iter().map(|(text, names)| format!("the materials {} {text}", listed(names))));
    }
}

/// The transform of each material's normal texture, from the JSON itself, or a remark; empty if the file has none.
fn normal_transforms(json: &[u8]) -> Vec<Result<Transform, String>> {
    let document = document_with(json, Transform::EXTENSION).unwrap_or_default();
    let transform = |material: &Value| Transform::of(&material["normalTexture"]["extensions"]);
    document["materials"].as_array().map_or_else(Vec::new, |materials| materials.iter().map(transform).collect())
}

/// The extensions of each material; empty if the file has none.
fn layers_of(json: &[u8]) -> Vec<Layers> {
    let document = document_with(json, "KHR_materials_");
    document.map(|document| Layers::of_all(&document)).unwrap_or_default()
}

struct MaterialReader<'a> {
    gltf: &'a gltf::Gltf,
    /// Buffer views by index.
    views: Vec<View<'a>>,
    buffers: &'a Buffers,
    /// By texture, its own picture, where one in an extension comes before it.
    other_pictures: &'a HashMap<usize, usize>,
    library: &'a mut TextureLibrary,
    normal_transforms: Vec<Result<Transform, String>>,
    layers: Vec<Layers>,
    glossiness: Vec<Option<Glossiness>>,
    ignored: Ignored,
}

impl MaterialReader<'_> {
    fn material(&mut self, source: &gltf::Material) -> Result<Material, Trouble> {
        let index = source.index().unwrap_or_default();
        let name = source.name().map_or_else(|| format!("material {index}"), str::to_owned);
        let mut material = Material {
            name,
            parameters: parameters(source).into(),
            double_sided: source.double_sided(),
            ..Default::default()
        };
        material.set_emission(Vec3::from_array(source.emissive_factor()));
        if source.occlusion_texture().is_some() {
            self.tell("have an occlusion texture, which is left out: occlusion is computed here", &material);
        }
        self.add_maps(&mut material, source)?;
        self.add_opacity(&mut material, source);
        self.add_glossiness(&mut material, index)?;
        self.add_layers(&mut material, index)?;
        Ok(material)
    }

    fn tell(&mut self, remark: impl Into<String>, material: &Material) {
        self.ignored.told.insert((remark.into(), material.name.clone()));
    }

    fn add_maps(&mut self, material: &mut Material, source: &gltf::Material) -> Result<(), Trouble> {
        let pbr = source.pbr_metallic_roughness();
        let name = &material.name;
        let maps = &mut material.maps;
        if let Some(info) = pbr.base_color_texture() {
            maps.set("base_color", Some(TextureSlot { color_space: ColorSpace::Srgb, ..self.slot(&info, name)? }));
        }
        if let Some(info) = pbr.metallic_roughness_texture() {
            let slot = self.slot(&info, name)?;
            maps.set("roughness", Some(TextureSlot { channel: Channel::G, ..slot.clone() }));
            maps.set("metalness", Some(TextureSlot { channel: Channel::B, ..slot }));
        }
        if let Some(info) = source.specular().and_then(|s| s.specular_texture()) {
            maps.set("specular", Some(TextureSlot { channel: Channel::A, ..self.slot(&info, name)? }));
        }
        if let Some(info) = source.emissive_texture() {
            maps.set("emission_color", Some(TextureSlot { color_space: ColorSpace::Srgb, ..self.slot(&info, name)? }));
        }
        if let Some(normal) = source.normal_texture() {
            let transform = self.normal_transforms.get(source.index().unwrap_or_default()).cloned();
            let transform = self.readable(transform.unwrap_or_else(|| Ok(Transform::default())), name);
            let slot = self.slot_of(&normal.texture(), normal.tex_coord(), transform, name)?;
            maps.set("normal", Some(TextureSlot { strength: normal.scale(), ..slot }));
        }
        Ok(())
    }

    /// Adds opacity from the alpha of the base color, if the material uses it.
    fn add_opacity(&self, material: &mut Material, source: &gltf::Material) {
        let cutoff = match source.alpha_mode() {
            AlphaMode::Opaque => return,
            AlphaMode::Mask => source.alpha_cutoff().unwrap_or(0.5),
            AlphaMode::Blend => 0.0,
        };
        if source.alpha_mode() == AlphaMode::Mask && cutoff <= 0.0 {
            return; // nothing is cut out
        }
        let [.., alpha] = source.pbr_metallic_roughness().base_color_factor();
        material.parameters.set("geometry_opacity", alpha);
        if cutoff > 0.0 {
            material.parameters.set("opacity_cutoff", cutoff);
        }
        let alpha = |slot: &TextureSlot| TextureSlot { channel: Channel::A, ..slot.clone() };
        let has_alpha = |slot: &TextureSlot| {
            let texture = &self.library.textures[slot.texture as usize];
            texture.least(Channel::A as usize, slot.color_space) < 1.0
        };
        let map = material.maps.get("base_color").map(alpha).filter(has_alpha);
        material.maps.set("geometry_opacity", map);
    }

    fn add_layers(&mut self, material: &mut Material, index: usize) -> Result<(), Trouble> {
        let Some(layers) = self.layers.get(index).cloned() else { return Ok(()) };
        let name = material.name.clone();
        let mean = material.maps.get("roughness").map_or(1.0, |slot| {
            self.library.textures[slot.texture as usize].mean(slot.color_space)[slot.channel as usize]
        });
        let told = layers.add_to(material, mean, |info| self.slot_in_extension(info, &name))?;
        self.ignored.told.extend(told.into_iter().map(|text| (text, material.name.clone())));
        Ok(())
    }

    /// Sets the numbers of a material of specular color and glossiness. Of their map the mean counts: no map here has its channels.
    fn add_glossiness(&mut self, material: &mut Material, index: usize) -> Result<(), Trouble> {
        let Some(glossiness) = self.glossiness.get(index).cloned().flatten() else { return Ok(()) };
        let mean =
            |reader: &Self, slot: &TextureSlot| reader.library.textures[slot.texture as usize].mean(ColorSpace::Srgb);
        let diffuse = material.maps.get("base_color").map_or(Vec3::ONE, |slot| mean(self, slot).truncate());
        let mut specular = Vec4::ONE;
        if let Some(info) = glossiness.texture() {
            let slot = self.slot_in_extension(info, &material.name)?;
            specular = mean(self, &slot);
            let text = "have a map of specular color and glossiness, of which the mean was taken; bake it to maps of \
                        metalness and roughness";
            self.tell(text, material);
        }
        let Metallic { base_color, metalness, roughness } =
            glossiness.metallic(diffuse, specular.truncate(), specular.w);
        if metalness < 0.5 {
            material.parameters.set("base_color", (base_color / diffuse.max(Vec3::splat(1e-3))).min(Vec3::ONE));
        } else {
            // The color of a metal is its specular one.
            material.parameters.set("base_color", base_color);
            if material.maps.get("base_color").is_some() {
                let text = "are metals with a diffuse map, which metals do not show; it is left out";
                self.tell(text, material);
            }
            material.maps.set("base_color", None);
        }
        material.parameters.set("metalness", metalness);
        material.parameters.set("roughness", roughness);
        Ok(())
    }

    /// The slot of a texture that an extension names.
    fn slot_in_extension(&mut self, info: &TextureInfo, material: &str) -> Result<TextureSlot, Trouble> {
        let missing = || Trouble::from(format!("a material refers to texture {}, which is not there", info.index));
        let texture = self.gltf.textures().nth(info.index).ok_or_else(missing)?;
        let transform = self.readable(info.transform(), material);
        self.slot_of(&texture, info.tex_coord, transform, material)
    }

    /// A transform, or the identity with a remark.
    fn readable(&mut self, transform: Result<Transform, String>, material: &str) -> Transform {
        transform.unwrap_or_else(|remark| {
            self.ignored.told.insert((remark, material.to_owned()));
            Transform::default()
        })
    }

    fn slot(&mut self, info: &gltf::texture::Info, material: &str) -> Result<TextureSlot, Trouble> {
        let transform = info.texture_transform().map(Transform::from).unwrap_or_default();
        self.slot_of(&info.texture(), info.tex_coord(), transform, material)
    }

    fn slot_of(
        &mut self,
        texture: &gltf::Texture,
        set: u32,
        transform: Transform,
        material: &str,
    ) -> Result<TextureSlot, Trouble> {
        let set = transform.tex_coord.unwrap_or(set);
        let further = &mut self.ignored.further_uvs;
        if set > 1 && further.last().is_none_or(|last| last != material) {
            further.push(material.to_owned());
        }
        let sampler = texture.sampler();
        let wrap = |mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        };
        Ok(TextureSlot {
            texture: self.texture(texture)?,
            scale: transform.scale,
            offset: transform.offset,
            rotation: transform.rotation,
            wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
            uv_set: if set == 1 { UvSet::Second } else { UvSet::First },
            ..Default::default()
        })
    }

    /// Loads the picture of a texture, or else its picture for programs without the extension of the first.
    fn texture(&mut self, texture: &gltf::Texture) -> Result<u32, Trouble> {
        let unread = match self.picture(texture.source().index())? {
            Ok(index) => return Ok(index),
            Err(unread) => unread,
        };
        let images = self.gltf.as_json().images.len();
        let other = self.other_pictures.get(&texture.index()).copied().filter(|&image| image < images);
        if let Some(Ok(index)) = other.map(|image| self.picture(image)).transpose()? {
            self.library.replaced(unread, index);
            return Ok(index);
        }
        self.library.missing(unread)
    }

    /// Loads an image from a file, a `data:` URI or a buffer view.
    fn picture(&mut self, image: usize) -> Result<Result<u32, Unread>, Trouble> {
        let json = &self.gltf.as_json().images[image];
        let name = json.name.clone().unwrap_or_else(|| format!("image {image}"));
        let (views, buffers) = (&self.views, self.buffers);
        match &json.uri {
            Some(uri) if !uri.starts_with("data:") => self.library.try_load(&percent_decoded(uri)),
            Some(uri) => self.library.try_load_with(&format!("image {image}"), &name, |files| {
                let bytes = read_uri(uri, files)?;
                read_picture(&bytes, Path::new(&name), None, files)
            }),
            None => self.library.try_load_with(&format!("image {image}"), &name, |files| {
                let view = json.buffer_view.and_then(|v| views.get(v.value())).ok_or("it has no data")?;
                read_picture(buffers.view(view)?, Path::new(&name), None, files)
            }),
        }
    }
}

fn parameters(source: &gltf::Material) -> GgxParameters {
    let pbr = source.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    GgxParameters {
        base_color: Vec3::new(r, g, b),
        roughness: pbr.roughness_factor(),
        metalness: pbr.metallic_factor(),
        ior: source.ior().unwrap_or(1.5),
        specular: source.specular().map_or(1.0, |specular| specular.specular_factor()),
        ..Default::default()
    }
}
