//! View options shared by all commands that make pictures, and their resolved form.

use super::{
    LensArgs, OutsideArgs, choices,
    light::{EnvironmentArgs, LocalLightArgs, LocalLights},
};
use crate::{outputs::CommandFiles, terminal::Console, values};
use anyhow::{Context as _, Result, bail};
use clap::{Args, ValueEnum};
use glam::Vec3;
use lapidary_core::{
    brdf::GgxParameters,
    camera::Camera,
    dataset::Dataset,
    ground::Ground,
    material::{BrdfModel, Material, PRESETS, Preset},
    memory,
    scene::{Scene, camera_named, pose::Poses},
};
use lapidary_interchange::{
    image,
    import::{ImportOptions, load_material, material_in_file, pictures_of_material},
};
use lapidary_render::{Background, Baked, Illumination, Look, View};
use std::{
    convert::Infallible,
    path::{Path, PathBuf},
    str::FromStr,
};

/// Dataset, light, material and view.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// Dataset written by `lapidary bake`
    #[arg(value_name = "FILE.cuts")]
    pub file: PathBuf,
    #[command(flatten)]
    light: EnvironmentArgs,
    #[command(flatten)]
    material: MaterialArgs,
    #[command(flatten)]
    camera: CameraArgs,
    // Not within the camera's: a group of options with another in it has no members for conflicts.
    #[command(flatten)]
    lens: LensArgs,
}

#[derive(Args, Clone, Debug)]
#[command(
    next_help_heading = "Material (any of these replaces all materials of the scene by one, --material NAME=FILE the named one)"
)]
struct MaterialArgs {
    /// Perceptual roughness of a GGX material, 0 to 1; alpha is its square [default if another is given: 0.5]
    #[arg(long, value_name = "R", value_parser = values::fraction)]
    roughness: Option<f32>,
    /// Base color of a GGX material, linear, each component 0 to 1 [default if another is given: 0.8,0.8,0.8]
    #[arg(long, value_name = "R,G,B", value_parser = values::color)]
    base_color: Option<Vec3>,
    /// Metalness of a GGX material, 0 to 1 [default if another is given: 0]
    #[arg(long, value_name = "M", value_parser = values::fraction)]
    metalness: Option<f32>,
    /// Material of any model, with textures, as a JSON file or a MaterialX document (FILE.mtlx, or FILE.mtlx#NAME for one of
    /// several); or preset:NAME, as listed by `lapidary models`. NAME= in front replaces the scene's material of that name only;
    /// may be given several times
    #[arg(long, value_name = "[NAME=]FILE", conflicts_with_all = ["roughness", "base_color", "metalness"])]
    material: Vec<MaterialChoice>,
    #[command(flatten)]
    outside: OutsideArgs,
}

/// A replacement material.
#[derive(Clone, Debug)]
struct MaterialChoice {
    /// Name of the replaced material; `None` replaces all.
    of: Option<String>,
    /// Its file or preset.
    file: PathBuf,
}

impl FromStr for MaterialChoice {
    type Err = Infallible;

    /// Text before `=` is a material name unless it is part of a path.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        let named = text.split_once('=').filter(|(name, _)| !name.contains(['/', '\\']) && !Path::new(text).exists());
        let (of, file) = named.map_or((None, text), |(name, file)| (Some(name.to_owned()), file));
        Ok(Self { of, file: file.into() })
    }
}

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "View")]
struct CameraArgs {
    /// Camera by name: one of the scene, or "Shot 1" and so on for the shots of the bake [default: the first shot,
    /// else the first camera of the scene, else a view of the whole scene]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Position of the eye in meters [default: the camera's]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::place, allow_hyphen_values = true)]
    eye: Option<Vec3>,
    /// Point to look at in meters [default: the camera's]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::place, allow_hyphen_values = true)]
    target: Option<Vec3>,
    /// Vertical field of view in degrees, 1 to 170 [default: the camera's; 40 with --eye and --target]
    #[arg(long, value_name = "DEG", value_parser = values::field_of_view)]
    fov: Option<f32>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = values::size)]
    size: [u32; 2],
    /// Samples per pixel, 1 to 256; 1 is the pixel's center [default: 16 for pictures of `render`, `sequence` and `reference --kind
    /// path`, 64 with --f-number, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    aa: Option<u32>,
    /// What pixels without a surface show; black leaves the environment out of measured errors
    #[arg(long, value_enum, default_value_t)]
    background: BackgroundOption,
    /// How the ground of the dataset is shown [default: as it was baked]
    #[arg(long, value_parser = choices::ground())]
    ground: Option<Ground>,
    /// Sharp reflections show the environment and bounced light as baked, instead of the scene
    #[arg(long)]
    no_mirrors: bool,
}

