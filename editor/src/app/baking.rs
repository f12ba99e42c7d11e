//! Baking from the window: starting, progress, and taking the result into the document.

use super::{
    files::Written,
    opening::{draft_of, kept_in},
    state::{
        EditorState,
        baking::{Ended, Looked, Run, Seen},
    },
};
use crate::{
    document::{
        Document, TextureEntry,
        objects::ObjectNumbers,
        parts::{OwnMaterials, Renumbering},
    },
    jobs::{
        Imported,
        bake::{BakeMessage, BakeRun, BakeTask, draft_is_sooner},
        kept_bakes,
    },
    panels::bake::{BakeStatus, Pace, control_name, stale_reasons},
};
use lapidary_core::{
    animation::{BoundAnimation, ClipTime},
    dataset::{BakeParts, BakeSettings, Dataset, bake_hash},
    ground::Ground,
    scene::pose::Poses,
    texture::Texture,
};
use lapidary_interchange::formats::SceneFormat;
use lapidary_precompute::{BakeJob, Leftover, Preset, leftover, resolve};
use lapidary_render::Baked;
use lapidary_studies::jobs::spawn;
use std::{
    path::{Path, PathBuf},
    sync::{Arc, mpsc::channel},
    time::{Duration, Instant, SystemTime},
};

/// Why a bake does not start while there is one.
const UNDER_WAY: &str = "A bake is under way; cancel it first";

impl EditorState {
    /// Bakes with the document's settings, or goes on with what was interrupted; `progressive` bakes a draft to look at first.
    pub(super) fn start_bake(&mut self, resume: bool, progressive: bool) {
        if !resume && self.write_kept() {
            return;
        }
        let interrupted = if resume { self.interrupted() } else { None };
        self.bake(interrupted.or_else(|| self.scene.bake_output.clone()), resume, progressive, false);
    }

    /// Bakes without being asked. A checkpoint of other settings is no reason to stop.
    pub(super) fn bake_by_itself(&mut self, resume: bool, progressive: bool) {
        // What the user began stays for the user to resume.
        self.bake(self.scene.kept_output.clone(), resume, progressive, true);
    }

