//! Clamps values of a file that a renderer cannot use, each with a warning.

use super::{Session, SessionCamera, SessionLight, SessionLook, SessionMaterial, SessionMaterials};
use crate::document::{ASPECTS, EnvironmentSettings, SunChoice, ViewSettings, lights};
use glam::Vec3;
use lapidary_core::{
    camera::Lens,
    lights::{Emission, Light, MAX_LIGHTS},
    names::told_apart,
};
use lapidary_precompute::{Preset, resolve};
use std::fmt::Display;

/// Brings all values of `session` into range, each change with a warning.
pub fn sanitize(session: &mut Session, warnings: &mut Vec<String>) {
    let mut checks = Checks { warnings };
    checks.materials(&mut session.materials);
    checks.light(&mut session.light);
    checks.view(&mut session.view);
    session.camera.take_if(|camera| !checks.camera_is_usable(camera, "the default view is used"));
    session.bookmarks.retain_mut(|camera| checks.camera_is_usable(camera, "it was left out"));
    checks.looks(&mut session.looks);
    if let Err(error) = resolve(session.bake.clone()) {
        checks.warnings.push(format!("the bake settings are replaced by the normal ones, since {error}"));
        session.bake = Preset::Normal.settings();
    }
}

struct Checks<'a> {
    warnings: &'a mut Vec<String>,
}

