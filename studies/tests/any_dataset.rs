//! Every readable dataset is verified and rendered without a panic, with finite pictures. Every bake reports an error or writes
//! such a dataset.

use fastrand::Rng;
use glam::{Vec2, Vec3};
use lapidary_core::{
    bounds::MOST_COORDINATE,
    brdf::GgxParameters,
    camera::Camera,
    dataset::{BakeParts, BakeSettings, Dataset, IndirectSettings, MeshlessSettings},
    environment::MOST_RADIANCE,
    lights::{self, Emission, Light},
    material::{MOST_MATERIAL_NUMBER, MaterialMaps},
    scene::Scene,
    shot::Shot,
    test_files::FileParts,
    test_scenes::{cuboid, floor, room, scene_of},
    texture::{Texture, TextureSlot},
};
use lapidary_interchange::{environment, image};
use lapidary_precompute::{BakeJob, Preset, Silent, bake, resolve, verify};
use lapidary_render::{Components, CpuBackend, Illumination, LitScene, Look, Solution, View};
use proptest::prelude::*;
use std::{fs, path::Path, sync::OnceLock};

/// A box in a room with a light, a camera, and a material with maps.
fn small_scene() -> Scene {
    let mut triangles = room(Vec3::ZERO, Vec3::new(1.0, 0.7, 0.8));
    triangles.extend(cuboid(Vec3::new(0.3, -0.4, 0.2), Vec3::splat(0.2)));
    let mut scene = scene_of(&triangles);
    for (i, uv) in scene.mesh.uvs.iter_mut().enumerate() {
        *uv = Vec2::new((i % 3) as f32, (i / 3 % 3) as f32);
    }
    scene.textures = vec![Texture::missing("a").into()];
    let maps = ["base_color", "normal", "bump"].map(|kind| (kind, TextureSlot::default()));
    scene.materials[0].maps = MaterialMaps::from(maps);
    scene.cameras = vec![Camera::look_at(Vec3::new(-0.8, 0.3, 0.6), Vec3::new(0.3, -0.4, 0.2), 60.0)];
    let emission = Emission::Spot { cone_degrees: 50.0, penumbra_degrees: 20.0 };
    scene.lights = vec![Light { emission, position: Vec3::new(0.0, 0.6, 0.0), ..Default::default() }];
    scene
}

fn small_settings() -> BakeSettings {
    let indirect = IndirectSettings { sources: 16, ..Default::default() };
    let meshless =
        MeshlessSettings { levels: 2, sender_levels: 2, rays: 16, coarse_radius: Some(0.6), ..Default::default() };
    BakeSettings {
        lights: 64,
        mode: BakeParts::ALL,
        pilot_clusters: 4,
        max_vertices: Some(150),
        indirect,
        meshless,
        ..Preset::Draft.settings()
    }
}

/// The first flaw of a picture by a solution, if any.
fn flaw(dataset: &Dataset, lights: &[Light], light: Illumination, solution: Solution) -> Option<String> {
    let view = View { aa: 2, ..View::new(dataset.scene.first_view(), [8, 6]) };
    let look = Look {
        lights: lights.into(),
        components: Components::ALL,
        solution,
        illum_cut: 16,
        ..Look::under_environment(&dataset.scene, view, light)
    };
    let mut scene = LitScene::new(Box::new(CpuBackend::new()), dataset.clone().into()).expect("a CPU");
    let picture = scene.show_whole(&look).expect("a picture");
    let shown = scene.display(&look.post).expect("a picture");
    assert_eq!(shown.len(), 48);
    let wrong = picture.image.pixels.iter().position(|pixel| !(pixel.is_finite() && pixel.min_element() >= 0.0))?;
    Some(format!("pixel {wrong} is {} with {solution:?}", picture.image.pixels[wrong]))
}

/// Verifies and renders a dataset.
fn use_all_of(dataset: &Dataset, light: &Illumination) -> Result<(), TestCaseError> {
    verify(dataset, 4);
    let solutions = Solution::of(dataset.bounces());
    for solution in if solutions.is_empty() { vec![Solution::Cuts] } else { solutions } {
        let flaw = flaw(dataset, &dataset.scene.lights, light.clone(), solution);
        prop_assert!(flaw.is_none(), "{}", flaw.unwrap_or_default());
    }
    Ok(())
}

fn even_light(radiance: f32, intensity: f32) -> Illumination {
    let (environment, _) = environment::from_spec(&format!("constant:{radiance}")).expect("radiance in its range");
    Illumination { environment: environment.into(), rotation: 0.0, intensity, sun: None }
}

/// A good dataset with all parts, as a file.
fn good_file() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let job = BakeJob::new(resolve(small_settings()).expect("good settings"), folder.path().join("a.cuts"));
        bake(small_scene(), &job, &Silent).expect("a good scene");
        fs::read(&job.output).expect("a written file")
    })
}

/// Reads a file and, if readable, uses all of it. Returns whether it was readable.
fn read_and_use(path: &Path) -> Result<bool, TestCaseError> {
    match Dataset::read(path, image::decode) {
        Err(error) => {
            let message = error.to_string();
            prop_assert!(message.ends_with(&format!("({})", path.display())), "{message}");
            Ok(false)
        }
        Ok(dataset) => use_all_of(&dataset, &even_light(1.0, 1.0)).map(|()| true),
    }
}

#[test]
fn a_good_file_is_used_and_one_of_numbers_that_are_none_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    fs::write(&path, good_file()).unwrap();
    assert!(read_and_use(&path).unwrap());
    let mut parts = FileParts::of(good_file());
    let positions = parts.tensors.iter_mut().find(|tensor| tensor.name == "positions").unwrap();
    positions.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    parts.sum();
    fs::write(&path, parts.to_bytes()).unwrap();
    assert!(!read_and_use(&path).unwrap(), "negative control");
    fs::write(&path, good_file()).unwrap();
    let good = Dataset::read(&path, image::decode).unwrap();
    let flaw = flaw(&good, &[], even_light(1.0, f32::NAN), Solution::Cuts);
    assert!(flaw.is_some(), "negative control: light that is no number");
}

