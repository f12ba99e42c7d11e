//! Sweepable parameters, by name.

use super::{Value, error::SweepError};
use glam::Vec3;
use lapidary_core::{
    brdf::{self, BrdfModel},
    camera::LEAST_F_NUMBER,
    lights::Light,
    material::Material,
};
use lapidary_render::{BrdfSampling, Look};
use std::{collections::BTreeSet, sync::Arc};

/// A parameter of a look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// A parameter declared by BRDF models, by name.
    Brdf(&'static str),
    /// Strength of the bump map.
    Bump,
    /// Strength of the normal map.
    Normal,
    /// Rotation of the environment in degrees.
    Rotation,
    /// Scale of the environment's radiance.
    Intensity,
    /// Exposure in stops.
    Exposure,
    /// Most nodes of the illumination cut.
    IllumCut,
    /// Largest share of a vertex's light that a node of its lit cut moves.
    LitCuts,
    /// Scale of the intensity of local lights.
    LightIntensity,
    /// Position of a local light.
    LightPosition,
    /// Target point of a local light.
    LightTarget,
    /// Position of the camera.
    Eye,
    /// Target point of the camera.
    Target,
    /// Vertical field of view in degrees.
    Fov,
    /// Focal length over diameter of the aperture.
    FNumber,
    /// Distance in focus in meters.
    Focus,
}

/// Owner of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One material by name, or all.
    Material,
    /// One local light by name; without a name all, or the only one.
    Light,
    /// The whole picture.
    Picture,
}

/// Values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// A number in a range.
    Number(f32, f32),
    /// Three numbers from 0 to 1.
    Color,
    /// A position in meters.
    Place,
}

impl Parameter {
    /// All parameters in list order.
    pub fn all() -> impl Iterator<Item = Self> {
        let declared = BrdfModel::all_declared().map(|p| p.name);
        let mut known = BTreeSet::new();
        declared.filter(move |name| known.insert(*name)).map(Self::Brdf).chain(Self::OTHERS)
    }

    const OTHERS: [Self; 15] = [
        Self::Bump,
        Self::Normal,
        Self::Rotation,
        Self::Intensity,
        Self::Exposure,
        Self::IllumCut,
        Self::LitCuts,
        Self::LightIntensity,
        Self::LightPosition,
        Self::LightTarget,
        Self::Eye,
        Self::Target,
        Self::Fov,
        Self::FNumber,
        Self::Focus,
    ];

    /// Name in options and files.
    pub fn name(self) -> String {
        let name = match self {
            Self::Brdf(name) => return name.replace('_', "-"),
            Self::Bump => "bump",
            Self::Normal => "normal",
            Self::Rotation => "rotation",
            Self::Intensity => "intensity",
            Self::Exposure => "exposure",
            Self::IllumCut => "illum-cut",
            Self::LitCuts => "lit-cuts",
            Self::LightIntensity => "light-intensity",
            Self::LightPosition => "light-position",
            Self::LightTarget => "light-target",
            Self::Eye => "eye",
            Self::Target => "target",
            Self::Fov => "fov",
            Self::FNumber => "f-number",
            Self::Focus => "focus",
        };
        name.into()
    }

    /// Its owner.
    pub fn target(self) -> Target {
        match self {
            Self::Brdf(_) | Self::Bump | Self::Normal => Target::Material,
            Self::LightIntensity | Self::LightPosition | Self::LightTarget => Target::Light,
            _ => Target::Picture,
        }
    }

    /// Its values.
    pub fn domain(self) -> Domain {
        match self {
            Self::Brdf(name) => match BrdfModel::declared(name) {
                Some(p) if !p.is_color() => Domain::Number(p.range[0], p.range[1]),
                _ => Domain::Color,
            },
            Self::LitCuts => Domain::Number(0.0, 1.0),
            Self::Bump | Self::Normal => Domain::Number(-1e3, 1e3),
            Self::Rotation => Domain::Number(-36_000.0, 36_000.0),
            Self::Intensity | Self::LightIntensity => Domain::Number(0.0, 1e6),
            Self::Exposure => Domain::Number(-30.0, 30.0),
            Self::IllumCut => Domain::Number(1.0, 32_768.0),
            Self::Fov => Domain::Number(1.0, 170.0),
            Self::FNumber => Domain::Number(LEAST_F_NUMBER, 1000.0),
            Self::Focus => Domain::Number(1e-6, 1e9),
            Self::LightPosition | Self::LightTarget | Self::Eye | Self::Target => Domain::Place,
        }
    }

    /// Sets it in a look to a value of its domain; `of` names a material or light.
    ///
    /// # Errors
    /// No such material, map or light, several where one must be named, or cuts that the look does not merge.
    pub fn set(self, look: &mut Look, of: Option<&str>, value: Value) -> Result<(), SweepError> {
        let (number, vector) = (value.number(), value.vector());
        match self {
            Self::Brdf(name) => {
                let is_color = self.domain() == Domain::Color;
                let value = if is_color { vector.into() } else { brdf::Value::from(number) };
                each_brdf(look, of, name, value)
            }
            Self::Bump => each_map(look, of, "bump", number),
            Self::Normal => each_map(look, of, "normal", number),
            Self::LightIntensity => each_light(look, of, |light| light.intensity *= number),
            Self::LightPosition => one_light(self, look, of, |light| light.position = vector),
            Self::LightTarget => one_light(self, look, of, |light| light.target = vector),
            _ => {
                self.check_cuts(look.sampling)?;
                self.set_of_picture(look, number, vector);
                Ok(())
            }
        }
    }

