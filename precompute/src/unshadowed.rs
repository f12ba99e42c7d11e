//! A dataset of a scene before its first bake, in which every vertex sees every light: it displays a newly opened scene until
//! visibility is traced.

use crate::vertices::sidedness::classify;
use lapidary_core::{
    cut::packed::{PackedCuts, pack_node},
    dataset::{BakeParts, BakeReport, BakeSettings, Dataset},
    ground::{Ground, add_ground},
    light_tree::{LightTree, TreeKind},
    scene::Scene,
};

/// Number of lights: light without shadows is smooth.
const LIGHTS: usize = 256;

/// The dataset of a scene as imported, without occlusion, on the ground of a bake with these settings and in its environment, if it has
/// one. It takes milliseconds. Without an environment it has no part of a bake, and is not to be written.
pub fn unshadowed(mut scene: Scene, scene_hash: String, baked: &BakeSettings) -> Dataset {
    let ground = baked.ground;
    let mode = if baked.mode.environment() { BakeParts::ENVIRONMENT } else { BakeParts::NONE };
    let source_vertices = scene.mesh.positions.len();
    if ground != Ground::Off {
        add_ground(&mut scene);
    }
    let (vertices, triangles) = (scene.mesh.positions.len(), scene.mesh.triangles.len());
    let mut cuts = PackedCuts::default();
    let all = cuts.push_cut(&[pack_node(0, 1.0)]);
    (0..vertices).for_each(|_| cuts.push_vertex(all));
    let tree = TreeKind::Geometric;
    Dataset {
        two_sided: classify(&scene).two_sided,
        vertex_valid: vec![true; vertices],
        tree: LightTree::geometric(LIGHTS).expect("a power of two"),
        cuts,
        indirect: None,
        meshless: None,
        object_bases: None,
        wavelet: None,
        settings: BakeSettings { mode, lights: LIGHTS, tree, ground, max_vertices: None, ..BakeSettings::default() },
        scene_hash,
        report: BakeReport { vertices, triangles, source_vertices, lights: LIGHTS, tree, ..BakeReport::default() },
        scene,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{room, scene_of};
    use glam::Vec3;
    use lapidary_core::dataset::scene_hash;

    #[test]
    fn it_is_a_valid_dataset_whose_vertices_see_everything() {
        let scene = scene_of(&room(Vec3::ZERO, Vec3::ONE));
        let vertices = scene.mesh.positions.len();
        let baked = |mode| BakeSettings { mode, ..BakeSettings::default() };
        let dataset = unshadowed(scene.clone(), scene_hash(&scene), &baked(BakeParts::CUTS));
        dataset.validate().unwrap();
        assert_eq!(dataset.settings.mode, BakeParts::ENVIRONMENT);
        let dark = unshadowed(scene.clone(), scene_hash(&scene), &baked(BakeParts::INDIRECT));
        assert!(!dark.settings.mode.environment(), "as the bake will be");
        assert_eq!((dataset.scene_hash, dataset.scene.mesh.positions.len()), (scene_hash(&scene), vertices));
        for vertex in 0..vertices as u32 {
            assert_eq!(dataset.cuts.cut(8, vertex), [pack_node(0, 1.0)]);
        }
    }
}
