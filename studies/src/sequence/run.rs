//! Renders planned frames one by one to files, each under a temporary name until complete. Finished frames survive any interruption
//! and can be resumed from.

use super::{FrameNames, SequenceFrame, record::Record};
use crate::{
    export::{Finished, LayerKind, Studio},
    outputs::{CommandFiles, create_folder},
    sheet::{DisplayPicture, SheetStyle, Tile, contact_sheet},
    terminal::Interrupted,
};
use anyhow::{Context, Result, bail};
use lapidary_core::{dataset::Dataset, input, lock::OutputLock, output::folder_of, texture::Texels};
use lapidary_interchange::image::{self, decode};
use lapidary_render::{Post, Progress};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// Longest side in pixels of a frame in a contact sheet.
const TILE: u32 = 240;

/// Treatment of existing frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Stop if any exists.
    #[default]
    Refuse,
    /// Keep them and render the others.
    Resume,
    /// Replace them.
    Overwrite,
}

/// A contact sheet of all frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetTask {
    /// The png file.
    pub path: PathBuf,
    /// Frames per row; by default about as many as rows.
    pub columns: Option<usize>,
}

/// A sequence to render.
#[derive(Clone, Debug)]
pub struct SequenceTask {
    /// Its frames.
    pub frames: Vec<SequenceFrame>,
    /// File names in each format.
    pub outputs: Vec<FrameNames>,
    /// Layers of exr files.
    pub layers: Vec<LayerKind>,
    /// Treatment of existing frames.
    pub existing: Existing,
    /// A contact sheet, if wanted.
    pub sheet: Option<SheetTask>,
}

/// A checked sequence. No other process writes its files until it is dropped.
#[derive(Debug)]
pub struct Prepared {
    record: Record,
    _locks: Vec<OutputLock>,
}

/// The end of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SequenceEnd {
    /// Rendered frames.
    pub rendered: usize,
    /// Existing frames that were kept.
    pub kept: usize,
    /// Whether it stopped early.
    pub cancelled: bool,
}

/// Adds a sequence's files to `files`.
pub fn sequence_files(
    files: CommandFiles,
    outputs: &[FrameNames],
    numbers: impl Iterator<Item = u32> + Clone,
    existing: Existing,
    sheet: Option<&Path>,
) -> CommandFiles {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let frames = |files: CommandFiles, names: &FrameNames| {
        let frames = numbers.clone().map(|number| name(&names.path(number)));
        match existing {
            Existing::Resume => files.completes(names.folder(), frames),
            Existing::Refuse | Existing::Overwrite => files.fills(names.folder(), frames),
        }
    };
    let files = outputs.iter().fold(files, frames);
    let others = outputs.first().map(FrameNames::record_path).into_iter().chain(sheet.map(Path::to_path_buf));
    others.fold(files, |files, path| files.fills(folder_of(&path), [name(&path)]))
}

impl SequenceTask {
    /// Adds the files that it writes to `files`.
    pub fn command_files(&self, files: CommandFiles) -> CommandFiles {
        let numbers = self.frames.iter().map(|frame| frame.number);
        let sheet = self.sheet.as_ref().map(|sheet| sheet.path.as_path());
        sequence_files(files, &self.outputs, numbers, self.existing, sheet)
    }

    /// Checks folders and existing files before anything slow, and locks the files for this process.
    ///
    /// # Errors
    /// Folders that cannot be created or written; existing frames that may not be replaced or belong to another sequence.
    pub fn prepare(&self, dataset: &Dataset) -> Result<Prepared> {
        for folder in self.folders() {
            create_folder(folder)?;
        }
        let locks = self.lock()?;
        let mut record = Record::new(&self.frames, &self.outputs, dataset);
        let there = self.frames.iter().filter(|frame| self.files(frame).iter().any(|file| file.exists())).count();
        match self.existing {
            Existing::Refuse if there > 0 => bail!(
                "{there} of the {} frames are there already; use --resume to render the others, --overwrite to replace them, \
                 or another name ({})",
                self.frames.len(),
                self.outputs[0].folder().display()
            ),
            Existing::Resume if there > 0 => {
                let begun = Record::read(&self.record_path())?;
                if let Some(what) = record.difference(&begun) {
                    bail!(
                        "the existing frames belong to another sequence: their {what} differs; use --overwrite to replace \
                         them, or another name ({})",
                        self.record_path().display()
                    );
                }
                record.keep(&begun);
            }
            _ => {}
        }
        Ok(Prepared { record, _locks: locks })
    }