    /// Whether a sweep of it changes pictures of a look: a material must read it, or the picture must merge the cuts that it sets.
    pub fn applies_to(self, look: &Look) -> bool {
        let is_read = |name| look.appearance.materials.iter().any(|m| read_by(m, name).is_some());
        self.check_cuts(look.sampling).is_ok() && !matches!(self, Self::Brdf(name) if !is_read(name))
    }

    /// Rejects settings of cuts that are not merged, whose sweep would give equal pictures.
    fn check_cuts(self, sampling: BrdfSampling) -> Result<(), SweepError> {
        match (self, sampling == BrdfSampling::Lit) {
            (Self::IllumCut, true) => Err(SweepError::NoIllumCut),
            (Self::LitCuts, false) => Err(SweepError::NoLitCuts),
            _ => Ok(()),
        }
    }

    fn set_of_picture(self, look: &mut Look, number: f32, vector: Vec3) {
        match self {
            Self::Rotation => look.illumination.rotation = number.to_radians(),
            Self::Intensity => look.illumination.intensity = number,
            Self::Exposure => look.post.exposure = number,
            Self::IllumCut => look.illum_cut = number as u32,
            Self::LitCuts => look.tau = number,
            Self::Eye => look.view.camera.eye = vector,
            Self::Target => look.view.camera.target = vector,
            Self::Fov => look.view.camera.fov_y = number.to_radians(),
            Self::FNumber => look.view.camera.lens.f_number = Some(number),
            Self::Focus => look.view.camera.lens.focus = Some(number),
            _ => {}
        }
    }
}

fn each_material(look: &mut Look, of: Option<&str>, mut change: impl FnMut(&mut Material)) -> Result<(), SweepError> {
    let mut found = false;
    for material in look.appearance.materials.iter_mut().filter(|m| of.is_none_or(|name| m.name == name)) {
        change(material);
        found = true;
    }
    let names = || names(look.appearance.materials.iter().map(|m| m.name.as_str()));
    if found { Ok(()) } else { Err(SweepError::NoMaterial { wanted: of.unwrap_or_default().into(), names: names() }) }
}

/// The parameter of a material's model with this name, or for the same quantity.
fn read_by(material: &Material, name: &str) -> Option<&'static brdf::Parameter> {
    let quantity = BrdfModel::declared(name).map_or(name, |parameter| parameter.quantity);
    material.parameter(name).or_else(|| material.parameter_for(quantity))
}

/// In materials whose model has the quantity under another name, that parameter is set.
fn each_brdf(look: &mut Look, of: Option<&str>, name: &'static str, value: brdf::Value) -> Result<(), SweepError> {
    let mut found = false;
    each_material(look, of, |material| {
        if let Some(parameter) = read_by(material, name) {
            material.parameters.set(parameter.name, parameter.sanitized(value));
            found = true;
        }
    })?;
    if found { Ok(()) } else { Err(SweepError::NotRead { parameter: name.replace('_', "-") }) }
}

fn each_map(look: &mut Look, of: Option<&str>, map: &'static str, strength: f32) -> Result<(), SweepError> {
    let mut found = false;
    each_material(look, of, |material| {
        if let Some(slot) = material.maps.get_mut(map) {
            slot.strength = strength;
            found = true;
        }
    })?;
    if found { Ok(()) } else { Err(SweepError::NoMap { map }) }
}

fn each_light(look: &mut Look, of: Option<&str>, change: impl Fn(&mut Light)) -> Result<(), SweepError> {
    let mut lights = look.lights.to_vec();
    let mut found = false;
    for light in lights.iter_mut().filter(|light| of.is_none_or(|name| light.name == name)) {
        change(light);
        found = true;
    }
    if !found {
        let names = names(lights.iter().map(|light| light.name.as_str()));
        return Err(SweepError::NoLight { wanted: of.unwrap_or_default().into(), names });
    }
    look.lights = Arc::from(lights);
    Ok(())
}

/// Selects a single light: moving all lights to one place is hardly intended.
fn one_light(
    parameter: Parameter,
    look: &mut Look,
    of: Option<&str>,
    change: impl Fn(&mut Light),
) -> Result<(), SweepError> {
    if of.is_none() && look.lights.len() > 1 {
        let names = names(look.lights.iter().map(|light| light.name.as_str()));
        return Err(SweepError::WhichLight { parameter: parameter.name(), names });
    }
    each_light(look, of, change)
}

/// Names for a message.
fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let named: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
    if named.is_empty() { "none with a name".into() } else { named.join(", ") }
}
