//! Visibility cuts on the GPU, from the bins of the leaves beside vertices.

use super::{
    GpuImplicit,
    forest::{GpuForest, cos_sin},
    vertices::LeavesBeside,
};
#[cfg(test)]
use crate::device::{GpuDevice, readback::read_range};
use crate::{
    device::{
        buffers::{storage, uniform, written},
        kernels::{CountedOthers, SkyBeside, WrittenOthers},
        layout::{
            CutUniforms, CutVertex,
            constants::{MOST_DIRECTIONS, MOVED},
        },
        readback::read_word,
    },
    error::BackendError,
};
use bytemuck::{bytes_of, cast_slice};
use glam::Vec3;
#[cfg(test)]
use lapidary_core::cut::packed::NODES_PER_TEXEL;
use lapidary_core::cut::packed::{TEXEL_BYTES, TEXTURE_WIDTH};
use std::ops::Range;

/// Fewest directions that a cut may be selected from: four are packed in a word.
const FEWEST_DIRECTIONS: usize = 4;

/// What stays of the cuts while a scene is posed.
pub struct CutTables {
    directions: wgpu::Buffer,
    count: usize,
}

/// What a pose asks of the cuts.
pub struct CutRequest<'a> {
    pub beside: &'a LeavesBeside,
    /// Vertices that get cuts, and whether they moved.
    pub vertices: &'a [(u32, bool)],
    /// Open share of each leaf, 0 to 1; it does not count for vertices that moved.
    pub open: &'a [f32],
    /// See [`lapidary_core::cut::CutCriterion::least_split`], by depth.
    pub least: &'a [u64],
    /// Texels of the cuts that are stored.
    pub stored_texels: u32,
}

/// Visibility cuts of some vertices, made on a device in place of those that are stored.
#[derive(Clone, Debug)]
pub struct DeviceCuts {
    /// Vertices in ascending order.
    pub(crate) vertices: Vec<u32>,
    pub(crate) cut_vertices: wgpu::Buffer,
    /// First texel of each.
    pub(crate) starts: wgpu::Buffer,
    /// The number of nodes of each, from the second word on.
    pub(crate) counts: wgpu::Buffer,
    /// Whole rows of texels.
    pub(crate) texels: wgpu::Buffer,
    /// First of these rows in the texture of all cuts.
    pub(crate) first_row: u32,
    pub(crate) rows: u32,
}

impl DeviceCuts {
    /// The cut of each vertex.
    #[cfg(test)]
    pub fn read(&self, gpu: &GpuDevice) -> Result<Vec<(u32, Vec<u16>)>, BackendError> {
        let count = self.vertices.len();
        let starts: Vec<u32> = read_range(gpu, &self.starts, 0..count)?;
        let counts: Vec<u32> = read_range(gpu, &self.counts, 1..count + 1)?;
        let row = TEXTURE_WIDTH * NODES_PER_TEXEL;
        let nodes: Vec<u16> = read_range(gpu, &self.texels, 0..self.rows as usize * row)?;
        let cut = |((&vertex, &start), &count): ((&u32, &u32), &u32)| {
            let first = start as usize * NODES_PER_TEXEL - self.first_row as usize * row;
            (vertex, nodes[first..first + count as usize].to_vec())
        };
        Ok(self.vertices.iter().zip(&starts).zip(&counts).map(cut).collect())
    }
}

impl GpuForest {
    /// Takes the directions at the leaves of a tree.
    pub fn cut_tables(&self, directions: &[Vec3]) -> CutTables {
        let wide: Vec<[f32; 4]> = directions.iter().map(|direction| direction.extend(0.0).to_array()).collect();
        CutTables {
            directions: storage(&self.on.gpu, "directions of cuts", cast_slice(&wide)),
            count: directions.len(),
        }
    }

    /// Whether cuts can be selected from so many directions.
    pub fn takes_directions(count: usize) -> bool {
        (FEWEST_DIRECTIONS..=MOST_DIRECTIONS).contains(&count)
    }

    /// Cuts of some vertices, by what the leaves beside them saw at the last walk. `None` if there is no room for them.
    ///
    /// # Errors
    /// A lost device.
    pub fn cuts(&self, tables: &CutTables, asked: &CutRequest) -> Result<Option<DeviceCuts>, BackendError> {
        let (GpuImplicit { gpu, kernels }, count) = (&self.on, asked.vertices.len() as u32);
        let first_row = asked.stored_texels.div_ceil(TEXTURE_WIDTH as u32);
        let first_texel = first_row * TEXTURE_WIDTH as u32;
        let uniforms = uniform(gpu, "cuts of vertices", bytes_of(&self.cut_uniforms(tables, asked.least, first_texel)));
        let cut_vertex = |&(vertex, moved): &(u32, bool)| {
            let Range { start: first, end } = asked.beside.of(vertex);
            CutVertex { number: vertex | if moved { MOVED } else { 0 }, first, end }
        };
        let cut_vertices: Vec<CutVertex> = asked.vertices.iter().map(cut_vertex).collect();
        let cut_vertices = storage(gpu, "vertices that get cuts", cast_slice(&cut_vertices));
        let open = storage(gpu, "open leaves", cast_slice(asked.open));
        let [starts, counts] = [count, count + 1].map(|words| written(gpu, "cuts of vertices", 4 * u64::from(words)));
        gpu.queue.write_buffer(&counts, 0, &first_texel.to_ne_bytes());
        let sky = SkyBeside {
            cuts: &uniforms,
            discs: &self.buffers.discs,
            views: &self.buffers.views,
            directions: &tables.directions,
            beside: &asked.beside.leaves,
            open: &open,
            cut_vertices: &cut_vertices,
        };
        let sky = sky.bind(gpu);
        let counted = CountedOthers { starts: &starts, counts: &counts }.bind(gpu);
        kernels.cuts_count.run(gpu, &[sky.clone(), counted], count)?;
        let rows = (read_word(gpu, &counts)? - first_texel).div_ceil(TEXTURE_WIDTH as u32);
        let bytes = u64::from(rows) * (TEXTURE_WIDTH * TEXEL_BYTES) as u64;
        if bytes > gpu.max_storage_bytes() || first_row + rows > gpu.limits.max_texture_dimension_2d {
            return Ok(None);
        }
        let texels = written(gpu, "nodes of cuts", bytes);
        let into = WrittenOthers { starts: &starts, texels: &texels }.bind(gpu);
        kernels.cuts_write.run(gpu, &[sky, into], count)?;
        let vertices = asked.vertices.iter().map(|&(vertex, _)| vertex).collect();
        Ok(Some(DeviceCuts { vertices, cut_vertices, starts, counts, texels, first_row, rows }))
    }

    fn cut_uniforms(&self, tables: &CutTables, least_by_depth: &[u64], first_texel: u32) -> CutUniforms {
        let mut least = [[0; 4]; 12];
        for (words, &error) in least.iter_mut().zip(least_by_depth) {
            *words = [error as u32, (error >> 32) as u32, 0, 0];
        }
        CutUniforms {
            least,
            turn: cos_sin(self.layout.turn),
            side: self.layout.cells.side as u32,
            height: tables.count.ilog2(),
            first_texel,
            padding: 0,
            more_padding: [0; 2],
        }
    }
}
