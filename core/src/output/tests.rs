use super::*;

fn message(path: &Path, inputs: &[&Path]) -> String {
    check_output(path, inputs).unwrap_err().to_string()
}

#[test]
fn a_folder_is_writable_if_files_can_be_made_in_it_and_none_stays() {
    let folder = tempfile::tempdir().unwrap();
    check_writable(folder.path()).unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let missing = check_writable(&folder.path().join("missing")).unwrap_err();
    assert!(missing.to_string().contains("no folder") && missing.to_string().contains("missing"), "{missing}");
    #[cfg(target_os = "linux")]
    assert!(check_writable(Path::new("/proc")).is_err(), "it is there and takes no files, whoever asks");
}

#[test]
fn a_failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("old");
    write_atomically(&target, b"old").unwrap();
    let below = write_atomically(&target.join("below-a-file"), b"new").unwrap_err();
    assert_eq!(below.kind(), io::ErrorKind::NotADirectory);
    fs::create_dir(folder.path().join("folder")).unwrap();
    let replaced = write_atomically(&folder.path().join("folder"), b"new").unwrap_err();
    assert_eq!(replaced.kind(), io::ErrorKind::IsADirectory);
    assert_eq!(fs::read(&target).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    write_atomically(&target, b"new").unwrap();
    assert_eq!(fs::read(&target).unwrap(), b"new");
}

#[test]
fn an_output_is_a_new_file_or_an_old_one_that_is_no_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("input"), b"in").unwrap();
    fs::write(path("old"), b"old").unwrap();
    fs::hard_link(path("input"), path("other name")).unwrap();
    let inputs = [path("input"), path("not there")];
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    for good in ["old", "new"] {
        check_output(&path(good), &inputs).unwrap();
    }
    for bad in ["input", "./input", "other name"] {
        assert!(message(&path(bad), &inputs).contains("over an input"), "{bad}");
    }
    assert_eq!(fs::read(path("input")).unwrap(), b"in");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left behind");
}

#[test]
fn two_names_of_one_place_are_the_same_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("inner")).unwrap();
    assert!(is_same_output(&path("a"), &path("inner/../a")), "where nothing is yet");
    assert!(!is_same_output(&path("a"), &path("b")) && !is_same_output(&path("a"), &path("inner/a")));
    fs::write(path("a"), b"").unwrap();
    fs::hard_link(path("a"), path("b")).unwrap();
    assert!(is_same_output(&path("a"), &path("b")));
}

#[test]
fn folders_and_names_without_a_file_are_no_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("inner")).unwrap();
    fs::write(path("file"), b"").unwrap();
    assert!(message(&path("inner"), &[]).contains("a folder"));
    for none in ["", "..", "inner/", "new/"] {
        let text = check_output(Path::new(none), &[]).unwrap_err().to_string();
        assert!(text.contains("name of a file"), "{none}: {text}");
    }
    assert!(message(&path("missing/a"), &[]).contains("no folder"));
    assert!(message(&path(&"x".repeat(300)), &[]).contains("xxx"), "a name that the file system does not take");
    check_output(&path("file/below"), &[]).unwrap_err();
}

#[test]
fn a_file_that_is_read_only_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("kept");
    fs::write(&file, b"old").unwrap();
    let mut permissions = fs::metadata(&file).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&file, permissions).unwrap();
    assert!(message(&file, &[]).contains("read-only"));
}

#[test]
#[cfg(unix)]
fn links_pipes_and_sockets_stay_what_they_are() {
    use std::{
        os::unix::{
            fs::{FileTypeExt, symlink},
            net::UnixListener,
        },
        process::Command,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("target"), b"old").unwrap();
    symlink(path("target"), path("link")).unwrap();
    symlink(path("nowhere"), path("dangling")).unwrap();
    assert!(Command::new("mkfifo").arg(path("fifo")).status().unwrap().success());
    let _socket = UnixListener::bind(path("socket")).unwrap();
    for (name, word) in
        [("link", "symbolic link"), ("dangling", "symbolic link"), ("fifo", "a pipe"), ("socket", "a socket")]
    {
        for text in [message(&path(name), &[]), write_atomically(&path(name), b"new").unwrap_err().to_string()] {
            assert!(text.contains(word) && text.contains("choose another name"), "{name}: {text}");
        }
    }
    assert_eq!(fs::read(path("target")).unwrap(), b"old");
    assert!(fs::symlink_metadata(path("link")).unwrap().is_symlink() && !path("nowhere").exists());
    assert!(fs::symlink_metadata(path("fifo")).unwrap().file_type().is_fifo());
    // A pipe as input is not opened.
    check_output(&path("target"), &[&path("fifo")]).unwrap();
}

/// Only checks: a test run as root could replace it.
#[test]
#[cfg(target_os = "linux")]
fn devices_are_no_outputs() {
    assert!(message(Path::new("/dev/full"), &[]).contains("a device"));
}
