//! Changed work survives its process; saved work leaves nothing behind.

use super::*;
use crate::document::{Edit, EnvironmentSettings, session::load};

const INTERVAL: Duration = Duration::from_secs(30);

struct Setup {
    folder: tempfile::TempDir,
    autosave: Autosave,
    document: Document,
    history: History,
    start: Instant,
}

fn setup() -> Setup {
    let folder = tempfile::tempdir().unwrap();
    let autosave = Autosave::new(&folder.path().join("state"), INTERVAL);
    let document = Document { scene: Some(folder.path().join("a.gltf")), ..Document::empty() };
    Setup { folder, autosave, document, history: History::new(), start: Instant::now() }
}

impl Setup {
    fn turn(&mut self, rotation_degrees: f32) {
        let edit = Edit::Environment(EnvironmentSettings { rotation_degrees, ..Default::default() });
        self.history.apply(&mut self.document, edit, "Rotation");
    }

    fn tick(&mut self, seconds: u64) -> bool {
        let session = self.folder.path().join("work/a.lapidary");
        let now = self.start + Duration::from_secs(seconds);
        self.autosave.tick(now, &self.document, &self.history, &Unknown::default(), Some(&session)).unwrap()
    }

    fn state(&self) -> PathBuf {
        self.folder.path().join("state")
    }

    /// Simulates a crash: the file belongs to a process of this number that began at another time.
    fn crash(&self) -> PathBuf {
        let Process { id, start } = Process::this();
        let orphan = self.state().join(format!("{PREFIX}{id}-{}.{EXTENSION}", start + 1));
        std::fs::rename(&self.autosave.file, &orphan).unwrap();
        orphan
    }
}

#[test]
fn changes_are_written_once_an_interval_and_only_changes() {
    let mut s = setup();
    assert!(!s.tick(0) && !s.tick(100), "nothing changed");
    s.turn(1.0);
    assert!(!s.tick(100) && !s.tick(129));
    assert!(s.tick(130) && !s.tick(200));
    s.turn(2.0);
    assert!(!s.tick(201) && !s.tick(230) && s.tick(231));
    assert_eq!(load(&s.autosave.file).unwrap().session.light.environment.rotation_degrees, 2.0);
}

#[test]
fn saving_undo_and_exit_remove_the_file() {
    let mut s = setup();
    let written = |s: &mut Setup| {
        s.turn(5.0 + s.document.environment.rotation_degrees);
        s.tick(0);
        s.tick(30) && s.autosave.file.is_file()
    };
    assert!(written(&mut s));
    s.history.mark_saved();
    assert!(!s.tick(31) && !s.autosave.file.exists());
    assert!(written(&mut s));
    s.history.undo(&mut s.document);
    assert!(!s.tick(32) && !s.autosave.file.exists());
    assert!(written(&mut s));
    s.autosave.finish().unwrap();
    s.autosave.finish().unwrap();
    assert!(!s.autosave.file.exists());
}

#[test]
fn work_of_a_process_that_is_gone_is_offered_and_that_of_a_running_one_is_not() {
    let mut s = setup();
    assert!(recoverable(&s.state()).is_empty());
    s.turn(7.0);
    s.tick(0);
    assert!(s.tick(30));
    assert!(recoverable(&s.state()).is_empty(), "this process runs");
    let orphan = s.crash();
    if start_of(std::process::id()).is_none() {
        let old = SystemTime::now() - 2 * GONE_AFTER;
        std::fs::File::options().write(true).open(&orphan).unwrap().set_modified(old).unwrap();
    }
    std::fs::write(s.state().join("autosave-1-x.lapidary"), "{}").unwrap();
    std::fs::write(s.state().join("autosave-4000000000-1.lapidary"), "{").unwrap();
    let found = recoverable(&s.state());
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].session_path, Some(s.folder.path().join("work/a.lapidary")));
    assert!(found[0].saved_at.elapsed().is_ok_and(|age| age < Duration::from_secs(60)));
    let loaded = load(&found[0].file).unwrap();
    assert_eq!(loaded.session.scene, Some(s.folder.path().join("a.gltf")), "paths are absolute");
    assert_eq!(loaded.session.light.environment.rotation_degrees, 7.0);
    assert_eq!(loaded.unknown, Unknown::default(), "the note is no part of the session");
    found[0].clone().discard().unwrap();
    assert!(recoverable(&s.state()).is_empty() && !orphan.exists());
}

#[test]
fn a_failed_write_says_so_once_an_interval() {
    let mut s = setup();
    std::fs::write(s.state(), b"a file where the folder should be").unwrap();
    s.turn(1.0);
    let path = None;
    let mut tick = |seconds| {
        let now = s.start + Duration::from_secs(seconds);
        s.autosave.tick(now, &s.document, &s.history, &Unknown::default(), path)
    };
    assert!(tick(0).is_ok());
    assert!(tick(30).is_err_and(|e| e.to_string().contains("permissions")));
    assert!(tick(31).is_ok_and(|written| !written) && tick(60).is_err());
}

#[test]
#[cfg(target_os = "linux")]
fn a_killed_process_does_not_run_even_before_its_parent_takes_note() {
    let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
    let start = start_of(child.id());
    assert!(start.is_some());
    child.kill().unwrap();
    let killed = Instant::now();
    while start_of(child.id()).is_some() {
        assert!(killed.elapsed() < Duration::from_secs(90), "it stays");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Path::new(&format!("/proc/{}/stat", child.id())).exists(), "a zombie is listed");
    child.wait().unwrap();
}

#[test]
fn a_process_on_its_way_out_has_ended() {
    let status =
        |state: &str, flags: u32| format!("7 (a) b) {state} 1 7 7 0 -1 {flags} 9 9 9 9 9 9 9 9 20 0 1 0 4711 9 9");
    assert_eq!(start_in(&status("S", 0x40_0100)), Some(4711));
    assert_eq!(start_in(&status("Z", 0x40_0100)), None);
    assert_eq!(start_in(&status("R", 0x40_0104)), None);
    assert_eq!(start_in("7 (a) R 1"), None);
}

#[test]
#[cfg(unix)]
fn a_link_under_a_name_that_can_be_known_leads_nowhere() {
    let mut s = setup();
    let victim = s.folder.path().join("victim");
    std::fs::write(&victim, "not ours").unwrap();
    std::fs::create_dir(s.state()).unwrap();
    let Process { id, start } = Process::this();
    let link = s.state().join(format!("{PREFIX}{id}-{start}.{EXTENSION}"));
    std::os::unix::fs::symlink(&victim, &link).unwrap();
    s.turn(1.0);
    assert!(!s.tick(0) && s.tick(30) && s.autosave.file.is_file());
    s.autosave.finish().unwrap();
    assert_eq!(std::fs::read_to_string(&victim).unwrap(), "not ours");
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
}
