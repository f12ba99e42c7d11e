//! Bakes divided among machines.

use super::*;
use crate::{
    errors::{CheckpointError, ShardError},
    shard::Shard,
};
use lapidary_core::camera::Camera;
use lapidary_interchange::image;
use std::fs;

/// Shares of a bake of the interior in three shards.
fn shared(folder: &Path) -> BakeJob {
    let job = indirect_job(folder, "shared.cuts", BakeParts::ALL);
    for shard in Shard::all(3) {
        bake_shard(interior(), &job, shard, None, &Silent).unwrap();
        assert!(shard.folder_of(&job.output).join("shard.json").exists());
    }
    job
}

/// The error of a merge, which changes no file.
fn refusal(output: &Path) -> ShardError {
    let listed = || {
        let entries = fs::read_dir(output.parent().unwrap()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = listed();
    let error = merge(output, image::decode, &Silent).unwrap_err();
    assert_eq!(listed(), before);
    let BakeError::Shard(error) = error else { panic!("{error:?}") };
    assert!(error.to_string().contains("shared.cuts"), "{error}");
    error
}

#[test]
fn merged_shares_are_the_file_of_one_bake() {
    let folder = tempfile::tempdir().unwrap();
    let whole = indirect_job(folder.path(), "whole.cuts", BakeParts::ALL);
    bake(interior(), &whole, &Silent).unwrap();
    let job = shared(folder.path());
    assert!(!job.output.exists());
    merge(&job.output, image::decode, &Silent).unwrap();
    let [whole, merged] = [&whole.output, &job.output].map(|path| fs::read(path).unwrap());
    assert!(whole == merged, "equal bakes are equal files");
    assert!(Shard::all(3).all(|shard| !shard.folder_of(&job.output).exists()), "the shares are removed");
    assert!(matches!(refusal(&job.output), ShardError::NoShares { .. }));
}

#[test]
fn an_interrupted_share_goes_on_and_a_complete_one_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(6), ..job(folder.path(), "shared.cuts") };
    let [first, second] = [1, 2].map(|index| Shard::new(index, 2).unwrap());
    bake_shard(scene(), &job, second, None, &Silent).unwrap();
    let interrupted = bake_shard(scene(), &job, first, None, &CancelIn::phase(Phase::Visibility));
    assert!(matches!(interrupted, Err(BakeError::Cancelled)));
    assert!(matches!(refusal(&job.output), ShardError::Incomplete { shard, .. } if shard == first));
    let chunk = |name: &str| first.folder_of(&job.output).join(name);
    let written = fs::metadata(chunk("chunk-00000.bin")).unwrap().modified().unwrap();
    assert!(!chunk("chunk-00001.bin").exists(), "that is the other's");
    for _ in 0..2 {
        bake_shard(scene(), &job, first, None, &Silent).unwrap();
        assert_eq!(
            fs::metadata(chunk("chunk-00000.bin")).unwrap().modified().unwrap(),
            written,
            "it is not made again"
        );
    }
    let merged = merge(&job.output, image::decode, &Silent).unwrap();
    let whole = bake(scene(), &BakeJob { output: folder.path().join("whole.cuts"), ..job }, &Silent).unwrap();
    assert_eq!(contents(&merged), contents(&whole));
}

#[test]
fn shares_that_do_not_belong_together_are_refused_and_nothing_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let job = shared(folder.path());
    let share = |index| Shard::new(index, 3).unwrap().folder_of(&job.output);
    let aside = folder.path().join("aside");
    fs::rename(share(2), &aside).unwrap();
    let missing = refusal(&job.output);
    assert!(missing.to_string().contains("bake with --shard 2/3"), "{missing}");

    let second = Shard::new(2, 3).unwrap();
    let other = with(job.clone(), |settings| settings.beta = 0.1);
    bake_shard(interior(), &other, second, None, &Silent).unwrap();
    assert!(matches!(refusal(&job.output), ShardError::OfAnother { .. }));
    let again = bake_shard(interior(), &job, second, None, &Silent).unwrap_err().to_string();
    assert!(again.contains("other settings") && again.contains("remove the folder"), "{again}");
    fs::remove_dir_all(share(2)).unwrap();

    copy(&share(3), &share(2));
    assert!(matches!(refusal(&job.output), ShardError::Renamed { .. }), "the third, doubled");
    fs::remove_dir_all(share(2)).unwrap();
    fs::rename(&aside, share(2)).unwrap();

    let chunk = share(2).join("source-chunk-00001.bin");
    let whole = fs::read(&chunk).unwrap();
    fs::write(&chunk, &whole[..whole.len() / 2]).unwrap();
    let damaged = refusal(&job.output);
    assert!(matches!(&damaged, ShardError::Incomplete { path, .. } if *path == chunk), "{damaged}");
    fs::write(&chunk, &whole).unwrap();
    assert!(merge(&job.output, image::decode, &Silent).is_ok(), "negative control");
}

#[test]
fn a_share_that_was_killed_before_it_was_signed_is_merged_and_a_link_is_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let job = shared(folder.path());
    let share = |index| Shard::new(index, 3).unwrap().folder_of(&job.output);
    fs::remove_file(share(3).join("shard.json")).unwrap();
    assert!(matches!(refusal(&job.output), ShardError::Incomplete { .. }));
    bake_shard(interior(), &job, Shard::new(3, 3).unwrap(), None, &Silent).unwrap();

    let busy = OutputLock::acquire(&share(1)).unwrap();
    assert!(matches!(merge(&job.output, image::decode, &Silent), Err(BakeError::Lock(LockError::Held { .. }))));
    drop(busy);
    #[cfg(unix)]
    {
        let elsewhere = folder.path().join("elsewhere");
        fs::rename(share(2), &elsewhere).unwrap();
        std::os::unix::fs::symlink(&elsewhere, share(2)).unwrap();
        assert!(matches!(
            merge(&job.output, image::decode, &Silent),
            Err(BakeError::Checkpoint(CheckpointError::Foreign { .. }))
        ));
        assert!(elsewhere.join("shard.json").exists() && share(1).exists(), "nothing is removed");
        fs::remove_file(share(2)).unwrap();
        fs::rename(&elsewhere, share(2)).unwrap();
    }
    assert!(merge(&job.output, image::decode, &Silent).is_ok(), "negative control");
    assert!(Shard::all(3).all(|shard| !OutputLock::path_of(&shard.folder_of(&job.output)).exists()), "locks are gone");
}

#[test]
fn shares_about_other_sources_are_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let job = searching(indirect_job(folder.path(), "shared.cuts", BakeParts::INDIRECT));
    let at = |eye: Vec3| {
        let mut scene = interior();
        scene.cameras = vec![Camera::look_at(eye, eye + Vec3::Z, 40.0)];
        scene
    };
    for (index, x) in [(1, 0.0), (2, 0.3)] {
        bake_shard(at(Vec3::new(x, 0.1, 0.0)), &job, Shard::new(index, 2).unwrap(), None, &Silent).unwrap();
    }
    assert!(matches!(refusal(&job.output), ShardError::OfAnother { shard, .. } if shard.index() == 2));
}

#[test]
fn a_number_of_chunks_beyond_the_points_is_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { chunks: Some(usize::MAX), ..job(folder.path(), "shared.cuts") };
    for shard in Shard::all(2) {
        bake_shard(scene(), &job, shard, None, &Silent).unwrap();
    }
    let merged = merge(&job.output, image::decode, &Silent).unwrap();
    assert_eq!(contents(&merged), contents(&bake(scene(), &job, &Silent).unwrap()));
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}
