//! Each factor's fault appears in its own step, the pictures match the renderer and the references, and exact cuts and references
//! leave no error.

use super::*;
use crate::{
    Quiet,
    test_scenes::{
        LIGHTS, dataset, dataset_of_sigma, floor_and_wall, from_the_side, glossy, illumination, mesh, trace_vertex,
    },
};
use lapidary_core::{
    brdf::GgxParameters,
    dataset::Dataset,
    material::BrdfModel,
    ray::{DirectionSet, Intersector},
    sources::SourceTree,
};
use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

const SIZE: u32 = 24;

/// A glossy floor with a blocker; `sigma` 0 stores the vertices' visibility exactly.
fn floor(cells: u32, sigma: f32) -> Dataset {
    let parameters = GgxParameters { base_color: Vec3::splat(0.5), ..glossy(0.4) };
    let mut dataset = dataset_of_sigma(mesh(cells, true), parameters, sigma);
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    dataset
}

/// A smooth sky with a broad bright patch, well represented by samples.
fn sky() -> Illumination {
    illumination([64, 32], |x, y| {
        let (dx, dy) = ((x as f32 - 33.0) / 5.0, (y as f32 - 10.0) / 3.0);
        Vec3::splat(0.3 + 8.0 * (-dx * dx - dy * dy).exp())
    })
}

struct Faults {
    illum_cut: u32,
    sampling: BrdfSampling,
    sky: Illumination,
    spp: u32,
}

impl Default for Faults {
    fn default() -> Self {
        Self { illum_cut: LIGHTS as u32, sampling: BrdfSampling::Once, sky: sky(), spp: 128 }
    }
}

fn split(dataset: &Dataset, faults: &Faults, progress: &dyn Progress) -> Option<ErrorSplit> {
    let renderer = Renderer::new(dataset.clone());
    let intersector = Intersector::new(&dataset.scene.mesh);
    let directions = DirectionSet::new(dataset.tree.leaf_directions());
    let trace = |v: u32, seen: &mut [u8]| trace_vertex(&dataset.scene.mesh, &intersector, &directions, v, seen);
    let lighting = renderer.lighting(&faults.sky, faults.illum_cut);
    let view = from_the_side(SIZE);
    let job = SplitJob {
        view: &view,
        region: Region { x: 2, y: 8, width: 20, height: 12 },
        light: CutLight::Environment(&lighting),
        sampling: faults.sampling,
        illumination: &faults.sky,
        lights: &[],
        spp: faults.spp,
        trace_vertex: Some(&trace),
    };
    renderer.split_error(&job, progress).unwrap()
}

/// Relative RMSE of the steps: BRDF sampling, light clusters, visibility clusters, interpolation, light samples.
fn steps(dataset: &Dataset, faults: &Faults) -> [f64; 5] {
    let split = split(dataset, faults, &Quiet).unwrap();
    let names: Vec<&str> = split.steps.iter().map(|step| step.factor).collect();
    assert_eq!(names, ["BRDF sampling", "light clusters", "visibility clusters", "interpolation", "light samples"]);
    assert!(split.steps.windows(2).all(|pair| pair[0].to == pair[1].from), "a chain");
    std::array::from_fn(|i| split.steps[i].rel_rmse)
}

#[test]
fn each_fault_appears_in_its_own_step() {
    let fine = steps(&floor(24, 0.0), &Faults::default());
    // Few light nodes: clusters wider than the lobe, sampled once or refined.
    let few = || Faults { illum_cut: 24, ..Faults::default() };
    let once = steps(&floor(24, 0.0), &few());
    let refined = steps(&floor(24, 0.0), &Faults { sampling: BrdfSampling::Refine, ..few() });
    let coarse_cuts = steps(&floor(24, 4.0), &Faults::default());
    let far_apart = steps(&floor(5, 0.0), &Faults::default());
    // A lamp smaller than the sample spacing, above a nearly mirror-like floor.
    let lamp = illumination([256, 128], |x, y| Vec3::splat(if (x, y) == (131, 40) { 3000.0 } else { 0.3 }));
    let mut mirror = floor(24, 0.0);
    mirror.scene.materials[0].parameters.set("roughness", 0.2);
    let small_lamp = steps(&mirror, &Faults { sky: lamp, ..Faults::default() });
    let told = format!("{fine:?} {once:?} {refined:?} {coarse_cuts:?} {far_apart:?} {small_lamp:?}");

    let [brdf, light, cuts, interpolation, samples] = [0, 1, 2, 3, 4];
    assert!(fine[brdf].max(fine[light]).max(fine[cuts]) < 1e-5, "nothing is clustered: {told}");
    assert!((0.001..0.3).contains(&fine[interpolation]) && fine[samples] < 0.1, "{told}");
    assert!(once[brdf] > 0.02 && once[light] > 0.004 && refined[brdf] < 0.7 * once[brdf], "{told}");
    assert_eq!(once[cuts..], fine[cuts..], "what comes after does not change");
    assert!(coarse_cuts[cuts] > 0.003 && coarse_cuts[interpolation..] == fine[interpolation..], "{told}");
    assert!(far_apart[interpolation] > 1.5 * fine[interpolation] && far_apart[cuts] < 1e-5, "{told}");
    // Rays start slightly farther off larger triangles.
    assert!((far_apart[samples] / fine[samples] - 1.0).abs() < 0.1, "{told}");
    // Both contain the paths' noise, identical for equal seeds.
    assert!(small_lamp[samples] > 1.2 * fine[samples] && small_lamp[brdf].max(small_lamp[cuts]) < 1e-5, "{told}");
}

