//! Measured BRDFs on the GPU: all tables that materials use, in one buffer.
//!
//! Each begins with a head of 8 words: squared width of its lobe, number of levels, and padding. A head of 8 words for each level follows: entries along its three axes, spread, index of its first word. An entry has two words,
//! three 16-bit floats and padding.

use crate::{
    appearance::Appearance,
    device::{GpuDevice, layout::constants::NO_TABLE, storage},
};
use half::f16;
use lapidary_core::{
    brdf::{BrdfModel, Content, Level, Measured},
    material::Material,
};
use std::sync::Arc;

const HEAD_WORDS: usize = 8;

/// The tables in use.
pub struct GpuMeasured {
    pub buffer: wgpu::Buffer,
    /// Each with its first word.
    tables: Vec<(Arc<Measured>, u32)>,
}

impl GpuMeasured {
    /// Uploads, unless `before` has the same tables. Also returns which have no place, in sentences.
    pub fn new(gpu: &GpuDevice, appearance: &Appearance, before: Option<Self>) -> (Self, Vec<String>) {
        let limit = gpu.max_storage_bytes() / 4;
        let (mut tables, mut messages): (Vec<(Arc<Measured>, u32)>, Vec<String>) = Default::default();
        let mut next = 0;
        for material in &appearance.materials {
            let Some(table) = table_of(material) else { continue };
            let words = words_of(table) as u64;
            if tables.iter().any(|(known, _)| known.hash() == table.hash()) {
                continue;
            }
            if next + words > limit {
                messages.push(format!(
                    "the measured BRDF of the material \"{}\" does not fit into the graphics memory that a scene may use and is \
                     shown in magenta; use fewer different ones",
                    material.name
                ));
                continue;
            }
            tables.push((table.clone(), next as u32));
            next += words;
        }
        if let Some(same) = before.filter(|before| before.has(&tables)) {
            return (same, messages);
        }
        let mut words = Vec::with_capacity(next as usize);
        tables.iter().for_each(|(table, _)| push_table(&mut words, table));
        // A buffer must not be empty.
        words.resize(words.len().max(4), 0);
        (Self { buffer: storage(gpu, "measured", bytemuck::cast_slice(&words)), tables }, messages)
    }

    fn has(&self, tables: &[(Arc<Measured>, u32)]) -> bool {
        let hash = |(table, _): &(Arc<Measured>, u32)| table.hash();
        self.tables.iter().map(hash).eq(tables.iter().map(hash))
    }

    /// First word of a material's table.
    pub fn first_word(&self, material: &Material) -> u32 {
        let of = |table: &Arc<Measured>| self.tables.iter().find(|(known, _)| known.hash() == table.hash());
        table_of(material).and_then(of).map_or(NO_TABLE, |(_, first)| *first)
    }
}

/// The table that a material shows.
fn table_of(material: &Material) -> Option<&Arc<Measured>> {
    let file = material.file.as_ref().filter(|_| material.model == BrdfModel::Merl)?;
    file.content.as_ref().and_then(Content::measured)
}

fn words_of(table: &Measured) -> usize {
    let of_level = |level: &Level| HEAD_WORDS + 2 * level.entries.len();
    HEAD_WORDS + table.levels().iter().map(of_level).sum::<usize>()
}

fn push_table(words: &mut Vec<u32>, table: &Measured) {
    let levels = table.levels();
    words.extend([table.width_sq().to_bits(), levels.len() as u32, 0, 0, 0, 0, 0, 0]);
    let mut first = words.len() + HEAD_WORDS * levels.len();
    for level in levels {
        words.extend(level.size.map(|n| n as u32));
        words.extend([level.spread.to_bits(), first as u32, 0, 0, 0]);
        first += 2 * level.entries.len();
    }
    for entry in levels.iter().flat_map(|level| &level.entries) {
        let [r, g, b] = entry.map(|x| u32::from(f16::from_f32(x).to_bits()));
        words.extend([r | g << 16, b]);
    }
}
