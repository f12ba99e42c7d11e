//! The mesh and its visibility cuts on the GPU. Poses move its vertices and replace their cuts; only another bake changes the rest.

use super::posed;
use crate::{
    appearance::Appearance,
    device::{
        DeviceCuts, GpuDevice, Kernel,
        kernels::ReplacedCuts,
        layout::{Triangle, Vertex, constants::TWO_SIDED},
        storage,
    },
    error::BackendError,
    remedy::Remedy,
    view::View,
    view_mode::visibility_cuts,
};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    cut::packed::{NODES_PER_TEXEL, PackedCuts, TEXEL_BYTES, TEXTURE_WIDTH},
    dataset::Dataset,
    ground::Ground,
    scene::Mesh,
    sources::IndirectBake,
    texture::UvSet,
};
use rayon::prelude::*;
use std::mem::offset_of;

/// Of the diagonal of the scene: nearer than that nothing is drawn.
const NEAR: f32 = 1e-5;

/// Buffers and textures of one dataset.
pub struct GpuScene {
    pub vertices: wgpu::Buffer,
    pub triangles: wgpu::Buffer,
    pub triangle_count: u32,
    pub ground: Option<GpuGround>,
    pub cuts: GpuCuts,
    /// Vertices' cuts over surface sources, if they were baked.
    pub sources: Option<SourceCuts>,
    /// What posed objects change of the light.
    pub posed: wgpu::TextureView,
    pub tree_height: u32,
    pub leaf_solid_angle: f32,
    /// Distance in meters nearer than which nothing is drawn.
    pub near: f32,
    /// Of the whole mesh but its ground.
    pub bounds: Bounds,
    /// Vertices with cuts that were made on the device.
    on_device: Vec<u32>,
}

/// The ground, whose triangles are the last ones.
pub struct GpuGround {
    pub first_triangle: u32,
    /// In meters along Y.
    height: f32,
}

/// Stored cuts.
pub struct GpuCuts {
    pub view: wgpu::TextureView,
    texture: wgpu::Texture,
    /// Those that are stored.
    pub stored: CutStarts,
    /// Those that a pose replaces them with.
    pub others: CutStarts,
    /// Number of texels of the stored ones, which come first.
    pub stored_texels: u32,
    /// Number of texels of the others.
    pub other_texels: u32,
}

/// Where some cuts begin; vertices may share one.
#[derive(Clone)]
pub struct CutStarts {
    /// First texel of each.
    pub texels: wgpu::Buffer,
    /// Number of cuts.
    pub count: u32,
}

/// Cuts over surface sources.
pub struct SourceCuts {
    pub cuts: GpuCuts,
    pub tree_height: u32,
}

impl GpuScene {
    /// Uploads a dataset.
    ///
    /// # Errors
    /// A dataset larger than the adapter's limits.
    pub fn new(gpu: &GpuDevice, dataset: &Dataset) -> Result<Self, BackendError> {
        let mesh = &dataset.scene.mesh;
        let bytes = |count: usize, size: usize| count as u64 * size as u64;
        let limit = gpu.max_storage_bytes();
        let remedy = Remedy::FewerVertices;
        gpu.within("the vertices", "bytes", bytes(mesh.positions.len(), size_of::<Vertex>()), limit, remedy)?;
        gpu.within("the triangles", "bytes", bytes(mesh.triangles.len(), size_of::<Triangle>()), limit, remedy)?;
        Ok(Self {
            cuts: upload_cuts(gpu, &dataset.cuts)?,
            sources: dataset.indirect.as_ref().map(|bake| source_cuts(gpu, bake)).transpose()?,
            vertices: storage(gpu, "vertices", bytemuck::cast_slice(&vertices(dataset))),
            triangles: storage(gpu, "triangles", bytemuck::cast_slice(&triangles(dataset, &Appearance::default()))),
            posed: posed::texture(gpu, None, false),
            triangle_count: mesh.triangles.len() as u32,
            ground: mesh.ground.map(|start| GpuGround {
                first_triangle: start.triangle,
                height: mesh.positions[start.vertex as usize].y,
            }),
            tree_height: dataset.tree.height(),
            leaf_solid_angle: dataset.tree.leaf_solid_angle(),
            near: NEAR * mesh.bounds().diagonal(),
            bounds: mesh.bounds(),
            on_device: Vec::new(),
        })
    }
}

