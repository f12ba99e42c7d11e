//! Baking from the window: starting, progress, and taking the result into the document.

use super::{
    opening::{draft_of, kept_in},
    state::{
        EditorState,
        baking::{Asker, BakeOrder, Ended, From, Looked, Run, Seen},
    },
};
use crate::{
    control_names::control_name,
    document::{
        Document, TextureEntry,
        objects::ObjectNumbers,
        parts::{OwnMaterials, Renumbering},
    },
    jobs::{Imported, kept_bakes},
    panels::bake::{BakeStatus, stale_reasons},
    workspace::Written,
};
use lapidary_core::{
    animation::{BoundAnimation, ClipTime},
    dataset::{BakeParts, BakeSettings, Dataset, bake_hash},
    ground::Ground,
    scene::pose::Poses,
    texture::Texture,
};
use lapidary_precompute::{BakeJob, Leftover, Preset, leftover, resolve};
use lapidary_render::Baked;
use lapidary_studies::jobs::{
    bake::{BakeMessage, BakeTask, draft_is_sooner},
    spawn,
};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, mpsc::channel},
    time::SystemTime,
};

/// Why a bake does not start while there is one.
const UNDER_WAY: &str = "A bake is under way; cancel it first";

impl EditorState {
    /// Bakes with the document's settings, or goes on with what was interrupted. What the user began stays for the user to resume.
    pub(super) fn bake(&mut self, order: BakeOrder) {
        let output = match (order.asked_by, order.from) {
            (Asker::Nobody, _) => self.work.scene.kept_output.clone(),
            (Asker::User, From::Checkpoint) => self.interrupted().or_else(|| self.work.scene.bake_output.clone()),
            (Asker::User, From::Beginning) if self.write_kept() => return,
            (Asker::User, From::Beginning) => self.work.scene.bake_output.clone(),
        };
        if self.baking.run.is_some() {
            return self.work.messages.note(UNDER_WAY);
        }
        match self.task(order, output) {
            Ok(Some(task)) => self.baking.begin(task, order, self.work.wake.clone()),
            // What would be written over was told of.
            Ok(None) => {}
            Err(error) => self.work.messages.error(error),
        }
    }

