//! Bounced light of meshless functions. Buffers hold the functions of a dataset, with the grid that finds them, and the
//! coefficients of a solution. They are uploaded when they change and not when the camera moves. A pass evaluates them at
//! every pixel.

use super::{groups, scene::float_texture};
use crate::{
    device::{GpuDevice, layout, storage, uniform},
    error::BackendError,
    light::bounce::{MeshlessLight, VerticesAsBaked},
    remedy::Remedy,
    view_mode::BasisView,
};
use bytemuck::{NoUninit, Zeroable};
use glam::{Mat3A, Vec3};
use lapidary_core::dataset::Dataset;
use std::sync::Arc;

/// Bounced light of the basis as it was last shown.
#[derive(Default)]
pub struct GpuMeshless {
    /// Those of a dataset, and whether they are those of its objects.
    functions: Option<(Arc<Dataset>, bool, Functions)>,
    coefficients: Option<(Arc<MeshlessLight>, Coefficients)>,
}

/// The coefficients of a solution.
struct Coefficients {
    vectors: wgpu::Buffer,
    harmonics: wgpu::TextureView,
}

/// The functions of a dataset.
struct Functions {
    slots: wgpu::Buffer,
    entries: wgpu::Buffer,
    functions: wgpu::Buffer,
    places: wgpu::TextureView,
}

impl GpuMeshless {
    /// Forgets the coefficients, for light that is not shown.
    pub fn forget_light(&mut self) {
        self.coefficients = None;
    }

    /// Uploads missing data, and binds what the pass reads.
    ///
    /// # Errors
    /// A basis beyond the adapter's limits.
    pub fn bound(
        &mut self,
        gpu: &GpuDevice,
        light: &Arc<MeshlessLight>,
        shown: BasisView,
    ) -> Result<wgpu::BindGroup, BackendError> {
        let key = (light.dataset(), light.as_baked().is_some());
        let known = self.functions.take().filter(|known| Arc::ptr_eq(&known.0, key.0) && known.1 == key.1);
        let make = || Ok((key.0.clone(), key.1, Functions::new(gpu, light)?));
        let (.., functions) = self.functions.insert(known.map_or_else(make, Ok)?);
        let known = self.coefficients.take().filter(|(known, _)| Arc::ptr_eq(known, light));
        let make = || {
            let vectors = coefficients(gpu, light.coefficients())?;
            Ok((light.clone(), Coefficients { vectors, harmonics: harmonics(gpu, light) }))
        };
        let (_, Coefficients { vectors: coefficients, harmonics }) =
            self.coefficients.insert(known.map_or_else(make, Ok)?);
        let Functions { slots, entries, functions, places } = functions;
        let basis = &uniform(gpu, "meshless light", bytemuck::bytes_of(&uniforms(light, shown)));
        Ok(groups::Basis { basis, slots, entries, functions, coefficients, places, harmonics }.bind(gpu))
    }

    /// What the pass reads in a picture whose bounced light is of vertices alone.
    pub fn without_functions(gpu: &GpuDevice) -> wgpu::BindGroup {
        // As large as the largest element of the arrays.
        let nothing = &storage(gpu, "no function", bytemuck::bytes_of(&layout::Coefficient::zeroed()));
        let basis = &uniform(gpu, "no basis", bytemuck::bytes_of(&layout::BasisUniforms::zeroed()));
        let places = &places(gpu, None);
        groups::Basis {
            basis,
            slots: nothing,
            entries: nothing,
            functions: nothing,
            coefficients: nothing,
            places,
            harmonics: places,
        }
        .bind(gpu)
    }

    /// The coefficients, to detect a new upload.
    #[cfg(test)]
    pub fn coefficients(&self) -> Option<&wgpu::Buffer> {
        self.coefficients.as_ref().map(|(_, coefficients)| &coefficients.vectors)
    }
}