/// Background option.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum BackgroundOption {
    /// The environment
    #[default]
    Environment,
    /// The environment, blurred
    Blurred,
    /// Black
    Black,
    /// Nothing; png and exr files get an alpha channel
    Transparent,
}

/// Standard deviation in radians of a blurred background: about 8 degrees.
const BLUR: f32 = 0.14;

impl From<BackgroundOption> for Background {
    fn from(option: BackgroundOption) -> Self {
        match option {
            BackgroundOption::Environment => Self::Environment,
            BackgroundOption::Blurred => Self::Blurred(BLUR),
            BackgroundOption::Transparent => Self::Transparent,
            BackgroundOption::Black => Self::Flat(Vec3::ZERO),
        }
    }
}

/// A resolved scene and view.
#[derive(Debug)]
pub struct ViewedScene {
    /// The baked scene, with the requested materials.
    pub baked: Baked,
    /// Poses of its objects.
    pub poses: Poses,
    /// Camera and picture size.
    pub view: View,
    /// The rotated and scaled environment; black if there is none.
    pub light: Illumination,
    /// Local lights and requested components.
    pub local: LocalLights,
}

impl ViewedScene {
    /// The look of the picture, with an illumination cut of 256 nodes.
    ///
    /// # Errors
    /// Bounced light was requested, and the dataset has none of that kind.
    pub fn look(&self) -> Result<Look> {
        let (components, solution) = self.local.bounces_of(&self.baked.dataset)?;
        let lights = self.local.lights.clone().into();
        let look = Look::under_environment(&self.baked.dataset.scene, self.view.clone(), self.light.clone());
        Ok(Look { lights, components, solution, poses: self.poses.clone(), ..look })
    }
}

impl ViewArgs {
    /// Import options for scenes and materials.
    pub fn import_options(&self) -> ImportOptions {
        self.material.outside.into()
    }

    /// Files that are read, including those of `local`.
    pub fn files(&self, local: &LocalLightArgs) -> CommandFiles {
        let files = CommandFiles::default().reads([&self.file]).reads(self.light.input()).reads(local.input());
        let chosen = self.material.material.iter().map(|choice| &choice.file);
        let materials: Vec<&PathBuf> = chosen.filter(|path| preset_name(path).is_none()).collect();
        files
            .reads(materials.iter().map(|path| material_in_file(path).0))
            .reads(materials.iter().flat_map(|path| pictures_of_material(path)))
    }

    /// Reads the files and resolves all defaults, with the local lights of `local`; warnings go to `console`.
    ///
    /// # Errors
    /// A file that cannot be read, options that contradict the scene, or a picture too large for memory.
    pub fn resolve(&self, local: &LocalLightArgs, console: Console) -> Result<ViewedScene> {
        self.check_memory(1)?;
        let light = self.light.resolve(local, console)?;
        let lights = local.read()?;
        let mut dataset = Dataset::read(&self.file, image::decode)?;
        let light = self.light.of_bake(light, dataset.settings.mode, console);
        let local = local.resolve(lights, &dataset, &self.file)?;
        self.material.apply(&mut dataset.scene, console)?;
        let camera = self.lens.applied(self.camera.resolve(&dataset.scene, &dataset.shot_views())?);
        let view = View {
            aa: self.camera.aa.unwrap_or(camera.lens.least_samples()),
            background: self.camera.background.into(),
            ground: self.camera.ground_of(&dataset, &self.file)?,
            mirrors: !self.camera.no_mirrors,
            ..View::new(camera, self.camera.size)
        };
        Ok(ViewedScene { baked: dataset.into(), poses: Poses::default(), view, light, local })
    }

    /// Samples per pixel of a picture for people.
    pub fn smooth_samples(&self, camera: &Camera) -> u32 {
        self.camera.aa.unwrap_or(SMOOTH.max(camera.lens.least_samples()))
    }