/// Paths with the environment's light alone, as in the split.
fn environment_paths(spp: u32) -> PathSettings {
    PathSettings { components: Components { environment: true, ..Components::NONE }, ..PathSettings::direct(spp) }
}

#[test]
fn the_pictures_are_those_of_renderer_and_references() {
    let dataset = floor(12, 1.0);
    let renderer = Renderer::new(dataset.clone());
    let faults = Faults { illum_cut: 32, sampling: BrdfSampling::Refine, spp: 8, ..Faults::default() };
    let split = split(&dataset, &faults, &Quiet).unwrap();
    // Light samples alone are split.
    let view = View { mirrors: false, ..from_the_side(SIZE) };
    let crop = |image: &Image| {
        let row = |y: u32| (split.region.columns()).map(move |x| (x, y));
        let pixels = split.region.rows().flat_map(row).map(|(x, y)| image.at(x as usize, y as usize)).collect();
        Image { size: split.region.size(), pixels }
    };
    let picture = |kind| &split.pictures.iter().find(|(k, _)| *k == kind).unwrap().1;
    let rendered = renderer.render(&view, &faults.sky, 32, BrdfSampling::Refine).0;
    assert_eq!(picture(SplitPicture::Rendered), &crop(&rendered));
    let samples = renderer.samples_reference(&view, &faults.sky, &Quiet);
    assert_eq!(picture(SplitPicture::Samples), &crop(&samples));
    let paths = renderer.path_reference(&view, &faults.sky, &[], environment_paths(8), &Quiet);
    assert!(compare(picture(SplitPicture::Paths), &crop(&paths)).unwrap().rel_rmse < 1e-5);
    assert_eq!(split.spp, 8);
    let once = renderer.render(&view, &faults.sky, 32, BrdfSampling::Once).0;
    assert_ne!(picture(SplitPicture::Rendered), &crop(&once), "negative control");
    let total = compare(&crop(&rendered), picture(SplitPicture::Paths)).unwrap();
    assert_eq!((split.total.rel_rmse, split.total.flip), (total.rel_rmse, total.flip));
    assert!(split.total.noise > 0.0 && split.steps[0].noise == 0.0);
}

#[test]
fn mean_brdf_and_all_leaves_are_sums_by_hand() {
    let dataset = floor(12, 1.0);
    let renderer = Renderer::new(dataset.clone());
    let faults = Faults { illum_cut: 16, spp: 2, ..Faults::default() };
    let split = split(&dataset, &faults, &Quiet).unwrap();
    let lighting = renderer.lighting(&faults.sky, 16);
    let light = CutLight::Environment(&lighting);
    let explained = renderer.explain(&from_the_side(SIZE), [11, 16], light, BrdfSampling::Once).unwrap();
    let point = explained.surface_point();
    let reflected = |leaf: usize| {
        let direction = dataset.tree.leaf_directions()[leaf];
        let wi = point.world_from_local.transpose() * direction;
        if point.receives(direction) { point.brdf.as_brdf().brdf_cos(wi, point.wo) } else { Vec3::ZERO }
    };
    let of_leaf = dataset.tree.leaf_solid_angle();
    let (mut by_nodes, mut by_leaves) = (Vec3::ZERO, Vec3::ZERO);
    for node in &explained.nodes {
        for leaf in crate::measure::explain::leaves_below(node.heap_index, LIGHTS) {
            by_nodes += node.radiance * node.visibility * reflected(leaf) * of_leaf;
            by_leaves += lighting.nodes.radiance[LIGHTS + leaf] * node.visibility * reflected(leaf) * of_leaf;
        }
    }
    let pixel = |kind| split.pictures.iter().find(|(k, _)| *k == kind).unwrap().1.at(11 - 2, 16 - 8);
    let (nodes, leaves) = (pixel(SplitPicture::MeanBrdf), pixel(SplitPicture::AllLeaves));
    assert!((nodes - by_nodes).length() < 1e-4 * by_nodes.length(), "{nodes} for {by_nodes}");
    assert!((leaves - by_leaves).length() < 1e-4 * by_leaves.length(), "{leaves} for {by_leaves}");
    assert!((nodes - by_leaves).length() > 1e-3 * by_leaves.length(), "negative control");
}