impl GpuScene {
    /// Moves the vertices from where they were uploaded to where `posed` has them, with its visibility cuts. All else of it is what
    /// was uploaded.
    ///
    /// # Errors
    /// Cuts beyond the adapter's limits.
    pub fn pose(&mut self, gpu: &GpuDevice, uploaded: &Dataset, posed: &Dataset) -> Result<(), BackendError> {
        let with_other_cuts = std::mem::take(&mut self.on_device);
        self.upload_vertices(gpu, posed, &with_other_cuts);
        self.upload_vertices(gpu, posed, &posed_vertices(uploaded, posed));
        self.cuts = replaced_cuts(gpu, &posed.cuts, &self.cuts)?;
        let bounds = posed.scene.mesh.bounds();
        (self.bounds, self.near) = (bounds, NEAR * bounds.diagonal());
        Ok(())
    }

    /// Replaces the cuts of some vertices by those that were made on the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn take_cuts(&mut self, gpu: &GpuDevice, kernel: &Kernel, cuts: &DeviceCuts) -> Result<(), BackendError> {
        let DeviceCuts { vertices, cut_vertices, starts, counts, .. } = cuts;
        let replaced = ReplacedCuts { cut_vertices, starts, counts, vertices: &self.vertices }.bind(gpu);
        kernel.run(gpu, &[replaced], (vertices.len() as u32).div_ceil(VERTICES_PER_GROUP))?;
        self.cuts = self.cuts.with_others(gpu, cuts);
        self.on_device.clone_from(vertices);
        Ok(())
    }

    /// Uploads some vertices, those near each other at once.
    fn upload_vertices(&self, gpu: &GpuDevice, dataset: &Dataset, vertices: &[u32]) {
        for run in vertices.chunk_by(|&a, &b| b - a <= VERTICES_BETWEEN_WRITES) {
            let (first, last) = (run[0], run[run.len() - 1]);
            let values: Vec<Vertex> = (first..=last).map(|v| vertex(dataset, v as usize)).collect();
            gpu.queue.write_buffer(
                &self.vertices,
                u64::from(first) * size_of::<Vertex>() as u64,
                bytemuck::cast_slice(&values),
            );
        }
    }

    /// Gives the triangles of `dataset` the materials that `appearance` assigns.
    pub fn assign(&self, gpu: &GpuDevice, dataset: &Dataset, appearance: &Appearance) {
        gpu.queue.write_buffer(&self.triangles, 0, bytemuck::cast_slice(&triangles(dataset, appearance)));
    }

    /// Number of triangles, from the first, that a view shows. From below the ground is not seen.
    pub fn triangles_shown(&self, view: &View) -> u32 {
        let hidden = |ground: &&GpuGround| view.ground() == Ground::Off || view.camera.eye.y < ground.height;
        self.ground.as_ref().filter(hidden).map_or(self.triangle_count, |ground| ground.first_triangle)
    }
}

fn source_cuts(gpu: &GpuDevice, bake: &IndirectBake) -> Result<SourceCuts, BackendError> {
    Ok(SourceCuts { cuts: upload_cuts(gpu, &bake.cuts)?, tree_height: bake.sources.len().ilog2() })
}

/// Invocations of a workgroup that replaces cuts.
const VERTICES_PER_GROUP: u32 = 64;

/// Where `replaced_cuts_kernel.wgsl` finds what it replaces.
const _: () = assert!(
    size_of::<Vertex>() == 80 && offset_of!(Vertex, cut_offset) == 12 && offset_of!(Vertex, cut_len) == 28,
    "a kernel writes these members"
);

/// Gaps of up to so many vertices that stay are uploaded, too: that is faster than another write.
const VERTICES_BETWEEN_WRITES: u32 = 64;

/// Vertices that a pose moves, or whose cut it replaces.
fn posed_vertices(before: &Dataset, posed: &Dataset) -> Vec<u32> {
    let (was, is) = (&before.scene.mesh, &posed.scene.mesh);
    let changes = |&vertex: &u32| {
        let v = vertex as usize;
        let place = |mesh: &Mesh| (mesh.positions[v], mesh.normals[v], mesh.tangents[v]);
        let [cut_before, cut] = [before, posed].map(|dataset| dataset.cuts.offsets()[v]);
        place(was) != place(is) || cut_before != cut || posed.cuts.is_replaced(vertex)
    };
    (0..is.positions.len() as u32).filter(changes).collect()
}

fn vertices(dataset: &Dataset) -> Vec<Vertex> {
    (0..dataset.scene.mesh.positions.len()).into_par_iter().map(|v| vertex(dataset, v)).collect()
}

