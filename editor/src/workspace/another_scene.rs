//! Exchanges the dataset or the version of the scene under a document: edited materials stay, and references to materials and
//! objects follow.

use super::Workspace;
use crate::{
    document::{
        Edit,
        fitting::{fit_materials, take_textures},
        looks::{LightOfLook, LookState, MaterialsOfLook},
        parts::{OwnMaterials, Renumbering},
    },
    jobs::{Imported, kept_bakes::kept_in, opening::bake_beside},
};
use lapidary_core::{animation::AnimationError, dataset::Dataset, lights::Light, scene::Scene};
use std::path::Path;

impl Workspace {
    /// Gives the document the materials that another dataset needs. Keeps the ground's material while no ground is shown.
    pub fn take_materials_of(&mut self, next: &Dataset) {
        let ground_of = |dataset: &Dataset| dataset.scene.mesh.ground_material().map(|index| index as usize);
        let own = self.document.own_materials();
        let shown = self.scene.rendered().and_then(|baked| ground_of(&baked.dataset)).filter(|&index| index < own);
        if let Some(index) = shown {
            self.document.hidden_ground = Some(self.document.materials.remove(index));
        }
        let numbers = fit_materials(&mut self.document, next);
        self.history.renumber_objects(&numbers);
        self.selection.renumber_objects(&numbers);
        let place = ground_of(next).and_then(|index| self.document.materials.get_mut(index));
        if let Some((place, kept)) = place.zip(self.document.hidden_ground.take_if(|_| ground_of(next).is_some())) {
            *place = kept;
        }
        let before = OwnMaterials { count: own, ground: shown };
        let after = OwnMaterials { count: self.document.own_materials(), ground: ground_of(next) };
        self.renumber_materials(Renumbering { before, after });
    }

    fn renumber_materials(&mut self, renumbering: Renumbering) {
        self.document.renumber_materials(&renumbering);
        self.history.renumber_materials(&renumbering, &self.document.materials);
        let selected = self.selection.material.map(|index| renumbering.of(index));
        self.selection.material = selected.filter(|&index| index < self.document.materials.len());
    }

    /// Takes a changed scene file. Its bake is out of date, unless only appearances or animations changed.
    pub fn scene_changed(&mut self, path: &Path, source: Imported) {
        if self.document.scene.as_deref() != Some(path) {
            return;
        }
        match self.scene.source.as_mut().filter(|known| known.hash == source.hash) {
            // Trials of its mesh stay known.
            Some(known) => {
                let before = std::mem::replace(&mut known.scene, source.scene.clone());
                (known.animation, known.report) = (source.animation, source.report);
                self.take_appearance(path, &before, &source.scene);
            }
            None => self.take_changed(path, source),
        }
        self.drop_lost_clip();
    }

    /// Takes the materials and lights that differ between two versions of the scene file, as one step of undo. Edits of the others
    /// stay.
    fn take_appearance(&mut self, path: &Path, before: &Scene, now: &Scene) {
        let places = take_textures(&mut self.document, &now.textures);
        let mut of_file = MaterialsOfLook::of(&self.document);
        let mut changed = 0;
        let versions = before.materials.iter().zip(&now.materials);
        for (own, (_, now)) in of_file.materials.iter_mut().zip(versions).filter(|(_, (before, now))| before != now) {
            *own = now.clone();
            let pictures = own.maps.slots_mut().filter(|slot| slot.image().is_some());
            pictures.for_each(|slot| slot.texture = places.get(slot.texture as usize).copied().unwrap_or(slot.texture));
            changed += 1;
        }
        let lights =
            (before.lights != now.lights).then(|| merged_lights(&self.document.lights, &before.lights, &now.lights));
        let light =
            lights.as_ref().map(|lights| LightOfLook { lights: lights.clone(), ..LightOfLook::of(&self.document) });
        let state = LookState { materials: Some(of_file), light, camera: None, view: None };
        let edit = Edit::Look(Box::new(state));
        if edit.changes(&self.document) {
            self.do_step(edit, "Changed scene file");
            let lights = if lights.is_some() { " and its lights" } else { "" };
            let text = format!(
                "The scene file has changed: {changed} of its materials{lights} were taken (Undo takes that back)"
            );
            self.messages.note(format!("{text} ({})", path.display()));
        }
    }

    fn take_changed(&mut self, path: &Path, source: Imported) {
        self.messages.warning(format!("The scene file has changed; bake it again to see it ({})", path.display()));
        let output = self.scene.bake_output.take().or_else(|| self.document.dataset.clone());
        self.scene.bake_output = output.or_else(|| Some(bake_beside(path, self.document.scene_in_file.as_deref())));
        if self.scene.baked.is_none() {
            take_textures(&mut self.document, &source.scene.textures);
        }
        // The picture stays on the screen, marked as out of date.
        self.scene.show_stale = self.scene.shown().is_some();
        let preview = (!self.scene.show_stale).then(|| source.unshadowed(&self.document.bake));
        preview.iter().for_each(|preview| self.take_materials_of(&preview.dataset));
        self.scene.preview = preview;
        self.scene.kept_output = Some(kept_in(&self.folders.bakes(), path, &source.hash));
        self.scene.source = Some(source);
    }

    /// Drops the time of a clip that the scene file lacks, with a warning.
    pub fn drop_lost_clip(&mut self) {
        let Some((source, time)) = self.scene.source.as_ref().zip(self.document.clip_time.as_ref()) else {
            return;
        };
        let no_clips = || AnimationError::NoClips { path: self.document.scene.clone().unwrap_or_default() };
        let found = source.animation.as_ref().ok_or_else(no_clips).and_then(|all| all.clip(Some(&time.clip)));
        if let Err(error) = found {
            self.messages.warning(format!("\"{}\" cannot be shown: {error}", time.clip));
            self.document.clip_time = None;
        }
    }
}

/// Lights of a document with those that differ between two versions of the scene file; others keep their edits, and lights that were
/// added stay.
fn merged_lights(own: &[Light], before: &[Light], now: &[Light]) -> Vec<Light> {
    let of_file = now.iter().enumerate().map(|(i, now)| match own.get(i) {
        Some(own) if before.get(i) == Some(now) => own.clone(),
        _ => now.clone(),
    });
    // Removed by the file, they are gone; added in the window, they follow.
    of_file.chain(own.iter().skip(before.len()).cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes;

    #[test]
    fn a_changed_light_is_taken_and_edits_and_additions_stay() {
        let light = |name: &str, red: f32| Light {
            name: name.into(),
            intensity: glam::Vec3::new(red, 1.0, 1.0),
            ..test_scenes::light()
        };
        let before = [light("key", 1.0), light("fill", 1.0)];
        let own = [light("key", 1.0), light("fill", 5.0), light("mine", 1.0)];
        let now = [light("key", 3.0), light("fill", 1.0)];
        assert_eq!(merged_lights(&own, &before, &now), [light("key", 3.0), light("fill", 5.0), light("mine", 1.0)]);
        assert_eq!(merged_lights(&own, &before, &now[..1]), [light("key", 3.0), light("mine", 1.0)], "one is gone");
        let more = [now[0].clone(), now[1].clone(), light("rim", 2.0)];
        assert_eq!(merged_lights(&own, &before, &more)[2..], [light("rim", 2.0), light("mine", 1.0)]);
    }
}
