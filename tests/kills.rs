//! Kills at random times, and two bakes at once: nothing good is lost, and what goes on ends as if nothing had been.
//!
//! `LAPIDARY_KILLS=200` kills as many bakes, and of the other commands a third each.

use crate::common::{Folder, SMALL, files_below, is_same_output, read};
use std::{
    fs,
    process::Stdio,
    time::{Duration, Instant},
};

/// Bakes with a chunk every few milliseconds.
const BAKE: &str =
    "bake scene.obj -o a.cuts --lights 4096 --pilot-clusters 16 --max-vertices 1500 --chunks 40 --progress none";

fn kills() -> u64 {
    std::env::var("LAPIDARY_KILLS").map_or(10, |kills| kills.parse().expect("a number in LAPIDARY_KILLS"))
}

/// Runs a command and kills it at a random time within `secs`. Whether it was killed before it ended.
fn killed(folder: &Folder, options: &str, secs: f64, random: &mut fastrand::Rng) -> bool {
    let mut child = folder.command(options);
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_secs_f64(secs * random.f64()));
    child.kill().expect("a child");
    child.wait().expect("a child").code().is_none()
}

/// Seconds that a command takes, which must succeed.
fn secs_of(folder: &Folder, options: &str) -> f64 {
    let began = Instant::now();
    folder.succeed(options);
    began.elapsed().as_secs_f64()
}

#[test]
fn a_killed_bake_keeps_the_old_dataset_and_resumes_to_the_same_bytes() {
    let folder = Folder::new();
    let secs = secs_of(&folder, BAKE);
    let right = read(&folder.path("a.cuts"));
    let mut random = fastrand::Rng::with_seed(29);
    let (mut early, mut resumed) = (0, 0);
    for kill in 0..kills() {
        fs::write(folder.path("a.cuts"), "an older dataset").expect("a writable folder");
        early += usize::from(killed(&folder, BAKE, secs, &mut random));
        let kept = read(&folder.path("a.cuts"));
        assert!(kept == b"an older dataset" || kept == right, "kill {kill} left neither the old nor the new dataset");
        resumed += usize::from(folder.path("a.cuts.partial/chunk-00000.bin").exists());
        folder.succeed(&format!("{BAKE} --resume"));
        assert!(read(&folder.path("a.cuts")) == right, "kill {kill} changed the dataset");
        assert!(!folder.path("a.cuts.partial").exists());
    }
    assert!(early > 0 && resumed > 0, "{early} were killed before the end, {resumed} had a chunk");
}

#[test]
fn a_killed_render_or_export_leaves_whole_files_and_runs_again() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    for options in [
        "render a.cuts --size 160x120 --out render/a.exr --out render/a.png",
        "export a.cuts --mitsuba export --env studio",
    ] {
        let out = folder.path(&options[..6]);
        fs::create_dir(&out).expect("a writable folder");
        let secs = secs_of(&folder, options);
        let right = files_below(&out);
        let mut random = fastrand::Rng::with_seed(29);
        for kill in 0..(kills() / 3).max(1) {
            fs::remove_dir_all(&out).and_then(|()| fs::create_dir(&out)).expect("a writable folder");
            let old: Vec<String> = right.keys().filter(|name| !name.contains('/')).cloned().collect();
            old.iter().for_each(|name| fs::write(out.join(name), "old").expect("a writable folder"));
            killed(&folder, options, secs, &mut random);
            // A killed process leaves what it was about to write, and its lock.
            let is_left = |name: &str| name.contains(".lapidary-") || name.ends_with(".lock");
            for (name, contents) in files_below(&out).iter().filter(|(name, _)| !is_left(name)) {
                assert!(
                    contents == b"old" || is_same_output(name, contents, &right[name]),
                    "kill {kill} of {options} broke {name}"
                );
            }
            folder.succeed(options);
            let again = files_below(&out);
            assert!(
                right.iter().all(|(name, contents)| is_same_output(name, contents, &again[name])),
                "kill {kill} of {options}"
            );
        }
    }
}

/// A process that stands still, so that it cannot end before the test goes on. None is left behind.
#[cfg(unix)]
struct Halted(std::process::Child);

#[cfg(unix)]
impl Halted {
    fn signal(&self, signal: &str) {
        let mut kill = std::process::Command::new("kill");
        let status = kill.args([signal, &self.0.id().to_string()]).status().expect("kill starts");
        assert!(status.success(), "kill {signal}");
    }

    fn new(child: std::process::Child) -> Self {
        let halted = Self(child);
        halted.signal("-STOP");
        halted
    }

    /// Lets it go on to its end. Whether it ends well.
    fn finish(mut self) -> bool {
        self.signal("-CONT");
        self.0.wait().expect("a child").success()
    }
}

#[cfg(unix)]
impl Drop for Halted {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

#[test]
#[cfg(unix)]
fn of_two_bakes_to_one_output_one_is_refused_and_the_other_is_right() {
    let folder = Folder::new();
    let other = BAKE.replace("--lights 4096", "--lights 2048");
    folder.succeed(BAKE);
    let right = read(&folder.path("a.cuts"));
    let mut first = folder.command(BAKE).stderr(Stdio::null()).spawn().expect("the program starts");
    let lock = folder.path("a.cuts.lock");
    let chunk = folder.path("a.cuts.partial/chunk-00000.bin");
    while !(lock.exists() && chunk.exists()) {
        assert!(first.try_wait().expect("a child").is_none(), "the bake ended before the other began");
        std::thread::sleep(Duration::from_millis(1));
    }
    let first = Halted::new(first);
    assert!(lock.exists() && chunk.exists(), "the bake ended before the other began");
    let refused = folder.fail(&other);
    assert!(refused.contains(&first.0.id().to_string()) && refused.contains("a.cuts"), "{refused}");
    assert!(first.finish());
    assert!(read(&folder.path("a.cuts")) == right, "the bake that went on");
    folder.succeed(&other);
    assert!(read(&folder.path("a.cuts")) != right, "negative control: other settings, another dataset");
}

#[test]
fn the_lock_of_a_killed_bake_is_taken_over() {
    let folder = Folder::new();
    let mut first = folder.command(BAKE).stderr(Stdio::null()).spawn().expect("the program starts");
    while !folder.path("a.cuts.lock").exists() {
        assert!(first.try_wait().expect("a child").is_none(), "the bake ended before it was killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    first.kill().expect("a child");
    first.wait().expect("a child");
    assert!(folder.path("a.cuts.lock").exists(), "it is left behind");
    folder.succeed(&format!("bake scene.obj -o a.cuts {SMALL}"));
}