    /// What the driver of bakes is given for an order; `None` if its output may not be written.
    fn task(&mut self, order: BakeOrder, output: Option<PathBuf>) -> Result<Option<BakeTask>, String> {
        let nothing = "There is no scene file to bake; open a scene (.gltf, .glb, .obj, .ply)";
        let (source, output) = self.work.scene.source.clone().zip(output).ok_or(nothing)?;
        let settings = resolve(self.work.document.bake.clone());
        let settings =
            settings.map_err(|error| format!("The bake settings do not work: {}", error.text(control_name)))?;
        if let Some(folder) = output.parent().filter(|f| !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|error| format!("cannot create the folder for the bake: {error} ({})", folder.display()))?;
        }
        if !self.work.may_write(&output, Written::Dataset) {
            return Ok(None);
        }
        // Of another version than the bake that is seen, it may have its objects in another order.
        let document = self.work.document.with_objects_of(&source.scene).into_owned();
        let (poses, clip_time) = poses_to_bake(&document, &source)?;
        let Imported { mut scene, import_secs, report, .. } = source;
        if document.lets_through_otherwise(&scene) {
            document.give_opacities(Arc::make_mut(&mut scene));
        }
        let (inputs, warnings, resume) = (report.files, report.warnings, order.from == From::Checkpoint);
        let job = BakeJob { settings, poses, clip_time, output, inputs, chunks: None, resume, import_secs, warnings };
        Ok(Some(BakeTask {
            scene,
            job,
            progressive: order.draft_first,
            or_afresh: order.asked_by == Asker::Nobody,
            turn: self.baking.turn.clone(),
            cache: self.work.folders.cache.clone(),
            name_of: control_name,
        }))
    }

    /// Writes the bake that is shown to where the user wants it, if it is what a bake would give. Returns whether it is.
    fn write_kept(&mut self) -> bool {
        let is_elsewhere =
            self.work.scene.kept_output != self.work.scene.bake_output && self.work.document.dataset.is_none();
        let whole = self
            .work
            .scene
            .shown()
            .filter(|_| is_elsewhere && !self.work.scene.is_draft && self.stale_reasons().is_empty());
        let Some((whole, output)) = whole.cloned().zip(self.work.scene.bake_output.clone()) else { return false };
        if self.work.may_write(&output, Written::Dataset) {
            let (sender, written) = channel();
            self.baking.written = Some(written);
            // How a ground is shown is the document's.
            let settings = BakeSettings { ground: self.work.document.bake.ground, ..whole.dataset.settings.clone() };
            let wake = self.work.wake.clone();
            spawn("write the bake", move || {
                // Nobody is left to tell if another scene was opened.
                let _ = sender.send(
                    whole.dataset.write_as(&output, &settings).map(|()| output).map_err(|error| error.to_string()),
                );
                wake();
            });
        }
        true
    }

    /// Tells of a bake that was written.
    fn collect_written(&mut self) {
        let Some(written) = self.baking.written.as_ref().and_then(|written| written.try_recv().ok()) else { return };
        self.baking.written = None;
        match written {
            Ok(output) => {
                self.work.messages.note(format!("The bake was written ({})", output.display()));
                self.work.document.dataset = Some(output);
            }
            Err(error) => self.work.messages.error(error),
        }
    }

    /// The output of an interrupted bake: the user's, or else one that began by itself.
    fn interrupted(&self) -> Option<PathBuf> {
        let outputs = [&self.work.scene.bake_output, &self.work.scene.kept_output];
        outputs.into_iter().flatten().find(|output| checkpoint_time(output).is_some()).cloned()
    }

    /// A long bake begins with a draft if it brings light that cannot be seen yet.
    pub(super) fn wants_draft(&self) -> bool {
        let wanted = &self.work.document.bake;
        let has = |part: fn(BakeParts) -> bool| {
            !part(wanted.mode) || self.work.scene.shown().is_some_and(|baked| part(baked.dataset.settings.mode))
        };
        let has_all = [BakeParts::environment, BakeParts::sources, BakeParts::meshless].into_iter().all(has);
        let bounces = wanted.mode.sources() || wanted.mode.meshless();
        !has_all && (bounces || wanted.lights > Preset::Draft.settings().lights) && draft_is_sooner(wanted)
    }

    pub(super) fn cancel_bake(&mut self) {
        if let Some(run) = &mut self.baking.run {
            run.job.cancel();
        }
    }

    pub(super) fn collect_bake(&mut self) {
        self.collect_written();
        let Some(run) = &mut self.baking.run else { return };
        let messages = run.job.messages();
        for message in messages {
            match message {
                BakeMessage::Warning(text) => self.work.messages.warning(text),
                BakeMessage::Draft(baked) => {
                    self.baking.run.iter_mut().for_each(|run| run.draft_shown = true);
                    self.keep_draft(&baked.dataset);
                    self.show_baked(baked, true);
                }
                BakeMessage::Done(baked) => {
                    self.work.messages.withdraw(UNDER_WAY);
                    if let Some(run) = self.baking.run.take() {
                        self.note_bake(&run, baked.dataset.report.vertices);
                    }
                    self.show_baked(baked, false);
                }
                BakeMessage::Cancelled => self.end_bake(Ended::Cancelled),
                BakeMessage::Failed(error) => {
                    self.work.messages.error(format!("The bake failed: {error}"));
                    self.end_bake(Ended::Failed(error));
                }
            }
        }
    }

    /// Tells of a bake that is done, and remembers its file if the user asked for it.
    fn note_bake(&mut self, run: &Run, vertices: usize) {
        self.work.messages.note(format!("Baked {vertices} vertices in {:.0} s", run.job.elapsed_secs()));
        if self.work.scene.bake_output.as_ref() == Some(&run.output) {
            self.work.document.dataset = Some(run.output.clone());
        }
        let (folder, latest) = (self.work.folders.bakes(), run.output.clone());
        if latest.starts_with(&folder) {
            spawn("kept bakes", move || {
                // A draft that stays is as old as the others some day.
                let _ = std::fs::remove_file(draft_of(&latest));
                kept_bakes::remove_oldest(&folder, &latest, kept_bakes::MOST_BYTES);
            });
        }
    }

    /// The draft is shown at the next start, if the bake is not finished by then.
    fn keep_draft(&self, dataset: &Arc<Dataset>) {
        let Some(scene) = &self.work.document.scene else { return };
        // It is of the scene as it was when its bake began.
        let path = draft_of(&kept_in(&self.work.folders.bakes(), scene, &dataset.scene_hash));
        let dataset = dataset.clone();
        spawn("keep draft", move || {
            // Without it the next start bakes a draft again.
            let _ = path.parent().map(std::fs::create_dir_all);
            let _ = dataset.write(&path);
        });
    }

    /// What an interrupted bake left for a bake with the present settings. It is read again only when its inputs have
    /// changed.
    pub(super) fn leftover(&mut self) -> Leftover {
        let Some((source, output)) = self.work.scene.source.as_ref().zip(self.interrupted()) else {
            return Leftover::Nothing;
        };
        let Some(written) = checkpoint_time(&output) else { return Leftover::Nothing };
        let Ok(settings) = resolve(self.work.document.bake.clone()) else { return Leftover::OfAnother };
        let document = self.work.document.with_objects_of(&source.scene);
        let opacities = document.opacities_for(&source.scene);
        let content = bake_hash(&source.hash, &opacities, &document.poses, document.clip_time.as_ref());
        let looked = Looked { output, scene_hash: content, settings, written };
        let known = self.baking.leftover.take().filter(|(known, _)| *known == looked);
        let look = || {
            let found = leftover(&looked.output, &looked.scene_hash, &looked.settings);
            (looked, found)
        };
        self.baking.leftover.insert(known.unwrap_or_else(look)).1
    }

    fn end_bake(&mut self, ended: Ended) {
        self.baking.run = None;
        self.work.messages.withdraw(UNDER_WAY);
        self.baking.ended = Some(ended);
    }

    /// Renders another bake of the scene. Materials that were edited stay.
    fn show_baked(&mut self, baked: Baked, is_draft: bool) {
        // The scene may have changed during its bake.
        let changed = self.work.scene.source.as_ref().filter(|source| source.hash != baked.dataset.scene_hash);
        let preview = changed.map(|source| source.unshadowed(self.work.document.bake.ground));
        self.take_materials_of(&preview.as_ref().unwrap_or(&baked).dataset);
        // The hierarchies are for the picture, and no guests.
        baked.begin();
        (self.work.scene.baked, self.work.scene.preview) = (Some(baked), preview);
        (self.work.scene.is_draft, self.work.scene.show_stale) = (is_draft, false);
    }

    /// Shows a ground that was asked for and is not in the bake: at once without shadows, and baked anew. One that is not wanted any
    /// more is hidden, whatever the bake has.
    pub(super) fn follow_ground(&mut self) {
        let ground = self.work.document.bake.ground;
        let Some(source) = self.work.scene.source.clone().filter(|_| !self.work.scene.show_stale) else { return };
        let suits = |baked: &Baked| ground == Ground::Off || baked.has_ground();
        let is_current = !self.work.scene.is_stale();
        if let Some(baked) = self.work.scene.baked.clone().filter(|baked| is_current && suits(baked)) {
            if self.work.scene.preview.is_some() {
                self.take_materials_of(&baked.dataset);
                self.work.scene.preview = None;
            }
            self.baking.wants_ground = false;
            return self.bake_ground();
        }
        if !self.work.scene.preview.as_ref().is_some_and(suits) {
            let preview = source.unshadowed(ground);
            self.take_materials_of(&preview.dataset);
            self.work.scene.preview = Some(preview);
            self.baking.wants_ground = is_current && self.work.preferences.bakes_scenes;
        }
        self.bake_ground();
    }

    /// Begins a bake for a ground if one is wanted. A bake without one that began by itself ends for it, and what is chosen by then
    /// is baked; one that the user asked for is finished first.
    fn bake_ground(&mut self) {
        let wants_ground = self.baking.wants_ground && self.work.document.bake.ground != Ground::Off;
        match &self.baking.run {
            Some(run) if run.has_ground => self.baking.wants_ground = false,
            Some(run) if wants_ground && run.asked_by == Asker::Nobody && !run.job.is_cancelling() => {
                self.cancel_bake();
                self.baking.begins_anew = true;
            }
            None if wants_ground || self.baking.begins_anew => {
                (self.baking.wants_ground, self.baking.begins_anew) = (false, false);
                self.bake(BakeOrder { asked_by: Asker::Nobody, from: From::Beginning, draft_first: true });
            }
            _ => {}
        }
    }

    /// What the user does not want is not begun anew either.
    pub(super) fn cancel_for_good(&mut self) {
        (self.baking.wants_ground, self.baking.begins_anew) = (false, false);
        self.cancel_bake();
    }

    /// Gives the document the materials that another dataset needs. That of a ground is kept while no ground is shown.
    fn take_materials_of(&mut self, next: &Dataset) {
        let ground_of = |dataset: &Dataset| dataset.scene.mesh.ground_material().map(|index| index as usize);
        let own = self.work.document.own_materials();
        let shown = self.work.scene.rendered().and_then(|baked| ground_of(&baked.dataset)).filter(|&index| index < own);
        if let Some(index) = shown {
            self.work.document.hidden_ground = Some(self.work.document.materials.remove(index));
        }
        let numbers = fit_materials(&mut self.work.document, next);
        self.work.history.renumber_objects(&numbers);
        self.work.selection.renumber_objects(&numbers);
        let place = ground_of(next).and_then(|index| self.work.document.materials.get_mut(index));
        if let Some((place, kept)) = place.zip(self.work.document.hidden_ground.take_if(|_| ground_of(next).is_some()))
        {
            *place = kept;
        }
        let before = OwnMaterials { count: own, ground: shown };
        let after = OwnMaterials { count: self.work.document.own_materials(), ground: ground_of(next) };
        self.renumber_materials(Renumbering { before, after });
    }

    fn renumber_materials(&mut self, renumbering: Renumbering) {
        self.work.document.renumber_materials(&renumbering);
        self.work.history.renumber_materials(&renumbering);
        let selected = self.work.selection.material.map(|index| renumbering.of(index));
        self.work.selection.material = selected.filter(|&index| index < self.work.document.materials.len());
    }

    /// What the picture is rendered by.
    pub(super) fn seen(&self) -> Seen {
        match self.work.scene.shown() {
            None => Seen::Unshadowed,
            Some(_) if self.work.scene.is_draft => Seen::Draft,
            Some(_) => Seen::Whole,
        }
    }

    /// Differences between the present bake and the result of a new one.
    pub(super) fn stale_reasons(&self) -> Vec<String> {
        let hash = self.work.scene.source.as_ref().map(|source| source.hash.as_str());
        let baked = self.work.scene.baked.as_ref();
        baked.map_or_else(Vec::new, |baked| stale_reasons(&self.work.document, &baked.dataset, hash))
    }

    /// The scene file has changed. Its bake is out of date, unless only appearances or animations were changed.
    pub(super) fn scene_changed(&mut self, path: &Path, source: Imported) {
        if self.work.document.scene.as_deref() != Some(path) {
            return;
        }
        match self.work.scene.source.as_mut().filter(|known| known.hash == source.hash) {
            // What was tried of its mesh stays known.
            Some(known) => (known.scene, known.animation) = (source.scene, source.animation),
            None => self.take_changed(path, source),
        }
        self.drop_lost_clip();
    }

    fn take_changed(&mut self, path: &Path, source: Imported) {
        self.work.messages.warning(format!("The scene file has changed; bake it again to see it ({})", path.display()));
        let output = self.work.scene.bake_output.take().or_else(|| self.work.document.dataset.clone());
        self.work.scene.bake_output = output.or_else(|| Some(path.with_extension("cuts")));
        if self.work.scene.baked.is_none() {
            take_textures(&mut self.work.document, &source.scene.textures);
        }
        // What is on the screen stays there, and is marked.
        self.work.scene.show_stale = self.work.scene.shown().is_some();
        let preview = (!self.work.scene.show_stale).then(|| source.unshadowed(self.work.document.bake.ground));
        preview.iter().for_each(|preview| self.take_materials_of(&preview.dataset));
        self.work.scene.preview = preview;
        self.work.scene.kept_output = Some(kept_in(&self.work.folders.bakes(), path, &source.hash));
        self.work.scene.source = Some(source);
    }

    /// How things stand, for the bake panel.
    pub(super) fn bake_status(&mut self) -> BakeStatus {
        if let Some(run) = &self.baking.run {
            return run.status();
        }
        let leftover = self.leftover();
        match (&self.baking.ended, &self.work.scene.baked) {
            (Some(Ended::Cancelled), _) => BakeStatus::Cancelled { leftover },
            (Some(Ended::Failed(message)), _) => BakeStatus::Failed { message: message.clone(), leftover },
            (None, Some(_)) => {
                let reasons = self.stale_reasons();
                if reasons.is_empty() { BakeStatus::UpToDate } else { BakeStatus::Stale { reasons } }
            }
            (None, None) if leftover != Leftover::Nothing => BakeStatus::Cancelled { leftover },
            (None, None) => BakeStatus::None,
        }
    }
}

