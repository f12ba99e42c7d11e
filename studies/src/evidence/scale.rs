//! Sizes of the measurements.

use lapidary_core::dataset::{MeshlessSettings, ObjectBasesSettings};
use serde::Serialize;

/// Sizes of all measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasurementScale {
    /// Samples of the environment, unless swept.
    pub lights: usize,
    /// Vertex clusters of pilot visibility.
    pub pilot_clusters: usize,
    /// Most vertices after tessellation, unless swept; a mesh that already has as many gets a quarter more.
    pub max_vertices: usize,
    /// Surface sources of scenes with local lights.
    pub sources: usize,
    /// Most vertices of scenes with local lights; as for `max_vertices`.
    pub bounce_vertices: usize,
    /// Levels of the meshless basis, and those of them that send.
    pub basis_levels: [usize; 2],
    /// Functions of objects.
    pub object_bases: ObjectBasesSettings,
    /// Pixels of pictures compared with references.
    pub view: [u32; 2],
    /// Pixels of timed pictures; the paper's are 640 x 480.
    pub frame: [u32; 2],
    /// Frames in the median.
    pub frames: usize,
    /// Side in texels of the cube map's faces.
    pub cube_side: usize,
    /// Points whose visibility wavelets and cuts approximate.
    pub cube_points: usize,
    /// Nodes of the illumination cut in sweeps of other settings: many, so that their error does not dominate.
    pub sweep_cut: u32,
    /// Light paths per pixel; even.
    pub spp: u32,
    /// Vertex clusters of pilot visibility in sweeps: fewer, because each point of a sweep samples its own.
    pub sweep_pilot_clusters: usize,
    /// Weights of the geometric metric.
    pub betas: &'static [f32],
    /// Error bounds of visibility cuts.
    pub sigmas: &'static [f32],
    /// Numbers of light samples.
    pub light_counts: &'static [usize],
    /// Vertex budgets as multiples of the mesh's vertices; 1 adds none.
    pub vertex_budgets: &'static [f64],
    /// Squares along the walls of rooms with timed links: 6 (side + 1)² vertices.
    pub room_sides: &'static [u32],
    /// Squares along the walls of the room whose links are compared with all pairs.
    pub refined_room_side: u32,
    /// Steps of a drag.
    pub drag_steps: u32,
    /// Light paths per pixel in posed scenes; even.
    pub drag_spp: u32,
}

impl MeasurementScale {
    /// Scale of the documented figures: some tens of minutes on two cores.
    pub const FULL: &'static Self = &Self {
        lights: 32_768,
        pilot_clusters: 1024,
        max_vertices: 50_000,
        sources: 8192,
        bounce_vertices: 20_000,
        basis_levels: [5, 3],
        object_bases: ObjectBasesSettings { functions: 150_000, levels: 6, sender_level: 4 },
        view: [160, 120],
        frame: [640, 480],
        frames: 3,
        cube_side: 128,
        cube_points: 256,
        sweep_cut: 512,
        spp: 512,
        sweep_pilot_clusters: 256,
        betas: &[0.0, 0.25, 0.5, 0.75, 1.0],
        sigmas: &[0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0],
        light_counts: &[2048, 4096, 8192, 16_384, 32_768],
        vertex_budgets: &[1.0, 1.05, 1.25, 1.75, 3.0],
        room_sides: &[11, 16, 23, 28, 90],
        refined_room_side: 28,
        drag_steps: 20,
        drag_spp: 128,
    };

    /// Scale of a quick check.
    pub const QUICK: &'static Self = &Self {
        lights: 1024,
        pilot_clusters: 32,
        max_vertices: 800,
        sources: 256,
        bounce_vertices: 400,
        basis_levels: [3, 2],
        object_bases: ObjectBasesSettings { functions: 600, levels: 3, sender_level: 1 },
        view: [32, 24],
        frame: [48, 36],
        frames: 1,
        cube_side: 16,
        cube_points: 16,
        sweep_cut: 128,
        spp: 16,
        sweep_pilot_clusters: 32,
        betas: &[0.0, 0.5, 1.0],
        sigmas: &[0.25, 1.0, 4.0],
        light_counts: &[256, 1024],
        vertex_budgets: &[1.0, 1.2],
        room_sides: &[4, 6],
        refined_room_side: 6,
        drag_steps: 2,
        drag_spp: 16,
    };

    /// The meshless basis of a bake.
    pub fn meshless_settings(&self) -> MeshlessSettings {
        let [levels, sender_levels] = self.basis_levels;
        MeshlessSettings { levels, sender_levels, ..MeshlessSettings::default() }
    }

    /// The error bound equivalent to sigma 2 at the paper's 32,768 lights: Eq. 5 bounds the number of lights times their variance.
    pub fn sigma_for(lights: usize) -> f32 {
        2.0 * (lights as f32 / 32_768.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::light_tree::height_of;

    #[test]
    fn sizes_are_ones_that_can_be_baked() {
        for scale in [MeasurementScale::FULL, MeasurementScale::QUICK] {
            let counts = scale.light_counts.iter().chain([&scale.lights, &scale.sources]);
            assert!(counts.clone().all(|&n| height_of(n).is_ok()));
            assert!(
                scale.cube_side.is_power_of_two()
                    && scale.spp.is_multiple_of(2)
                    && scale.drag_spp.is_multiple_of(2)
                    && scale.frames > 0
            );
            assert!(scale.betas.iter().all(|b| (0.0..=1.0).contains(b)));
        }
        assert_eq!((MeasurementScale::sigma_for(32_768), MeasurementScale::sigma_for(8192)), (2.0, 1.0));
    }
}
