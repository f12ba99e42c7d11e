//! Looks: the materials, the light, the camera and the view as they were, to go back to.

use super::{
    ComponentSettings, Document, EnvironmentSettings, ViewSettings,
    objects::ObjectNumbers,
    parts::{Assignment, Renumbering, renumber},
};
use lapidary_core::{camera::Camera, lights::Light, material::Material};
use lapidary_render::Solution;
use std::mem::swap;

/// A look with the name that tells it from the others.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLook {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub state: LookState,
}

/// What a look shows. What is `None` stays as it is in the document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LookState {
    /// The materials.
    pub materials: Option<MaterialsOfLook>,
    /// The light.
    pub light: Option<LightOfLook>,
    /// The camera.
    pub camera: Option<Camera>,
    /// How the picture is made and shown.
    pub view: Option<ViewSettings>,
}

/// The materials of a document, and the parts that have them. The fields are those of [`Document`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialsOfLook {
    /// The scene's own, then the added ones.
    pub materials: Vec<Material>,
    /// Number of added ones.
    pub added: usize,
    /// Parts with another material than the mesh's.
    pub assigned: Assignment,
    /// The material of the ground while none is shown.
    pub hidden_ground: Option<Material>,
}

/// The light of a document. The fields are those of [`Document`].
#[derive(Clone, Debug, PartialEq)]
pub struct LightOfLook {
    /// The environment.
    pub environment: EnvironmentSettings,
    /// Local lights.
    pub lights: Vec<Light>,
    /// Which parts of the light are in the picture.
    pub components: ComponentSettings,
    /// How bounced light is computed.
    pub solution: Solution,
}

/// What is put in place of a look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LookPart {
    /// All of it.
    All,
    /// Only its materials.
    Materials,
    /// Only its light.
    Light,
    /// Only its camera.
    Camera,
}

impl LookState {
    /// All that a document shows.
    pub fn of(document: &Document) -> Self {
        Self {
            materials: Some(MaterialsOfLook::of(document)),
            light: Some(LightOfLook::of(document)),
            camera: Some(document.camera.clone()),
            view: Some(document.view.clone()),
        }
    }

    /// A part of it.
    pub fn part(&self, part: LookPart) -> Self {
        let Self { materials, light, camera, .. } = self.clone();
        match part {
            LookPart::All => self.clone(),
            LookPart::Materials => Self { materials, ..Self::default() },
            LookPart::Light => Self { light, ..Self::default() },
            LookPart::Camera => Self { camera, ..Self::default() },
        }
    }

    /// Puts it into a document, and what the document has into it.
    pub fn swap(&mut self, document: &mut Document) {
        self.materials.iter_mut().for_each(|materials| materials.swap(document));
        self.light.iter_mut().for_each(|light| light.swap(document));
        self.camera.iter_mut().for_each(|camera| swap(camera, &mut document.camera));
        self.view.iter_mut().for_each(|view| swap(view, &mut document.view));
    }

    /// Whether a document shows anything else.
    pub fn differs(&self, document: &Document) -> bool {
        let Self { camera, view, .. } = self;
        !self.has_materials_and_light_of(document)
            || camera.as_ref().is_some_and(|camera| *camera != document.camera)
            || view.as_ref().is_some_and(|view| *view != document.view)
    }

    /// Whether a document has its materials and its light.
    pub fn has_materials_and_light_of(&self, document: &Document) -> bool {
        self.materials.as_ref().is_none_or(|materials| materials.is_that_of(document))
            && self.light.as_ref().is_none_or(|light| light.is_that_of(document))
    }

    /// Its materials, each with its index.
    pub fn materials_mut(&mut self) -> impl Iterator<Item = (usize, &mut Material)> {
        self.materials.iter_mut().flat_map(|of_look| of_look.materials.iter_mut().enumerate())
    }

