//! The `info` command: what a dataset holds, or a scene that can be baked.

use crate::{
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::Result;
use clap::Args;
use lapidary_core::dataset::{BakeAudit, BakeSettings, Dataset, IndirectReport, MeshlessReport, sigma_text};
use lapidary_interchange::{
    formats::{FileFormat, SceneFormat},
    image,
    import::{Imported, import},
};
use std::path::PathBuf;

/// Options of `info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Dataset or scene.
    #[arg(help = format!("Dataset to describe, or a scene: {}", SceneFormat::names()))]
    pub file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl InfoArgs {
    /// What it reads.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads([&self.file])
    }

    /// Prints what a dataset or a scene holds.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn run(&self) -> Result<()> {
        if SceneFormat::of(&self.file).is_some() {
            let imported = import(&self.file)?;
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
    if s.mode.environment() {
        text += &format!("light tree {} samples, {:?}, beta {}\n", r.lights, s.tree, s.beta);
        let sigma = sigma_text(r.sigma, s.criterion.sigma);
        text += &format!("cuts       {:.1} nodes on average, {} at most, sigma {sigma}\n", r.mean_cut, r.max_cut);
        text += &format!("error      {:.4} RMS of visibility\n", r.rms_visibility);
        text += &r.audit.as_ref().map_or(String::new(), audit_text);
    } else {
        text += "cuts       not baked: the environment is dark\n";
    }
    text += &r.indirect.as_ref().map_or(String::new(), |indirect| indirect_text(indirect, s));
    text += &r.meshless.as_ref().map_or(String::new(), meshless_text);
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

fn audit_text(audit: &BakeAudit) -> String {
    let wrong = 100.0 * audit.leaves_wrong;
    match audit.leaves_per_probe {
        1 => "audit      too fine for boundaries: every light was traced\n".into(),
        lights => format!(
            "audit      {wrong:.3} % of visibility wrong, {:.4} RMS where {:.4} is possible, over {} vertices; a probe for \
             {lights} lights\n",
            audit.rms_error, audit.rms_exhaustive, audit.vertices
        ),
    }
}

fn indirect_text(r: &IndirectReport, s: &BakeSettings) -> String {
    let [x, y, z] = r.viewpoint;
    let without = if r.without_area > 0 { format!(" ({} of them on none)", r.without_area) } else { String::new() };
    let apart = if r.widest_spacing > r.radius {
        format!("{:.3} to {:.3}", r.radius, r.widest_spacing)
    } else {
        format!("{:.3}", r.radius)
    };
    let audit = match &r.audit {
        None => String::new(),
        Some(audit) if audit.leaves_per_probe == 1 => ", too fine for boundaries".into(),
        Some(audit) => format!(", {:.3} % of sources missed", 100.0 * audit.leaves_wrong),
    };
    format!(
        "sources    {} on {:.1} m²{without}, {apart} m apart, reached from {x:.2}, {y:.2}, {z:.2}\n\
         seen       {:.1} nodes on average, {} at most, sigma {}, {:.1} % error of solid angles, {:.1} MB{audit}\n",
        r.sources,
        r.area,
        r.mean_cut,
        r.max_cut,
        sigma_text(r.criterion(s.indirect.criterion).sigma, s.indirect.criterion.sigma),
        100.0 * r.relative_error,
        r.bytes_cuts as f64 / 1e6
    )
}

fn meshless_text(r: &MeshlessReport) -> String {
    format!(
        "meshless   {} functions on {} levels, {} of them send\n\
         links      {}, {:.3} % of the possible ones, {:.1} MB with points\n",
        r.functions.iter().sum::<usize>(),
        r.functions.len(),
        r.senders,
        r.links,
        100.0 * r.share,
        (r.bytes_links + r.bytes_points) as f64 / 1e6
    )
}
