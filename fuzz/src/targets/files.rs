//! Targets of one file, a mutated copy of a valid one.

use super::{Target, named, scenes::datasets};
use crate::{choices::Choices, mutate::Mutation};
use lapidary_core::{brdf::Content, texture::ColorSpace};
use lapidary_interchange::{
    environment,
    image::{self, decode, dimensions, footprint},
};
use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::OnceLock,
};

/// Description of a target of one file.
#[derive(Clone, Copy)]
pub struct FileKind {
    /// See [`Target::name`].
    pub name: &'static str,
    /// See [`Target::share`].
    pub share: u64,
    /// Name of the file.
    pub file: &'static str,
    /// Mutates a valid file.
    pub mutation: Mutation,
    /// Reads the file.
    pub read: fn(&Path) -> Result<(), String>,
}

/// A target of one file. The files of `corpus/beside`, which it may name, are beside it.
pub struct FileTarget {
    kind: FileKind,
    /// Valid files, loaded or made on the first input.
    sound: OnceLock<Vec<Vec<u8>>>,
}

impl FileTarget {
    /// A target of this kind.
    pub fn new(kind: FileKind) -> Self {
        Self { kind, sound: OnceLock::new() }
    }

    /// The files of the folder named after the target. Datasets are baked; bakes use the glTF scenes.
    fn sound(&self) -> &[Vec<u8>] {
        let folder = match self.kind.name {
            "cuts" => return self.sound.get_or_init(datasets),
            "bake" => "gltf",
            name => name,
        };
        self.sound.get_or_init(|| {
            let files = files_in(&corpus(folder)).expect("the corpus lies beside the source");
            files.iter().map(|path| fs::read(path).expect("a file of the corpus")).collect()
        })
    }
}

impl Target for FileTarget {
    fn name(&self) -> &str {
        self.kind.name
    }

    fn share(&self) -> u64 {
        self.kind.share
    }

    fn prepare(&self, folder: &Path) -> io::Result<()> {
        for path in files_in(&corpus("beside"))? {
            fs::copy(&path, folder.join(path.file_name().unwrap_or_default()))?;
        }
        Ok(())
    }

    fn write(&self, choices: &mut Choices, folder: &Path) -> io::Result<()> {
        let mut bytes = choices.of(self.sound()).clone();
        if !choices.are_over() {
            (self.kind.mutation)(&mut bytes, self.sound(), choices);
        }
        fs::write(folder.join(self.kind.file), bytes)
    }

    fn read(&self, folder: &Path) -> Result<(), String> {
        (self.kind.read)(&folder.join(self.kind.file))
    }
}

/// A folder of the corpus.
pub fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name)
}

/// Files of a folder, sorted by name, so that inputs are reproducible.
pub fn files_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    let mut files: Vec<PathBuf> = entries.iter().map(fs::DirEntry::path).filter(|path| path.is_file()).collect();
    files.sort();
    Ok(files)
}

/// Reads a picture in every way: as a texture, as an environment, its size only, and its layers.
pub fn read_picture(path: &Path) -> Result<(), String> {
    let bytes = fs::read(path).map_err(|e| e.to_string())?;
    match footprint(&bytes, path) {
        // Reads it only if it fits: texels as a picture and as an environment, and the decoder's memory.
        Ok(needed) if needed.held.saturating_add(needed.decoding) > crate::MOST_BYTES as u64 / 4 => return Ok(()),
        Ok(_) => {}
        Err(error) => named(&error, path)?,
    }
    match decode(&bytes, path) {
        Ok(texture) => {
            let size = dimensions(path).unwrap_or(texture.size);
            if size != texture.size {
                return Err(format!("the header says {size:?}, the picture has {:?}", texture.size));
            }
        }
        Err(error) => named(&error, path)?,
    }
    match environment::read(path, ColorSpace::Srgb) {
        Ok((environment, _)) if environment.map.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0) => {}
        Ok(_) => return Err("the environment is not finite".into()),
        Err(error) => named(&error, path)?,
    }
    for layer in ["beauty", "normal", "depth"] {
        if let Err(error) = image::read_layer(path, layer) {
            named(&error, path)?;
        }
    }
    Ok(())
}

/// Reads a BRDF file.
pub fn read_brdf(path: &Path) -> Result<(), String> {
    Content::read(path).map(drop).or_else(|error| named(&error, path))
}

/// Reads a session and all files it names.
pub fn read_session(path: &Path) -> Result<(), String> {
    lapidary::check(path, &Default::default()).map(drop).or_else(|error| named(&error, path))
}
