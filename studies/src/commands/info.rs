//! The `info` command: contents of a dataset, and of the files that it is made of.

mod inputs;

use crate::{
    bake_parts,
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::{Result, bail};
use clap::Args;
use inputs::{Input, origin_text};
use lapidary_core::dataset::Dataset;
use lapidary_interchange::{
    formats::{FileFormat, SceneFormat},
    image,
};
use std::path::PathBuf;

/// Options of `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Dataset, scene, material or picture.
    #[arg(help = format!("Dataset to describe; or a scene ({}), a material or a picture, with what of it is left out", SceneFormat::names()))]
    pub file: PathBuf,
    /// Scene of a glTF file with several, by name or by number from 0 [default: the file's default scene]
    #[arg(long, value_name = "NAME|NUMBER")]
    scene: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl InfoArgs {
    /// Files that it reads.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads([image::file_and_layer(&self.file).0])
    }

    /// Prints the contents of the file.
    ///
    /// # Errors
    /// An unreadable file, or a scene chosen in a file that has none.
    pub fn run(&self) -> Result<()> {
        if self.scene.is_some() && SceneFormat::of(&self.file).is_none() {
            bail!("--scene chooses a scene of a glTF file; leave it out here ({})", self.file.display());
        }
        if let Some(input) = Input::read(&self.file, self.scene.clone())? {
            return print_out(&if self.json { json_text(&input.json())? } else { input.text() });
        }
        let dataset = Dataset::read(&self.file, image::decode)?;
        if self.json { print_out(&json_text(&info_json(&dataset))?) } else { print_out(&info_text(&dataset)) }
    }
}

fn info_json(dataset: &Dataset) -> serde_json::Value {
    let scene = &dataset.scene;
    serde_json::json!({
        "settings": dataset.settings,
        "report": dataset.report,
        "scene_hash": dataset.scene_hash,
        "origin": scene.origin,
        "materials": scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
        "objects": scene.objects.iter().map(|o| &o.name).collect::<Vec<_>>(),
        "hidden": scene.hidden.keys().map(|&object| &scene.objects[object as usize].name).collect::<Vec<_>>(),
        "textures": scene.textures.iter().map(|t| &t.name).collect::<Vec<_>>(),
        "cameras": scene.cameras,
    })
}

fn info_text(dataset: &Dataset) -> String {
    let (r, s, scene) = (&dataset.report, &dataset.settings, &dataset.scene);
    let size = scene.mesh.bounds().max - scene.mesh.bounds().min;
    let mut text = format!(
        "mesh       {} vertices, {} triangles, {:.2} x {:.2} x {:.2} m\n",
        r.vertices, r.triangles, size.x, size.y, size.z
    );
    text += &origin_text(scene);
    text += &format!(
        "scene      {} objects, {} materials, {} textures, {} cameras\n",
        scene.objects.len(),
        scene.materials.len(),
        scene.textures.len(),
        scene.cameras.len()
    );
    let hidden: Vec<&str> = scene.hidden.keys().map(|&object| &*scene.objects[object as usize].name).collect();
    if !hidden.is_empty() {
        text += &format!("hidden     {}\n", hidden.join(", "));
    }
    if !s.shots.is_empty() {
        let plural = if s.shots.len() == 1 { "" } else { "s" };
        text += &format!("for        {} shot{plural}\n", s.shots.len());
    }
    text.extend(bake_parts::all().map(|part| part.info(r, s)));
    text += &format!(
        "size       {:.1} MB of cuts, {:.1} MB in all\n",
        r.bytes_cuts as f64 / 1e6,
        r.bytes_total as f64 / 1e6
    );
    if let Some(run) = &r.run {
        let seconds = r.seconds("total").unwrap_or(0.0);
        let speed = run.samples_per_second / 1e6;
        text += &format!("bake       {seconds:.1} s, {speed:.1} million samples a second\n");
    }
    for warning in &r.warnings {
        text += &format!("warning    {warning}\n");
    }
    text
}
