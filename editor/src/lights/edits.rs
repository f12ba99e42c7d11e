//! Edits of local lights, as steps of undo.

use super::panel::LightsPanel;
use crate::{
    actions::LightAction,
    document::{
        Edit,
        lights::{LightKind, copied_name, new_light},
    },
    workspace::{Inspector, Workspace, Written},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    bounds::Bounds,
    camera::Camera,
    lights::{Light, LightsFile, MAX_LIGHTS},
};
use lapidary_render::Baked;
use std::path::Path;

/// Offset of a new light from its target, in units of the eye's distance: to the right, up, toward the eye.
const NEW_AT: Vec3 = Vec3::new(0.25, 0.45, 0.25);
/// Position of a new light, as a share of the distance to a wall that is nearer than its usual position.
const BEFORE_A_WALL: f32 = 0.8;
/// A point before the surface that a new light lights, as a share of the way to the eye.
const OFF_SURFACE: f32 = 0.02;
/// Offset of a copy from the original, as a share of the scene's diagonal.
const COPY_BESIDE: f32 = 0.03;
/// Extent framed around a light without a target, in diagonals of the scene.
const FRAMED_AROUND: f32 = 0.1;

impl LightsPanel {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, action: LightAction) {
        match action {
            LightAction::Select(light) => self.select_light(work, light),
            LightAction::Add(kind) => self.add_light(work, kind),
            LightAction::Duplicate(index) => self.duplicate_light(work, index),
            LightAction::Delete(index) => self.delete_light(work, index),
            LightAction::Aim(place) => self.aim_light(work, place),
            LightAction::Load(Some(path)) => self.load_lights(work, &path),
            LightAction::Save(Some(path)) => save_lights(work, &path),
            // The path is asked for first.
            LightAction::Load(None) | LightAction::Save(None) => {}
        }
    }

    /// Selects a light in place of objects.
    fn select_light(&mut self, work: &mut Workspace, light: Option<usize>) {
        work.selection.light = light;
        self.aiming = false;
        if light.is_some() {
            work.selection.set_object(None);
            work.tabs.inspector = Inspector::Lights;
        }
    }

    fn add_light(&mut self, work: &mut Workspace, kind: LightKind) {
        let mut lights = work.document.lights.clone();
        let camera = lit_view(work);
        let light = new_light(kind, &lights, &camera, place_for_light(work, &camera));
        lights.push(light);
        let last = lights.len() - 1;
        self.set_lights(work, lights, "Add light", Some(last));
    }

    fn duplicate_light(&mut self, work: &mut Workspace, index: usize) {
        let mut lights = work.document.lights.clone();
        let Some(light) = lights.get(index).cloned() else { return };
        let beside = COPY_BESIDE * work.scene_size() * work.document.camera.world_from_view().x_axis;
        let name = copied_name(&lights, &light.name);
        let copy = Light { name, position: light.position + beside, target: light.target + beside, ..light };
        lights.insert(index + 1, copy);
        self.set_lights(work, lights, "Duplicate light", Some(index + 1));
    }

    fn delete_light(&mut self, work: &mut Workspace, index: usize) {
        let mut lights = work.document.lights.clone();
        if index >= lights.len() {
            return;
        }
        lights.remove(index);
        self.set_lights(work, lights, "Delete light", None);
    }

    /// Aims the selected light.
    fn aim_light(&mut self, work: &mut Workspace, place: Option<Vec3>) {
        self.aiming = false;
        let (Some(target), Some(index)) = (place, work.selected_light()) else { return };
        let light = Light { target, ..work.document.lights[index].clone() };
        match light.validate() {
            Ok(()) => work.do_step(Edit::Light { index, light: Box::new(light) }, "Aim light"),
            Err(problem) => work.messages.warning(format!("Light unchanged, since {problem}")),
        }
    }

    fn load_lights(&mut self, work: &mut Workspace, path: &Path) {
        match LightsFile::read(path) {
            Ok(file) => {
                let count = file.lights.len();
                let added = file.lights.into_iter().map(named);
                let lights: Vec<Light> = work.document.lights.iter().cloned().chain(added).collect();
                let first = (count > 0).then_some(work.document.lights.len());
                if self.set_lights(work, lights, "Load lights", first) {
                    work.messages.note(format!("Lights added: {count} ({})", path.display()));
                }
            }
            Err(error) => work.messages.error(error.to_string()),
        }
    }

    /// Replaces the lights by a list, and selects one. Returns whether it did: there may be too many.
    fn set_lights(
        &mut self,
        work: &mut Workspace,
        lights: Vec<Light>,
        label: &'static str,
        selected: Option<usize>,
    ) -> bool {
        let count = lights.len();
        if count > MAX_LIGHTS {
            work.messages.error(format!("A scene can have {MAX_LIGHTS} lights, not {count}; remove some first"));
            return false;
        }
        work.do_step(Edit::Lights(lights), label);
        self.select_light(work, selected);
        true
    }
}