impl Checks<'_> {
    /// Clamps; NaN becomes `fallback`.
    fn range<T: PartialOrd + Copy + Display>(&mut self, what: &str, value: &mut T, [low, high, fallback]: [T; 3]) {
        if *value >= low && *value <= high {
            return;
        }
        let given = *value;
        *value = if given < low {
            low
        } else if given > high {
            high
        } else {
            fallback
        };
        self.warnings.push(format!("{what} is {given}, outside {low} to {high}; {value} is used", value = *value));
    }

    /// Looks, whose names tell them apart.
    fn looks(&mut self, looks: &mut [SessionLook]) {
        let name = |look: &SessionLook| if look.name.is_empty() { "Look".into() } else { look.name.clone() };
        let names = told_apart(looks.iter().map(name).collect());
        for (look, name) in looks.iter_mut().zip(names) {
            if look.name != name {
                self.warnings.push(match look.name.as_str() {
                    "" => format!("a look has no name; it is now \"{name}\""),
                    taken => format!("a look called \"{taken}\" has another one's name; it is now \"{name}\""),
                });
                look.name = name;
            }
            let told = self.warnings.len();
            look.materials.iter_mut().for_each(|materials| self.materials(materials));
            look.light.iter_mut().for_each(|light| self.light(light));
            look.view.iter_mut().for_each(|view| self.view(view));
            look.camera.take_if(|camera| !self.camera_is_usable(camera, "the look leaves the camera where it is"));
            let of_look = &mut self.warnings[told..];
            of_look.iter_mut().for_each(|warning| *warning = format!("in the look \"{}\", {warning}", look.name));
        }
    }

    fn materials(&mut self, SessionMaterials { materials, added, .. }: &mut SessionMaterials) {
        materials.iter_mut().for_each(|material| self.material(material));
        *added = (*added).min(materials.len());
    }

    fn light(&mut self, SessionLight { environment, lights, .. }: &mut SessionLight) {
        self.environment(environment);
        self.lights(lights.as_mut());
    }

    fn material(&mut self, material: &mut SessionMaterial) {
        let sanitized = material.parameters.clone().sanitized();
        if sanitized != material.parameters {
            self.warnings
                .push(format!("parameters of the material \"{}\" were out of range; they are clamped", material.name));
            material.parameters = sanitized;
        }
        let name = material.name.clone();
        let what = |value: &str| format!("{value} of a map of the material \"{name}\"");
        for slot in material.maps.slots_mut() {
            for i in 0..2 {
                self.range(&what("the scale"), &mut slot.scale[i], [-1e6, 1e6, 1.0]);
                self.range(&what("the offset"), &mut slot.offset[i], [-1e6, 1e6, 0.0]);
            }
            self.range(&what("the rotation"), &mut slot.rotation_degrees, [-1e6, 1e6, 0.0]);
            self.range(&what("the strength"), &mut slot.strength, [-1e6, 1e6, 1.0]);
        }
        material.maps.retain(|map, slot| {
            let is_told = slot.texture.is_some() || slot.procedural.is_some();
            if !is_told {
                self.warnings
                    .push(format!("the map {map} of the material \"{name}\" names no texture; it is left out"));
            }
            is_told
        });
    }

    fn environment(&mut self, environment: &mut EnvironmentSettings) {
        self.range("the rotation of the environment", &mut environment.rotation_degrees, [-1e6, 1e6, 0.0]);
        self.range("the intensity of the environment", &mut environment.intensity, [0.0, 1e6, 1.0]);
        let (sun, usual) = (&mut environment.sun, SunChoice::default());
        self.range("the threshold of suns", &mut sun.threshold, [1.0, 1e6, usual.threshold]);
        self.range("the largest angle of suns", &mut sun.largest_degrees, [0.1, 90.0, usual.largest_degrees]);
        if environment.spec.is_empty() {
            environment.spec = EnvironmentSettings::default().spec;
            self.warnings.push(format!("the environment names no map; \"{}\" is used", environment.spec));
        }
    }

    fn lights(&mut self, given: Option<&mut Vec<Light>>) {
        let Some(given) = given else { return };
        if given.len() > MAX_LIGHTS {
            self.warnings.push(format!("there are {} lights; the first {MAX_LIGHTS} are used", given.len()));
            given.truncate(MAX_LIGHTS);
        }
        given.iter_mut().for_each(|light| self.light_numbers(light));
        given.retain(|light| {
            let problem = light.validate().err();
            if let Some(problem) = &problem {
                self.warnings.push(format!("the light \"{}\" was left out, since {problem}", light.name));
            }
            problem.is_none()
        });
    }

    fn light_numbers(&mut self, light: &mut Light) {
        let name = light.name.clone();
        let what = |value: &str| format!("{value} of the light \"{name}\"");
        for i in 0..3 {
            self.range(&what("the intensity"), &mut light.intensity[i], [0.0, lights::MOST_INTENSITY, 1.0]);
        }
        match &mut light.emission {
            Emission::Spot { cone_degrees, penumbra_degrees } => {
                let [narrowest, widest] = lights::CONE_DEGREES;
                self.range(&what("the cone"), cone_degrees, [narrowest, widest, 35.0]);
                self.range(&what("the penumbra"), penumbra_degrees, [0.0, *cone_degrees, 0.0]);
            }
            Emission::Rectangle { width, height } => {
                let [smallest, largest] = lights::SIDES;
                self.range(&what("the width"), width, [smallest, largest, 1.0]);
                self.range(&what("the height"), height, [smallest, largest, 1.0]);
            }
            Emission::Directional { angle_degrees } => {
                self.range(&what("the angle"), angle_degrees, [0.0, lights::ANGLE_DEGREES[1], 0.0]);
            }
            Emission::Point => {}
        }
    }

    fn view(&mut self, view: &mut ViewSettings) {
        let default = ViewSettings::default();
        self.range("the exposure", &mut view.post.exposure, [-32.0, 32.0, 0.0]);
        self.range("the vignette", &mut view.post.vignette, [0.0, 1.0, 0.0]);
        self.range("the blur of the background", &mut view.blur_degrees, [0.0, 90.0, default.blur_degrees]);
        for i in 0..3 {
            let fallback = default.background_color[i];
            self.range("the background color", &mut view.background_color[i], [0.0, 1e6, fallback]);
        }
        self.range("the illumination cut", &mut view.illum_cut, [1, 32_768, default.illum_cut]);
        self.range("the share that lit cuts move", &mut view.tau, [0.0, 1.0, default.tau]);
        self.range("the number of samples per pixel", &mut view.aa, [1, 256, default.aa]);
        let [narrowest, widest] = ASPECTS;
        let is_gate = |aspect: &f32| (narrowest..=widest).contains(aspect);
        if !view.aspect.as_ref().is_none_or(is_gate) {
            view.aspect = None;
            self.warnings.push("the shape of the picture is out of range; it is that of the window".into());
        }
        self.range("the frame budget", &mut view.frame_budget_ms, [1.0, 10_000.0, default.frame_budget_ms]);
    }

    fn camera_is_usable(&mut self, camera: &mut SessionCamera, otherwise: &str) -> bool {
        let name = camera.name.clone();
        let axis = camera.target - camera.eye;
        let usable = [camera.eye, camera.target, camera.up].iter().all(|v| v.is_finite())
            && axis.is_finite()
            && axis != Vec3::ZERO;
        if !usable {
            self.warnings.push(format!("the camera \"{name}\" has no view direction; {otherwise}"));
            return false;
        }
        if camera.up == Vec3::ZERO {
            camera.up = Vec3::Y;
        }
        let what = format!("the field of view of the camera \"{name}\"");
        self.range(&what, &mut camera.fov_y_degrees, [1.0, 170.0, 40.0]);
        if !camera.lens.is_valid() {
            camera.lens = Lens::default();
            self.warnings
                .push(format!("the lens of the camera \"{name}\" has a number out of range; a pinhole is used"));
        }
        true
    }
}