impl Functions {
    fn new(gpu: &GpuDevice, light: &MeshlessLight) -> Result<Self, BackendError> {
        let basis = light.functions();
        let function = |p: &lapidary_core::surfel::Surfel| layout::BasisFunction {
            position: p.position.extend(0.0).to_array(),
            normal: p.normal.extend(0.0).to_array(),
        };
        let functions: Vec<_> = basis.points().iter().map(function).collect();
        Ok(Self {
            slots: within_limits(gpu, "cells of the meshless basis", basis.grid().slots(), Remedy::FewerFunctions)?,
            entries: within_limits(
                gpu,
                "entries of the meshless basis",
                basis.grid().entries(),
                Remedy::FewerFunctions,
            )?,
            functions: within_limits(gpu, "functions of the meshless basis", &functions, Remedy::FewerFunctions)?,
            places: places(gpu, light.as_baked().map(|vertices| &**vertices)),
        })
    }
}

/// Texels in a row of places, and of coefficients by direction.
const WIDTH: usize = 8192;

/// The place of each vertex as baked, and its object, row by row; a single texel for functions that are not of objects.
fn places(gpu: &GpuDevice, as_baked: Option<&VerticesAsBaked>) -> wgpu::TextureView {
    let Some(VerticesAsBaked { positions, owners }) = as_baked else {
        return float_texture(gpu, "no places", [1, 1], &[[0.0; 4]]);
    };
    let place = |(position, &object): (&Vec3, &u32)| position.extend(object as f32).to_array();
    rows(gpu, "places as baked", positions.iter().zip(owners).map(place).collect())
}

/// Coefficients by direction, nine texels a function; a single texel where they are not known.
fn harmonics(gpu: &GpuDevice, light: &MeshlessLight) -> wgpu::TextureView {
    let Some(arriving) = light.by_direction() else {
        return float_texture(gpu, "no directions", [1, 1], &[[0.0; 4]]);
    };
    let texels = arriving.coefficients.iter().flat_map(|of| of.0).map(|color| color.extend(0.0).to_array());
    rows(gpu, "light by direction", texels.collect())
}

/// Texels row by row.
fn rows(gpu: &GpuDevice, label: &str, mut texels: Vec<[f32; 4]>) -> wgpu::TextureView {
    texels.resize(texels.len().next_multiple_of(WIDTH).max(WIDTH), [0.0; 4]);
    float_texture(gpu, label, [WIDTH as u32, (texels.len() / WIDTH) as u32], &texels)
}

fn coefficients(gpu: &GpuDevice, coefficients: &[Mat3A]) -> Result<wgpu::Buffer, BackendError> {
    let padded = |v: &Mat3A| layout::Coefficient { vector: v.to_cols_array_2d().map(|[x, y, z]| [x, y, z, 0.0]) };
    let contents: Vec<_> = coefficients.iter().map(padded).collect();
    within_limits(gpu, "coefficients of the meshless basis", &contents, Remedy::FewerFunctions)
}

/// A buffer that holds at least one element, because it cannot be empty.
pub(super) fn within_limits<T: NoUninit + Zeroable>(
    gpu: &GpuDevice,
    what: &'static str,
    contents: &[T],
    remedy: Remedy,
) -> Result<wgpu::Buffer, BackendError> {
    let one = [T::zeroed()];
    let bytes: &[u8] = bytemuck::cast_slice(if contents.is_empty() { &one } else { contents });
    gpu.within(what, "bytes", bytes.len() as u64, gpu.max_storage_bytes(), remedy)?;
    Ok(storage(gpu, what, bytes))
}

fn uniforms(light: &MeshlessLight, shown: BasisView) -> layout::BasisUniforms {
    let (basis, of_objects) = (light.functions(), light.as_baked().is_some());
    let grid = basis.grid();
    let mut levels = [layout::BasisLevel::zeroed(); layout::constants::MOST_BASIS_LEVELS];
    for (level, place) in levels.iter_mut().take(basis.levels()).enumerate() {
        *place = layout::BasisLevel {
            // The same for all objects.
            cells_per_metre: grid.cells_per_metre().get(level).copied().unwrap_or_default(),
            radius: basis.radii()[level],
            end: basis.level(level).end as u32,
            padding: 0,
        };
    }
    layout::BasisUniforms {
        levels,
        level_count: basis.levels() as u32,
        last_slot: grid.slots().len() as u32 - 1,
        shown_level: shown.level,
        shown_function: shown.function,
        of_objects: u32::from(of_objects),
        directional_levels: light.by_direction().map_or(0, |arriving| arriving.levels as u32),
    }
}