    /// Writes the bake that is shown to where the user wants it, if it is what a bake would give. Returns whether it is.
    fn write_kept(&mut self) -> bool {
        let is_elsewhere = self.scene.kept_output != self.scene.bake_output && self.document.dataset.is_none();
        let whole =
            self.scene.shown().filter(|_| is_elsewhere && !self.scene.is_draft && self.stale_reasons().is_empty());
        let Some((whole, output)) = whole.cloned().zip(self.scene.bake_output.clone()) else { return false };
        if self.may_write(&output, Written::Dataset) {
            let (sender, written) = channel();
            self.baking.written = Some(written);
            // How a ground is shown is the document's.
            let settings = BakeSettings { ground: self.document.bake.ground, ..whole.dataset.settings.clone() };
            let wake = self.wake.clone();
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
                self.messages.note(format!("The bake was written ({})", output.display()));
                self.document.dataset = Some(output);
            }
            Err(error) => self.messages.error(error),
        }
    }

    /// The output of an interrupted bake: the user's, or else one that began by itself.
    fn interrupted(&self) -> Option<PathBuf> {
        let outputs = [&self.scene.bake_output, &self.scene.kept_output];
        outputs.into_iter().flatten().find(|output| checkpoint_time(output).is_some()).cloned()
    }

    fn bake(&mut self, output: Option<PathBuf>, resume: bool, progressive: bool, or_afresh: bool) {
        if self.baking.run.is_some() {
            self.messages.note(UNDER_WAY);
            return;
        }
        let Some((source, output)) = self.scene.source.clone().zip(output) else {
            let scenes = SceneFormat::names_richest_first();
            self.messages.error(format!("There is no scene file to bake; open a scene ({scenes})"));
            return;
        };
        let settings = match resolve(self.document.bake.clone()) {
            Ok(settings) => settings,
            Err(error) => {
                return self.messages.error(format!("The bake settings do not work: {}", error.text(control_name)));
            }
        };
        if let Some(folder) = output.parent().filter(|f| !f.as_os_str().is_empty())
            && let Err(error) = std::fs::create_dir_all(folder)
        {
            return self
                .messages
                .error(format!("cannot create the folder for the bake: {error} ({})", folder.display()));
        }
        if !self.may_write(&output, Written::Dataset) {
            return;
        }
        // Of another version than the bake that is seen, it may have its objects in another order.
        let document = self.document.with_objects_of(&source.scene).into_owned();
        let (poses, clip_time) = match poses_to_bake(&document, &source) {
            Ok(poses) => poses,
            Err(error) => return self.messages.error(error),
        };
        let Imported { mut scene, import_secs, report, .. } = source;
        if document.lets_through_otherwise(&scene) {
            document.give_opacities(Arc::make_mut(&mut scene));
        }
        let (mode, has_ground) = (settings.mode, settings.ground != Ground::Off);
        let (inputs, warnings) = (report.files, report.warnings);
        let job = BakeJob {
            settings,
            poses,
            clip_time,
            output: output.clone(),
            inputs,
            chunks: None,
            resume,
            import_secs,
            warnings,
        };
        let task = BakeTask {
            scene,
            job,
            progressive,
            or_afresh,
            turn: self.baking.turn.clone(),
            cache: self.folders.cache.clone(),
        };
        let now = Instant::now();
        let job = BakeRun::start(task, self.wake.clone());
        self.baking.ended = None;
        self.baking.run = Some(Run {
            job,
            mode,
            output,
            since: now,
            phase: None,
            phase_since: now,
            waited_before: Duration::ZERO,
            pace: Pace::default(),
            cancelling: false,
            draft_shown: false,
            has_ground,
            by_itself: or_afresh,
        });
    }

    /// A long bake begins with a draft if it brings light that cannot be seen yet.
    pub(super) fn wants_draft(&self) -> bool {
        let wanted = &self.document.bake;
        let has = |part: fn(BakeParts) -> bool| {
            !part(wanted.mode) || self.scene.shown().is_some_and(|baked| part(baked.dataset.settings.mode))
        };
        let has_all = [BakeParts::environment, BakeParts::sources, BakeParts::meshless].into_iter().all(has);
        let bounces = wanted.mode.sources() || wanted.mode.meshless();
        !has_all && (bounces || wanted.lights > Preset::Draft.settings().lights) && draft_is_sooner(wanted)
    }

    pub(super) fn cancel_bake(&mut self) {
        if let Some(run) = &mut self.baking.run {
            run.cancelling = true;
            run.job.cancel();
        }
    }

    pub(super) fn collect_bake(&mut self) {
        self.collect_written();
        let Some(run) = &mut self.baking.run else { return };
        run.follow();
        let messages = run.job.messages();
        for message in messages {
            match message {
                BakeMessage::Warning(text) => self.messages.warning(text),
                BakeMessage::Draft(baked) => {
                    self.baking.run.iter_mut().for_each(|run| run.draft_shown = true);
                    self.keep_draft(&baked.dataset);
                    self.show_baked(baked, true);
                }
                BakeMessage::Done(baked) => {
                    self.messages.withdraw(UNDER_WAY);
                    if let Some(run) = self.baking.run.take() {
                        self.note_bake(&run, baked.dataset.report.vertices);
                    }
                    self.show_baked(baked, false);
                }
                BakeMessage::Cancelled => self.end_bake(Ended::Cancelled),
                BakeMessage::Failed(error) => {
                    self.messages.error(format!("The bake failed: {error}"));
                    self.end_bake(Ended::Failed(error));
                }
            }
        }
    }

    /// Tells of a bake that is done, and remembers its file if the user asked for it.
    fn note_bake(&mut self, run: &Run, vertices: usize) {
        self.messages.note(format!("Baked {vertices} vertices in {:.0} s", run.since.elapsed().as_secs_f64()));
        if self.scene.bake_output.as_ref() == Some(&run.output) {
            self.document.dataset = Some(run.output.clone());
        }
        let (folder, latest) = (self.folders.bakes(), run.output.clone());
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
        let Some(scene) = &self.document.scene else { return };
        // It is of the scene as it was when its bake began.
        let path = draft_of(&kept_in(&self.folders.bakes(), scene, &dataset.scene_hash));
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
        let Some((source, output)) = self.scene.source.as_ref().zip(self.interrupted()) else {
            return Leftover::Nothing;
        };
        let Some(written) = checkpoint_time(&output) else { return Leftover::Nothing };
        let Ok(settings) = resolve(self.document.bake.clone()) else { return Leftover::OfAnother };
        let document = self.document.with_objects_of(&source.scene);
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
        self.messages.withdraw(UNDER_WAY);
        self.baking.ended = Some(ended);
    }

    /// Renders another bake of the scene. Materials that were edited stay.
    fn show_baked(&mut self, baked: Baked, is_draft: bool) {
        // The scene may have changed during its bake.
        let changed = self.scene.source.as_ref().filter(|source| source.hash != baked.dataset.scene_hash);
        let preview = changed.map(|source| source.unshadowed(self.document.bake.ground));
        self.take_materials_of(&preview.as_ref().unwrap_or(&baked).dataset);
        // The hierarchies are for the picture, and no guests.
        baked.begin();
        (self.scene.baked, self.scene.preview) = (Some(baked), preview);
        (self.scene.is_draft, self.scene.show_stale) = (is_draft, false);
    }

    /// Shows a ground that was asked for and is not in the bake: at once without shadows, and baked anew. One that is not wanted any
    /// more is hidden, whatever the bake has.
    pub(super) fn follow_ground(&mut self) {
        let ground = self.document.bake.ground;
        let Some(source) = self.scene.source.clone().filter(|_| !self.scene.show_stale) else { return };
        let suits = |baked: &Baked| ground == Ground::Off || baked.has_ground();
        let is_current = !self.scene.is_stale();
        if let Some(baked) = self.scene.baked.clone().filter(|baked| is_current && suits(baked)) {
            if self.scene.preview.is_some() {
                self.take_materials_of(&baked.dataset);
                self.scene.preview = None;
            }
            self.baking.wants_ground = false;
            return self.bake_ground();
        }
        if !self.scene.preview.as_ref().is_some_and(suits) {
            let preview = source.unshadowed(ground);
            self.take_materials_of(&preview.dataset);
            self.scene.preview = Some(preview);
            self.baking.wants_ground = is_current && self.preferences.bakes_scenes;
        }
        self.bake_ground();
    }

    /// Begins a bake for a ground if one is wanted. A bake without one that began by itself ends for it, and what is chosen by then
    /// is baked; one that the user asked for is finished first.
    fn bake_ground(&mut self) {
        let wants_ground = self.baking.wants_ground && self.document.bake.ground != Ground::Off;
        match &self.baking.run {
            Some(run) if run.has_ground => self.baking.wants_ground = false,
            Some(run) if wants_ground && run.by_itself && !run.cancelling => {
                self.cancel_bake();
                self.baking.begins_anew = true;
            }
            None if wants_ground || self.baking.begins_anew => {
                (self.baking.wants_ground, self.baking.begins_anew) = (false, false);
                self.bake_by_itself(false, true);
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
        self.history.renumber_materials(&renumbering);
        let selected = self.selection.material.map(|index| renumbering.of(index));
        self.selection.material = selected.filter(|&index| index < self.document.materials.len());
    }

    /// What the picture is rendered by.
    pub(super) fn seen(&self) -> Seen {
        match self.scene.shown() {
            None => Seen::Unshadowed,
            Some(_) if self.scene.is_draft => Seen::Draft,
            Some(_) => Seen::Whole,
        }
    }

    /// Differences between the present bake and the result of a new one.
    pub(super) fn stale_reasons(&self) -> Vec<String> {
        let hash = self.scene.source.as_ref().map(|source| source.hash.as_str());
        let baked = self.scene.baked.as_ref();
        baked.map_or_else(Vec::new, |baked| stale_reasons(&self.document, &baked.dataset, hash))
    }

    /// The scene file has changed. Its bake is out of date, unless only appearances or animations were changed.
    pub(super) fn scene_changed(&mut self, path: &Path, source: Imported) {
        if self.document.scene.as_deref() != Some(path) {
            return;
        }
        match self.scene.source.as_mut().filter(|known| known.hash == source.hash) {
            // What was tried of its mesh stays known.
            Some(known) => (known.scene, known.animation) = (source.scene, source.animation),
            None => self.take_changed(path, source),
        }
        self.drop_lost_clip();
    }

    fn take_changed(&mut self, path: &Path, source: Imported) {
        self.messages.warning(format!("The scene file has changed; bake it again to see it ({})", path.display()));
        let output = self.scene.bake_output.take().or_else(|| self.document.dataset.clone());
        self.scene.bake_output = output.or_else(|| Some(path.with_extension("cuts")));
        if self.scene.baked.is_none() {
            take_textures(&mut self.document, &source.scene.textures);
        }
        // What is on the screen stays there, and is marked.
        self.scene.show_stale = self.scene.shown().is_some();
        let preview = (!self.scene.show_stale).then(|| source.unshadowed(self.document.bake.ground));
        preview.iter().for_each(|preview| self.take_materials_of(&preview.dataset));
        self.scene.preview = preview;
        self.scene.kept_output = Some(kept_in(&self.folders.bakes(), path, &source.hash));
        self.scene.source = Some(source);
    }

    /// How things stand, for the bake panel.
    pub(super) fn bake_status(&mut self) -> BakeStatus {
        if let Some(run) = &self.baking.run {
            return run.status();
        }
        let leftover = self.leftover();
        match (&self.baking.ended, &self.scene.baked) {
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