    /// Renumbers its materials; the scene's own that it lacks are those of a document, `now`.
    pub fn renumber_materials(&mut self, renumbering: &Renumbering, now: &[Material]) {
        self.materials.iter_mut().for_each(|materials| materials.renumber(renumbering, now));
        self.view.iter_mut().for_each(|view| view.renumber_materials(renumbering));
    }

    /// Renumbers the objects whose parts have other materials.
    pub fn renumber_objects(&mut self, numbers: &ObjectNumbers) {
        self.materials.iter_mut().for_each(|materials| numbers.renumber(&mut materials.assigned));
    }
}

impl MaterialsOfLook {
    /// Those of a document.
    pub fn of(document: &Document) -> Self {
        let Document { materials, added, assigned, hidden_ground, .. } = document;
        let (materials, assigned) = (materials.clone(), assigned.clone());
        Self { materials, added: *added, assigned, hidden_ground: hidden_ground.clone() }
    }

    fn swap(&mut self, document: &mut Document) {
        swap(&mut self.materials, &mut document.materials);
        swap(&mut self.added, &mut document.added);
        swap(&mut self.assigned, &mut document.assigned);
        swap(&mut self.hidden_ground, &mut document.hidden_ground);
    }

    fn is_that_of(&self, document: &Document) -> bool {
        let Self { materials, added, assigned, hidden_ground } = self;
        *materials == document.materials
            && *added == document.added
            && *assigned == document.assigned
            && *hidden_ground == document.hidden_ground
    }

    fn renumber(&mut self, renumbering: &Renumbering, now: &[Material]) {
        let Renumbering { before, after } = *renumbering;
        let added = self.materials.split_off(before.count.min(self.materials.len()));
        let mut own: Vec<Material> = now.iter().take(after.count).cloned().collect();
        for (index, material) in self.materials.drain(..).enumerate() {
            match own.get_mut(renumbering.of(index)) {
                Some(place) => *place = material,
                None if before.ground == Some(index) => self.hidden_ground = Some(material),
                None => {}
            }
        }
        let shown = after.ground.and_then(|ground| own.get_mut(ground)).filter(|_| before.ground.is_none());
        if let Some((place, hidden)) = shown.zip(self.hidden_ground.take_if(|_| after.ground.is_some())) {
            *place = hidden;
        }
        self.materials = own;
        self.materials.extend(added);
        renumber(&mut self.assigned, renumbering);
    }
}

impl LightOfLook {
    /// That of a document.
    pub fn of(document: &Document) -> Self {
        let Document { environment, lights, components, solution, .. } = document;
        let (environment, lights) = (environment.clone(), lights.clone());
        Self { environment, lights, components: *components, solution: *solution }
    }

    fn is_that_of(&self, document: &Document) -> bool {
        let Self { environment, lights, components, solution } = self;
        *environment == document.environment
            && *lights == document.lights
            && *components == document.components
            && *solution == document.solution
    }

    fn swap(&mut self, document: &mut Document) {
        swap(&mut self.environment, &mut document.environment);
        swap(&mut self.lights, &mut document.lights);
        swap(&mut self.components, &mut document.components);
        swap(&mut self.solution, &mut document.solution);
    }
}

impl Document {
    /// The look of a name.
    pub fn look(&self, name: &str) -> Option<&NamedLook> {
        self.looks.iter().find(|look| look.name == name)
    }

    /// A name that no look has.
    pub fn free_look_name(&self) -> String {
        (1..).map(|number| format!("Look {number}")).find(|name| self.look(name).is_none()).unwrap_or_default()
    }

    /// Its materials and those of its looks, each with its index.
    pub fn materials_and_those_of_looks(&mut self) -> impl Iterator<Item = (usize, &mut Material)> {
        let of_looks = self.looks.iter_mut().flat_map(|look| look.state.materials_mut());
        self.materials.iter_mut().enumerate().chain(of_looks)
    }
}

#[cfg(test)]
mod tests;
