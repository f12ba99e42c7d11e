use super::*;
use crate::bake::settings::resolve;
use lapidary_core::surfel::Surfel;

fn content() -> Content {
    Content::still("hash")
}

fn settings() -> BakeSettings {
    BakeSettings { lights: 2, ..Default::default() }
}

fn created(output: &Path) -> Checkpoint {
    Checkpoint::create(output, &Work::All, content(), &settings(), 10, 3, &[0, 1]).unwrap()
}

/// A checkpoint of ten points in three chunks, opened for resuming.
pub fn reopened(output: &Path) -> Checkpoint {
    created(output);
    Checkpoint::open(output, &Work::All, &content(), &settings()).unwrap().unwrap()
}

/// Cuts of one node.
fn chunk() -> Chunk {
    Chunk { nodes: vec![7, 8, 9], lengths: vec![1; 3], squared_errors: vec![0.25; 3], rays: 99 }
}

#[test]
fn chunks_survive_and_damaged_or_misplaced_ones_do_not_count() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.cuts");
    let checkpoint = reopened(&output);
    let kept = checkpoint.series(Series::Environment, Places::of(&[], &[]));
    kept.store(0, &chunk()).unwrap();
    assert_eq!(kept.load(0, 3, 1), Some(chunk()));
    assert_eq!((kept.load(0, 4, 1), kept.load(1, 3, 1)), (None, None));
    assert_eq!((0..3).map(|c| kept.range(10, c).len()).sum::<usize>(), 10);
    let file = |series: Series, index| Checkpoint::folder_of(&output).join(series.file_name(index));
    let first = file(Series::Environment, 0);
    fs::copy(&first, file(Series::Environment, 1)).unwrap();
    fs::copy(&first, file(Series::Sources, 0)).unwrap();
    let sources = checkpoint.series(Series::Sources, Places::of(&[], &[]));
    assert_eq!((kept.load(1, 3, 1), sources.load(0, 3, 1)), (None, None), "doubled");
    let mut bytes = fs::read(&first).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&first, &bytes).unwrap();
    assert_eq!(kept.load(0, 3, 1), None);
}

#[test]
fn chunks_of_another_bake_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let [output, other] = ["a.cuts", "b.cuts"].map(|name| folder.path().join(name));
    let checkpoint = reopened(&output);
    Checkpoint::create(&other, &Work::All, content(), &BakeSettings { beta: 0.4, ..settings() }, 10, 3, &[0, 1])
        .unwrap();
    let other_settings = BakeSettings { beta: 0.4, ..settings() };
    let of_other = Checkpoint::open(&other, &Work::All, &content(), &other_settings).unwrap().unwrap();
    of_other.series(Series::Environment, Places::of(&[], &[])).store(0, &chunk()).unwrap();
    let name = Series::Environment.file_name(0);
    fs::copy(Checkpoint::folder_of(&other).join(&name), Checkpoint::folder_of(&output).join(&name)).unwrap();
    let kept = checkpoint.series(Series::Environment, Places::of(&[], &[]));
    assert_eq!(kept.load(0, 3, 1), None);
    assert!(!kept.has_met_others(), "it is no chunk of this bake about other points");
    assert!(of_other.series(Series::Environment, Places::of(&[], &[])).load(0, 3, 1).is_some(), "negative control");
}

#[test]
fn chunks_about_other_points_are_told_and_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let checkpoint = reopened(&folder.path().join("a.cuts"));
    let at = |x| Places::of(&[Surfel { position: glam::Vec3::X * x, ..Default::default() }], &[0.5]);
    checkpoint.series(Series::Sources, at(1.0)).store(0, &chunk()).unwrap();
    let moved = checkpoint.series(Series::Sources, at(2.0));
    assert!(moved.load(0, 3, 1).is_none() && moved.has_met_others());
    let same = checkpoint.series(Series::Sources, at(1.0));
    assert!(same.load(0, 3, 1).is_some() && !same.has_met_others());
}

