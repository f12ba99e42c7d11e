//! `lapidary export`: the scene for another renderer, and its materials for other programs.

use crate::{
    args::{LocalLightArgs, ViewArgs, ViewedScene, choices},
    export::{
        materials::{self, MaterialExport},
        mitsuba::{self, Exported, MitsubaScene},
    },
    outputs::{CommandFiles, take_folder},
    terminal::Console,
    terminal::Outcome,
};
use anyhow::{Result, bail};
use clap::Args;
use glam::Vec3;
use lapidary_core::{lights::Light, scene::Scene};
use lapidary_interchange::materialx::Surface;
use lapidary_render::{Components, Illumination};
use std::path::{Path, PathBuf};

/// Options of `export`.
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// Folder for a Mitsuba 3 scene: scene.xml, materials.xml, meshes, textures and environment; existing files are replaced
    #[arg(long, value_name = "DIR", required_unless_present = "materials")]
    mitsuba: Option<PathBuf>,
    /// File for the materials alone: .mtlx (MaterialX), .mtl, .gltf or .glb. Pictures of a .mtlx or .mtl go into a folder beside
    /// it. A .gltf or .glb also has the meshes, unless --original is given
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// Surface of a MaterialX document
    #[arg(long, value_name = "SURFACE", default_value = "open-pbr", value_parser = choices::surface(), requires = "materials")]
    surface: Surface,
    /// glTF file that the scene was baked from: --materials is a copy of it with new materials
    #[arg(long, value_name = "FILE.gltf", requires = "materials")]
    original: Option<PathBuf>,
    /// Scene of the --original, by name or by number from 0 [default: the file's default scene]
    #[arg(long, value_name = "NAME|NUMBER", requires = "original")]
    scene: Option<String>,
    /// Most bounces of light between surfaces, 0 to 1000; 1 is direct light and one indirect bounce [default: 0; 1 if
    /// --components names indirect]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    bounces: Option<u32>,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewArgs,
}

impl ExportArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let mut files = self.view.files(&self.local);
        if let Some(folder) = &self.mitsuba {
            files = files.fills(folder, mitsuba::FILES);
        }
        self.materials().map_or(files.clone(), |materials| materials.files(files))
    }

    fn materials(&self) -> Option<MaterialExport> {
        let path = self.materials.clone()?;
        Some(MaterialExport { path, surface: self.surface, original: self.original.clone(), scene: self.scene.clone() })
    }
}

/// Writes the scene, its materials, or both.
///
/// # Errors
/// Unreadable or unwritable files, light components that Mitsuba cannot show alone, or no light.
pub fn run(args: &ExportArgs, console: Console) -> Result<Outcome> {
    let _taken = args.mitsuba.as_deref().map(take_folder).transpose()?;
    let viewed = with_settled_parts(args.view.resolve(&args.local, console)?);
    if let Some(folder) = &args.mitsuba {
        write_mitsuba(&viewed, args.bounces, folder, console)?;
    }
    if let Some(export) = args.materials() {
        let exported = export.write(&viewed.baked.dataset.scene)?;
        exported.remarks.iter().for_each(|remark| console.warning(remark));
        console.summary(materials::summary(&exported, &export.path))?;
    }
    Ok(Outcome::Done)
}

/// Bakes parts' own opacity into their materials: other formats have no such override.
fn with_settled_parts(viewed: ViewedScene) -> ViewedScene {
    if viewed.baked.dataset.scene.part_opacities.is_empty() {
        return viewed;
    }
    let mut dataset = (*viewed.baked.dataset).clone();
    dataset.scene.settle_parts();
    ViewedScene { baked: dataset.into(), ..viewed }
}

fn write_mitsuba(viewed: &ViewedScene, bounces: Option<u32>, folder: &Path, console: Console) -> Result<()> {
    let exported = scene(viewed, bounces)?.write(folder)?;
    let Exported { meshes, triangles, materials, remarks } = exported;
    remarks.iter().for_each(|remark| console.warning(remark));
    let scene = folder.join("scene.xml");
    console
        .summary(format_args!("{}: {triangles} triangles in {meshes} meshes, {materials} materials", scene.display()))
}

/// The requested light, as lights and a number of bounces.
fn scene(viewed: &ViewedScene, bounces: Option<u32>) -> Result<MitsubaScene<'_>> {
    let components = viewed.local.components.unwrap_or(Components::ALL);
    let default = u32::from(viewed.local.components.is_some_and(|c| c.indirect));
    let bounces = if components.indirect { bounces.unwrap_or(default) } else { 0 };
    let environment = Some(&viewed.light).filter(|light| gives_light(light));
    let lights: Vec<&Light> = viewed.local.lights.iter().filter(|light| light.shines()).collect();
    let dataset = &viewed.baked.dataset;
    let shines = any_surface_shines(&dataset.scene);
    let is_direct = shines || !lights.is_empty();
    let left_out = (environment.is_some() && !components.environment) || (is_direct && !components.direct);
    if bounces > 0 && left_out {
        bail!(
            "Mitsuba shows bounced light with the direct light that it comes from; leave --components out, or name \
             environment and direct beside indirect"
        );
    }
    let environment = environment.filter(|_| components.environment);
    let lights = if components.direct { lights } else { Vec::new() };
    let emission = components.direct && shines;
    if environment.is_none() && lights.is_empty() && !emission {
        bail!("there is no light to export; give one with --env or --lights, or let a material shine");
    }
    Ok(MitsubaScene { dataset, view: &viewed.view, environment, lights, emission, bounces })
}

fn any_surface_shines(scene: &Scene) -> bool {
    scene.mesh.triangle_material.iter().any(|&material| scene.materials[material as usize].shines())
}

fn gives_light(light: &Illumination) -> bool {
    light.intensity > 0.0 && light.environment.map.pixels.iter().any(|texel| *texel != Vec3::ZERO)
}
