use super::*;
use crate::sequence::{SequenceSettings, plan};
use glam::Vec3;
use lapidary_core::{
    animation::ClipTime,
    scene::pose::{Pose, Poses},
    test_scenes,
};
use lapidary_interchange::image;
use lapidary_render::{Appearance, Baked, CpuBackend, View};
use lapidary_render::{Look, test_looks::look};
use std::{
    fs,
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
};

/// Cancels after some frames have started.
struct Stop {
    after: u64,
    begun: AtomicU64,
    /// Its first progress values.
    first: OnceLock<(u64, u64)>,
}

impl Stop {
    fn never() -> Self {
        Self::after(u64::MAX)
    }

    fn after(after: u64) -> Self {
        Self { after, begun: AtomicU64::new(0), first: OnceLock::new() }
    }
}

impl Progress for Stop {
    fn advanced(&self, done: u64, total: u64) {
        self.first.get_or_init(|| (done, total));
        self.begun.store(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.begun.load(Ordering::Relaxed) >= self.after
    }
}

fn baked() -> Baked {
    test_scenes::dataset(&["a"], &[]).into()
}

/// The triangle of the test dataset from above.
fn base(baked: &Baked) -> Look {
    let mut base = Look { appearance: Appearance::of(&baked.dataset.scene), ..look() };
    base.view = View { size: [12, 8], ..base.view };
    base.components.indirect = false;
    base
}

fn task(baked: &Baked, folder: &Path, sweep: &str, frames: u32) -> SequenceTask {
    let settings = SequenceSettings { frames, turn: None, sweeps: vec![sweep.parse().unwrap()], ..Default::default() };
    SequenceTask {
        frames: plan(&base(baked), &settings).unwrap(),
        outputs: vec![
            FrameNames::new(&folder.join("f.##.png")).unwrap(),
            FrameNames::new(&folder.join("f.##.exr")).unwrap(),
        ],
        layers: vec![LayerKind::Beauty, LayerKind::Depth],
        existing: Existing::Refuse,
        sheet: Some(SheetTask { path: folder.join("sheet.png"), columns: Some(2) }),
    }
}

fn run(task: &SequenceTask, baked: &Baked, stop: &Stop) -> Result<SequenceEnd> {
    let prepared = task.prepare(&baked.dataset)?;
    task.run(prepared, &mut Studio::new(Box::new(CpuBackend::new()), baked.clone())?, stop)
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn frames_are_written_in_all_formats_with_a_record_and_a_sheet() {
    let (folder, baked) = (tempfile::tempdir().unwrap(), baked());
    let folder = folder.path().join("made/for/it");
    let task = task(&baked, &folder, "intensity=1..3", 3);
    let end = run(&task, &baked, &Stop::never()).unwrap();
    assert_eq!(end, SequenceEnd { rendered: 3, kept: 0, cancelled: false });
    let expected = ["f.01.exr", "f.01.png", "f.02.exr", "f.02.png", "f.03.exr", "f.03.png", "f.json", "sheet.png"];
    assert_eq!(files(&folder), expected);
    let record: serde_json::Value = serde_json::from_slice(&fs::read(folder.join("f.json")).unwrap()).unwrap();
    assert_eq!(record["frames"][1]["values"]["intensity"], 2.0);
    assert_eq!(record["frames"][1]["files"][1], "f.02.exr");
    assert!(record["frames"][2]["seconds"].is_number());
    let read = |name: &str| image::read(&folder.join(name)).unwrap();
    let ratio = read("f.03.exr").pixels[0].x / read("f.01.exr").pixels[0].x;
    assert!((ratio - 3.0).abs() < 1e-4, "{ratio}");
    let depth = image::read_layer(&folder.join("f.01.exr"), "depth").unwrap();
    assert!(depth.pixels.iter().any(|p| p.x < 10.0));
}

#[test]
fn what_is_there_is_neither_replaced_nor_mixed_with_another_sequence() {
    let (folder, baked) = (tempfile::tempdir().unwrap(), baked());
    let folder = folder.path();
    let mut task = task(&baked, folder, "intensity=1..3", 3);
    run(&task, &baked, &Stop::never()).unwrap();
    let before = fs::read(folder.join("f.02.exr")).unwrap();
    let refused = |task: &SequenceTask| task.prepare(&baked.dataset).unwrap_err().to_string();
    let message = refused(&task);
    assert!(message.contains("3 of the 3") && message.contains("--resume") && message.contains("--overwrite"));
    let mut other = self::task(&baked, folder, "intensity=1..5", 3);
    other.existing = Existing::Resume;
    assert!(refused(&other).contains("another sequence"));
    for frame in &mut other.frames {
        frame.look.view.size = [6, 4];
    }
    assert!(refused(&other).contains("size differs"));
    assert_eq!(fs::read(folder.join("f.02.exr")).unwrap(), before);
    task.existing = Existing::Overwrite;
    assert_eq!(run(&task, &baked, &Stop::never()).unwrap().rendered, 3);
}

#[test]
fn frames_of_bakes_that_are_placed_otherwise_are_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    let placed = |x: f32, seconds: f32| {
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let mut poses = Poses::default();
        poses.set(0, Pose { translate: Vec3::Y * x, ..Pose::AS_BAKED });
        dataset.scene.place(&poses).unwrap();
        dataset.scene.clip_time = Some(ClipTime { clip: "walk".into(), seconds });
        Baked::from(dataset)
    };
    let task = task(&placed(0.1, 1.0), folder.path(), "intensity=1..3", 2);
    run(&task, &placed(0.1, 1.0), &Stop::never()).unwrap();
    let resume = SequenceTask { existing: Existing::Resume, ..task };
    let refused = |baked: &Baked| resume.prepare(&baked.dataset).unwrap_err().to_string();
    assert!(refused(&placed(0.2, 1.0)).contains("their bake.poses differs"));
    assert!(refused(&placed(0.1, 2.0)).contains("their bake.clip.seconds differs"));
    assert!(resume.prepare(&placed(0.1, 1.0).dataset).is_ok(), "negative control");
}

#[test]
fn a_stopped_sequence_keeps_its_frames_and_goes_on_to_the_same_end() {
    let (folder, whole, baked) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), baked());
    let mut task = task(&baked, folder.path(), "intensity=0.1..0.6", 4);
    let end = run(&task, &baked, &Stop::after(2)).unwrap();
    assert_eq!(end, SequenceEnd { rendered: 2, kept: 0, cancelled: true });
    assert_eq!(files(folder.path()), ["f.01.exr", "f.01.png", "f.02.exr", "f.02.png", "f.json"]);
    fs::remove_file(folder.path().join("f.02.png")).unwrap();
    task.existing = Existing::Resume;
    let resumed = Stop::never();
    let end = run(&task, &baked, &resumed).unwrap();
    assert_eq!(end, SequenceEnd { rendered: 3, kept: 1, cancelled: false }, "a frame is there in all formats or not");
    assert_eq!(resumed.first.get(), Some(&(1, 4)), "so that what it keeps does not count for its pace");
    run(&self::task(&baked, whole.path(), "intensity=0.1..0.6", 4), &baked, &Stop::never()).unwrap();
    for name in ["f.01.png", "f.02.png", "f.04.png", "sheet.png"] {
        let read = |folder: &Path| fs::read(folder.join(name)).unwrap();
        assert!(read(folder.path()) == read(whole.path()), "{name}");
    }
    let picture = |name: &str| fs::read(whole.path().join(name)).unwrap();
    assert!(picture("f.01.png") != picture("f.04.png"), "negative control");
}

