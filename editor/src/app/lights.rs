//! Local lights: what is done with them, as steps of undo.

use super::state::EditorState;
use crate::{
    document::{
        Edit,
        lights::{LightKind, copied_name, new_light},
    },
    workspace::{Inspector, Written},
};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    lights::{Light, LightsFile, MAX_LIGHTS},
};
use lapidary_render::Baked;
use std::path::Path;

/// Offset of a new light from its target, in distances of the eye from that target: to the right, up, toward the eye.
const NEW_AT: Vec3 = Vec3::new(0.25, 0.45, 0.25);
/// Share of the distance to a wall at which a new light is placed, if the wall is nearer than its usual position.
const BEFORE_A_WALL: f32 = 0.8;
/// A copy stands beside the original by this share of the scene's diagonal.
const COPY_BESIDE: f32 = 0.03;
/// Extent that is framed around a light without a target, in diagonals of the scene.
const FRAMED_AROUND: f32 = 0.1;

impl EditorState {
    /// Selects a light in place of objects.
    pub(super) fn select_light(&mut self, light: Option<usize>) {
        self.work.selection.light = light;
        self.interface.lights.aiming = false;
        if light.is_some() {
            self.work.selection.set_object(None);
            self.work.tabs.inspector = Inspector::Lights;
        }
    }

    pub(super) fn add_light(&mut self, kind: LightKind) {
        let mut lights = self.work.document.lights.clone();
        let light = new_light(kind, &lights, &self.work.document.camera, self.place_for_light());
        lights.push(light);
        let last = lights.len() - 1;
        self.set_lights(lights, "Add light", Some(last));
    }

    pub(super) fn duplicate_light(&mut self, index: usize) {
        let mut lights = self.work.document.lights.clone();
        let Some(light) = lights.get(index).cloned() else { return };
        let beside = COPY_BESIDE * self.work.scene_size() * self.work.document.camera.world_from_view().x_axis;
        let name = copied_name(&lights, &light.name);
        let copy = Light { name, position: light.position + beside, target: light.target + beside, ..light };
        lights.insert(index + 1, copy);
        self.set_lights(lights, "Duplicate light", Some(index + 1));
    }

    pub(super) fn delete_light(&mut self, index: usize) {
        let mut lights = self.work.document.lights.clone();
        if index >= lights.len() {
            return;
        }
        lights.remove(index);
        self.set_lights(lights, "Delete light", None);
    }

    /// Aims the selected light.
    pub(super) fn aim_light(&mut self, place: Option<Vec3>) {
        self.interface.lights.aiming = false;
        let (Some(target), Some(index)) = (place, self.work.selected_light()) else { return };
        let light = Light { target, ..self.work.document.lights[index].clone() };
        match light.validate() {
            Ok(()) => self.work.do_step(Edit::Light { index, light: Box::new(light) }, "Aim light"),
            Err(problem) => self.work.messages.warning(format!("The light stays as it is, since {problem}")),
        }
    }

    pub(super) fn load_lights(&mut self, path: &Path) {
        match LightsFile::read(path) {
            Ok(file) => {
                let count = file.lights.len();
                let added = file.lights.into_iter().map(named);
                let lights: Vec<Light> = self.work.document.lights.iter().cloned().chain(added).collect();
                let first = (count > 0).then_some(self.work.document.lights.len());
                if self.set_lights(lights, "Load lights", first) {
                    self.work.messages.note(format!("Lights added: {count} ({})", path.display()));
                }
            }
            Err(error) => self.work.messages.error(error.to_string()),
        }
    }

    pub(super) fn save_lights(&mut self, path: &Path) {
        if !self.work.may_write(path, Written::Other) {
            return;
        }
        let lights = LightsFile { lights: self.work.document.lights.clone() };
        match lights.write(path) {
            Ok(()) => self.work.messages.note(format!("Lights written: {} ({})", lights.lights.len(), path.display())),
            Err(error) => self.work.messages.error(error.to_string()),
        }
    }

    /// Replaces the lights by a list, and selects one. Returns whether it did: there may be too many.
    fn set_lights(&mut self, lights: Vec<Light>, label: &'static str, selected: Option<usize>) -> bool {
        let count = lights.len();
        if count > MAX_LIGHTS {
            self.work
                .messages
                .error(format!("{count} lights are more than the {MAX_LIGHTS} of a scene; remove some first"));
            return false;
        }
        self.work.do_step(Edit::Lights(lights), label);
        self.select_light(selected);
        true
    }

    /// Where a new light stands: beside the view, but before any wall, as the eye is.
    fn place_for_light(&self) -> Vec3 {
        let camera = &self.work.document.camera;
        let distance = camera.eye.distance(camera.target).min(self.work.scene_size());
        let place = camera.target + distance * (camera.world_from_view() * NEW_AT);
        let (direction, reach) = ((place - camera.eye).normalize_or(Vec3::Y), place.distance(camera.eye));
        let intersector = self.work.scene.rendered().and_then(Baked::intersector_if_ready);
        let wall = intersector.and_then(|i| i.closest_hit(camera.eye, direction)).map(|hit| hit.distance);
        camera.eye + direction * wall.map_or(reach, |wall| reach.min(BEFORE_A_WALL * wall))
    }

    /// The selected light and what it is aimed at.
    pub(super) fn light_bounds(&self) -> Option<Bounds> {
        let light = &self.work.document.lights[self.work.selected_light()?];
        let around = Vec3::splat(FRAMED_AROUND * self.work.scene_size());
        let target = if light.emission.is_aimed() { light.target } else { light.position };
        Some(Bounds::around([light.position - around, light.position + around, target]))
    }
}

/// Lights files may leave names out; here they are how lights are told apart.
fn named(light: Light) -> Light {
    let name = if light.name.is_empty() { LightKind::of(&light).label().to_owned() } else { light.name };
    Light { name, ..light }
}
