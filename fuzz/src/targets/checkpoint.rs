//! Checkpoints: an interrupted bake is resumed from changed, swapped, duplicated or lost files.

use super::{
    Target,
    files::files_in,
    named,
    scenes::{sound, tiny_bake},
};
use crate::{
    choices::Choices,
    mutate::{self, json, tensors, text},
};
use lapidary_core::dataset::BakeParts;
use lapidary_precompute::{BakeJob, Event, Observer, Phase, Silent, bake};
use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::{Mutex, OnceLock},
};

/// Resumes a bake of all parts.
#[derive(Default)]
pub struct Checkpoint(OnceLock<Sound>);

/// An interrupted bake and its correct result.
struct Sound {
    /// Names and contents of the checkpoint's files once all chunks are done.
    files: Vec<(String, Vec<u8>)>,
    /// Tensors of the uninterrupted bake.
    tensors: Vec<u8>,
}

const OUTPUT: &str = "input.cuts";
const FOLDER: &str = "input.cuts.partial";

impl Sound {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let copies = CopiesInTheEnd { folder: folder.path().join(FOLDER), files: Mutex::default() };
        bake(sound(), &job(folder.path(), false), &copies).expect("a bake");
        let tensors = tensors_in(&folder.path().join(OUTPUT)).expect("a dataset");
        Self { files: copies.files.into_inner().expect("no thread panics with it"), tensors }
    }
}

fn job(folder: &Path, resume: bool) -> BakeJob {
    BakeJob { chunks: Some(4), resume, ..BakeJob::new(tiny_bake(BakeParts::ALL), folder.join(OUTPUT)) }
}

fn tensors_in(file: &Path) -> Option<Vec<u8>> {
    tensors::tensors_of(&fs::read(file).ok()?)
}

impl Target for Checkpoint {
    fn name(&self) -> &str {
        "checkpoint"
    }

    fn share(&self) -> u64 {
        1
    }

    fn prepare(&self, _folder: &Path) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, choices: &mut Choices, folder: &Path) -> io::Result<()> {
        let mut files = self.0.get_or_init(Sound::new).files.clone();
        let mut forged = false;
        if !choices.are_over() {
            mutate::repeatedly(choices, |choices| forged |= mutate(&mut files, choices));
        }
        for name in [FOLDER, OUTPUT, FORGED] {
            let path = folder.join(name);
            if path.is_dir() {
                fs::remove_dir_all(&path)?
            } else if path.exists() {
                fs::remove_file(&path)?
            }
        }
        if forged {
            fs::write(folder.join(FORGED), "")?;
        }
        let folder = folder.join(FOLDER);
        fs::create_dir(&folder)?;
        files.iter().try_for_each(|(name, bytes)| fs::write(folder.join(name), bytes))
    }

    /// A resumed bake ends with the tensors of an uninterrupted one, or with an error that names the checkpoint. With
    /// forged files the dataset only has to be valid, like every written dataset.
    fn read(&self, folder: &Path) -> Result<(), String> {
        let right = &self.0.get_or_init(Sound::new).tensors;
        match bake(sound(), &job(folder, true), &Silent) {
            Ok(_) if tensors_in(&folder.join(OUTPUT)).as_ref() == Some(right) => Ok(()),
            Ok(_) if folder.join(FORGED).exists() => Ok(()),
            Ok(_) => Err("the resumed bake differs from one that was not interrupted".into()),
            Err(error) => named(&error, &folder.join(FOLDER)),
        }
    }
}

/// Copies the checkpoint once all chunks are done, before its removal.
struct CopiesInTheEnd {
    folder: PathBuf,
    files: Mutex<Vec<(String, Vec<u8>)>>,
}

impl Observer for CopiesInTheEnd {
    fn event(&self, event: Event) {
        if matches!(event, Event::Started { phase: Phase::Pack, .. }) {
            let file = |path: &PathBuf| {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                (name, fs::read(path).expect("a file of the checkpoint"))
            };
            let paths = files_in(&self.folder).expect("a checkpoint");
            *self.files.lock().expect("no thread panics with it") = paths.iter().map(file).collect();
        }
    }
}

/// Name of a file with a valid checksum over contents that no bake has written. Its result cannot be right.
const FORGED: &str = "forged";

/// Bytes of a chunk's file before its body: three hashes; the first covers the rest.
const HEAD: usize = 96;

/// Mutates one file or mixes two. Returns whether any forged contents got a valid checksum.
fn mutate(files: &mut Vec<(String, Vec<u8>)>, choices: &mut Choices) -> bool {
    if files.is_empty() {
        return false;
    }
    let (at, other) = (choices.below(files.len()), choices.below(files.len()));
    let manifest = files.iter().position(|(name, _)| name == "bake.json").unwrap_or(at);
    let kind = choices.below(10);
    match kind {
        0 => drop(files.remove(at)),
        1 => files[at].1 = files[other].1.clone(),
        2 => {
            let (a, b) = (files[at].1.clone(), files[other].1.clone());
            (files[at].1, files[other].1) = (b, a);
        }
        3 | 4 => {
            let donor = files[other].1.clone();
            mutate::bytes(&mut files[at].1, &[donor], choices);
        }
        5 | 6 => json::json(&mut files[manifest].1, &[], choices),
        7 => forge_manifest(&mut files[manifest].1, choices),
        _ => forge_chunk(&mut files[at].1, choices),
    }
    kind >= 7
}

fn forge_manifest(bytes: &mut Vec<u8>, choices: &mut Choices) {
    let mark = b"\"manifest\":";
    let Some(at) = bytes.windows(mark.len()).position(|window| window == mark) else { return };
    let mut manifest = bytes[at + mark.len()..bytes.len() - 1].to_vec();
    text::text(&mut manifest, &[], choices);
    let checksum = blake3::hash(&manifest).to_hex();
    *bytes = [format!("{{\"checksum\":\"{checksum}\",\"manifest\":").as_bytes(), &manifest, b"}"].concat();
}

fn forge_chunk(bytes: &mut Vec<u8>, choices: &mut Choices) {
    if bytes.len() < HEAD {
        return;
    }
    let mut body = bytes.split_off(HEAD);
    mutate::bytes(&mut body, &[], choices);
    let rest = [&bytes[32..], &body].concat();
    *bytes = [blake3::hash(&rest).as_bytes(), &rest[..]].concat();
}