#[test]
fn folders_that_take_no_files_are_told_before_anything_is_rendered() {
    let (folder, baked) = (tempfile::tempdir().unwrap(), baked());
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let message = task(&baked, &file.join("below"), "fov=20..30", 2).prepare(&baked.dataset).unwrap_err().to_string();
    assert!(message.contains("cannot write to the folder") && message.contains("below"), "{message}");
    #[cfg(target_os = "linux")]
    assert!(task(&baked, Path::new("/proc"), "fov=20..30", 2).prepare(&baked.dataset).is_err());
}

#[test]
#[cfg(unix)]
fn a_write_that_fails_leaves_the_frames_before_it_and_says_how_to_go_on() {
    let (folder, baked) = (tempfile::tempdir().unwrap(), baked());
    let task = task(&baked, folder.path(), "intensity=1..3", 3);
    let prepared = task.prepare(&baked.dataset).unwrap();
    // A folder at the path of a file cannot be replaced by it, like a write to a full disk.
    fs::create_dir(folder.path().join("f.02.png")).unwrap();
    let mut studio = Studio::new(Box::new(CpuBackend::new()), baked).unwrap();
    let error = crate::terminal::error_text(&task.run(prepared, &mut studio, &Stop::never()).unwrap_err());
    assert!(error.contains("1 of 3 frames") && error.contains("--resume"), "{error}");
    assert!(image::read(&folder.path().join("f.01.exr")).is_ok());
}