#[test]
fn nothing_is_read_unless_a_bake_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.cuts");
    let fresh = created(&output);
    let kept = fresh.series(Series::Environment, Places::of(&[], &[]));
    kept.store(0, &chunk()).unwrap();
    assert_eq!(kept.load(0, 3, 1), None);
    let resumed = Checkpoint::open(&output, &Work::All, &content(), &settings()).unwrap().unwrap();
    assert!(resumed.series(Series::Environment, Places::of(&[], &[])).load(0, 3, 1).is_some(), "negative control");
    drop(created(&output));
    assert_eq!(fs::read_dir(Checkpoint::folder_of(&output)).unwrap().count(), 1, "the manifest alone");
}

#[test]
fn a_checkpoint_of_another_bake_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.cuts");
    let settings = resolve(settings()).unwrap();
    assert!(Checkpoint::open(&output, &Work::All, &content(), &settings).unwrap().is_none());
    assert_eq!(leftover(&output, "hash", &settings), Leftover::Nothing);
    created(&output);
    assert!(matches!(
        Checkpoint::open(&output, &Work::All, &Content::still("other"), &settings),
        Err(CheckpointError::Mismatch { .. })
    ));
    let other = resolve(BakeSettings { beta: 0.4, ..settings.clone().into_settings() }).unwrap();
    assert!(matches!(Checkpoint::open(&output, &Work::All, &content(), &other), Err(CheckpointError::Mismatch { .. })));
    assert_eq!(leftover(&output, "hash", &other), Leftover::OfAnother);
    assert_eq!(leftover(&output, "hash", &settings), Leftover::Fitting);
    fs::write(Checkpoint::folder_of(&output).join(manifest::FILE), "{}").unwrap();
    assert!(matches!(
        Checkpoint::open(&output, &Work::All, &content(), &settings),
        Err(CheckpointError::Damaged { .. })
    ));
}

#[test]
fn what_no_bake_has_put_there_stays() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.cuts");
    let partial = Checkpoint::folder_of(&output);
    for foreign in ["thesis.txt", "chunk-1.bin", "chunk-00000.bin.bak", "source-chunk-abcde.bin"] {
        let checkpoint = created(&output);
        fs::write(partial.join(foreign), "mine").unwrap();
        assert_eq!(checkpoint.remove().unwrap(), Some(partial.join(foreign)), "it is told");
        let again = Checkpoint::create(&output, &Work::All, content(), &settings(), 10, 3, &[0, 1]);
        assert!(
            matches!(again, Err(CheckpointError::Foreign { .. }))
                && Checkpoint::is_left(&Checkpoint::folder_of(&output)).is_err()
        );
        assert_eq!(fs::read_dir(&partial).unwrap().count(), 1, "it stays, and what is ours is gone");
        fs::remove_file(partial.join(foreign)).unwrap();
    }
    fs::create_dir_all(&partial).unwrap();
    fs::write(partial.join(".DS_Store"), "of a file manager").unwrap();
    assert_eq!(created(&output).remove().unwrap(), None);
    assert!(!partial.exists(), "negative control");
    fs::write(&partial, "a file").unwrap();
    assert!(matches!(Checkpoint::is_left(&Checkpoint::folder_of(&output)), Err(CheckpointError::Foreign { .. })));
}

#[cfg(unix)]
#[test]
fn a_link_in_place_of_the_folder_is_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (output, elsewhere) = (folder.path().join("a.cuts"), folder.path().join("elsewhere"));
    fs::create_dir(&elsewhere).unwrap();
    fs::write(elsewhere.join("chunk-00000.bin"), "mine").unwrap();
    std::os::unix::fs::symlink(&elsewhere, Checkpoint::folder_of(&output)).unwrap();
    let refused = Checkpoint::create(&output, &Work::All, content(), &settings(), 10, 3, &[0, 1]);
    assert!(matches!(refused, Err(CheckpointError::Foreign { .. })));
    assert!(elsewhere.join("chunk-00000.bin").exists());
}