/// Where a bake of a document has the objects, relative to the file, and the time of the animation that it is at.
fn poses_to_bake(document: &Document, source: &Imported) -> Result<(Poses, Option<ClipTime>), String> {
    let poses = document.poses.clone();
    let Some((animation, time)) = source.animation.as_ref().zip(document.clip_time.clone()) else {
        return Ok((poses, None));
    };
    let posed = BoundAnimation::new(animation.clone(), &source.scene).and_then(|bound| {
        let clip = animation.clip(Some(&time.clip))?;
        bound.poses_at(clip, time.seconds, &poses)
    });
    posed.map(|poses| (poses, Some(time))).map_err(|error| error.to_string())
}

/// Time of the last change of the folder that an interrupted bake leaves beside its output, if there is one.
fn checkpoint_time(output: &Path) -> Option<SystemTime> {
    let mut folder = output.as_os_str().to_owned();
    folder.push(".partial");
    std::fs::metadata(folder).ok().filter(|m| m.is_dir())?.modified().ok()
}

/// A scene that was changed in another program may have other materials. Materials that the document lacks are added,
/// so that there are as many as the mesh refers to. Returns the numbers of its objects.
pub(super) fn fit_materials(document: &mut Document, dataset: &Dataset) -> ObjectNumbers {
    let materials = &dataset.scene.materials;
    let added = document.materials.split_off(document.own_materials());
    document.materials.truncate(materials.len());
    let known = document.materials.len();
    let places = take_textures(document, &dataset.scene.textures);
    document.materials.extend_from_slice(&materials[known..]);
    for slot in document.materials[known..].iter_mut().flat_map(|material| material.maps.slots_mut()) {
        if let Some(&place) = places.get(slot.texture as usize) {
            slot.texture = place;
        }
    }
    document.materials.extend(added);
    document.take_objects(&dataset.scene)
}