    /// Renders the missing frames after [`Self::prepare`]. `progress` counts frames, including existing ones.
    ///
    /// # Errors
    /// A failing renderer, or unwritable files; earlier frames are kept.
    pub fn run(&self, prepared: Prepared, studio: &mut Studio, progress: &dyn Progress) -> Result<SequenceEnd> {
        let dataset = studio.baked().dataset.clone();
        let Prepared { mut record, _locks } = prepared;
        let mut end = SequenceEnd { rendered: 0, kept: 0, cancelled: false };
        let mut tiles = Vec::new();
        record.write(&self.record_path())?;
        let all = self.frames.len() as u64;
        // Existing frames first: from then on the progress shows the pace.
        let mut done = self.frames.iter().filter(|frame| self.is_there(frame)).count() as u64;
        for (index, frame) in self.frames.iter().enumerate() {
            progress.advanced(done, all);
            if self.is_there(frame) {
                end.kept += 1;
                tiles.extend(self.sheet.as_ref().map(|_| self.read_tile(frame)).transpose()?);
                continue;
            }
            let look = frame.posed().with_context(|| self.so_far(end))?;
            let finished = match Finished::take(studio, &look, &self.layers, &|| progress.cancelled()) {
                Err(error) if error.is::<Interrupted>() => {
                    end.cancelled = true;
                    return Ok(end);
                }
                finished => finished?,
            };
            tiles.extend(self.sheet.as_ref().map(|_| tile(frame, &finished.taken.shown)));
            record.finished(index, &finished.taken.stats);
            finished.write(&look, &dataset, &self.files(frame)).with_context(|| self.so_far(end))?;
            record.write(&self.record_path())?;
            end.rendered += 1;
            done += 1;
        }
        progress.advanced(all, all);
        self.write_sheet(&tiles)?;
        Ok(end)
    }

    /// Locks the records of all formats, each in its folder, and the sheet.
    fn lock(&self) -> Result<Vec<OutputLock>> {
        let records = self.outputs.iter().map(FrameNames::record_path);
        let files = records.chain(self.sheet.iter().map(|sheet| sheet.path.clone()));
        // Two formats in one folder share one record, under any name of the folder.
        let place = |file: PathBuf| Ok(folder_of(&file).canonicalize()?.join(file.file_name().unwrap_or_default()));
        let places = files.map(place).collect::<Result<BTreeSet<PathBuf>>>()?;
        places.iter().map(|place| Ok(OutputLock::acquire(place)?)).collect()
    }

    fn so_far(&self, end: SequenceEnd) -> String {
        let done = end.rendered + end.kept;
        format!("{done} of {} frames are written and kept; --resume continues", self.frames.len())
    }

    /// Path of the record.
    pub fn record_path(&self) -> PathBuf {
        self.outputs[0].record_path()
    }

    fn folders(&self) -> impl Iterator<Item = &Path> {
        let sheet = self.sheet.iter().filter_map(|sheet| sheet.path.parent());
        self.outputs.iter().map(FrameNames::folder).chain(sheet.filter(|folder| !folder.as_os_str().is_empty()))
    }

    fn files(&self, frame: &SequenceFrame) -> Vec<PathBuf> {
        self.outputs.iter().map(|names| names.path(frame.number)).collect()
    }

    /// Whether a frame exists in all formats and is kept.
    fn is_there(&self, frame: &SequenceFrame) -> bool {
        self.existing == Existing::Resume && self.files(frame).iter().all(|file| file.exists())
    }

    /// Reads an existing frame.
    fn read_tile(&self, frame: &SequenceFrame) -> Result<Tile> {
        let files = self.files(frame);
        let is_png = |file: &&PathBuf| file.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        let shown = match files.iter().find(is_png) {
            Some(file) => read_png(file)?,
            None => DisplayPicture::shown(&image::read(&files[0])?, &frame.look.post),
        };
        Ok(tile(frame, &shown))
    }

    fn write_sheet(&self, tiles: &[Tile]) -> Result<()> {
        let Some(SheetTask { path, columns }) = &self.sheet else { return Ok(()) };
        let columns = columns.unwrap_or((tiles.len() as f64).sqrt().ceil() as usize);
        contact_sheet(tiles, columns, &SheetStyle::default()).write_png(path)
    }
}

fn tile(frame: &SequenceFrame, shown: &DisplayPicture) -> Tile {
    Tile { image: shown.shrunk(TILE), caption: frame.caption() }
}

fn read_png(path: &Path) -> Result<DisplayPicture> {
    let unreadable = || format!("cannot read a frame that was rendered before; remove it ({})", path.display());
    let texture = decode(&input::read(path).with_context(unreadable)?, path).with_context(unreadable)?;
    match texture.texels {
        Texels::U8(pixels) => Ok(DisplayPicture { size: texture.size, pixels }),
        Texels::U16(pixels) => {
            let code = |code: u16| ((u32::from(code) + 128) / 257) as u8;
            let pixels = pixels.into_iter().map(|pixel| pixel.map(code)).collect();
            Ok(DisplayPicture { size: texture.size, pixels })
        }
        Texels::F32(_) | Texels::Wide { .. } => Ok(DisplayPicture::shown(&image::read(path)?, &Post::default())),
    }
}

#[cfg(test)]
mod tests;
