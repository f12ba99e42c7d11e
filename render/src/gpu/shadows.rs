//! Shadow maps of local lights: layers of one depth texture. Only layers whose view has changed are rendered again.

mod plan;
mod view;

pub use plan::{Plan, ShadowRoom, capacity, shines};
pub use view::{ShadowViewSettings, views, views_per_point};

use super::{draw::bind, targets::format};
use crate::device::{GpuDevice, layout::ShadowView, pass::Pass};

/// A depth texture and what its layers show.
pub struct ShadowMaps {
    size: u32,
    /// All layers, for the direct pass.
    pub array: wgpu::TextureView,
    layers: Vec<wgpu::TextureView>,
    /// View from which each layer was rendered.
    rendered: Vec<Option<ShadowView>>,
}

impl ShadowMaps {
    /// Maps of `size` texels per side with nothing in them.
    pub fn new(gpu: &GpuDevice, size: u32, layers: u32) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: format::DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = |label, dimension, first, count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some(label),
                dimension: Some(dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                ..Default::default()
            })
        };
        let layer = |i| view("shadow map", wgpu::TextureViewDimension::D2, i, 1);
        Self {
            size,
            array: view("shadow maps", wgpu::TextureViewDimension::D2Array, 0, layers),
            layers: (0..layers).map(layer).collect(),
            rendered: vec![None; layers as usize],
        }
    }

    /// Whether `layers` of `size` texels per side fit in as they are.
    pub fn holds(&self, size: u32, layers: u32) -> bool {
        self.size == size && self.layers.len() >= layers as usize
    }

    /// Layers to be rendered to show `views`.
    pub fn stale(&self, views: &[ShadowView]) -> Vec<u32> {
        stale(&self.rendered, views)
    }

    /// Marks all layers as out of date, after a change of the scene.
    pub fn forget(&mut self) {
        self.rendered.fill(None);
    }

    /// Renders a layer: the view at its index in `groups`, whose first is the frame, then scene and views.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pass: &Pass,
        groups: [&wgpu::BindGroup; 3],
        corners: u32,
        (layer, view): (u32, ShadowView),
    ) {
        let mut drawing = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(pass.label),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.layers[layer as usize],
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        bind(&mut drawing, pass, &groups);
        drawing.draw(0..corners, layer..layer + 1);
        self.rendered[layer as usize] = Some(view);
    }
}

fn stale(rendered: &[Option<ShadowView>], views: &[ShadowView]) -> Vec<u32> {
    let differs = |(before, view): &(&Option<ShadowView>, &ShadowView)| before.as_ref() != Some(*view);
    let numbered = rendered.iter().zip(views).enumerate();
    numbered.filter(|(_, pair)| differs(pair)).map(|(layer, _)| layer as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::lights::{Emission, Light};

    fn lamps() -> Vec<Light> {
        let lamp = |emission, x| Light { emission, position: Vec3::new(x, 2.0, 0.0), ..Default::default() };
        let spot = Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 10.0 };
        vec![lamp(spot, 0.0), lamp(Emission::Point, 1.0), lamp(spot, 2.0)]
    }

    fn all_views(lights: &[Light]) -> Vec<ShadowView> {
        lights.iter().flat_map(|l| views(l, &ShadowViewSettings { near: 1e-4, size: 512, grid: 2 })).collect()
    }

    #[test]
    fn only_layers_of_a_light_that_moved_are_stale() {
        let lights = lamps();
        let mut rendered = vec![None; 9];
        assert_eq!(stale(&rendered, &all_views(&lights)).len(), 8, "at first all are");
        rendered[..8].clone_from_slice(&all_views(&lights).into_iter().map(Some).collect::<Vec<_>>());
        assert!(stale(&rendered, &all_views(&lights)).is_empty());
        let changed = |change: fn(&mut Vec<Light>)| {
            let mut lights = lights.clone();
            change(&mut lights);
            stale(&rendered, &all_views(&lights))
        };
        assert_eq!(changed(|l| l[1].position.x += 0.01), [1, 2, 3, 4, 5, 6]);
        assert_eq!(changed(|l| l[0].target.x += 0.01), [0]);
        assert!(changed(|l| l.iter_mut().for_each(|l| l.intensity *= 3.0)).is_empty());
        assert_eq!(changed(|l| l[2].position *= 2.0), [7]);
        let softer = Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 20.0 };
        assert!(stale(&rendered, &all_views(&[Light { emission: softer, ..lights[0].clone() }])).is_empty());
    }
}