/// Takes over the textures of a scene, by name, first at the same index. They replace their stand-ins; new ones are
/// appended. Returns the index of each.
fn take_textures(document: &mut Document, textures: &[Arc<Texture>]) -> Vec<u32> {
    let mut places = Vec::with_capacity(textures.len());
    for (i, texture) in textures.iter().enumerate() {
        let is_it = |entry: &TextureEntry| entry.file.is_none() && entry.texture.name == texture.name;
        let same = document.textures.get(i).is_some_and(is_it).then_some(i);
        let place = same.or_else(|| document.textures.iter().position(is_it)).unwrap_or(document.textures.len());
        let entry = TextureEntry { texture: texture.clone(), file: None };
        match document.textures.get_mut(place) {
            Some(old) => *old = entry,
            None => document.textures.push(entry),
        }
        places.push(place as u32);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::material::Material;

    #[test]
    fn another_bake_keeps_edited_materials_and_adds_new_ones() {
        let named = |name: &str| Material { name: name.into(), ..Default::default() };
        let mut dataset = crate::test_support::baked_triangle();
        dataset.scene.materials = vec![named("a"), named("b")];
        let mut document = Document { materials: vec![named("edited")], ..Document::empty() };
        fit_materials(&mut document, &dataset);
        let names: Vec<_> = document.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["edited", "b"]);
        document.materials.push(named("gone"));
        fit_materials(&mut document, &dataset);
        assert_eq!(document.materials.len(), 2);
    }

    #[test]
    fn a_checkpoint_is_found_beside_its_output() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        assert!(checkpoint_time(&output).is_none());
        std::fs::create_dir(folder.path().join("a.cuts.partial")).unwrap();
        assert!(checkpoint_time(&output).is_some());
    }
}
