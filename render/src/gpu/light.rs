//! The light on the GPU: tree, illumination cut, and the map as the background. An edit of the environment changes
//! these.

use super::{
    lit::{GpuLitCuts, LitField, LitKernels, LitTree},
    scene::{GpuCuts, GpuScene, SourceCuts, cut_view, float_texture, shared_exponent_texture},
};
use crate::{
    device::{GpuDevice, layout::Node, storage},
    error::BackendError,
    light::{
        bounce::SourceLighting,
        environment::{EnvironmentLight, Illumination, TurnedMap},
        node_row::{NodeExtent, NodeRow},
        sent::{KNOTS, SentByDirection},
        tree_light::TreeLight,
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::packed::pack_node,
    environment::{Environment, Pyramid},
    image::Image,
};
use std::{borrow::Cow, sync::Arc};

/// The light of a tree's nodes.
#[derive(Clone)]
pub struct NodeBuffers {
    pub nodes: wgpu::Buffer,
    pub brightness: wgpu::Buffer,
}

impl NodeBuffers {
    /// Uploads some megabytes.
    fn uploaded<L>(gpu: &GpuDevice, light: &TreeLight<L>) -> Self {
        let node = |(row, extent): (&NodeRow, &NodeExtent)| Node {
            radiance: row.radiance.to_array(),
            spread: row.spread,
            place: row.place.to_array(),
            radius: extent.radius,
        };
        let nodes: Vec<Node> = light.rows.iter().zip(&light.extents).map(node).collect();
        let brightness: Vec<f32> = light.extents.iter().map(|extent| extent.brightness).collect();
        Self {
            nodes: storage(gpu, "light of a tree", bytemuck::cast_slice(&nodes)),
            brightness: storage(gpu, "brightness", bytemuck::cast_slice(&brightness)),
        }
    }

    fn under<'a>(&'a self, field: LitField, cuts: &'a GpuCuts, height: u32) -> LitTree<'a> {
        LitTree { field, cuts, height, nodes: &self.nodes, brightness: &self.brightness }
    }
}

/// The light of a tree's nodes, and the lit cuts of a scene over it.
#[derive(Clone)]
pub struct GpuTreeLight {
    pub of_nodes: NodeBuffers,
    pub cut: wgpu::TextureView,
    pub lit: GpuLitCuts,
    /// What the nodes send by direction; a texel without.
    pub sent: wgpu::TextureView,
    pub sends_by_direction: bool,
    /// Most nodes that the illumination cut was allowed.
    pub max_nodes: u32,
}

impl GpuTreeLight {
    /// Uploads a few megabytes, and makes the lit cuts.
    ///
    /// # Errors
    /// A lost device.
    fn new<L>(
        gpu: &GpuDevice,
        kernels: &LitKernels,
        (field, cuts): (LitField, &GpuCuts),
        light: &TreeLight<L>,
    ) -> Result<Self, BackendError> {
        let of_nodes = NodeBuffers::uploaded(gpu, light);
        Ok(Self {
            lit: kernels.make(gpu, of_nodes.under(field, cuts, light.height()), light.lit.tau())?,
            of_nodes,
            cut: cut_view(gpu, "illumination cut", &light.cut),
            sent: sent_view(gpu, light.sent.as_deref()),
            sends_by_direction: light.sent.is_some(),
            max_nodes: light.max_nodes,
        })
    }

    /// The light of a turned map, whose illumination cut is the root alone.
    ///
    /// # Errors
    /// A lost device.
    fn turned(
        gpu: &GpuDevice,
        kernels: &LitKernels,
        scene: &GpuScene,
        (turned, of_nodes): (&TurnedMap, NodeBuffers),
    ) -> Result<Self, BackendError> {
        let tree = of_nodes.under(LitField::Environment, &scene.cuts, scene.tree_height);
        Ok(Self {
            lit: kernels.make(gpu, tree, turned.gathering.tau)?,
            of_nodes,
            cut: cut_view(gpu, "no illumination cut", &[pack_node(0, 0.0)]),
            sent: sent_view(gpu, None),
            sends_by_direction: false,
            max_nodes: turned.gathering.illum_cut,
        })
    }

    /// Lights the cuts of a scene where a pose replaced others than before.
    ///
    /// # Errors
    /// A lost device.
    fn replace_cuts(&mut self, gpu: &GpuDevice, kernels: &LitKernels, scene: &GpuScene) -> Result<(), BackendError> {
        let tree = self.of_nodes.under(LitField::Environment, &scene.cuts, scene.tree_height);
        self.lit = kernels.replace(gpu, tree, self.lit.clone())?;
        Ok(())
    }

    /// No light, for a tree of `height`.
    fn dark(gpu: &GpuDevice, height: u32) -> Self {
        let nodes = 2_usize << height;
        Self {
            of_nodes: NodeBuffers {
                nodes: storage(gpu, "no light", &vec![0; nodes * size_of::<Node>()]),
                brightness: storage(gpu, "no brightness", &vec![0; nodes * size_of::<f32>()]),
            },
            lit: GpuLitCuts::none(gpu),
            cut: cut_view(gpu, "no illumination cut", &[pack_node(0, 0.0)]),
            sent: sent_view(gpu, None),
            sends_by_direction: false,
            max_nodes: 0,
        }
    }
}

/// Nodes in a row of squares, as in `sent.wgsl`.
pub const SENT_COLUMNS: usize = 256;

/// Squares of knots, node by node.
fn sent_view(gpu: &GpuDevice, sent: Option<&SentByDirection>) -> wgpu::TextureView {
    let (codes, side) = (sent.map_or(&[][..], SentByDirection::codes), KNOTS.side);
    let rows = codes.len().div_ceil(SENT_COLUMNS);
    let mut texels = Vec::with_capacity(rows * SENT_COLUMNS * KNOTS.len());
    for (row, y) in (0..rows).flat_map(|row| (0..side).map(move |y| (row, y))) {
        for node in row * SENT_COLUMNS..(row + 1) * SENT_COLUMNS {
            let of_node = codes.get(node).unwrap_or(&[0; KNOTS.len()]);
            texels.extend_from_slice(&of_node[y * side..][..side]);
        }
    }
    if rows == 0 {
        return shared_exponent_texture(gpu, "no light sent by direction", [1, 1], &[0]);
    }
    let size = [SENT_COLUMNS * side, rows * side];
    shared_exponent_texture(gpu, "light sent by direction", size.map(|side| side as u32), &texels)
}

/// Light of the environment.
#[derive(Clone)]
pub struct GpuLight {
    pub tree: GpuTreeLight,
    pub rotation: f32,
    pub intensity: f32,
    /// The map for sharp lobes.
    pub mirrored: Option<GpuPyramid>,
    /// Has the illumination cut, if it is not uploaded yet.
    cut_of: Option<Arc<EnvironmentLight>>,
}

/// All levels of a map, in an atlas.
#[derive(Clone)]
pub struct GpuPyramid {
    pyramid: Arc<Pyramid>,
    pub view: wgpu::TextureView,
}

impl GpuPyramid {
    /// Uploads the levels, unless `before` is the same.
    fn new(gpu: &GpuDevice, pyramid: &Arc<Pyramid>, before: Option<&Self>) -> Self {
        if let Some(same) = before.filter(|before| Arc::ptr_eq(&before.pyramid, pyramid)) {
            return same.clone();
        }
        Self { pyramid: pyramid.clone(), view: upload(gpu, "levels of the environment", &pyramid.atlas()) }
    }

    /// Of the finest level.
    pub fn height(&self) -> u32 {
        self.pyramid.levels()[0].size[1]
    }
}

impl GpuLight {
    /// The light of the environment, with `nodes` if kernels computed them; else it is uploaded. What of `before` is the same is kept.
    ///
    /// # Errors
    /// A lost device.
    pub fn new(
        gpu: &GpuDevice,
        kernels: &LitKernels,
        scene: &GpuScene,
        (light, lighting, nodes): (&Illumination, &Arc<EnvironmentLight>, Option<NodeBuffers>),
        before: Option<&Self>,
    ) -> Result<Self, BackendError> {
        let before = before.and_then(|before| before.mirrored.as_ref());
        let (tree, cut_of) = match lighting.turned().zip(nodes) {
            Some(turned) => (GpuTreeLight::turned(gpu, kernels, scene, turned)?, Some(lighting.clone())),
            None => (GpuTreeLight::new(gpu, kernels, (LitField::Environment, &scene.cuts), &**lighting)?, None),
        };
        Ok(Self {
            tree,
            rotation: light.rotation,
            intensity: light.intensity,
            mirrored: lighting.pyramid().map(|pyramid| GpuPyramid::new(gpu, &pyramid, before)),
            cut_of,
        })
    }

    /// Uploads the illumination cut, for pictures that merge it. It is selected on the cores.
    pub fn upload_cut(&mut self, gpu: &GpuDevice) {
        if let Some(lighting) = self.cut_of.take().filter(|_| self.tree.max_nodes > 1) {
            self.tree.cut = cut_view(gpu, "illumination cut", &lighting.cut);
        }
    }

    /// The same light where a pose replaced other cuts than before.
    ///
    /// # Errors
    /// A lost device.
    pub fn replace_cuts(
        &mut self,
        gpu: &GpuDevice,
        kernels: &LitKernels,
        scene: &GpuScene,
    ) -> Result<(), BackendError> {
        self.tree.replace_cuts(gpu, kernels, scene)
    }

    /// No light, for a tree of `height`.
    pub fn dark(gpu: &GpuDevice, height: u32) -> Self {
        Self { tree: GpuTreeLight::dark(gpu, height), rotation: 0.0, intensity: 0.0, mirrored: None, cut_of: None }
    }
}

/// Surface sources that send light.
pub struct GpuSources {
    pub tree: GpuTreeLight,
    lighting: Arc<SourceLighting>,
}

impl GpuSources {
    /// Uploads, and makes the lit cuts over the sources, unless `before` is the same.
    ///
    /// # Errors
    /// A lost device.
    pub fn new(
        gpu: &GpuDevice,
        kernels: &LitKernels,
        baked: &SourceCuts,
        lighting: &Arc<SourceLighting>,
        before: Option<Self>,
    ) -> Result<Self, BackendError> {
        if let Some(same) = before.filter(|b| Arc::ptr_eq(&b.lighting, lighting)) {
            return Ok(same);
        }
        let tree = GpuTreeLight::new(gpu, kernels, (LitField::Sources, &baked.cuts), lighting)?;
        Ok(Self { tree, lighting: lighting.clone() })
    }
}

/// A map that is seen directly.
pub struct GpuMap {
    environment: Arc<Environment>,
    /// Blur in radians; `None` for the map itself.
    blur: Option<f32>,
    pub view: wgpu::TextureView,
}

impl GpuMap {
    /// Uploads a map, blurred if asked, unless `before` is the same.
    pub fn new(gpu: &GpuDevice, environment: &Arc<Environment>, blur: Option<f32>, before: Option<Self>) -> Self {
        let same = |m: &Self| Arc::ptr_eq(&m.environment, environment) && m.blur == blur;
        if let Some(same) = before.filter(same) {
            return same;
        }
        let shown = match blur {
            Some(width) => Cow::Owned(environment.blurred(width).map),
            None => fitted(&environment.map, gpu.limits.max_texture_dimension_2d),
        };
        Self { environment: environment.clone(), blur, view: upload(gpu, "environment", &shown) }
    }
}

/// Remark on a map that is larger than the limit of textures.
pub fn scaled_map(environment: &Environment, limit: u32) -> Option<String> {
    let [width, height] = environment.map.size;
    (width.max(height) > limit).then(|| {
        format!(
            "the environment \"{}\" of {width} x {height} is shown smaller behind the scene: this adapter allows textures of \
             {limit} texels per side; it lights the scene in full",
            environment.name
        )
    })
}

/// The map, reduced if necessary by leaving out texels so that it fits; only the background loses detail.
fn fitted(map: &Image, limit: u32) -> Cow<'_, Image> {
    let step = map.size[0].max(map.size[1]).div_ceil(limit);
    if step == 1 {
        return Cow::Borrowed(map);
    }
    let size = map.size.map(|s| (s / step).max(1));
    Cow::Owned(Image::from_fn(size, |x, y| map.at((x * step) as usize, (y * step) as usize)))
}

fn upload(gpu: &GpuDevice, label: &str, map: &Image) -> wgpu::TextureView {
    let texels: Vec<[f32; 4]> = map.pixels.iter().map(|p: &Vec3| p.extend(1.0).to_array()).collect();
    float_texture(gpu, label, map.size, &texels)
}
