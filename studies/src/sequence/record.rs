//! The JSON file beside the frames that describes each of them. Resuming uses it to check that existing frames belong to the same
//! sequence.

use super::{FrameNames, SequenceFrame, Value};
use crate::{export::settings, terminal::write_json};
use anyhow::{Context, Result};
use lapidary_core::{dataset::Dataset, input};
use lapidary_render::{Look, RenderStats};
use serde::{Deserialize, Serialize};
use serde_json::Map;
use std::{collections::BTreeMap, path::Path};

/// Contents of the file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Width and height of the frames in pixels.
    size: [u32; 2],
    /// All settings of the first frame's picture.
    settings: Map<String, serde_json::Value>,
    /// The frames in order.
    frames: Vec<FrameRecord>,
}

/// Description of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct FrameRecord {
    frame: u32,
    files: Vec<String>,
    /// Varying values.
    values: BTreeMap<String, Value>,
    /// Wall-clock seconds of rendering, once rendered.
    seconds: Option<f64>,
    /// Nodes of the merged cut, averaged over its pixels.
    mean_merged_nodes: Option<f64>,
}

impl Record {
    /// Creates a record of planned frames, none of them rendered.
    pub fn new(frames: &[SequenceFrame], outputs: &[FrameNames], dataset: &Dataset) -> Self {
        let file = |names: &FrameNames, number| {
            names.path(number).file_name().unwrap_or_default().to_string_lossy().into_owned()
        };
        let record = |frame: &SequenceFrame| FrameRecord {
            frame: frame.number,
            files: outputs.iter().map(|names| file(names, frame.number)).collect(),
            values: frame.values.iter().cloned().collect(),
            seconds: None,
            mean_merged_nodes: None,
        };
        let first: Option<&Look> = frames.first().map(|frame| &frame.look);
        Self {
            size: first.map_or([0, 0], |look| look.view.size),
            settings: first.map(|look| settings(look, dataset)).unwrap_or_default(),
            frames: frames.iter().map(record).collect(),
        }
    }

    /// Reads the record of an existing sequence.
    ///
    /// # Errors
    /// An unreadable file, or one that is not a record.
    pub fn read(path: &Path) -> Result<Self> {
        let begun = || format!("cannot determine what the existing frames show; use --overwrite ({})", path.display());
        let text = input::read(path).with_context(begun)?;
        serde_json::from_slice(&text).with_context(begun)
    }

    /// Writes the record.
    ///
    /// # Errors
    /// The file system's error.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_json(path, self)
    }

    /// The difference between two sequences in a word or two; `None` if one continues the other.
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.size != other.size {
            return Some("size".into());
        }
        let names = self.settings.keys().chain(other.settings.keys());
        let mut names = names.filter(|name| self.settings.get(*name) != other.settings.get(*name));
        if let Some(name) = names.next() {
            return Some(name.clone());
        }
        let values = |record: &Self| -> Vec<_> {
            record.frames.iter().map(|frame| (frame.frame, frame.values.clone(), frame.files.clone())).collect()
        };
        (values(self) != values(other)).then(|| "frames, turn or sweep".into())
    }

    /// Takes over another record's data on rendered frames.
    pub fn keep(&mut self, other: &Self) {
        for (frame, known) in self.frames.iter_mut().zip(&other.frames) {
            (frame.seconds, frame.mean_merged_nodes) = (known.seconds, known.mean_merged_nodes);
        }
    }

    /// Marks a frame as rendered.
    pub fn finished(&mut self, index: usize, stats: &RenderStats) {
        let frame = &mut self.frames[index];
        (frame.seconds, frame.mean_merged_nodes) = (Some(stats.seconds), Some(stats.mean_merged_nodes));
    }
}