fn vertex(dataset: &Dataset, v: usize) -> Vertex {
    let mesh = &dataset.scene.mesh;
    let (height, counted) = visibility_cuts(dataset);
    Vertex {
        position: mesh.positions[v].to_array(),
        cut_offset: dataset.cuts.offsets()[v],
        normal: mesh.normals[v].to_array(),
        cut_len: counted.cut(height, v as u32).len() as u32,
        tangent: mesh.tangents[v].truncate().to_array(),
        handedness: mesh.tangents[v].w,
        uv: mesh.uvs[v].to_array(),
        is_valid: u32::from(dataset.vertex_valid[v]),
        source_cut_offset: dataset.indirect.as_ref().map_or(0, |bake| bake.cuts.offsets()[v]),
        second_uv: mesh.uv_set(UvSet::Second)[v].to_array(),
        color: packed_color(mesh.colors.get(v).copied().unwrap_or(Vec3::ONE)),
    }
}

/// A color as fractions of 16 bits.
fn packed_color(color: Vec3) -> [u32; 2] {
    let [r, g, b] = color.to_array().map(|x| (65_535.0 * x.clamp(0.0, 1.0)).round() as u32);
    [r | g << 16, b]
}

fn triangles(dataset: &Dataset, appearance: &Appearance) -> Vec<Triangle> {
    let mesh = &dataset.scene.mesh;
    let triangle = |(index, (&vertices, &two_sided)): (usize, (&[u32; 3], &bool))| Triangle {
        vertices,
        material: appearance.material_of(mesh, index) | if two_sided { TWO_SIDED } else { 0 },
    };
    mesh.triangles.iter().zip(&dataset.two_sided).enumerate().map(triangle).collect()
}

fn upload_cuts(gpu: &GpuDevice, cuts: &PackedCuts) -> Result<GpuCuts, BackendError> {
    let [stored, others] = cuts.parts();
    let rows = rows_within_limits(gpu, stored.len() + others.len())?;
    // The next pose may have longer cuts.
    let spare = others.len().div_ceil(ROW_NODES) as u32;
    let texture = cut_texture(gpu, "visibility cuts", (rows + spare).min(gpu.limits.max_texture_dimension_2d));
    write_cut_rows(gpu, &texture, 0, [stored, others]);
    Ok(GpuCuts::of(gpu, texture, cuts, CutStarts::of(gpu, cuts, false)))
}

/// Cuts of which those stored are in the texture of `before`. Where it has too few rows for the others, all are uploaded.
fn replaced_cuts(gpu: &GpuDevice, cuts: &PackedCuts, before: &GpuCuts) -> Result<GpuCuts, BackendError> {
    let [stored, others] = cuts.parts();
    if rows_within_limits(gpu, stored.len() + others.len())? > before.texture.height() {
        // Vertices may return to any cut that is stored.
        return Ok(GpuCuts { stored: before.stored.clone(), ..upload_cuts(gpu, cuts)? });
    }
    let first = stored.len() / ROW_NODES;
    write_cut_rows(gpu, &before.texture, first as u32, [&stored[first * ROW_NODES..], others]);
    Ok(GpuCuts::of(gpu, before.texture.clone(), cuts, before.stored.clone()))
}

/// Rows of a texture for so many nodes.
fn rows_within_limits(gpu: &GpuDevice, nodes: usize) -> Result<u32, BackendError> {
    let rows = nodes.div_ceil(ROW_NODES).max(1);
    let limit = gpu.limits.max_texture_dimension_2d as u64;
    gpu.within("the visibility cuts", "rows of a texture", rows as u64, limit, Remedy::SmallerCuts)?;
    Ok(rows as u32)
}

impl GpuCuts {
    fn of(gpu: &GpuDevice, texture: wgpu::Texture, cuts: &PackedCuts, stored: CutStarts) -> Self {
        Self {
            view: texture.create_view(&Default::default()),
            texture,
            stored,
            others: CutStarts::of(gpu, cuts, true),
            stored_texels: cuts.stored_texels(),
            other_texels: (cuts.parts()[1].len() / NODES_PER_TEXEL) as u32,
        }
    }

    /// The stored cuts with others that were made on the device.
    fn with_others(&self, gpu: &GpuDevice, cuts: &DeviceCuts) -> Self {
        let &DeviceCuts { first_row, rows, .. } = cuts;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let texture = match first_row + rows <= self.texture.height() {
            true => self.texture.clone(),
            false => {
                // The next pose may have longer cuts.
                let most = gpu.limits.max_texture_dimension_2d;
                let larger = cut_texture(gpu, "visibility cuts", (first_row + 2 * rows).min(most));
                let stored = extent([TEXTURE_WIDTH as u32, self.stored_texels.div_ceil(TEXTURE_WIDTH as u32)]);
                encoder.copy_texture_to_texture(self.texture.as_image_copy(), larger.as_image_copy(), stored);
                larger
            }
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some((TEXTURE_WIDTH * TEXEL_BYTES) as u32),
            rows_per_image: None,
        };
        let into = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x: 0, y: first_row, z: 0 },
            ..texture.as_image_copy()
        };
        let from = wgpu::TexelCopyBufferInfo { buffer: &cuts.texels, layout };
        encoder.copy_buffer_to_texture(from, into, extent([TEXTURE_WIDTH as u32, rows]));
        gpu.queue.submit([encoder.finish()]);
        Self {
            view: texture.create_view(&Default::default()),
            texture,
            stored: self.stored.clone(),
            others: CutStarts { texels: cuts.starts.clone(), count: cuts.vertices.len() as u32 },
            stored_texels: self.stored_texels,
            other_texels: rows * TEXTURE_WIDTH as u32,
        }
    }

    /// Texels that there is room for.
    pub fn most_texels(&self) -> u32 {
        self.texture.width() * self.texture.height()
    }
}

