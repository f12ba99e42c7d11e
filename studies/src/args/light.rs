//! Options for light: the environment, local lights, and the components shown.

use super::choices::{self, SunOption};
use crate::{terminal::Console, values};
use anyhow::{Result, bail};
use clap::Args;
use lapidary_core::{
    dataset::{BakePart, BakeParts, Dataset},
    environment::SunSettings,
    lights::{Light, LightsFile},
    texture::ColorSpace,
};
use lapidary_interchange::{environment, image::file_and_layer};
use lapidary_render::{Components, Illumination, Renderer, Solution, is_buried};
use std::path::{Path, PathBuf};

/// Name for no environment.
const NONE: &str = "none";
const DARK: &str = "constant:0,0,0";

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Light")]
pub(super) struct EnvironmentArgs {
    /// Environment map: a latitude-longitude .hdr or .exr file (FILE.exr#LAYER for one of its layers), or one of
    /// constant:R,G,B (each 0 to 1e12), sun-sky:ELEVATION (0 to 90 degrees), studio, orientation and none [default:
    /// studio; none with --lights or if the dataset was baked without the environment]
    #[arg(long, value_name = "MAP")]
    env: Option<String>,
    /// Color space of the environment file
    #[arg(long, value_name = "SPACE", default_value = "srgb", value_parser = choices::color_space())]
    env_space: ColorSpace,
    /// Rotation of the environment about the vertical in degrees, counter-clockwise seen from above
    #[arg(long, value_name = "DEG", default_value = "0", value_parser = values::finite, allow_hyphen_values = true)]
    rotate: f32,
    /// Factor on the environment's radiance, 0 to 1000000
    #[arg(long, value_name = "X", default_value = "1", value_parser = values::intensity)]
    intensity: f32,
    /// Whether small bright parts of the environment are suns, with sharp shadows; light paths see the map as it is
    #[arg(long, default_value = "on", value_parser = choices::sun())]
    sun: SunOption,
}

/// Local lights and the components of all light.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Local lights")]
pub struct LocalLightArgs {
    // The brackets are JSON, not links.
    #[allow(rustdoc::broken_intra_doc_links)]
    /// Local lights: a JSON file, or none. The file holds {"lights": [{"kind": "point|spot|directional|rectangle",
    /// "position": [x,y,z], "target": [x,y,z], "intensity": [r,g,b], ...}]}. Spots have cone_degrees (axis to edge)
    /// and penumbra_degrees; rectangles have width and height in meters. Intensity is in W/sr; for directional lights
    /// it is the irradiance in W/m², for rectangles the radiance in W/(m² sr) [default: the lights of the scene]
    #[arg(long, value_name = "FILE.json")]
    lights: Option<PathBuf>,
    /// Components of the light in the picture, separated by commas: environment (its direct light, and the
    /// background), direct (direct light of local lights) and indirect (bounced light) [default: all that the dataset
    /// has; references leave indirect out]
    #[arg(long, value_name = "LIST")]
    components: Option<Components>,
    /// How bounced light is computed from the dataset; light paths do not use it [default: cuts if baked, else
    /// meshless; `bounces` measures all]
    #[arg(long, value_parser = choices::solution())]
    solution: Option<Solution>,
}

/// Requested local lights.
#[derive(Clone, Debug, Default)]
pub struct LocalLights {
    /// The validated lights.
    pub lights: Vec<Light>,
    /// Requested components, if any.
    pub components: Option<Components>,
    /// Requested solution of bounced light, if any.
    pub solution: Option<Solution>,
}

impl EnvironmentArgs {
    /// The environment file, unless a built-in map is named.
    pub fn input(&self) -> Option<&Path> {
        self.env.as_deref().map(|spec| file_and_layer(Path::new(spec)).0).filter(|path| path.is_file())
    }

    /// The environment; `studio` by default, or none if `local` names lights.
    pub fn resolve(&self, local: &LocalLightArgs, console: Console) -> Result<Illumination> {
        let default = if local.has_file() { NONE } else { "studio" };
        let spec = match self.env.as_deref().unwrap_or(default) {
            NONE => DARK,
            spec => spec,
        };
        let (environment, warnings) = environment::from_spec_in(spec, self.env_space)?;
        warnings.iter().for_each(|w| console.warning(w));
        Ok(Illumination {
            environment: environment.into(),
            rotation: self.rotate.to_radians(),
            intensity: self.intensity,
            sun: (self.sun == SunOption::On).then(SunSettings::default),
        })
    }

    /// Drops an unnamed environment if none was baked: it would light nothing, but a reference would show its light.
    pub fn of_bake(&self, light: Illumination, mode: BakeParts, console: Console) -> Illumination {
        let dark = || environment::from_spec(DARK).map(|(environment, _)| environment.into());
        match self.env.as_deref() {
            _ if mode.environment() => light,
            None => Illumination { environment: dark().unwrap_or(light.environment), ..light },
            Some(NONE) => light,
            Some(_) => {
                console.warning(
                    "only light paths show light of the environment: the dataset was baked without it; bake with \
                     --mode cuts or all, or add --env none",
                );
                light
            }
        }
    }
}

