//! Whole bakes of small scenes.

use super::*;
use crate::{
    bake::{
        checkpoint::Checkpoint,
        settings::{Preset, resolve},
    },
    observer::Silent,
    test_scenes::{cuboid, floor, room, scene_of},
};
use glam::Vec3;
use lapidary_core::{
    cut::{
        LARGEST_SOLID_ANGLE,
        packed::{VALUE_MAX, depth},
        solid_angle,
    },
    dataset::{BakeParts, BakeSettings, IndirectSettings, MeshlessSettings},
    lock::LockError,
    sources::{Source, SourceTree},
};
use lapidary_interchange::image;
use std::{
    f32::consts::PI,
    path::Path,
    sync::{
        Mutex, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
};

mod devices;
mod ground;
mod opacity;
mod posed;
mod progress;
mod resumed;
mod shards;
mod viewpoint;

fn scene() -> Scene {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
    scene_of(&triangles)
}

fn settings() -> BakeSettings {
    BakeSettings { lights: 512, pilot_clusters: 32, max_vertices: Some(600), ..Preset::Draft.settings() }
}

fn job(folder: &Path, name: &str) -> BakeJob {
    BakeJob::new(resolve(settings()).unwrap(), folder.join(name))
}

/// The job with other settings.
fn with(job: BakeJob, change: impl FnOnce(&mut BakeSettings)) -> BakeJob {
    let mut settings = job.settings.into_settings();
    change(&mut settings);
    BakeJob { settings: resolve(settings).unwrap(), ..job }
}

/// Baked contents of the environment.
fn contents(dataset: &Dataset) -> (Vec<u16>, Vec<u32>, Vec<u32>, Vec<Vec3>) {
    let mesh = &dataset.scene.mesh;
    (
        dataset.cuts.nodes().to_vec(),
        dataset.cuts.offsets().to_vec(),
        dataset.tree.order().to_vec(),
        mesh.positions.clone(),
    )
}

/// Cancels at the first progress of a phase.
struct CancelIn {
    phase: Phase,
    started: AtomicBool,
    cancelled: AtomicBool,
}

impl CancelIn {
    fn phase(phase: Phase) -> Self {
        Self { phase, started: AtomicBool::new(false), cancelled: AtomicBool::new(false) }
    }
}

impl Observer for CancelIn {
    fn event(&self, event: Event) {
        match event {
            Event::Started { phase, .. } => self.started.store(phase == self.phase, Ordering::Relaxed),
            Event::Advanced { .. } if self.started.load(Ordering::Relaxed) => {
                self.cancelled.store(true, Ordering::Relaxed)
            }
            _ => {}
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Keeps warnings.
#[derive(Default)]
struct Told(Mutex<Vec<String>>);

impl Told {
    fn all(&self) -> Vec<String> {
        self.0.lock().unwrap().clone()
    }
}

impl Observer for Told {
    fn event(&self, event: Event) {
        if let Event::Warning { message } = event {
            self.0.lock().unwrap().push(message.to_string());
        }
    }
}

#[test]
fn chunks_and_threads_do_not_change_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, chunks, threads, change: fn(&mut BakeSettings)| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let job = BakeJob { chunks, ..with(indirect_job(folder.path(), name, BakeParts::ALL), change) };
        pool.install(|| bake(interior(), &job, &Silent)).unwrap();
        std::fs::read(&job.output).unwrap()
    };
    let one = run("a.cuts", Some(1), 1, |_| {});
    assert!(one == run("b.cuts", Some(7), 3, |_| {}), "equal bakes are equal files");
    assert!(one == run("c.cuts", None, 2, |_| {}), "equal bakes are equal files");
    assert!(one != run("d.cuts", Some(1), 1, |settings| settings.beta = 0.1), "negative control");
}

#[test]
fn report_adds_up_and_a_floor_of_two_triangles_gets_a_shadow() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = bake(scene(), &job(folder.path(), "a.cuts"), &Silent).unwrap();
    let report = &dataset.report;
    assert_eq!(report.samples_resolved, report.bake_points as u64 * 512);
    assert_eq!(report.cut_size_histogram.iter().sum::<u64>(), report.bake_points as u64);
    assert!(report.rms_visibility > 0.0 && report.rms_visibility < 0.2);
    assert!(report.rays_traced < report.samples_resolved);
    for phase in ["import", "tessellate", "pilot", "tree", "visibility", "pack", "total"] {
        assert!(report.seconds(phase).is_some(), "{phase}");
    }
    // Directly under the box the zenith is blocked, far away it is open.
    let zenith = |near: Vec3| {
        let mesh = &dataset.scene.mesh;
        let on_floor = (0..mesh.positions.len()).filter(|&v| mesh.positions[v].y == 0.0);
        let distance = |v: &usize| mesh.positions[*v].distance(near);
        let vertex = on_floor.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let leaf = (0..512).max_by(|&a, &b| {
            let y = |l: usize| dataset.tree.leaf_directions()[l].y;
            y(a).total_cmp(&y(b))
        });
        let mut end = 0;
        let cut = dataset.cuts.cut(9, vertex as u32);
        let node = cut.iter().find(|&&n| {
            end += 512 >> lapidary_core::cut::packed::depth(n);
            end > leaf.unwrap()
        });
        lapidary_core::cut::packed::value(*node.unwrap())
    };
    assert!(zenith(Vec3::new(0.3, 0.0, 0.2)) < 0.5);
    assert!(zenith(Vec3::new(-1.8, 0.0, -1.8)) > 0.8);
}

#[test]
fn a_bake_follows_boundaries_and_is_as_good_as_an_exhaustive_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, exhaustive| {
        let job =
            with(job(folder.path(), name), |settings| (settings.lights, settings.exhaustive) = (4096, exhaustive));
        bake(scene(), &job, &Silent).unwrap()
    };
    let (followed, exhaustive) = (run("a.cuts", false).report, run("b.cuts", true).report);
    let audit = followed.audit.expect("an audit");
    assert!(exhaustive.audit.is_none() && audit.leaves_per_probe == 16, "{audit:?}");
    assert_eq!(audit.vertices, 64);
    assert!(audit.leaves_wrong < 1e-3 && audit.rms_exhaustive > 0.0, "{audit:?}");
    assert!(audit.rms_error <= 1.01 * audit.rms_exhaustive, "{audit:?}");
    assert!(10 * followed.rays_traced < 4 * exhaustive.rays_traced, "{} rays", followed.rays_traced);
    assert!((followed.mean_cut / exhaustive.mean_cut - 1.0).abs() < 0.01);
    assert!((followed.rms_visibility / exhaustive.rms_visibility - 1.0).abs() < 0.01);
}