impl CutStarts {
    fn of(gpu: &GpuDevice, cuts: &PackedCuts, replaced: bool) -> Self {
        let mut starts = cuts.starts(replaced);
        let count = starts.len() as u32;
        // Buffers cannot be empty.
        starts.resize(starts.len().max(1), 0);
        Self { texels: storage(gpu, "first texels of cuts", bytemuck::cast_slice(&starts)), count }
    }
}

/// A texture of four floats a texel, row by row.
pub fn float_texture(gpu: &GpuDevice, label: &str, size: [u32; 2], texels: &[[f32; 4]]) -> wgpu::TextureView {
    texture_of(gpu, label, wgpu::TextureFormat::Rgba32Float, size, texels)
}

/// The same of zeros.
pub fn empty_float_texture(gpu: &GpuDevice, label: &str, size: [u32; 2]) -> wgpu::Texture {
    empty_texture(gpu, label, wgpu::TextureFormat::Rgba32Float, size)
}

/// A texture of colors with a shared exponent, row by row.
pub fn shared_exponent_texture(gpu: &GpuDevice, label: &str, size: [u32; 2], codes: &[u32]) -> wgpu::TextureView {
    texture_of(gpu, label, wgpu::TextureFormat::Rgb9e5Ufloat, size, codes)
}

fn texture_of<T: bytemuck::Pod>(
    gpu: &GpuDevice,
    label: &str,
    format: wgpu::TextureFormat,
    size: [u32; 2],
    texels: &[T],
) -> wgpu::TextureView {
    let texture = empty_texture(gpu, label, format, size);
    write_rows(gpu, &texture, 0, size[0] as usize * size_of::<T>(), bytemuck::cast_slice(texels));
    texture.create_view(&Default::default())
}

fn empty_texture(gpu: &GpuDevice, label: &str, format: wgpu::TextureFormat, size: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Packed nodes as rows of texels.
pub fn cut_view(gpu: &GpuDevice, label: &str, nodes: &[u16]) -> wgpu::TextureView {
    let texture = cut_texture(gpu, label, nodes.len().div_ceil(ROW_NODES).max(1) as u32);
    write_cut_rows(gpu, &texture, 0, [nodes, &[]]);
    texture.create_view(&Default::default())
}

/// Nodes in a row of texels.
const ROW_NODES: usize = TEXTURE_WIDTH * NODES_PER_TEXEL;

fn cut_texture(gpu: &GpuDevice, label: &str, rows: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent([TEXTURE_WIDTH as u32, rows]),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Writes nodes, one part after the other, from the start of a row on.
fn write_cut_rows(gpu: &GpuDevice, texture: &wgpu::Texture, first_row: u32, parts: [&[u16]; 2]) {
    let mut padded = parts.concat();
    padded.resize(padded.len().next_multiple_of(ROW_NODES), 0);
    write_rows(gpu, texture, first_row, TEXTURE_WIDTH * TEXEL_BYTES, bytemuck::cast_slice(&padded));
}

/// Most bytes written to a texture at once: the driver keeps a copy of each until it is done.
const BYTES_PER_WRITE: usize = 32 << 20;

/// Writes whole rows of `row_bytes` from `first_row` on.
pub fn write_rows(gpu: &GpuDevice, texture: &wgpu::Texture, first_row: u32, row_bytes: usize, bytes: &[u8]) {
    let rows_per_write = (BYTES_PER_WRITE / row_bytes).max(1);
    for (i, part) in bytes.chunks(rows_per_write * row_bytes).enumerate() {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: first_row + (i * rows_per_write) as u32, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            part,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes as u32), rows_per_image: None },
            extent([texture.width(), (part.len() / row_bytes) as u32]),
        );
        // Hand the copy on now, so that the next one can reuse its memory.
        gpu.queue.submit([]);
    }
}

/// A texture's size.
pub fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}
