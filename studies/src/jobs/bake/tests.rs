//! A single triangle, which bakes almost instantly.

use super::*;
use crate::jobs::testing::{silent, wait_for};
use glam::Vec3;
use lapidary_core::{
    cut::{CutCriterion, SourceCriterion},
    dataset::{
        BakeParts, BakeSettings, Dataset, IndirectSettings, MeshlessSettings, ObjectBasesSettings, WaveletSettings,
    },
};
use lapidary_interchange::{image, import::import};
use lapidary_precompute::{Preset, ResolvedBake, SettingsError};

const LIGHTS: usize = 256;
/// More lights than a draft has.
const MANY_LIGHTS: usize = 4096;

/// A task in its own folder.
fn task(folder: &Path, progressive: bool) -> BakeTask {
    let obj = folder.join("a.obj");
    std::fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n").unwrap();
    let settings = BakeSettings { lights: LIGHTS, pilot_clusters: 2, ..Preset::Normal.settings() };
    let output = folder.join("a.cuts");
    let job = BakeJob::new(resolve(settings).unwrap(), output);
    BakeTask {
        scene: import(&obj).unwrap().scene.into(),
        job,
        progressive,
        or_afresh: false,
        turn: Arc::default(),
        cache: folder.join("cache"),
        name_of: Setting::name,
    }
}

/// The settings of a task with another number of lights.
fn with_lights(task: &BakeTask, lights: usize) -> Result<ResolvedBake, SettingsError> {
    resolve(BakeSettings { lights, ..task.job.settings.clone().into_settings() })
}

/// All messages up to the last one of the bake.
fn all(run: &mut BakeRun) -> Vec<BakeMessage> {
    let mut messages = Vec::new();
    wait_for("the bake", || {
        messages.extend(run.messages(false));
        let ended = |m: &BakeMessage| !matches!(m, BakeMessage::Warning(_) | BakeMessage::Draft(_));
        messages.last().is_some_and(ended).then_some(())
    });
    messages
}

#[test]
fn a_draft_comes_first_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let mut task = task(folder.path(), true);
    task.job.settings = with_lights(&task, MANY_LIGHTS).unwrap();
    let (output, cache) = (task.job.output.clone(), task.cache.clone());
    let mut run = BakeRun::start(task, silent());
    let messages = all(&mut run);
    let [BakeMessage::Draft(draft), BakeMessage::Done(dataset)] = &messages[..] else { panic!("{messages:?}") };
    assert_eq!(
        (draft.dataset.tree.len(), dataset.dataset.tree.len()),
        (first_draft(&Preset::Normal.settings(), 0).lights, MANY_LIGHTS)
    );
    assert_eq!(Dataset::read(&output, image::decode).unwrap().tree.len(), MANY_LIGHTS);
    assert_eq!(std::fs::read_dir(cache).unwrap().count(), 0);
    let progress = run.progress();
    assert_eq!((progress.draft, progress.phase), (false, Some(Phase::Pack)));
}

#[test]
fn a_bake_that_is_held_waits_and_then_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let task = task(folder.path(), false);
    // It starts when the turn is free.
    let turn = task.turn.clone();
    let lock = turn.lock().unwrap();
    let mut run = BakeRun::start(task, silent());
    run.hold(true);
    drop(lock);
    std::thread::sleep(Duration::from_millis(300));
    assert!(run.messages(false).is_empty() && run.door.waited() >= Duration::from_millis(300));
    run.hold(false);
    assert!(matches!(all(&mut run)[..], [BakeMessage::Done(_)]));
    let folder = tempfile::tempdir().unwrap();
    let mut run = BakeRun::start(self::task(folder.path(), false), silent());
    run.hold(true);
    run.cancel();
    assert!(matches!(all(&mut run).last(), Some(BakeMessage::Cancelled | BakeMessage::Done(_))), "held or not");
}

