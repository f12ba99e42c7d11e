//! Datasets of one geometry with cuts selected elsewhere.

use super::{
    checkpoint::Chunk,
    phases::{
        geometry::Geometry,
        pack::pack,
        point_cuts::{PointCuts, unbaked},
    },
    report::report,
    settings::ResolvedBake,
};
use crate::errors::{BakeError, CutsOf};
use lapidary_core::{
    dataset::{BakeReport, Dataset},
    light_tree::LightTree,
};

impl Geometry {
    /// The dataset of distant light with `cuts` over `tree`, one for each of `points`, and fully occluded cuts for all other
    /// points. Its report covers `points` alone, without times; it has no scene hash.
    ///
    /// # Errors
    /// Cuts too large for a texture.
    pub fn environment_dataset(
        &self,
        settings: ResolvedBake,
        tree: LightTree,
        points: &[u32],
        cuts: &Chunk,
    ) -> Result<Dataset, BakeError> {
        let mut of_points = PointCuts::new(tree.height());
        of_points.push_borrowed(cuts);
        // The last cut belongs to all unbaked points.
        let mut cut_of_point = vec![points.len() as u32; self.bake_points()];
        points.iter().enumerate().for_each(|(i, &point)| cut_of_point[point as usize] = i as u32);
        if points.len() < self.bake_points() {
            of_points.push(unbaked(1));
        }
        let of_vertex = self.points.of_vertex.iter().map(|&p| cut_of_point[p as usize]);
        let packed = pack(&of_points, None, of_vertex, CutsOf::Environment)?;
        let pairs = points.len() as u64 * settings.lights as u64;
        let report = BakeReport {
            mean_cut: cuts.nodes.len() as f64 / points.len().max(1) as f64,
            sigma: settings.criterion.sigma,
            rms_visibility: (cuts.squared_errors.iter().sum::<f64>() / pairs.max(1) as f64).sqrt(),
            samples_resolved: pairs,
            bake_points: points.len(),
            ..report(self, &settings, &packed, Vec::new())
        };
        let mut dataset = Dataset {
            scene: self.scene.clone(),
            two_sided: self.sides.two_sided.clone(),
            vertex_valid: self.vertex_valid(),
            tree,
            cuts: packed.cuts,
            indirect: None,
            meshless: None,
            object_bases: None,
            wavelet: None,
            settings: settings.into_settings(),
            scene_hash: String::new(),
            report,
        };
        dataset.report.bytes_total = dataset.tensor_bytes();
        Ok(dataset)
    }
}