    /// Checks that this many pictures of the requested size fit in memory at once. Layers of a file count as pictures.
    ///
    /// # Errors
    /// Needed and available memory, with a remedy.
    pub fn check_memory(&self, pictures: usize) -> Result<()> {
        check_memory(self.camera.size, pictures)
    }
}

/// Checks that this many pictures of a size fit in memory at once. Layers of a file count as pictures.
///
/// # Errors
/// Needed and available memory, with a remedy.
pub fn check_memory(size: [u32; 2], pictures: usize) -> Result<()> {
    check_room(size, pictures, memory::available())
}

/// Samples per pixel at which edges are smooth.
pub const SMOOTH: u32 = 16;

/// Bytes per pixel of the first picture: samples, sum, coverage, depth, an output copy and the encoded file.
const BYTES_OF_PICTURE: u64 = 64;
/// Bytes per pixel of each further picture: itself and an output copy.
const BYTES_OF_FURTHER: u64 = 16;

fn check_room([width, height]: [u32; 2], pictures: usize, available: Option<u64>) -> Result<()> {
    let bytes = BYTES_OF_PICTURE + BYTES_OF_FURTHER.saturating_mul((pictures as u64).saturating_sub(1));
    let needed = (u64::from(width) * u64::from(height)).saturating_mul(bytes);
    match available {
        Some(available) if needed > available => bail!(
            "{} of {width} x {height} need about {} MB of memory, {} MB are free; choose a smaller size",
            if pictures > 1 { format!("{pictures} pictures or layers") } else { "the buffers of a picture".to_owned() },
            needed >> 20,
            available >> 20
        ),
        _ => Ok(()),
    }
}

/// The name after `preset:`.
fn preset_name(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix("preset:")
}

/// A preset by name, ignoring case.
fn preset(name: &str) -> Result<Material> {
    let found = PRESETS.iter().find(|preset| preset.name.eq_ignore_ascii_case(name.trim()));
    let names = || PRESETS.iter().map(|preset| preset.name).collect::<Vec<_>>().join(", ");
    found.map(Preset::material).with_context(|| format!("there is no preset \"{name}\"; there are {}", names()))
}

impl MaterialArgs {
    /// Replaces materials as requested.
    fn apply(&self, scene: &mut Scene, console: Console) -> Result<()> {
        for MaterialChoice { of, file } in &self.material {
            let material = self.read(file, scene, console)?;
            match of {
                Some(name) => replace_named(&mut scene.materials, name, &material)?,
                None => replace_all(scene, &material),
            }
        }
        self.ggx().iter().for_each(|material| replace_all(scene, material));
        Ok(())
    }

    fn read(&self, file: &Path, scene: &mut Scene, console: Console) -> Result<Material> {
        if let Some(name) = preset_name(file) {
            return preset(name);
        }
        let (material, warnings) = load_material(file, scene, &self.outside.into())?;
        warnings.iter().for_each(|warning| console.warning(warning));
        Ok(material)
    }

    fn ggx(&self) -> Option<Material> {
        let given = self.roughness.is_some() || self.base_color.is_some() || self.metalness.is_some();
        let fallback = GgxParameters::default();
        let parameters = GgxParameters {
            roughness: self.roughness.unwrap_or(fallback.roughness),
            base_color: self.base_color.unwrap_or(fallback.base_color),
            metalness: self.metalness.unwrap_or(fallback.metalness),
            ..fallback
        };
        given.then(|| Material { model: BrdfModel::Ggx, parameters: parameters.into(), ..Default::default() })
    }
}

fn replace_all(scene: &mut Scene, material: &Material) {
    let ground = scene.mesh.ground_material();
    replace_materials(&mut scene.materials, ground, material);
}

/// Replaces the materials with this name.
fn replace_named(materials: &mut [Material], name: &str, material: &Material) -> Result<()> {
    if !materials.iter().any(|old| old.name == name) {
        let names: Vec<&str> = materials.iter().map(|old| old.name.as_str()).collect();
        bail!("the scene has no material \"{name}\"; it has {}", names.join(", "));
    }
    for old in materials.iter_mut().filter(|old| old.name == name) {
        *old = Material { name: name.into(), double_sided: old.double_sided, ..material.clone() };
    }
    Ok(())
}

/// Gives a whole scene one material, except for its ground. Surfaces baked as two-sided stay two-sided.
pub fn replace_materials(materials: &mut [Material], ground: Option<u32>, material: &Material) {
    for (_, old) in (0..).zip(materials).filter(|(index, _)| Some(*index) != ground) {
        *old = Material { double_sided: old.double_sided, ..material.clone() };
    }
}

