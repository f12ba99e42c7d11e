//! How large the measurements are.

use serde::Serialize;

/// Sizes of everything that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasurementScale {
    /// Samples of the environment, but where their number is swept.
    pub lights: usize,
    /// Vertex clusters of pilot visibility.
    pub pilot_clusters: usize,
    /// Most vertices after tessellation, but where they are swept; a mesh that has as many gets a quarter more.
    pub max_vertices: usize,
    /// Surface sources of scenes with local lights.
    pub sources: usize,
    /// Most vertices of scenes with local lights, likewise.
    pub bounce_vertices: usize,
    /// Pictures that are held against references, in pixels.
    pub view: [u32; 2],
    /// Pictures whose time is taken, in pixels; the paper's are 640 x 480.
    pub frame: [u32; 2],
    /// Frames to take the median of.
    pub frames: usize,
    /// Side in texels of the cube map's faces.
    pub cube_side: usize,
    /// Points whose visibility is approximated by wavelets and cuts.
    pub cube_points: usize,
    /// Nodes of the illumination cut where other things are swept: many, so that theirs is not the error.
    pub sweep_cut: u32,
    /// Samples a pixel of light paths; even.
    pub spp: u32,
    /// Vertex clusters of pilot visibility there: fewer, for each point of a sweep samples its own.
    pub sweep_pilot_clusters: usize,
    /// Weights of the geometric metric.
    pub betas: &'static [f32],
    /// Error bounds of visibility cuts.
    pub sigmas: &'static [f32],
    /// Numbers of light samples.
    pub light_counts: &'static [usize],
    /// Vertex budgets, as multiples of what the mesh has; 1 leaves it as it is.
    pub vertex_budgets: &'static [f64],
    /// Squares along the walls of rooms whose links are timed: 6 (side + 1)² vertices.
    pub room_sides: &'static [u32],
    /// The same of the room whose links are held against all pairs.
    pub refined_room_side: u32,
    /// Steps of a drag.
    pub drag_steps: u32,
    /// Samples a pixel of light paths of posed scenes; even.
    pub drag_spp: u32,
}

impl MeasurementScale {
    /// What the documented figures are made with: some tens of minutes on two cores.
    pub const FULL: &'static Self = &Self {
        lights: 32_768,
        pilot_clusters: 1024,
        max_vertices: 50_000,
        sources: 8192,
        bounce_vertices: 20_000,
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

    /// To see that it works.
    pub const QUICK: &'static Self = &Self {
        lights: 1024,
        pilot_clusters: 32,
        max_vertices: 800,
        sources: 256,
        bounce_vertices: 400,
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

    /// The error bound that means as much as sigma 2 at the paper's 32,768 lights: Eq. 5 bounds the number of lights times
    /// their variance.
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