/// A number of any magnitude up to a limit.
fn up_to(most: f32, random: &mut Rng) -> f32 {
    let size = [1e-30, 1e-12, 1e-6, 1e-3, 0.5, 1.0, 2.0, 1e3, 1e6, 1e9, most][random.usize(..11)];
    size.min(most)
}

fn signed(most: f32, random: &mut Rng) -> f32 {
    if random.bool() { up_to(most, random) } else { -up_to(most, random) }
}

fn place(random: &mut Rng) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| signed(MOST_COORDINATE, random)))
}

/// A scene of extreme size and position.
fn extreme_mesh(random: &mut Rng) -> Scene {
    let scale = [1e-7, 1e-6, 1e-3, 1.0, 1e3, 1e6, 4e8][random.usize(..7)];
    let mut scene = if random.u8(..4) > 0 { small_scene() } else { scene_of(&floor(1.0, 0.0)) };
    let at = if random.bool() { Vec3::ZERO } else { place(random).clamp_length_max(5e8) };
    let squash = [Vec3::ONE, Vec3::new(1.0, 1e-6, 1.0), Vec3::new(1e-6, 1.0, 1e-3)][random.usize(..3)];
    for position in &mut scene.mesh.positions {
        *position = *position * scale * squash + at;
    }
    for camera in &mut scene.cameras {
        (camera.eye, camera.target) = (camera.eye * scale + at, camera.target * scale + at);
    }
    let stretch = up_to(4e8, random);
    scene.mesh.uvs.iter_mut().for_each(|uv| *uv *= stretch);
    scene
}

fn extreme_light(scene: &Scene, random: &mut Rng) -> Light {
    let bounds = scene.mesh.bounds();
    let near = |random: &mut Rng| bounds.min.lerp(bounds.max, random.f32());
    let length = |random: &mut Rng| up_to(MOST_COORDINATE, random);
    let emission = match random.u8(..4) {
        0 => Emission::Point,
        1 => Emission::PARALLEL,
        2 => Emission::Spot { cone_degrees: up_to(90.0, random), penumbra_degrees: 0.0 },
        _ => Emission::Rectangle { width: length(random), height: length(random) },
    };
    Light {
        emission,
        position: if random.bool() { near(random) } else { place(random) },
        target: if random.bool() { near(random) } else { place(random) },
        intensity: Vec3::from_array([0; 3].map(|_| up_to(lights::MOST_INTENSITY, random))),
        ..Default::default()
    }
}

fn extreme_scene(random: &mut Rng) -> Scene {
    let mut scene = extreme_mesh(random);
    scene.lights = (0..random.usize(..3)).map(|_| extreme_light(&scene, random)).collect();
    for slot in scene.materials[0].maps.slots_mut() {
        let number = |random: &mut Rng| signed(MOST_MATERIAL_NUMBER, random);
        slot.scale = Vec2::new(number(random), number(random));
        (slot.offset, slot.rotation) = (Vec2::splat(number(random)), number(random));
        slot.strength = number(random);
    }
    let bound = |random: &mut Rng| f32::from(random.u8(..2));
    scene.materials[0].parameters = GgxParameters {
        base_color: Vec3::splat(bound(random)),
        roughness: bound(random),
        metalness: bound(random),
        anisotropy: 2.0 * bound(random) - 1.0,
        ior: up_to(10.0, random),
        specular: bound(random),
        edge_color: Vec3::splat(bound(random)),
    }
    .into();
    scene
}

fn extreme_settings(scene: &Scene, random: &mut Rng) -> BakeSettings {
    let mut settings = small_settings();
    let diagonal = scene.mesh.bounds().diagonal();
    settings.mode = [BakeParts::ALL, BakeParts::CUTS, BakeParts::MESHLESS][random.usize(..3)];
    let radius = diagonal * [0.2, 0.3, 1.0, 2.0][random.usize(..4)];
    settings.meshless.coarse_radius = random.bool().then_some(radius).or(Some(0.25 * diagonal));
    settings.indirect.viewpoint = (random.u8(..4) == 0).then(|| place(random));
    settings.max_vertices = random.bool().then_some(150);
    if random.u8(..4) == 0 {
        settings.shots = scene.cameras.iter().map(|camera| Shot { camera: camera.clone(), aspect: 1.5 }).collect();
    }
    settings
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_read_of_a_disturbed_file_can_be_used(seed: u64) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.cuts");
        let mut parts = FileParts::of(good_file());
        parts.disturb(&mut Rng::with_seed(seed));
        parts.sum();
        fs::write(&path, parts.to_bytes()).expect("a writable folder");
        read_and_use(&path)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_bake_that_ends_well_can_be_used(seed: u64) {
        let random = &mut Rng::with_seed(seed);
        let folder = tempfile::tempdir().expect("a folder");
        let scene = extreme_scene(random);
        let settings = extreme_settings(&scene, random);
        let Ok(settings) = resolve(settings) else { return Ok(()) };
        let job = BakeJob::new(settings, folder.path().join("a.cuts"));
        match bake(scene, &job, &Silent) {
            Err(error) => prop_assert!(!error.to_string().contains("null"), "{error}"),
            Ok(_) => {
                let dataset = Dataset::read(&job.output, image::decode).map_err(|error| TestCaseError::fail(error.to_string()))?;
                use_all_of(&dataset, &even_light(MOST_RADIANCE, up_to(1e6, random)))?;
            }
        }
    }
}