#[test]
fn sources_are_traced_along_boundaries_and_as_good_as_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, exhaustive| {
        let job = with(job(folder.path(), name), |settings| {
            (settings.mode, settings.lights, settings.exhaustive) = (BakeParts::INDIRECT, 256, exhaustive);
            settings.indirect.sources = 4096;
        });
        bake(scene(), &job, &Silent).unwrap()
    };
    let (dataset, exhaustive) = (run("a.cuts", false), run("b.cuts", true).report.indirect.unwrap());
    let verified = crate::verify(&dataset, 64);
    assert!(verified.passed && verified.sources.source_vertices == 64, "{verified:?}");
    assert!(verified.sources.source_error <= 1.02 * verified.sources.exhaustive_source_error, "{verified:?}");
    let followed = dataset.report.indirect.unwrap();
    let audit = followed.audit.expect("an audit");
    assert!(exhaustive.audit.is_none() && exhaustive.sources_per_probe() == 1);
    assert!(audit.leaves_per_probe > 1 && audit.vertices == 64, "{audit:?}");
    assert!(audit.leaves_wrong < 5e-3 && audit.rms_exhaustive > 0.0, "{audit:?}");
    assert!(followed.rays_traced < exhaustive.rays_traced, "{} rays", followed.rays_traced);
    assert!((followed.mean_cut / exhaustive.mean_cut - 1.0).abs() < 0.02, "{}", followed.mean_cut);
}

#[test]
fn what_is_too_fine_for_boundaries_is_traced_exhaustively() {
    // Specks over a floor, each as wide as one or two lights, so that most lie between probes.
    let mut triangles = floor(1.0, 0.0).to_vec();
    for speck in 0..49 {
        let (x, z) = (0.3 * (speck % 7 - 3) as f32, 0.3 * (speck / 7 - 3) as f32);
        triangles.extend(cuboid(Vec3::new(x, 0.5, z), Vec3::splat(0.012)));
    }
    let folder = tempfile::tempdir().unwrap();
    let job = with(job(folder.path(), "a.cuts"), |settings| {
        (settings.lights, settings.criterion.sigma) = (2048, 0.6);
    });
    let dataset = bake(scene_of(&triangles), &job, &Silent).unwrap();
    let audit = dataset.report.audit.expect("an audit");
    assert_eq!((audit.leaves_per_probe, audit.leaves_wrong), (1, 0.0), "{audit:?}");
    assert_eq!(audit.rms_error, audit.rms_exhaustive);
    assert!(3 * dataset.report.rays_traced > dataset.report.samples_resolved, "all above the horizons");
    assert!(crate::verify(&dataset, 64).passed);
}

