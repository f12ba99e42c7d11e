//! Boundaries on the GPU for bakes: the tables of a set of directions as `shaders/boundaries_pass.wgsl` reads them.

use super::{
    adapter::GpuDevice,
    buffers::{storage, uniform, written},
    kernels::BoundaryWork,
    layout,
    rays::RowsOfOrigins,
};
use lapidary_core::ray::BoundaryTables;

/// Binds the tables, with results for so many origins at a time.
pub(super) fn bind(gpu: &GpuDevice, tables: &BoundaryTables, results: &RowsOfOrigins) -> wgpu::BindGroup {
    let (uniforms, words) = packed(tables);
    let directions: Vec<[f32; 4]> = tables.directions.iter().map(|d| d.extend(0.0).to_array()).collect();
    let states = results.at_a_time * bytes_of_states(tables);
    BoundaryWork {
        rays: &uniform(gpu, "uniforms of boundaries", bytemuck::bytes_of(&uniforms)),
        directions: &storage(gpu, "directions of boundaries", bytemuck::cast_slice(&directions)),
        tables: &storage(gpu, "tables of boundaries", bytemuck::cast_slice(&words)),
        origins: &results.origins,
        states: &written(gpu, "states of boundaries", states as u64),
        open_words: &results.open,
    }
    .bind(gpu)
}

/// Bytes of the states and the queue of an origin.
pub(super) fn bytes_of_states(tables: &BoundaryTables) -> usize {
    2 * tables.touching.len() * size_of::<u32>()
}

/// The uniforms and the words of tables.
fn packed(tables: &BoundaryTables) -> (layout::BoundaryUniforms, Vec<u32>) {
    let BoundaryTables { targets, probes, touching, groups_per_block, .. } = tables;
    let (count, groups) = (targets.len(), touching.len());
    let places = probes.len();
    let starts = places + count;
    let mut words = probes.clone();
    words.resize(starts, 0);
    (0..).zip(targets).for_each(|(place, &target)| words[places + target as usize] = place);
    let mut next = starts + groups + 1;
    words.push(next as u32);
    for list in touching {
        next += list.len();
        words.push(next as u32);
    }
    words.extend(touching.iter().flatten().map(|&(group, lanes)| group << 8 | u32::from(lanes)));
    let uniforms = layout::BoundaryUniforms {
        directions: count as u32,
        words: count.div_ceil(32) as u32,
        groups: groups as u32,
        groups_per_block: *groups_per_block as u32,
        places: places as u32,
        starts: starts as u32,
    };
    (uniforms, words)
}
