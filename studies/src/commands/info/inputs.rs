//! Scenes, materials and pictures, with the messages of their import: what is approximated and left out.

use anyhow::Result;
use glam::DVec3;
use lapidary_core::{
    input,
    material::Material,
    scene::Scene,
    texture::{Texels, Texture},
};
use lapidary_interchange::{
    formats::{FileFormat, PictureFormat, SceneFormat},
    image,
    import::{
        ImportOptions, Imported, import_with, is_materialx, load_material, material_in_file, materials_in_file,
        sanitized,
    },
};
use serde_json::{Value, json};
use std::path::Path;

/// A file that a dataset is made of.
pub(super) enum Input {
    Scene(Box<Imported>),
    /// A material, the names of all in its file, its textures and warnings.
    Material(Box<Material>, Vec<String>, Box<Scene>, Vec<String>),
    /// A picture, its layers and warnings.
    Picture(Box<Texture>, Layers, Vec<String>),
}

/// The layers of a picture; none if there is no choice.
#[derive(Default)]
pub(super) struct Layers {
    all: Vec<String>,
    /// The one that is read.
    read: String,
}

impl Layers {
    fn of(path: &Path) -> Self {
        let all = image::layers_in(path);
        let read = image::layer_of(path).or_else(|| all.first().cloned()).unwrap_or_default();
        Self { all, read }
    }
}

impl Input {
    /// Reads a file of one of these kinds; `None` for others.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn read(path: &Path, scene: Option<String>) -> Result<Option<Self>> {
        let options = ImportOptions { scene, ..Default::default() };
        if SceneFormat::of(path).is_some() {
            return Ok(Some(Self::Scene(Box::new(import_with(path, &options)?))));
        }
        let (file, _) = material_in_file(path);
        if is_materialx(file) || file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
            let mut scene = Scene::default();
            let (material, warnings) = load_material(path, &mut scene, &options)?;
            return Ok(Some(Self::Material(Box::new(material), materials_in_file(path), Box::new(scene), warnings)));
        }
        let (file, layer) = image::file_and_layer(path);
        if PictureFormat::of(file).is_none() {
            return Ok(None);
        }
        let failed = |source| lapidary_core::image::ImageError::Io { action: "read", path: file.into(), source };
        let mut warnings = Vec::new();
        let mut texture = image::decode_with(&input::read(file).map_err(failed)?, file, layer, &mut warnings)?;
        warnings.extend(sanitized(&mut texture));
        Ok(Some(Self::Picture(Box::new(texture), Layers::of(path), warnings)))
    }

    pub fn json(&self) -> Value {
        match self {
            Self::Scene(imported) => scene_json(imported),
            Self::Material(material, all, scene, warnings) => json!({
                "material": material.name,
                "model": material.model,
                "materials": all,
                "textures": scene.textures.iter().map(|texture| &texture.name).collect::<Vec<_>>(),
                "warnings": warnings,
            }),
            Self::Picture(texture, layers, warnings) => json!({
                "width": texture.size[0],
                "height": texture.size[1],
                "texels": depth(texture),
                "layers": layers.all,
                "layer": layers.read,
                "warnings": warnings,
            }),
        }
    }

    pub fn text(&self) -> String {
        match self {
            Self::Scene(imported) => scene_text(imported),
            Self::Material(material, all, scene, warnings) => {
                let (name, model, textures) = (&material.name, material.model.label(), scene.textures.len());
                format!("material   {name}, {model}, {textures} textures\n")
                    + &lines("of         ", all.iter().filter(|other| *other != name))
                    + &lines(WARNING, warnings)
            }
            Self::Picture(texture, layers, warnings) => {
                let [width, height] = texture.size;
                let read = Some(&layers.read).filter(|read| !read.is_empty());
                format!("picture    {width} x {height} texels, {}\n", depth(texture))
                    + &lines("layer      ", read)
                    + &lines("of         ", layers.all.iter().filter(|other| **other != layers.read))
                    + &lines(WARNING, warnings)
            }
        }
    }
}

/// What begins the line of a warning.
const WARNING: &str = "warning    ";

fn lines<'a>(what: &str, texts: impl IntoIterator<Item = &'a String>) -> String {
    texts.into_iter().map(|text| format!("{what}{text}\n")).collect()
}

fn depth(texture: &Texture) -> &'static str {
    match texture.texels {
        Texels::U8(_) => "8 bits",
        Texels::U16(_) => "16 bits",
        Texels::F32(_) | Texels::Wide { .. } => "32-bit floats",
    }
}

fn names<T>(of: &[T], name: impl Fn(&T) -> &String) -> Vec<&String> {
    of.iter().map(name).collect()
}

fn scene_json(Imported { scene, report }: &Imported) -> serde_json::Value {
    serde_json::json!({
        "vertices": scene.mesh.positions.len(),
        "triangles": scene.mesh.triangles.len(),
        "origin": scene.origin,
        "materials": names(&scene.materials, |m| &m.name),
        "scenes": report.scenes,
        "variants": report.variants,
        "objects": names(&scene.objects, |o| &o.name),
        "cameras": scene.cameras,
        "lights": names(&scene.lights, |l| &l.name),
        "warnings": report.warnings,
    })
}

/// Where the origin is in the source file, if the scene was moved.
pub fn origin_text(scene: &Scene) -> String {
    let DVec3 { x, y, z } = scene.origin;
    if scene.origin == DVec3::ZERO { String::new() } else { format!("origin     {x}, {y}, {z} in the file\n") }
}

fn scene_text(Imported { scene, report }: &Imported) -> String {
    let size = scene.mesh.bounds().max - scene.mesh.bounds().min;
    let mut text = format!(
        "mesh       {} vertices, {} triangles, {:.2} x {:.2} x {:.2} m\n",
        scene.mesh.positions.len(),
        scene.mesh.triangles.len(),
        size.x,
        size.y,
        size.z
    );
    text += &format!(
        "scene      {} objects, {} materials, {} textures, {} cameras, {} lights\n",
        scene.objects.len(),
        scene.materials.len(),
        scene.textures.len(),
        scene.cameras.len(),
        scene.lights.len()
    );
    text += &origin_text(scene);
    text += &lines("material   ", scene.materials.iter().map(|material| &material.name));
    text += &lines("scenes     ", &report.scenes);
    text += &lines("variant    ", &report.variants);
    text + &lines(WARNING, &report.warnings)
}