#[test]
fn a_byte_budget_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    // Each cut takes a texel at least: halves of finer cuts have room for more.
    let fine = |name| with(job(folder.path(), name), |settings| settings.criterion.sigma = 0.5);
    let free = bake(scene(), &fine("a.cuts"), &Silent).unwrap();
    let half = (2 * free.cuts.nodes().len() as u64) / 2;
    let job = with(fine("b.cuts"), |settings| settings.max_bytes = Some(half));
    let tight = bake(scene(), &job, &Silent).unwrap();
    assert!(2 * tight.cuts.nodes().len() as u64 <= half);
    assert!(tight.report.sigma > free.report.sigma && tight.report.mean_cut < free.report.mean_cut);
}

#[test]
fn an_output_that_cannot_be_written_is_an_error_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob { output: folder.path().join("no/such/folder/\0a.cuts"), ..job(folder.path(), "") };
    assert!(matches!(bake(scene(), &job, &Silent), Err(BakeError::Output(_))));
}

/// A small room with a box in it.
fn interior() -> Scene {
    let mut triangles = room(Vec3::ZERO, Vec3::new(1.0, 0.7, 0.8));
    triangles.extend(cuboid(Vec3::new(0.3, -0.4, 0.2), Vec3::splat(0.2)));
    scene_of(&triangles)
}

/// A small bake from a viewpoint in the interior: searching for one would take longer than everything else.
fn indirect_job(folder: &Path, name: &str, mode: BakeParts) -> BakeJob {
    let viewpoint = Some(Vec3::new(0.1, -0.1, -0.2));
    let indirect = IndirectSettings { sources: 512, viewpoint, ..Default::default() };
    let meshless =
        MeshlessSettings { levels: 3, sender_levels: 2, rays: 64, coarse_radius: Some(0.6), ..Default::default() };
    let settings = BakeSettings { mode, indirect, meshless, lights: 256, ..settings() };
    BakeJob { settings: resolve(settings).unwrap(), chunks: Some(3), ..job(folder, name) }
}

/// The same job without a viewpoint.
fn searching(job: BakeJob) -> BakeJob {
    with(job, |settings| settings.indirect.viewpoint = None)
}

/// The interior with all parts, baked once for all tests that use it.
fn whole_interior() -> &'static Dataset {
    static WHOLE: OnceLock<Dataset> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        bake(interior(), &indirect_job(folder.path(), "a.cuts", BakeParts::ALL), &Silent).unwrap()
    })
}

fn indirect_contents(dataset: &Dataset) -> (Vec<Source>, Vec<u16>, Vec<u32>, Vec<u16>) {
    let indirect = dataset.indirect.as_ref().unwrap();
    let (cuts, environment) = (&indirect.cuts, &indirect.environment_cuts);
    (indirect.sources.clone(), cuts.nodes().to_vec(), cuts.offsets().to_vec(), environment.nodes().to_vec())
}

#[test]
fn sources_are_baked_and_read_back_and_the_environment_stays_dark() {
    let folder = tempfile::tempdir().unwrap();
    let job = indirect_job(folder.path(), "a.cuts", BakeParts::INDIRECT);
    let dataset = bake(interior(), &job, &Silent).unwrap();
    let report = dataset.report.indirect.clone().unwrap();
    let expected = 2.0 * (2.0 * 1.4 + 2.0 * 1.6 + 1.4 * 1.6) + 4.0 * 0.16 + 2.0 * 0.16;
    assert!((report.area / expected - 1.0).abs() < 0.02, "{} m² for {expected}", report.area);
    assert!(report.mean_cut > 4.0 && report.relative_error > 0.0 && report.relative_error < 0.5, "{report:?}");
    assert!(dataset.cuts.nodes().iter().all(|&n| n == 0), "nothing of the environment");
    assert_eq!(dataset.report.samples_resolved, 0);
    for phase in ["points", "source-tree", "source-visibility"] {
        assert!(dataset.report.seconds(phase).is_some(), "{phase}");
    }
    assert_eq!(indirect_contents(&Dataset::read(&job.output, image::decode).unwrap()), indirect_contents(&dataset));
    let plain = bake(interior(), &indirect_job(folder.path(), "b.cuts", BakeParts::ENVIRONMENT), &Silent).unwrap();
    assert!(plain.indirect.is_none() && plain.report.indirect.is_none());
    // A closed room sees none of the environment; only tracing shows that.
    assert!(plain.report.samples_resolved > 0);
}