impl LocalLightArgs {
    /// The lights file, if named.
    pub fn input(&self) -> Option<&Path> {
        self.lights.as_deref().filter(|path| *path != Path::new(NONE))
    }

    /// Reads the lights file early, so that errors appear before the dataset is read.
    pub(super) fn read(&self) -> Result<Option<Vec<Light>>> {
        match &self.lights {
            None => Ok(None),
            Some(path) if path == Path::new(NONE) => Ok(Some(Vec::new())),
            Some(path) => Ok(Some(LightsFile::read(path)?.lights)),
        }
    }

    /// The requested lights; the scene's own lights if `lights`, read earlier, is `None`.
    pub(super) fn resolve(&self, lights: Option<Vec<Light>>, dataset: &Dataset, path: &Path) -> Result<LocalLights> {
        let file = LightsFile { lights: lights.unwrap_or_else(|| dataset.scene.lights.clone()) };
        file.validate(path)?;
        Ok(LocalLights { lights: file.lights, components: self.components, solution: self.solution })
    }

    /// Whether components are named.
    pub fn names_components(&self) -> bool {
        self.components.is_some()
    }

    fn has_file(&self) -> bool {
        self.lights.as_ref().is_some_and(|path| path != Path::new(NONE))
    }
}

impl LocalLights {
    /// Components of a picture and its solution of bounced light: as requested, or all that the dataset has.
    ///
    /// # Errors
    /// Bounced light was requested, and the dataset has none of that kind.
    pub fn bounces_of(&self, dataset: &Dataset) -> Result<(Components, Solution)> {
        let bounces = dataset.bounces();
        let wanted = self.solution.or(Solution::closest_to(Solution::default(), bounces)).unwrap_or_default();
        let missing = wanted.needs().without(bounces);
        let has = missing == BakeParts::NONE;
        let components = self.components.unwrap_or(Components { indirect: has, ..Components::ALL });
        if !has && (components.indirect || self.solution.is_some()) {
            let nouns: Vec<&str> = missing.parts().map(BakePart::noun).collect();
            let mode = wanted.needs().with(dataset.settings.mode);
            bail!("the dataset has no {}; bake it with --mode {mode}", nouns.join(" and no "));
        }
        Ok((components, wanted))
    }
}

/// Most lights named in separate warnings.
const MOST_NAMED: usize = 5;

/// Warns of lights inside objects.
pub fn warn_of_buried(renderer: &Renderer, lights: &[Light], console: Console) {
    let is_inside = |light: &&Light| is_buried(renderer.dataset(), renderer.intersector(), light);
    let buried: Vec<&Light> = lights.iter().filter(is_inside).collect();
    for Light { name, position, .. } in buried.iter().take(MOST_NAMED) {
        console.warning(format_args!(
            "the light \"{name}\" at {position} is inside an object and lights nothing; move it"
        ));
    }
    if buried.len() > MOST_NAMED {
        let more = buried.len() - MOST_NAMED;
        console.warning(format_args!(
            "{more} more of {} lights are inside objects; move them or switch them off",
            lights.len()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Options {
        #[command(flatten)]
        environment: EnvironmentArgs,
        #[command(flatten)]
        local: LocalLightArgs,
    }

    fn options(text: &str) -> Result<Options, clap::Error> {
        Options::try_parse_from(std::iter::once("test").chain(text.split_whitespace()))
    }

    #[test]
    fn there_is_no_environment_beside_local_lights_unless_it_is_named() {
        let dark = |text: &str| {
            let Options { environment, local } = options(text).unwrap();
            let light = environment.resolve(&local, Console { quiet: true }).unwrap();
            light.environment.map.pixels.iter().all(|p| *p == glam::Vec3::ZERO)
        };
        assert!(dark("--lights a.json") && dark("--env none") && dark("--env none --lights a.json"));
        assert!(!dark("") && !dark("--lights a.json --env studio") && !dark("--lights none"));
        let dark = |text: &str, mode: BakeParts| {
            let Options { environment, local } = options(text).unwrap();
            let quiet = Console { quiet: true };
            let light = environment.of_bake(environment.resolve(&local, quiet).unwrap(), mode, quiet);
            light.environment.map.pixels.iter().all(|p| *p == glam::Vec3::ZERO)
        };
        assert!(dark("", BakeParts::INDIRECT) && dark("", BakeParts::MESHLESS) && !dark("", BakeParts::CUTS));
        assert!(!dark("--env studio", BakeParts::INDIRECT) && dark("--env none", BakeParts::ALL));
    }

    #[test]
    fn components_and_solutions_are_read_by_name() {
        let local = |text: &str| options(text).map(|o| o.local);
        let two = local("--components direct,indirect --solution cuts+meshless").unwrap();
        assert_eq!(two.components, Some(Components { environment: false, ..Components::ALL }));
        assert_eq!(two.solution, Some(Solution::CutsMeshless));
        let bad = local("--components sun").unwrap_err().to_string();
        assert!(bad.contains("environment, direct or indirect"), "{bad}");
        assert!(local("--solution magic").is_err());
    }
}
