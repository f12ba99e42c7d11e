//! Writes the pictures of materials, as imported, to a folder beside the file that names them.

use super::error::ExportError;
use crate::{
    file_format::FileFormat,
    image::{PictureFormat, split},
    material_file::{MaterialFile, SlotFile},
};
use lapidary_core::{material::Material, output::write_atomically, texture::Texture};
use std::{
    collections::{BTreeSet, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

/// A folder of pictures, each written once.
pub struct PictureFolder<'a> {
    folder: PathBuf,
    textures: &'a [Arc<Texture>],
    /// Names of the written pictures by texture.
    names: HashMap<u32, Option<String>>,
    taken: BTreeSet<String>,
    /// The written files.
    pub files: Vec<PathBuf>,
    /// Missing pictures, in sentences.
    pub remarks: Vec<String>,
}

impl<'a> PictureFolder<'a> {
    /// A folder for the file at `path`.
    pub fn beside(path: &Path, textures: &'a [Arc<Texture>]) -> Self {
        Self {
            folder: pictures_beside(path),
            textures,
            names: HashMap::new(),
            taken: BTreeSet::new(),
            files: Vec::new(),
            remarks: Vec::new(),
        }
    }

    /// The material with maps that name pictures. Maps with missing pictures are left out.
    pub fn material(&mut self, material: &Material) -> Result<MaterialFile, ExportError> {
        let mut maps = material.maps.filter_map(|slot| Some((slot.clone(), None::<String>)));
        for (slot, name) in maps.slots_mut() {
            *name = self.picture(slot.texture)?;
        }
        Ok(material.with_maps(maps.filter_map(|(slot, name)| Some(SlotFile::of(slot, name.clone()?)))))
    }

    /// The name of a texture's picture, relative to the file beside the folder. Writes the picture on first use.
    fn picture(&mut self, texture: u32) -> Result<Option<String>, ExportError> {
        if let Some(known) = self.names.get(&texture) {
            return Ok(known.clone());
        }
        let name = match self.textures.get(texture as usize) {
            Some(texture) if !texture.encoded.is_empty() => Some(self.write(texture)?),
            Some(texture) => {
                self.remarks.push(format!("the picture \"{}\" was missing, and its maps are left out", texture.name));
                None
            }
            None => None,
        };
        self.names.insert(texture, name.clone());
        Ok(name)
    }

    fn write(&mut self, texture: &Texture) -> Result<String, ExportError> {
        let file = self.name_of(texture);
        let path = self.folder.join(&file);
        std::fs::create_dir_all(&self.folder).map_err(ExportError::write(&self.folder))?;
        write_atomically(&path, &texture.encoded).map_err(ExportError::write(&path))?;
        self.files.push(path);
        let folder = self.folder.file_name().unwrap_or_default().to_string_lossy();
        Ok(format!("{folder}/{file}"))
    }

    /// A unique portable name, with the extension of the picture's format.
    fn name_of(&mut self, texture: &Texture) -> String {
        let (file, layer) = split(&texture.name).unwrap_or((&texture.name, ""));
        let last = file.rsplit(['/', '\\']).next().unwrap_or_default();
        let extension = PictureFormat::ending_of(&texture.encoded);
        let is_picture = PictureFormat::of(Path::new(last)).is_some();
        let stem = last.rsplit_once('.').filter(|_| is_picture).map_or(last, |(stem, _)| stem);
        let letter = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let separator = if layer.is_empty() { "" } else { "_" };
        let stem: String = [stem, separator, layer].concat().chars().map(letter).take(80).collect();
        let stem = stem.trim_start_matches('.');
        let stem = if stem.is_empty() { "picture" } else { stem };
        let mut name = format!("{stem}.{extension}");
        let mut count = 1;
        // Some file systems ignore case.
        while !self.taken.insert(name.to_lowercase()) {
            count += 1;
            name = format!("{stem}-{count}.{extension}");
        }
        name
    }
}

/// The folder beside a material file for its pictures.
pub fn pictures_beside(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-maps"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_is_in_the_name_of_its_file() {
        let mut folder = PictureFolder::beside(Path::new("a.mtlx"), &[]);
        let mut name = |name: &str| {
            let encoded = [0x76, 0x2f, 0x31, 0x01].as_slice().into();
            folder.name_of(&Texture { encoded, ..Texture::missing(name) })
        };
        assert_eq!(["b/wood.exr#View.N/1", "wood.exr"].map(&mut name), ["wood_View.N_1.exr", "wood.exr"]);
    }
}