#[test]
fn a_closed_room_is_a_white_furnace_and_a_full_hemisphere_in_every_cut() {
    let folder = tempfile::tempdir().unwrap();
    let job = searching(indirect_job(folder.path(), "a.cuts", BakeParts::INDIRECT));
    let scene = scene_of(&room(Vec3::ZERO, Vec3::new(1.0, 0.7, 0.8)));
    let dataset = bake(scene, &job, &Silent).unwrap();
    let indirect = dataset.indirect.as_ref().unwrap();
    let inner = |v: &usize| {
        let p = dataset.scene.mesh.positions[*v] / Vec3::new(1.0, 0.7, 0.8);
        p.abs().to_array().iter().filter(|x| **x < 0.8).count() == 2
    };
    let vertices: Vec<usize> = (0..dataset.scene.mesh.positions.len()).filter(inner).collect();
    let tree = SourceTree::new(&indirect.sources);
    let irradiance = |v: usize, sources: usize| {
        let (mesh, mut first, mut sum) = (&dataset.scene.mesh, 0, 0.0);
        for &node in indirect.cuts.cut(9, v as u32) {
            let leaves = 512_usize >> depth(node);
            let center = tree.centers()[(512 + first) / leaves];
            let cosine = (center - mesh.positions[v]).normalize_or_zero().dot(mesh.normals[v]).max(0.0);
            if first < sources {
                sum += solid_angle(node & VALUE_MAX) * leaves as f32 * cosine;
            }
            first += leaves;
        }
        sum / PI
    };
    for &v in &vertices {
        let found = irradiance(v, 512);
        assert!((found - 1.0).abs() < 0.1, "{found} at vertex {v}");
        let angle = |&n: &u16| solid_angle(n & VALUE_MAX) * (512_u32 >> depth(n)) as f32;
        let total: f32 = indirect.cuts.cut(9, v as u32).iter().map(angle).sum();
        assert!((total / LARGEST_SOLID_ANGLE - 1.0).abs() < 0.1, "{total} sr at vertex {v}");
    }
    assert!(vertices.iter().any(|&v| irradiance(v, 256) < 0.8), "negative control: half of the sources");
}

#[test]
fn sources_depend_on_neither_threads_nor_chunks_nor_interruptions() {
    let folder = tempfile::tempdir().unwrap();
    let (one, of_cuts) =
        (indirect_contents(whole_interior()), |name| indirect_job(folder.path(), name, BakeParts::CUTS));
    let on_threads = |threads, job: &BakeJob, observer: &dyn Observer| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(interior(), job, observer))
    };
    let job = BakeJob { chunks: Some(1), ..of_cuts("a.cuts") };
    let alone = on_threads(1, &job, &Silent).unwrap();
    assert!(alone.meshless.is_none() && whole_interior().meshless.is_some());
    assert_eq!(indirect_contents(&alone), one, "all but the meshless basis");
    let job = BakeJob { chunks: Some(4), ..of_cuts("b.cuts") };
    let stop = CancelIn::phase(Phase::SourceVisibility);
    assert!(matches!(on_threads(3, &job, &stop), Err(BakeError::Cancelled)));
    assert!(Checkpoint::folder_of(&job.output).join("source-chunk-00000.bin").exists());
    let resumed = on_threads(3, &BakeJob { resume: true, ..job }, &Silent).unwrap();
    assert_eq!(indirect_contents(&resumed), one);
}

#[test]
fn the_meshless_basis_is_baked_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let job = indirect_job(folder.path(), "a.cuts", BakeParts::MESHLESS);
    let dataset = bake(interior(), &job, &Silent).unwrap();
    let (report, bake_of) = (dataset.report.meshless.clone().unwrap(), dataset.meshless.as_ref().unwrap());
    assert!(dataset.indirect.is_none() && report.links > 0 && report.functions.len() == 3, "{report:?}");
    assert_eq!((bake_of.transport.packed().len(), bake_of.basis.senders().len()), (report.links, report.senders));
    for phase in ["basis", "transport"] {
        assert!(dataset.report.seconds(phase).is_some(), "{phase}");
    }
    let read = Dataset::read(&job.output, image::decode).unwrap().meshless.unwrap();
    assert_eq!((read.basis.points(), &read.transport), (bake_of.basis.points(), &bake_of.transport));
}

#[test]
fn environment_and_meshless_basis_are_baked_without_sources_as_they_are_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let job = indirect_job(folder.path(), "a.cuts", BakeParts::ENVIRONMENT_MESHLESS);
    bake(interior(), &job, &Silent).unwrap();
    let both = Dataset::read(&job.output, image::decode).unwrap();
    assert_eq!(both.settings.mode, BakeParts::ENVIRONMENT_MESHLESS);
    assert!(both.indirect.is_none() && both.report.samples_resolved > 0);
    let parts = |dataset: &Dataset| (contents(dataset), dataset.meshless.as_ref().unwrap().transport.clone());
    assert_eq!(parts(&both), parts(whole_interior()), "all but the sources");
}
