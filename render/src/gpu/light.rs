//! The light on the GPU: tree, illumination cut, and the map as the background. An edit of the environment changes
//! these.

use super::{
    lit::{GpuLitCuts, LitField, LitPass},
    scene::{GpuScene, SourceCuts, cut_view, float_texture},
};
use crate::{
    device::{GpuDevice, layout::Node, storage},
    error::BackendError,
    light::{
        bounce::SourceLighting,
        environment::{Illumination, SceneLighting},
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::packed::pack_node,
    environment::{Environment, Pyramid},
    image::Image,
};
use std::{borrow::Cow, sync::Arc};

/// Light of one scene.
#[derive(Clone)]
pub struct GpuLight {
    pub nodes: wgpu::Buffer,
    pub brightness: wgpu::Buffer,
    pub cut: wgpu::TextureView,
    pub lit: GpuLitCuts,
    /// Most nodes that the illumination cut was allowed.
    pub max_nodes: u32,
    pub rotation: f32,
    pub intensity: f32,
    /// The map for sharp lobes.
    pub mirrored: Option<GpuPyramid>,
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
    /// Uploads a few megabytes, and makes the lit cuts of a scene. What of `before` is the same is kept.
    ///
    /// # Errors
    /// A lost device.
    pub fn new(
        gpu: &GpuDevice,
        pass: &LitPass,
        scene: &GpuScene,
        light: &Illumination,
        lighting: &SceneLighting,
        before: Option<&Self>,
    ) -> Result<Self, BackendError> {
        let before = before.and_then(|before| before.mirrored.as_ref());
        let nodes = storage(gpu, "light tree", bytemuck::cast_slice(&nodes(lighting)));
        let stored = (&scene.cuts, scene.tree_height);
        Ok(Self {
            lit: pass.make(gpu, LitField::Environment, stored, &nodes, &lighting.lit)?,
            nodes,
            brightness: storage(gpu, "brightness", bytemuck::cast_slice(&lighting.brightness)),
            cut: cut_view(gpu, "illumination cut", &lighting.cut),
            max_nodes: lighting.max_nodes,
            rotation: light.rotation,
            intensity: light.intensity,
            mirrored: lighting.mirrored.as_ref().map(|map| GpuPyramid::new(gpu, map.pyramid(), before)),
        })
    }

    /// No light, for a tree of `height`.
    pub fn dark(gpu: &GpuDevice, height: u32) -> Self {
        let nodes = 2_usize << height;
        Self {
            nodes: storage(gpu, "no light", &vec![0; nodes * size_of::<Node>()]),
            brightness: storage(gpu, "no brightness", &vec![0; nodes * size_of::<f32>()]),
            lit: GpuLitCuts::none(gpu),
            cut: cut_view(gpu, "no illumination cut", &[pack_node(0, 0.0)]),
            max_nodes: 0,
            rotation: 0.0,
            intensity: 0.0,
            mirrored: None,
        }
    }
}

fn nodes(lighting: &SceneLighting) -> Vec<Node> {
    let n = &lighting.nodes;
    let node = |i: usize| Node {
        radiance: n.radiance[i].to_array(),
        spread: n.inv_kappa[i],
        place: n.direction[i].to_array(),
        radius: lighting.radii[i],
    };
    (0..n.radiance.len()).map(node).collect()
}

/// Surface sources that send light.
pub struct GpuSources {
    pub nodes: wgpu::Buffer,
    pub brightness: wgpu::Buffer,
    pub lit: GpuLitCuts,
    pub cut: wgpu::TextureView,
    lighting: Arc<SourceLighting>,
}

impl GpuSources {
    /// Uploads, and makes the lit cuts over the sources, unless `before` is the same.
    ///
    /// # Errors
    /// A lost device.
    pub fn new(
        gpu: &GpuDevice,
        pass: &LitPass,
        baked: &SourceCuts,
        lighting: &Arc<SourceLighting>,
        before: Option<Self>,
    ) -> Result<Self, BackendError> {
        if let Some(same) = before.filter(|b| Arc::ptr_eq(&b.lighting, lighting)) {
            return Ok(same);
        }
        let (n, radii) = (&lighting.nodes, lighting.tree.radii());
        let node = |i: usize| Node {
            radiance: n.radiance[i].to_array(),
            spread: n.spread[i],
            place: n.center[i].to_array(),
            radius: radii[i],
        };
        let nodes: Vec<Node> = (0..n.radiance.len()).map(node).collect();
        let nodes = storage(gpu, "source tree", bytemuck::cast_slice(&nodes));
        let stored = (&baked.cuts, baked.tree_height);
        Ok(Self {
            lit: pass.make(gpu, LitField::Sources, stored, &nodes, &lighting.lit)?,
            nodes,
            brightness: storage(gpu, "brightness of sources", bytemuck::cast_slice(&lighting.brightness)),
            cut: cut_view(gpu, "illumination cut of sources", &lighting.cut),
            lighting: lighting.clone(),
        })
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
