//! Begins a bake: the task for the driver of bakes, and the remains of an interrupted bake.

use super::state::{Asker, BakeOrder, Baking, From, Looked};
use crate::{
    control_names::control_name,
    document::Document,
    jobs::Imported,
    workspace::{OpenScene, Workspace, Written},
};
use lapidary_core::{
    animation::{BoundAnimation, ClipTime},
    dataset::bake_hash,
    scene::pose::Poses,
};
use lapidary_interchange::formats::SceneFormat;
use lapidary_precompute::{BakeJob, Leftover, Preset, ResolvedBake, leftover, resolve};
use lapidary_studies::jobs::bake::{BakeTask, draft_is_sooner};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::SystemTime,
};

/// What a request for a bake does while one runs.
pub const UNDER_WAY: &str = "What is shown is being baked already";
pub const STARTS_AGAIN: &str = "The bake starts again, with what is shown now";

impl Baking {
    /// Bakes with the document's settings, or resumes an interrupted bake. Only the user resumes bakes that the user began.
    pub fn bake(&mut self, work: &mut Workspace, order: BakeOrder) {
        let output = match (order.asked_by, order.from) {
            (Asker::Nobody, _) => work.scene.kept_output.clone(),
            (Asker::User, From::Checkpoint) => interrupted(&work.scene).or_else(|| work.scene.bake_output.clone()),
            (Asker::User, From::Beginning) if self.write_kept(work) => return,
            (Asker::User, From::Beginning) => work.scene.bake_output.clone(),
        };
        if self.run.is_some() {
            return self.ask_again(work, order);
        }
        let asked_anew = (order.asked_by, order.from) == (Asker::User, From::Beginning);
        if asked_anew && self.update_instead(work, output.as_ref()) {
            return;
        }
        match self.task(work, order, output) {
            Ok(Some(task)) => self.begin(task, order, content(work), work.wake.clone()),
            // The user has been warned that a file would be overwritten.
            Ok(None) => {}
            Err(error) => work.messages.error(error),
        }
    }

    /// A request while a bake runs: it starts again if it would bake something else. A bake that nobody asked for is kept as the
    /// user's once it is done.
    fn ask_again(&mut self, work: &mut Workspace, order: BakeOrder) {
        let now = content(work);
        let Some(run) = self.run.as_ref().filter(|_| order.asked_by == Asker::User) else { return };
        let is_same = now.is_some() && run.content == now && !run.job.is_cancelling();
        if is_same {
            self.again = (run.asked_by == Asker::Nobody).then_some(order);
            return work.messages.note(UNDER_WAY);
        }
        self.again = Some(order);
        work.messages.note(STARTS_AGAIN);
        self.cancel();
    }

    /// The driver's task for an order; `None` if its output may not be written.
    fn task(
        &self,
        work: &mut Workspace,
        order: BakeOrder,
        output: Option<PathBuf>,
    ) -> Result<Option<BakeTask>, String> {
        let scenes = SceneFormat::names_richest_first();
        let nothing = || format!("There is no scene file to bake; open a scene ({scenes})");
        let (source, output) = work.scene.source.clone().zip(output).ok_or_else(nothing)?;
        let settings = resolve(work.document.bake.clone());
        let settings = settings.map_err(|error| format!("Invalid bake settings: {}", error.text(control_name)))?;
        if let Some(folder) = output.parent().filter(|f| !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|error| format!("cannot create the folder for the bake: {error} ({})", folder.display()))?;
        }
        if !work.may_write(&output, Written::Dataset) {
            return Ok(None);
        }
        // Another version of the scene may order its objects differently from the bake on the screen.
        let document = work.document.with_objects_of(&source.scene).into_owned();
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
            turn: self.turn.clone(),
            cache: work.folders.cache.clone(),
            name_of: control_name,
        }))
    }

    /// The remains of an interrupted bake that suit the present settings. They are read again only when their inputs have changed.
    pub fn leftover(&mut self, work: &Workspace) -> Leftover {
        let output = work.scene.source.as_ref().and_then(|_| interrupted(&work.scene));
        let Some(output) = output else { return Leftover::Nothing };
        let Some(written) = checkpoint_time(&output) else { return Leftover::Nothing };
        let Some((scene_hash, settings)) = content(work) else { return Leftover::OfAnother };
        let looked = Looked { output, scene_hash, settings, written };
        let known = self.leftover.take().filter(|(known, _)| *known == looked);
        let look = || {
            let found = leftover(&looked.output, &looked.scene_hash, &looked.settings);
            (looked, found)
        };
        self.leftover.insert(known.unwrap_or_else(look)).1
    }
}

/// What a bake of the document would hold: a hash of the scene as it would be baked, and the settings; `None` if it cannot be baked.
pub fn content(work: &Workspace) -> Option<(String, ResolvedBake)> {
    let source = work.scene.source.as_ref()?;
    let settings = resolve(work.document.bake.clone()).ok()?;
    let document = work.document.with_objects_of(&source.scene);
    let opacities = document.opacities_for(&source.scene);
    Some((bake_hash(&source.hash, &opacities, &document.poses, document.clip_time.as_ref()), settings))
}

/// The output of an interrupted bake: the user's, or else an automatic one.
fn interrupted(scene: &OpenScene) -> Option<PathBuf> {
    let outputs = [&scene.bake_output, &scene.kept_output];
    outputs.into_iter().flatten().find(|output| checkpoint_time(output).is_some()).cloned()
}

/// Whether a bake begins with a draft: a long one does if it adds light that is not visible yet.
pub fn wants_draft(work: &Workspace) -> bool {
    let wanted = &work.document.bake;
    let has_all = work.scene.shown().is_some_and(|baked| baked.dataset.settings.mode.has_all(wanted.mode));
    !has_all && (wanted.mode.bounces() || wanted.lights > Preset::Draft.settings().lights) && draft_is_sooner(wanted)
}

/// Poses of the objects in a bake of a document, relative to the file, and the time of its animation.
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

/// Time of the last change of the checkpoint folder beside an output, if there is one.
fn checkpoint_time(output: &Path) -> Option<SystemTime> {
    let mut folder = output.as_os_str().to_owned();
    folder.push(".partial");
    std::fs::metadata(folder).ok().filter(|m| m.is_dir())?.modified().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_is_found_beside_its_output() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        assert!(checkpoint_time(&output).is_none());
        std::fs::create_dir(folder.path().join("a.cuts.partial")).unwrap();
        assert!(checkpoint_time(&output).is_some());
    }
}