/// Field of view in degrees when only positions are given.
const DEFAULT_FOV: f32 = 40.0;

impl CameraArgs {
    fn ground_of(&self, dataset: &Dataset, file: &Path) -> Result<Ground> {
        let has_ground = dataset.scene.mesh.ground.is_some();
        match self.ground {
            Some(ground) if ground != Ground::Off && !has_ground => {
                bail!("the dataset has no ground; bake the scene with --ground {ground} ({})", file.display())
            }
            ground => Ok(ground.unwrap_or(dataset.settings.ground)),
        }
    }

    fn resolve(&self, scene: &Scene, shots: &[Camera]) -> Result<Camera> {
        let base = self.named_camera(scene, shots)?;
        let fov = |default: f32| self.fov.unwrap_or(default);
        let camera = match (self.eye, self.target, base) {
            (Some(eye), Some(target), _) => Camera::look_at(eye, target, fov(DEFAULT_FOV)),
            (eye, target, Some(base)) => Camera {
                eye: eye.unwrap_or(base.eye),
                target: target.unwrap_or(base.target),
                fov_y: fov(base.fov_y.to_degrees()).to_radians(),
                ..base.clone()
            },
            (None, None, None) => {
                // Without a camera the whole scene is shown.
                let camera = scene.first_view();
                Camera { fov_y: fov(camera.fov_y.to_degrees()).to_radians(), ..camera }
            }
            (Some(_), None, None) => bail!("the scene has no camera to take the target from; give --target with --eye"),
            (None, Some(_), None) => bail!("the scene has no camera to take the eye from; give --eye with --target"),
        };
        if camera.eye == camera.target {
            bail!("--eye and --target are the same point; move one of them");
        }
        Ok(camera)
    }