fn save_lights(work: &mut Workspace, path: &Path) {
    if !work.may_write(path, Written::Other) {
        return;
    }
    let lights = LightsFile { lights: work.document.lights.clone() };
    match lights.write(path) {
        Ok(()) => work.messages.note(format!("Lights written: {} ({})", lights.lights.len(), path.display())),
        Err(error) => work.messages.error(error.to_string()),
    }
}

/// The view in which a new light lights what the camera sees: it looks at the surface in the middle of the picture, or at the target
/// where there is none.
fn lit_view(work: &Workspace) -> Camera {
    let camera = work.document.camera.clone();
    let reach = camera.eye.distance(camera.target);
    let forward = camera.direction_through(Vec2::splat(0.5), [1, 1]);
    let intersector = work.scene.rendered().and_then(Baked::intersector_if_ready);
    let seen = intersector.and_then(|i| i.closest_hit(camera.eye, forward)).map(|hit| hit.distance);
    // A backdrop far behind the target is not what the picture is about.
    let distance = seen.filter(|distance| *distance < 3.0 * reach).unwrap_or(reach);
    Camera { target: camera.eye + forward * distance, ..camera }
}

/// Position of a new light for a view: beside it, on the eye's side of any wall, and below a ceiling over what it lights.
fn place_for_light(work: &Workspace, camera: &Camera) -> Vec3 {
    let distance = camera.eye.distance(camera.target).min(work.scene_size());
    let beside = distance * (camera.world_from_view() * NEW_AT);
    let intersector = work.scene.rendered().and_then(Baked::intersector_if_ready);
    let before_a_wall = |from: Vec3, to: Vec3| {
        let (direction, reach) = ((to - from).normalize_or(Vec3::Y), to.distance(from));
        let wall = intersector.and_then(|i| i.closest_hit(from, direction)).map(|hit| hit.distance);
        from + direction * wall.map_or(reach, |wall| reach.min(BEFORE_A_WALL * wall))
    };
    let place = before_a_wall(camera.eye, camera.target + beside);
    // Off the surface that it lights.
    let lit = camera.target.lerp(camera.eye, OFF_SURFACE);
    before_a_wall(lit, place)
}

/// Bounds of the selected light and its target.
pub fn light_bounds(work: &Workspace) -> Option<Bounds> {
    let light = &work.document.lights[work.selected_light()?];
    let around = Vec3::splat(FRAMED_AROUND * work.scene_size());
    let target = if light.emission.is_aimed() { light.target } else { light.position };
    Some(Bounds::around([light.position - around, light.position + around, target]))
}

/// Names a nameless light of a lights file, since the window identifies lights by name.
fn named(light: Light) -> Light {
    let name = if light.name.is_empty() { LightKind::of(&light).label().to_owned() } else { light.name };
    Light { name, ..light }
}
