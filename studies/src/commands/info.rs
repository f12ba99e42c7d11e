//! The `info` command: contents of a dataset or of a scene.

use crate::{
    bake_parts,
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::Result;
use clap::Args;
use lapidary_core::dataset::Dataset;
use lapidary_interchange::{
    formats::{FileFormat, SceneFormat},
    image,
    import::{ImportOptions, Imported, import_with},
};
use std::path::PathBuf;

/// Options of `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Dataset or scene.
    #[arg(help = format!("Dataset to describe, or a scene: {}", SceneFormat::names()))]
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
        CommandFiles::default().reads([&self.file])
    }

    /// Prints the contents of a dataset or scene.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn run(&self) -> Result<()> {
        if SceneFormat::of(&self.file).is_some() {
            let options = ImportOptions { scene: self.scene.clone(), ..Default::default() };
            let imported = import_with(&self.file, &options)?;
            return if self.json {
                print_out(&json_text(&scene_json(&imported))?)
            } else {
                print_out(&scene_text(&imported))
            };
        }
        let dataset = Dataset::read(&self.file, image::decode)?;
        if self.json { print_out(&json_text(&info_json(&dataset))?) } else { print_out(&info_text(&dataset)) }
    }
}

fn names<T>(of: &[T], name: impl Fn(&T) -> &String) -> Vec<&String> {
    of.iter().map(name).collect()
}

fn scene_json(Imported { scene, report }: &Imported) -> serde_json::Value {
    serde_json::json!({
        "vertices": scene.mesh.positions.len(),
        "triangles": scene.mesh.triangles.len(),
        "materials": names(&scene.materials, |m| &m.name),
        "scenes": report.scenes,
        "variants": report.variants,
        "objects": names(&scene.objects, |o| &o.name),
        "cameras": scene.cameras,
        "lights": names(&scene.lights, |l| &l.name),
        "warnings": report.warnings,
    })
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
    let lists = [
        ("material  ", names(&scene.materials, |m| &m.name)),
        ("scenes    ", names(&report.scenes, |name| name)),
        ("variant   ", names(&report.variants, |name| name)),
        ("warning   ", names(&report.warnings, |warning| warning)),
    ];
    for (what, names) in lists {
        text.extend(names.iter().map(|name| format!("{what} {name}\n")));
    }
    text
}

fn info_json(dataset: &Dataset) -> serde_json::Value {
    let scene = &dataset.scene;
    serde_json::json!({
        "settings": dataset.settings,
        "report": dataset.report,
        "scene_hash": dataset.scene_hash,
        "materials": scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
        "objects": scene.objects.iter().map(|o| &o.name).collect::<Vec<_>>(),
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
    text += &format!(
        "scene      {} objects, {} materials, {} textures, {} cameras\n",
        scene.objects.len(),
        scene.materials.len(),
        scene.textures.len(),
        scene.cameras.len()
    );
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
