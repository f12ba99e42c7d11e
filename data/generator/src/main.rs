//! Makes everything that Lapidary ships in `data/`: scenes, environments and textures.
//!
//! Units are meters, Y is up, coordinates are right-handed, colors linear Rec. 709. Every run writes the
//! same bytes.

mod backdrop;
mod beach;
mod bending_tower;
mod cloth;
mod color_box;
mod curve;
mod environment;
mod filigree;
mod furniture;
mod gem;
mod gltf_writer;
mod interior;
mod knot;
mod lidded_box;
mod material_study;
mod mesh;
mod motion;
mod noise;
mod pear;
mod pictures;
mod quads;
mod room;
mod rounded_box;
mod scene;
mod shader_ball;
mod still_life;
mod studio;
mod sun_and_sky;
mod textures;
mod tube;
mod turned;
mod vase;
mod window_room;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use glam::vec3;

use crate::pictures::{paint_color, paint_data, paint_height, paint_normals, save_png, save_png16};
use crate::scene::Scene;

/// Vertices along a side of the draped cloth.
const CLOTH_RESOLUTION: usize = 104;

#[derive(Parser)]
#[command(about = "Makes everything that Lapidary ships in data/")]
struct Options {
    /// Folder to write to; by default this repository's data folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write a beach of about this many vertices for scaling measurements instead of the bundle; requires --out.
    #[arg(long, value_name = "VERTICES", requires = "out", value_parser = clap::value_parser!(u32).range(100_000..=20_000_000))]
    beach: Option<u32>,
    /// Write the scenes of quads for wavelet transport instead of the bundle; requires --out.
    #[arg(long, requires = "out", conflicts_with = "beach")]
    quads: bool,
}

fn main() -> Result<()> {
    let options = Options::parse();
    let out = options.out.unwrap_or_else(data_folder);
    if let Some(vertices) = options.beach {
        return write_scene(&beach::beach(vertices as usize), &folder(&out, "beach")?);
    }
    if options.quads {
        return quads::scenes().iter().try_for_each(|scene| write_scene(scene, &folder(&out, scene.name)?));
    }
    write_bundle(&out, CLOTH_RESOLUTION)
}

fn write_bundle(out: &Path, cloth_resolution: usize) -> Result<()> {
    write_environments(&folder(out, "environments")?)?;
    write_textures(&folder(out, "textures")?)?;
    write_still_life(&folder(out, "still-life")?, cloth_resolution)?;
    write_interior(&folder(out, "interior")?)?;
    write_scene(&material_study::material_study(), &folder(out, "material-study")?)?;
    write_scene(&bending_tower::bending_tower(), &folder(out, "bending-tower")?)?;
    write_scene(&color_box::color_box(), &folder(out, "color-box")?)
}

/// The `data` folder of this crate.
fn data_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn folder(out: &Path, name: &str) -> Result<PathBuf> {
    let folder = out.join(name);
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(folder)
}

fn write_environments(folder: &Path) -> Result<()> {
    studio::studio().save(&folder.join("studio.hdr"))?;
    sun_and_sky::sun_and_sky().save(&folder.join("sun-and-sky.hdr"))?;
    window_room::window_room().save(&folder.join("window-room.hdr"))
}

fn write_textures(folder: &Path) -> Result<()> {
    let size = 512;
    save_png(&paint_color(size, textures::walnut), &folder.join("walnut.png"))?;
    save_png(&paint_color(size, textures::linen), &folder.join("linen.png"))?;
    save_png16(&paint_height(size, |uv| textures::hammered(uv, 12)), &folder.join("hammered-height.png"))?;
    save_png(&paint_normals(size, 0.012, textures::engraved), &folder.join("engraved-normal.png"))?;
    save_png(&roughness(size, textures::worn), &folder.join("worn-roughness.png"))
}

fn write_still_life(folder: &Path, cloth_resolution: usize) -> Result<()> {
    let scene = still_life::still_life(cloth_resolution);
    save_png(&paint_color(512, textures::painted_canvas), &folder.join("canvas.png"))?;
    save_png(&paint_color(512, textures::walnut), &folder.join("walnut.png"))?;
    save_png(&paint_color(512, textures::banded_cloth), &folder.join("cloth.png"))?;
    save_png(&roughness(256, textures::glaze), &folder.join("glaze-roughness.png"))?;
    save_png(&paint_normals(256, 0.016, |uv| textures::hammered(uv, 8)), &folder.join("hammered-normal.png"))?;
    write_scene(&scene, folder)
}

fn write_interior(folder: &Path) -> Result<()> {
    save_png(&paint_color(512, textures::boards), &folder.join("boards.png"))?;
    save_png(&paint_color(512, textures::rug), &folder.join("rug.png"))?;
    save_png(&paint_color(512, textures::painting), &folder.join("painting.png"))?;
    save_png(&paint_color(256, textures::upholstery), &folder.join("upholstery.png"))?;
    save_png(&paint_color(256, textures::walnut), &folder.join("walnut.png"))?;
    write_scene(&interior::interior(), folder)
}

fn write_scene(scene: &Scene, folder: &Path) -> Result<()> {
    println!("{}: {} vertices, {} triangles", scene.name, scene.vertex_count(), scene.triangle_count());
    gltf_writer::write(scene, folder)
}

/// Roughness in the green channel, as in glTF; blue 1 leaves metallic to its factor.
fn roughness(size: u32, pattern: impl Fn(glam::Vec2) -> f32) -> image::RgbImage {
    paint_data(size, |uv| vec3(1.0, pattern(uv), 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Bytes of everything below `folder`, by path; the generator's own sources do not count.
    fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut found = BTreeMap::new();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("generator") {
                found.extend(contents(&path));
            } else if path.is_file() {
                found.insert(path.clone(), fs::read(&path).unwrap());
            }
        }
        found
    }

    fn relative(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
        let absolute = contents(folder).into_iter();
        absolute.map(|(path, bytes)| (path.strip_prefix(folder).unwrap().to_owned(), bytes)).collect()
    }

    #[test]
    fn every_run_writes_the_same_bytes() {
        let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        write_bundle(first.path(), 24).unwrap();
        write_bundle(second.path(), 24).unwrap();
        let (first, second) = (relative(first.path()), relative(second.path()));
        assert!(first.len() > 15 && first.keys().eq(second.keys()));
        for (path, bytes) in &first {
            assert!(*bytes == second[path], "{} differs", path.display());
        }
    }

    #[test]
    fn every_texture_a_scene_names_is_there() {
        let out = tempfile::tempdir().unwrap();
        write_bundle(out.path(), 24).unwrap();
        for name in ["still-life", "interior"] {
            let folder = out.path().join(name);
            let text = fs::read(folder.join(name).with_extension("gltf")).unwrap();
            let root: serde_json::Value = serde_json::from_slice(&text).unwrap();
            let images = root["images"].as_array().unwrap();
            assert!(!images.is_empty());
            for image in images {
                let path = folder.join(image["uri"].as_str().unwrap());
                image::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
        }
    }

    #[test]
    fn the_bundle_stays_small() {
        let bytes: usize = contents(&data_folder()).values().map(Vec::len).sum();
        assert!(bytes > 1_000_000, "the bundle is missing: run the generator");
        assert!(bytes < 7_000_000, "{bytes} bytes");
    }
}