#[test]
#[cfg(unix)]
fn a_link_under_a_name_that_can_be_known_leads_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let mut task = task(folder.path(), true);
    task.job.settings = with_lights(&task, MANY_LIGHTS).unwrap();
    let victim = folder.path().join("victim");
    [&victim, &task.cache].into_iter().for_each(|folder| std::fs::create_dir_all(folder).unwrap());
    let links: Vec<_> = (0..9).map(|n| task.cache.join(format!("draft-{}-{n}", std::process::id()))).collect();
    links.iter().for_each(|link| std::os::unix::fs::symlink(&victim, link).unwrap());
    let before = std::fs::metadata(&victim).unwrap().modified().unwrap();
    let messages = all(&mut BakeRun::start(task, silent()));
    assert!(matches!(&messages[..], [BakeMessage::Draft(_), BakeMessage::Done(_)]), "{messages:?}");
    assert_eq!(std::fs::metadata(&victim).unwrap().modified().unwrap(), before, "nothing was made in it");
    assert!(links.iter().all(|link| link.is_symlink()));
}

/// A floor and a wall that faces it.
const CORNER: &str = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 0 1 1\nf 1 4 3 2\nf 1 5 6 4\n";

#[test]
fn a_draft_has_the_parts_of_the_light_that_are_wanted() {
    let folder = tempfile::tempdir().unwrap();
    for (mode, parts) in [(BakeParts::INDIRECT, (true, false)), (BakeParts::MESHLESS, (false, true))] {
        let mut task = task(folder.path(), true);
        let obj = folder.path().join("corner.obj");
        std::fs::write(&obj, CORNER).unwrap();
        task.scene = import(&obj).unwrap().scene.into();
        let normal = Preset::Draft.settings();
        let viewpoint = Some(Vec3::new(0.6, 0.5, 0.5));
        let indirect = IndirectSettings { viewpoint, sources: 4096, ..normal.indirect };
        let meshless = MeshlessSettings { levels: 1, sender_levels: 1, ..normal.meshless };
        let settings = BakeSettings { mode, indirect, meshless, lights: LIGHTS, max_vertices: None, ..normal };
        task.job.settings = resolve(settings).unwrap();
        let mut messages = all(&mut BakeRun::start(task.clone(), silent()));
        messages.retain(|m| !matches!(m, BakeMessage::Warning(_))); // two walls are no closed space
        let [BakeMessage::Draft(draft), BakeMessage::Done(whole)] = &messages[..] else { panic!("{messages:?}") };
        for dataset in [&draft.dataset, &whole.dataset] {
            assert_eq!((dataset.indirect.is_some(), dataset.meshless.is_some()), parts, "{mode:?}");
        }
        let sources = |baked: &Baked| baked.dataset.indirect.as_ref().map_or(0, |bake| bake.sources.len());
        assert!(sources(draft) <= sources(whole) / 2, "{mode:?}");
        assert_eq!(first_draft(&task.job.settings, 0).indirect.viewpoint, task.job.settings.indirect.viewpoint);
    }
}

#[test]
fn a_draft_is_in_nothing_finer_than_what_is_wanted_and_comes_only_where_it_is_sooner() {
    let normal = Preset::Normal.settings();
    let criterion = CutCriterion { sigma: 5.0, max_nodes: 40, ..normal.criterion };
    let sources = IndirectSettings {
        sources: 512,
        criterion: SourceCriterion { sigma: 9.0, ..normal.indirect.criterion },
        ..normal.indirect
    };
    let meshless = MeshlessSettings { levels: 2, sender_levels: 1, rays: 32, ..normal.meshless };
    let object_bases = ObjectBasesSettings { functions: 2000, levels: 3, sender_level: 2 };
    let few = BakeSettings {
        mode: BakeParts::ALL,
        object_bases,
        lights: 512,
        pilot_clusters: 3,
        max_vertices: Some(700),
        criterion,
        indirect: sources,
        meshless,
        wavelet: WaveletSettings { compression: 1e-3 },
        ..normal.clone()
    };
    let draft = first_draft(&few, 0);
    assert_eq!(draft, BakeSettings { tree: draft.tree, beta: draft.beta, even_vertices: true, ..few.clone() });
    assert_eq!(first_draft(&BakeSettings { max_vertices: None, ..few.clone() }, 0).max_vertices, None);
    assert_eq!(first_draft(&normal, 0).criterion.sigma, 0.375, "negative control");
    assert!(!draft_is_sooner(&few));
    for (mode, [lights, sources, basis, bases]) in [
        (BakeParts::ENVIRONMENT, [true, false, false, false]),
        (BakeParts::INDIRECT, [false, true, false, false]),
        (BakeParts::MESHLESS, [false, false, true, false]),
        (BakeParts::RADIOSITY, [false, false, false, true]),
        (BakeParts::ALL.with(BakeParts::RADIOSITY), [true; 4]),
    ] {
        let few = BakeSettings { mode, ..few.clone() };
        assert_eq!(draft_is_sooner(&BakeSettings { lights: 32_768, ..few.clone() }), lights, "{mode:?}");
        assert_eq!(draft_is_sooner(&BakeSettings { indirect: normal.indirect, ..few.clone() }), sources, "{mode:?}");
        assert_eq!(draft_is_sooner(&BakeSettings { meshless: normal.meshless, ..few.clone() }), basis, "{mode:?}");
        assert_eq!(draft_is_sooner(&BakeSettings { object_bases: normal.object_bases, ..few }), bases, "{mode:?}");
    }
}