    fn named_camera<'a>(&self, scene: &'a Scene, shots: &'a [Camera]) -> Result<Option<&'a Camera>> {
        // A shot may equal one of the scene's own cameras.
        let mut cameras = shots.iter().chain(scene.cameras.iter().filter(|camera| !shots.contains(camera)));
        match &self.camera {
            Some(name) => Ok(Some(camera_named(cameras, name)?)),
            None => Ok(cameras.next()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::brdf::Parameters;

    const NOTHING: CameraArgs = CameraArgs {
        camera: None,
        eye: None,
        target: None,
        fov: None,
        size: [4, 4],
        aa: None,
        background: BackgroundOption::Environment,
        ground: None,
        no_mirrors: false,
    };

    fn scene(cameras: Vec<Camera>) -> Scene {
        let mut scene = Scene { cameras, materials: vec![Material::default(); 2], ..Default::default() };
        scene.mesh.positions = vec![Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0)];
        scene
    }

    fn named(name: &str, x: f32) -> Camera {
        Camera { name: name.into(), ..Camera::look_at(Vec3::new(x, 0.0, 9.0), Vec3::ZERO, 30.0) }
    }

    #[test]
    fn cameras_default_to_the_first_and_are_overridden_in_part() {
        let scene = scene(vec![named("a", 1.0), named("b", 2.0)]);
        assert_eq!(NOTHING.resolve(&scene, &[]).unwrap(), named("a", 1.0));
        let b = CameraArgs { camera: Some("b".into()), ..NOTHING };
        assert_eq!(b.resolve(&scene, &[]).unwrap(), named("b", 2.0));
        let moved = CameraArgs { eye: Some(Vec3::Y), fov: Some(50.0), ..NOTHING }.resolve(&scene, &[]).unwrap();
        assert_eq!((moved.eye, moved.target), (Vec3::Y, Vec3::ZERO));
        assert!((moved.fov_y.to_degrees() - 50.0).abs() < 1e-4);
        let explicit = CameraArgs { eye: Some(Vec3::Y), target: Some(Vec3::X), ..NOTHING };
        assert_eq!(explicit.resolve(&scene, &[]).unwrap(), Camera::look_at(Vec3::Y, Vec3::X, DEFAULT_FOV));
    }

    #[test]
    fn shots_come_before_the_cameras_of_the_scene_and_have_names_too() {
        let scene = scene(vec![named("a", 1.0)]);
        let shots = [named("Shot 1", 3.0), named("Shot 2", 4.0), named("a", 1.0)];
        let resolved = |camera: Option<&str>| {
            CameraArgs { camera: camera.map(Into::into), ..NOTHING }.resolve(&scene, &shots).map(|camera| camera.name)
        };
        assert_eq!(resolved(None).unwrap(), "Shot 1");
        assert_eq!(resolved(Some("Shot 2")).unwrap(), "Shot 2");
        assert_eq!(resolved(Some("a")).unwrap(), "a");
        let missing = resolved(Some("Shot 3")).unwrap_err().to_string();
        assert!(missing.ends_with("it has Shot 1, Shot 2, a"), "each once: {missing}");
    }

    #[test]
    fn what_no_camera_supplies_is_asked_for() {
        let bare = scene(vec![]);
        assert_eq!(NOTHING.resolve(&bare, &[]).unwrap().target, Vec3::X);
        let message = |args: CameraArgs| args.resolve(&bare, &[]).unwrap_err().to_string();
        assert!(message(CameraArgs { eye: Some(Vec3::Y), ..NOTHING }).contains("--target"));
        assert!(message(CameraArgs { target: Some(Vec3::Y), ..NOTHING }).contains("--eye"));
        let same = CameraArgs { eye: Some(Vec3::Y), target: Some(Vec3::Y), ..NOTHING };
        assert!(message(same).contains("same point"));
        let unknown = CameraArgs { camera: Some("c".into()), ..NOTHING };
        assert!(unknown.resolve(&scene(vec![named("a", 1.0)]), &[]).unwrap_err().to_string().contains("it has a"));
    }

    #[test]
    fn pictures_that_do_not_fit_in_memory_are_refused_with_both_numbers() {
        let free = Some(100 << 20);
        assert!(check_room([1000, 1000], 1, free).is_ok());
        let message = |size, pictures| check_room(size, pictures, free).unwrap_err().to_string();
        let one = message([2000, 1000], 1);
        assert!(one.contains("2000 x 1000 need about 122 MB") && one.contains("100 MB are free"), "{one}");
        let layers = message([1000, 1000], 13);
        assert!(layers.starts_with("13 pictures or layers") && layers.contains("about 244 MB"), "{layers}");
        assert!(message([32_768, 8192], usize::MAX).contains("choose a smaller size"));
        assert!(check_room([32_768, 8192], usize::MAX, None).is_ok(), "the system does not report its memory");
    }

    #[test]
    fn one_option_of_a_material_replaces_all_and_none_replaces_none() {
        let none = MaterialArgs {
            roughness: None,
            base_color: None,
            metalness: None,
            material: Vec::new(),
            outside: OutsideArgs::default(),
        };
        let quiet = Console { quiet: true };
        let mut changed = scene(vec![]);
        changed.materials[1].double_sided = true;
        changed.materials[0].name = "own".into();
        none.apply(&mut changed, quiet).unwrap();
        assert_eq!(changed.materials[0].name, "own");
        MaterialArgs { roughness: Some(0.2), ..none }.apply(&mut changed, quiet).unwrap();
        let parameters = Parameters::from(GgxParameters { roughness: 0.2, ..Default::default() });
        assert!(changed.materials.iter().all(|m| m.parameters == parameters && m.name.is_empty()));
        assert!(!changed.materials[0].double_sided && changed.materials[1].double_sided);
    }

    #[test]
    fn a_named_material_is_replaced_and_a_name_that_is_not_there_is_an_error() {
        let choice = |text: &str| text.parse::<MaterialChoice>().unwrap();
        let named = choice("Shell=preset:Gold");
        assert_eq!((named.of.as_deref(), named.file.to_str()), (Some("Shell"), Some("preset:Gold")));
        assert!(choice("./a=b.json").of.is_none() && choice("gold.json").of.is_none());
        let mut two = scene(vec![]);
        two.materials[0].name = "Shell".into();
        let gold = preset("gold").unwrap();
        replace_named(&mut two.materials, "Shell", &gold).unwrap();
        assert_eq!((&two.materials[0].parameters, two.materials[0].name.as_str()), (&gold.parameters, "Shell"));
        assert_ne!(two.materials[1].parameters, gold.parameters, "negative control: another name");
        let error = replace_named(&mut two.materials, "Core", &gold).unwrap_err().to_string();
        assert!(error.contains("no material \"Core\"") && error.contains("Shell"), "{error}");
    }
}
