//! Shading without occlusion: a single convex surface.
//!
//! The merge is the renderer's. Full visibility is a cut with the root alone, so the merged cut is the illumination cut.

use crate::{
    appearance::{Appearance, ResolvedAppearance},
    light::environment::SceneLighting,
    shade::{
        merge::Shader,
        surface::{PlaceLook, SurfacePlace, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::cut::packed::{PackedCuts, pack_node};
use std::sync::LazyLock;

/// A vertex that sees every light.
static FULL_VISIBILITY: LazyLock<PackedCuts> = LazyLock::new(|| {
    let mut cuts = PackedCuts::default();
    let first = cuts.push_cut(&[pack_node(0, 1.0)]);
    cuts.push_vertex(first);
    cuts
});

/// Shades surface positions that see every direction above their horizon, with BRDF refinement; keeps its buffers between them.
pub struct UnoccludedShader<'a> {
    appearance: ResolvedAppearance,
    shader: Shader<'a, &'a SceneLighting>,
}

impl<'a> UnoccludedShader<'a> {
    /// For surface positions with the materials of `appearance` under `lighting`. All maps must be present
    /// ([`Appearance::fitted`]).
    pub fn new(appearance: Appearance, lighting: &'a SceneLighting) -> Self {
        Self { appearance: appearance.into(), shader: Shader::unoccluded(lighting, &FULL_VISIBILITY) }
    }

    /// Radiance that a surface position with this material emits and reflects toward `wo`, a unit direction in world space.
    ///
    /// # Panics
    /// If the material index is out of range.
    pub fn shade(&mut self, place: &SurfacePlace, material: usize, wo: Vec3) -> Vec3 {
        let PlaceLook { world_from_local, wo, slopes, material: look } =
            place.under(&self.appearance, self.appearance.material(material as u32), wo);
        let reflected = self.shader.shade(&SurfacePoint {
            material: material as u32,
            triangle: 0,
            vertices: [0; 3],
            corners: [place.position; 3],
            barycentric: Vec3::X,
            weights: [1.0, 0.0, 0.0],
            from_behind: false,
            position: place.position,
            ray_origin: place.position,
            face_normal: place.smooth_normal,
            smooth_normal: place.smooth_normal,
            world_from_local,
            wo,
            base_color: look.base_color,
            roughness: look.roughness,
            brdf: look.brdf,
            emission: look.emission,
            slopes,
            by_cone: 0.0,
            is_catcher: false,
            ground: None,
        });
        look.emission + reflected
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use lapidary_core::{
        brdf::GgxParameters,
        light_tree::LightTree,
        material::{BrdfModel, Material},
    };

    #[test]
    fn a_white_place_in_a_white_furnace_is_white_and_a_lamp_below_its_horizon_is_not_seen() {
        let tree = LightTree::geometric(4096).unwrap();
        let parameters = GgxParameters { base_color: Vec3::ONE, ..Default::default() };
        let white = Material { model: BrdfModel::Lambert, parameters: parameters.into(), ..Default::default() };
        let appearance = Appearance { materials: vec![white], ..Default::default() };
        let place = SurfacePlace {
            position: Vec3::ZERO,
            smooth_normal: Vec3::Y,
            tangent: Vec3::X,
            handedness: 1.0,
            attributes: Vec2::ZERO.into(),
            slopes: [None; 2],
        };
        let shaded = |radiance: &dyn Fn(Vec3) -> f32| {
            let leaves: Vec<Vec3> = tree.leaf_directions().iter().map(|&d| Vec3::splat(radiance(d))).collect();
            let lighting = SceneLighting::new(&tree, &leaves, 256);
            UnoccludedShader::new(appearance.clone(), &lighting).shade(&place, 0, Vec3::new(0.6, 0.8, 0.0)).x
        };
        assert!((shaded(&|_| 1.0) - 1.0).abs() < 5e-3, "{}", shaded(&|_| 1.0));
        assert_eq!(shaded(&|d| if d.y < 0.0 { 1.0 } else { 0.0 }), 0.0);
        assert!(shaded(&|d| if d.y > 0.0 { 0.98 } else { 0.0 }) < 0.99, "negative control: two percent less is seen");
    }
}