#[test]
fn without_a_draft_there_is_only_the_bake() {
    let folder = tempfile::tempdir().unwrap();
    let messages = all(&mut BakeRun::start(task(folder.path(), false), silent()));
    assert!(matches!(&messages[..], [BakeMessage::Done(_)]), "{messages:?}");
}

#[test]
fn a_cancelled_bake_says_so_and_goes_on_when_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let mut task = task(folder.path(), true);
    let messages = all(&mut BakeRun::start_with(task.clone(), silent(), Arc::new(true.into())));
    assert!(matches!(&messages[..], [BakeMessage::Cancelled]), "{messages:?}");
    assert!(!task.job.output.exists());
    task.job.resume = true;
    let messages = all(&mut BakeRun::start(task, silent()));
    assert!(matches!(&messages[..], [BakeMessage::Done(_)]), "no draft when going on: {messages:?}");
}

#[test]
fn a_checkpoint_of_other_settings_is_an_error_only_to_who_asked_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut task = task(folder.path(), false);
    task.job.resume = true;
    std::fs::create_dir(folder.path().join("a.cuts.partial")).unwrap();
    std::fs::write(folder.path().join("a.cuts.partial/bake.json"), "{}").unwrap();
    let messages = all(&mut BakeRun::start(task.clone(), silent()));
    assert!(matches!(&messages[..], [BakeMessage::Failed(_)]), "{messages:?}");
    let messages = all(&mut BakeRun::start(BakeTask { or_afresh: true, ..task }, silent()));
    assert!(matches!(messages.last(), Some(BakeMessage::Done(_))), "{messages:?}");
}

#[test]
fn a_bake_waits_for_one_that_was_left() {
    let folder = tempfile::tempdir().unwrap();
    let task = task(folder.path(), false);
    let turn = task.turn.clone();
    let held = turn.lock().unwrap();
    let mut run = BakeRun::start(task, silent());
    std::thread::sleep(std::time::Duration::from_millis(50));
    assert!(run.messages(false).is_empty() && !folder.path().join("a.cuts").exists());
    drop(held);
    assert!(matches!(&all(&mut run)[..], [BakeMessage::Done(_)]));
}

#[test]
fn what_cannot_be_baked_or_written_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mut odd = task(folder.path(), false);
    assert!(with_lights(&odd, 1000).is_err_and(|error| error.to_string().contains("1000")));
    let meshless = MeshlessSettings { coarse_radius: Some(1e-5), ..Default::default() };
    let tiny = BakeSettings { mode: BakeParts::MESHLESS, meshless, ..odd.job.settings.into_settings() };
    odd.job.settings = resolve(tiny).unwrap();
    let messages = all(&mut BakeRun::start(odd, silent()));
    assert!(matches!(&messages[..], [BakeMessage::Failed(text)] if text.contains("coarse radius")), "{messages:?}");
    let mut nowhere = task(folder.path(), true);
    std::fs::write(folder.path().join("file"), "").unwrap();
    nowhere.cache = folder.path().join("file");
    let messages = all(&mut BakeRun::start(nowhere, silent()));
    let [BakeMessage::Warning(text), BakeMessage::Done(_)] = &messages[..] else { panic!("{messages:?}") };
    assert!(text.contains("no draft"), "{text}");
}

#[test]
fn fractions_are_known_when_the_total_is() {
    let progress = BakeProgress { done: 3, total: 4, ..Default::default() };
    assert_eq!(progress.fraction(), Some(0.75));
    assert_eq!(BakeProgress::default().fraction(), None);
}
