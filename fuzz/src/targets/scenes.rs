//! Reads scenes, datasets, lights and materials, and renders them.

use super::{files::corpus, named};
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, Dataset, IndirectSettings, MeshlessSettings},
    environment::Environment,
    lights::LightsFile,
    scene::Scene,
};
use lapidary_interchange::{
    environment, image,
    import::{ImportError, ImportOptions, Imported, import_with, load_material},
};
use lapidary_precompute::{BakeJob, Preset, ResolvedBake, Silent, bake, resolve, verify};
use lapidary_render::{Baked, Components, CpuBackend, Illumination, LitScene, Look, Solution, View};
use std::{
    fs,
    path::Path,
    sync::{Arc, OnceLock},
};

/// The import may take half of an input's memory.
const OPTIONS: ImportOptions =
    ImportOptions { budget: Some(crate::MOST_BYTES as u64 / 2), allow_outside: false, variant: None, scene: None };

fn import(path: &Path) -> Result<Imported, ImportError> {
    import_with(path, &OPTIONS)
}

/// Imports a scene.
pub fn import_file(path: &Path) -> Result<(), String> {
    import(path).map(drop).or_else(|error| named(&error, path))
}

/// Imports a scene whose materials are in the input.
pub fn import_with_materials(path: &Path) -> Result<(), String> {
    let scene = path.with_file_name("materials.obj");
    import(&scene).map(drop).or_else(|error| named(&error, path).or_else(|_| named(&error, &scene)))
}

/// Imports a scene and bakes it. The result of a successful bake can be read, verified and rendered.
pub fn bake_file(path: &Path) -> Result<(), String> {
    let scene = match import(path) {
        Ok(imported) => imported.scene,
        Err(error) => return named(&error, path),
    };
    if scene.mesh.triangles.len() > 500 {
        return Ok(());
    }
    let output = path.with_extension("cuts");
    let all = [BakeParts::ENVIRONMENT, BakeParts::INDIRECT, BakeParts::MESHLESS, BakeParts::ALL];
    let mode = all[scene.mesh.positions.len() % all.len()];
    // A scene that cannot be baked is refused; the command names its file.
    if bake(scene, &BakeJob::new(tiny_bake(mode), output.clone()), &Silent).is_err() {
        return Ok(());
    }
    let dataset = Dataset::read(&output, image::decode)
        .map_err(|error| format!("the bake succeeded, but its output is invalid: {error}"))?;
    show(dataset)
}

/// Reads a dataset, verifies and renders it, and writes it again.
pub fn read_dataset(path: &Path) -> Result<(), String> {
    let dataset = match Dataset::read(path, image::decode) {
        Ok(dataset) => dataset,
        Err(error) => return named(&error, path),
    };
    let copy = path.with_extension("copy.cuts");
    dataset.write(&copy).map_err(|error| format!("it can be read, but not written: {error}"))?;
    Dataset::read(&copy, image::decode)
        .map_err(|error| format!("it can be read and written, but not read again: {error}"))?;
    verify(&dataset, 4);
    show(dataset)
}

/// Reads lights and lights a scene with them.
pub fn read_lights(path: &Path) -> Result<(), String> {
    match LightsFile::read(path) {
        Ok(file) => picture(&sound_scene(), |look| look.lights = file.lights.clone().into()),
        Err(error) => named(&error, path),
    }
}

/// Reads a material and assigns it to the whole scene.
pub fn read_material(path: &Path) -> Result<(), String> {
    let baked = sound_scene();
    let mut scene = baked.dataset.scene.clone();
    match load_material(path, &mut scene, &OPTIONS) {
        Ok((material, _)) => {
            scene.materials.fill(material);
            let appearance = lapidary_render::Appearance::of(&scene);
            picture(&baked, |look| look.appearance = appearance.clone())
        }
        Err(error) => named(&error, path),
    }
}

/// Renders a dataset by each of its solutions.
fn show(dataset: Dataset) -> Result<(), String> {
    let baked = Baked::from(dataset);
    picture(&baked, |_| ())?;
    Solution::of(baked.dataset.bounces())
        .into_iter()
        .try_for_each(|solution| picture(&baked, |look| look.solution = solution))
}

/// Renders 8 by 6 pixels, which must be finite, with all light after `change`.
fn picture(baked: &Baked, change: impl Fn(&mut Look)) -> Result<(), String> {
    let scene = &baked.dataset.scene;
    let view = View::new(scene.first_view(), [8, 6]);
    let light = Illumination { environment: studio(), rotation: 0.5, intensity: 1.0, sun: None };
    let mut look = Look { illum_cut: 64, ..Look::under_environment(scene, view, light) };
    let environment = baked.dataset.settings.mode.environment();
    look.components = Components { environment, ..Components::ALL };
    look.lights = scene.lights.clone().into();
    change(&mut look);
    let shown = LitScene::new(Box::new(CpuBackend::new()), baked.clone()).and_then(|mut lit| lit.show_whole(&look));
    // A scene may exceed a renderer's limits, which is an error.
    let Ok(picture) = shown else { return Ok(()) };
    match picture.image.pixels.iter().position(|pixel| !pixel.is_finite()) {
        Some(at) => Err(format!("pixel {at} of the picture by {} is {}", look.solution, picture.image.pixels[at])),
        None => Ok(()),
    }
}

fn studio() -> Arc<Environment> {
    static STUDIO: OnceLock<Arc<Environment>> = OnceLock::new();
    STUDIO.get_or_init(|| environment::from_spec("constant:1,0.9,0.8").expect("a formula").0.into()).clone()
}

/// The scene whose bakes are the valid datasets.
pub fn sound() -> Scene {
    import(&corpus("beside").join("room.obj")).expect("a sound scene").scene
}

/// Settings of the smallest bake with all details of its parts.
pub fn tiny_bake(mode: BakeParts) -> ResolvedBake {
    let draft = Preset::Draft.settings();
    let settings = BakeSettings {
        lights: 64,
        pilot_clusters: 4,
        max_vertices: Some(60),
        indirect: IndirectSettings { sources: 16, ..draft.indirect },
        meshless: MeshlessSettings {
            levels: 1,
            sender_levels: 1,
            coarse_radius: Some(0.8),
            rays: 16,
            ..draft.meshless
        },
        mode,
        ..draft
    };
    resolve(settings).expect("settings within their ranges")
}

/// Valid datasets of all parts.
pub fn datasets() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let modes = [BakeParts::ENVIRONMENT, BakeParts::INDIRECT, BakeParts::MESHLESS, BakeParts::CUTS, BakeParts::ALL];
    let bytes = |mode| {
        let output = folder.path().join("sound.cuts");
        bake(sound(), &BakeJob::new(tiny_bake(mode), output.clone()), &Silent).expect("a bake");
        fs::read(&output).expect("a dataset")
    };
    modes.map(bytes).into()
}

/// A valid dataset for lights and materials.
fn sound_scene() -> Baked {
    static BAKED: OnceLock<Baked> = OnceLock::new();
    let baked = || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let job = BakeJob::new(tiny_bake(BakeParts::CUTS), folder.path().join("sound.cuts"));
        bake(sound(), &job, &Silent).expect("a bake").into()
    };
    BAKED.get_or_init(baked).clone()
}