#[test]
fn lit_cuts_are_a_step_of_their_own_which_grows_with_tau() {
    let dataset = floor(12, 1.0);
    let renderer = Renderer::new(dataset.clone());
    let view = from_the_side(SIZE);
    let steps = |tau: f32, sampling| {
        let lighting = renderer.lighting(&sky(), 1).with_tau(tau);
        let job = SplitJob {
            view: &view,
            region: Region { x: 2, y: 8, width: 20, height: 12 },
            light: CutLight::Environment(&lighting),
            sampling,
            illumination: &sky(),
            lights: &[],
            spp: 2,
            trace_vertex: None,
        };
        renderer.split_error(&job, &Quiet).unwrap().unwrap().steps
    };
    let lit = |tau| {
        let steps = steps(tau, BrdfSampling::Lit);
        assert_eq!((steps[0].factor, steps[1].factor), ("lit cuts", "BRDF sampling"));
        steps[0].rel_rmse
    };
    assert!(lit(0.0) < 1e-6, "the stored cuts, and an illumination cut of the root, summed in another order");
    assert!(lit(0.3) > 2.0 * lit(0.003) && lit(0.3) > 1e-4, "{} {}", lit(0.3), lit(0.003));
    assert!(steps(0.3, BrdfSampling::Refine).iter().all(|step| step.factor != "lit cuts"), "negative control");
}

#[test]
fn bounced_light_is_split_without_a_step_of_vertices() {
    let dataset = floor_and_wall(4);
    let renderer = Renderer::new(dataset.clone());
    let sources = &dataset.indirect.as_ref().unwrap().sources;
    let lighting = SourceLighting::new(Arc::new(SourceTree::new(sources)), &vec![Vec3::ONE; sources.len()], 16);
    let (view, dark) = (from_the_side(SIZE), illumination([8, 4], |_, _| Vec3::ZERO));
    let job = SplitJob {
        view: &view,
        region: Region { x: 8, y: 12, width: 8, height: 8 },
        light: CutLight::Sources(&lighting),
        sampling: BrdfSampling::Refine,
        illumination: &dark,
        lights: &[],
        spp: 2,
        trace_vertex: None,
    };
    let split = renderer.split_error(&job, &Quiet).unwrap().unwrap();
    let names: Vec<&str> = split.steps.iter().map(|step| step.factor).collect();
    assert_eq!(names, ["BRDF sampling", "light clusters", "visibility", "light samples"]);
    // No light reaches the wall, although these sources are bright there.
    assert!(split.steps[2].rel_rmse < 0.1 && split.pictures[4].1.pixels.iter().all(|p| *p == Vec3::ZERO));
    let samples = renderer.sources_reference(&view, &lighting, &Quiet);
    assert_eq!(split.pictures[3].1.at(3, 3), samples.at(11, 15));
}

#[test]
fn a_cancelled_split_is_none_and_progress_only_rises() {
    struct Stop {
        after: usize,
        last: AtomicUsize,
        pictures: AtomicUsize,
    }
    impl Progress for Stop {
        fn advanced(&self, done: u64, total: u64) {
            let permille = (1000 * done / total) as usize;
            assert!(permille <= 1000 && self.last.fetch_max(permille, Ordering::Relaxed) <= permille);
        }
        fn preview(&self, _: &crate::Preview) {
            self.pictures.fetch_add(1, Ordering::Relaxed);
        }
        fn cancelled(&self) -> bool {
            self.pictures.load(Ordering::Relaxed) >= self.after
        }
    }
    let dataset = floor(4, 1.0);
    let faults = Faults { illum_cut: 16, spp: 4, ..Faults::default() };
    for after in [0, 3, 5] {
        let stop = Stop { after, last: 0.into(), pictures: 0.into() };
        assert!(split(&dataset, &faults, &stop).is_none(), "after {after}");
        assert_eq!(stop.pictures.load(Ordering::Relaxed), after);
    }
    let through = Stop { after: 99, last: 0.into(), pictures: 0.into() };
    assert!(split(&dataset, &faults, &through).is_some());
    assert_eq!((through.last.into_inner(), through.pictures.into_inner()), (1000, 6));
}

#[test]
fn regions_without_pixels_or_surfaces_are_refused() {
    let renderer = Renderer::new(dataset(mesh(2, false), glossy(0.5)));
    let sky = sky();
    let lighting = renderer.lighting(&sky, 16);
    let mut view = from_the_side(SIZE);
    view.camera.target = view.camera.eye + Vec3::Y + Vec3::Z * 0.01;
    let job = |region| SplitJob {
        view: &view,
        region,
        light: CutLight::Environment(&lighting),
        sampling: BrdfSampling::Once,
        illumination: &sky,
        lights: &[],
        spp: 1,
        trace_vertex: None,
    };
    let error = |region| renderer.split_error(&job(region), &Quiet).unwrap_err();
    assert_eq!(error(Region { x: 0, y: 0, width: 0, height: 3 }), SplitError::Region(RegionError::Empty));
    assert!(matches!(
        error(Region { x: 20, y: 0, width: 9, height: 3 }),
        SplitError::Region(RegionError::Outside { .. })
    ));
    assert_eq!(error(Region::whole(view.size)), SplitError::NoSurface);
}
