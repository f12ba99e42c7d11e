//! A dataset after an edit of its scene: cuts are baked anew where the edit reaches, and only there.
//!
//! An edit changes light only along rays that meet the boxes of what changed, before or after it. Each point keeps the nodes whose
//! rays meet none. Mesh, tree and sources stay those of the bake, and ride along with their objects.

mod change;
mod reach;
mod renewed;

use super::{
    clock::Clock,
    phases::{
        chunks::{CutMaker, bake_chunk},
        geometry::Geometry,
        pack::{Packed, pack},
        point_cuts::PointCuts,
    },
};
use crate::{
    errors::{BakeError, CutsOf},
    meshless::meshless_bake,
    object_bases::{place_object_bases, report_of},
    observer::{Observer, Phase},
    sources::{areas::sample_areas, placement::AREAS_SEED, sampler::SourceSampler},
    vertices::{points::BakePoint, sampler::bake_points, sidedness::classify},
    wavelet::wavelet_transport,
};
use change::Change;
use glam::Vec3;
use lapidary_core::{
    cut::packed::PackedCuts,
    dataset::{BakeRun, Dataset, MeshlessReport, WaveletReport},
    lock::OutputLock,
    memory,
    mesh::Mesh,
    mesh_surface::MeshSurface,
    meshless::{MeshlessBake, ObjectBases, Owner},
    output::check_output,
    ray::Intersector,
    scene::{Scene, pose::check_objects},
    sources::{IndirectBake, Source},
    surfel::{Surface, Surfel},
    wavelet::{
        WaveletTransport,
        patch::{Patch, patch_of_triangles},
        reflecting::ReflectingPatch,
    },
};
use renewed::{OldCuts, RenewedEnvironment, RenewedSources};
use std::{borrow::Cow, path::Path};

/// The dataset of an edited scene, which has the same triangles, objects and materials. Objects may have moved, opacities may have
/// changed. Settings of the bake stay.
///
/// # Errors
/// [`BakeError::Cancelled`], or more cuts than a texture holds.
pub fn update(before: &Dataset, scene: Scene, observer: &dyn Observer) -> Result<Dataset, BakeError> {
    let change = Change::between(&before.scene, &scene);
    update_where(before, scene, &change, observer)
}

/// [`update`] with the result in a file. Only one bake at a time writes an output.
///
/// # Errors
/// As [`update`], and an output that cannot be written, told before the work.
pub fn update_file(
    before: &Dataset,
    scene: Scene,
    output: &Path,
    observer: &dyn Observer,
) -> Result<Dataset, BakeError> {
    check_output(output, &[])?;
    let _lock = OutputLock::acquire(output)?;
    let updated = update(before, scene, observer)?;
    updated.write(output)?;
    Ok(updated)
}

/// [`update`] where a change reaches.
fn update_where(
    before: &Dataset,
    scene: Scene,
    change: &Change,
    observer: &dyn Observer,
) -> Result<Dataset, BakeError> {
    check_objects(&scene).map_err(BakeError::Pose)?;
    if change.is_nothing() {
        return Ok(Dataset { scene, ..before.clone() });
    }
    let mut clock = Clock::new(observer, 0.0);
    let geometry = edited_geometry(before, scene, change, observer)?;
    let updating = Updating { before, geometry: &geometry, change };
    let environment = updating.environment(&mut clock)?;
    let indirect = updating.sources(&mut clock)?;
    let object_bases =
        before.object_bases.as_deref().map(|bases| updating.object_bases(bases, observer)).transpose()?;
    let meshless = updating.meshless(&mut clock)?;
    let wavelet = updating.wavelet(&mut clock)?;
    let (points, vertex_valid) = (geometry.bake_points(), geometry.vertex_valid());
    let buried_points = geometry.buried.iter().filter(|&&buried| buried).count();
    let two_sided = geometry.sides.two_sided;
    let mut updated = Dataset { vertex_valid, two_sided, ..without_parts(before, geometry.scene) };
    let report = &mut updated.report;
    (report.bake_points, report.buried_points) = (points, buried_points);
    report.updates += 1;
    match environment {
        Some(packed) => {
            (report.mean_cut, report.max_cut, report.rays_traced) = (packed.mean_cut(), packed.max_cut, packed.rays);
            (report.bytes_cuts, report.cut_size_histogram) = (packed.bytes(), packed.histogram);
            updated.cuts = packed.cuts;
        }
        None => updated.cuts.clone_from(&before.cuts),
    }
    if let (Some((bake, [seen, sky])), Some(report)) = (indirect, &mut report.indirect) {
        (report.mean_cut, report.max_cut, report.mean_environment_cut) = (seen.mean, seen.longest, sky.mean);
        (report.rays_traced, report.bytes_cuts) = (seen.rays, seen.bytes + sky.bytes);
        report.area = bake.sources.iter().map(|source| f64::from(source.area)).sum();
        updated.indirect = Some(bake);
    }
    if let Some(bases) = object_bases {
        (report.object_bases, updated.object_bases) = (Some(report_of(&bases)), Some(bases.into()));
    }
    if let Some((bake, of_basis)) = meshless {
        (updated.meshless, report.meshless) = (Some(bake.into()), Some(of_basis));
    }
    if let Some((transport, of_transport)) = wavelet {
        (updated.wavelet, report.wavelet) = (Some(transport.into()), Some(of_transport));
    }
    updated.report.bytes_total = updated.tensor_bytes();
    let peak_memory_bytes = memory::peak();
    updated.report.run = Some(BakeRun { seconds: clock.finish(), peak_memory_bytes, ..BakeRun::default() });
    Ok(updated)
}

/// A dataset with another scene, and without the data of its parts.
fn without_parts(before: &Dataset, scene: Scene) -> Dataset {
    Dataset {
        scene,
        two_sided: before.two_sided.clone(),
        vertex_valid: before.vertex_valid.clone(),
        tree: before.tree.clone(),
        cuts: PackedCuts::default(),
        indirect: None,
        meshless: None,
        object_bases: None,
        wavelet: None,
        settings: before.settings.clone(),
        scene_hash: before.scene_hash.clone(),
        report: before.report.clone(),
    }
}

/// The geometry after the edit: thin surfaces are seen from both sides, and what something was or is around of may be buried.
fn edited_geometry(
    before: &Dataset,
    scene: Scene,
    change: &Change,
    observer: &dyn Observer,
) -> Result<Geometry, BakeError> {
    let sides = classify(&scene);
    let mut dataset = without_parts(before, scene);
    change.other_opacity().iter().for_each(|&triangle| dataset.two_sided[triangle] = sides.two_sided[triangle]);
    let mut geometry = Geometry::of_dataset(dataset);
    let now = geometry.points.buried(&geometry.intersector, &sides, observer)?;
    for ((buried, now), point) in geometry.buried.iter_mut().zip(now).zip(&geometry.points.points) {
        if change.is_around(point.position) {
            *buried = now;
        }
    }
    Ok(geometry)
}

/// Relative change of areas below which objects have the size of before.
const SAME_SIZE: f32 = 1e-3;

/// Inputs of an update.
struct Updating<'a> {
    before: &'a Dataset,
    /// After the edit.
    geometry: &'a Geometry,
    change: &'a Change,
}

/// Figures of packed cuts for a report.
struct CutFigures {
    mean: f64,
    longest: usize,
    rays: u64,
    bytes: u64,
}

impl CutFigures {
    fn of(packed: &Packed) -> Self {
        Self { mean: packed.mean_cut(), longest: packed.max_cut, rays: packed.rays, bytes: packed.bytes() }
    }
}

impl Updating<'_> {
    /// The vertices' cuts over the environment; `None` if they were not baked.
    fn environment(&self, clock: &mut Clock) -> Result<Option<Packed>, BakeError> {
        let Self { before, geometry, change } = *self;
        if !before.settings.mode.environment() {
            return Ok(None);
        }
        let of_point = self.vertex_of_points(&bake_points(before).points, &geometry.points.points);
        let old = OldCuts::of_visibility(&before.cuts, before.tree.height(), of_point);
        let maker = RenewedEnvironment::new(before, &geometry.intersector, (&geometry.points.points, old), change);
        let cuts = renewed(&maker, Phase::Visibility, clock)?;
        Ok(Some(pack(&cuts, None, geometry.points.of_vertex.iter().copied(), CutsOf::Environment)?))
    }

    /// For each point a vertex whose cut was of the very same point; none where the point moved, or samples elsewhere.
    fn vertex_of_points(&self, before: &[BakePoint], now: &[BakePoint]) -> Vec<Option<u32>> {
        let of_vertex = bake_points(self.before).of_vertex;
        let mut of_point = vec![None; now.len()];
        for ((vertex, &point), &point_before) in (0..).zip(&self.geometry.points.of_vertex).zip(&of_vertex) {
            if now[point as usize] == before[point_before as usize] {
                of_point[point as usize] = Some(vertex);
            }
        }
        of_point
    }

    /// Sources where they are now, with both kinds of cuts.
    fn sources(&self, clock: &mut Clock) -> Result<Option<(IndirectBake, [CutFigures; 2])>, BakeError> {
        let Self { before, geometry, change } = *self;
        let Some(bake) = &before.indirect else { return Ok(None) };
        let offset = self.surface().offset();
        let sources = self.carried(&bake.sources, clock.observer)?;
        let receivers =
            geometry.points.for_sources(&geometry.scene.mesh, &geometry.intersector, &before.settings.shots);
        let report = before.report.indirect.as_ref();
        let per_probe = report.map_or(1, |report| report.sources_per_probe());
        let sampler = SourceSampler::new(&geometry.intersector, &sources, offset, per_probe);
        let rays = Intersector::of_scene(&before.scene);
        let receivers_before = bake_points(before).for_sources(&before.scene.mesh, &rays, &before.settings.shots);
        let of_point = self.vertex_of_points(&receivers_before, &receivers);
        let old = OldCuts::of_solid_angles(&bake.cuts, bake.sources.len().ilog2(), of_point);
        let maker = RenewedSources::new(before, sampler, (&sources, &bake.sources), (&receivers, old), change);
        let cuts = renewed(&maker, Phase::SourceVisibility, clock)?;
        let seen = pack(&cuts, None, geometry.points.of_vertex.iter().copied(), CutsOf::Sources)?;
        let points: Vec<BakePoint> = sources.iter().map(|source| BakePoint::of_surfel(source.surfel, offset)).collect();
        let is_still = |i: u32| (sources[i as usize].surfel == bake.sources[i as usize].surfel).then_some(i);
        let old = OldCuts::of_visibility(
            &bake.environment_cuts,
            before.tree.height(),
            (0..sources.len() as u32).map(is_still).collect(),
        );
        let sky = match before.settings.mode.environment() {
            true => {
                let maker = RenewedEnvironment::new(before, &geometry.intersector, (&points, old), change);
                let cuts = renewed(&maker, Phase::SourceEnvironment, clock)?;
                pack(&cuts, None, 0..sources.len() as u32, CutsOf::SourceEnvironment)?
            }
            false => {
                pack(&PointCuts::unbaked(sources.len()), None, 0..sources.len() as u32, CutsOf::SourceEnvironment)?
            }
        };
        let told = [&seen, &sky].map(CutFigures::of);
        Ok(Some((IndirectBake { sources, cuts: seen.cuts, environment_cuts: sky.cuts }, told)))
    }

    /// The meshes before and after the edit, with hidden objects where they would be.
    fn shown_meshes(&self) -> [Cow<'_, Mesh>; 2] {
        [&self.before.scene, &self.geometry.scene].map(Scene::shown_mesh)
    }

    /// Sources on their triangles after the edit. Those of hidden objects have no area, until it is measured when they are shown.
    fn carried(&self, sources: &[Source], observer: &dyn Observer) -> Result<Vec<Source>, BakeError> {
        let meshes = self.shown_meshes();
        let mut carried: Vec<Source> = sources.iter().map(|source| carried(source, &meshes)).collect();
        let [was_hidden, is_hidden] =
            [&self.before.scene, &self.geometry.scene].map(|scene| move |source: &Source| is_of_hidden(scene, source));
        let is_shown_again = |source: &Source| was_hidden(source) && !is_hidden(source);
        if carried.iter().any(is_shown_again) {
            // Those of hidden objects own nothing.
            let shown = carried.iter_mut().filter(|source| !is_hidden(source)).collect::<Vec<_>>();
            let samples: Vec<(Surfel, f32)> = shown.iter().map(|source| (source.surfel, source.spacing)).collect();
            let areas = sample_areas(&self.surface(), &samples, AREAS_SEED, observer)?;
            let again = shown.into_iter().zip(areas).filter(|(source, _)| was_hidden(source));
            again.for_each(|(source, area)| source.area = area);
        }
        carried.iter_mut().filter(|source| is_hidden(source)).for_each(|source| source.area = 0.0);
        Ok(carried)
    }

    /// The functions of objects where they are now; placed anew if an object has another size, for distances are those of all.
    fn object_bases(&self, bases: &ObjectBases, observer: &dyn Observer) -> Result<ObjectBases, BakeError> {
        let [before, now] = &self.shown_meshes();
        let area = |mesh: &Mesh, point: &Surfel| mesh.area_vector(point.place.triangle as usize).length();
        let is_as_large = |point: &Surfel| (area(now, point) / area(before, point) - 1.0).abs() < SAME_SIZE;
        if !bases.points().iter().all(is_as_large) {
            let Geometry { intersector, sides, .. } = self.geometry;
            let surface = MeshSurface::new(now, intersector, &sides.two_sided, &|_| Vec3::ZERO);
            return place_object_bases(now, &surface, &self.before.settings.object_bases, observer);
        }
        let place =
            |(point, owner): (&Surfel, &Owner)| now.surfel(point.place.triangle, point.place.barycentric, owner.back);
        let points = bases.points().iter().zip(bases.owners()).map(place).collect();
        let (owners, offsets) = (bases.owners().to_vec(), bases.offsets().to_vec());
        Ok(ObjectBases::from_parts(points, owners, offsets, bases.radii().to_vec(), bases.sender_level())?)
    }

    /// The meshless basis, whose links cross the whole scene: it is baked anew.
    fn meshless(&self, clock: &mut Clock) -> Result<Option<(MeshlessBake, MeshlessReport)>, BakeError> {
        let Some(report) = self.before.report.meshless.as_ref().filter(|_| self.before.meshless.is_some()) else {
            return Ok(None);
        };
        let (settings, observer) = (&self.before.settings.meshless, clock.observer);
        clock.time(Phase::Transport, settings.expected_functions(), "functions", || {
            meshless_bake(&self.surface(), report.viewpoint.into(), settings, observer).map(Some)
        })
    }

    /// Wavelet transport between the quads where they are now: it is computed anew.
    fn wavelet(&self, clock: &mut Clock) -> Result<Option<(WaveletTransport, WaveletReport)>, BakeError> {
        let Some(transport) = &self.before.wavelet else { return Ok(None) };
        let Geometry { scene, intersector, .. } = self.geometry;
        let patches = ReflectingPatch::all(self.carried_patches(&transport.patches), &scene.materials);
        let (pairs, settings) = ((patches.len() * patches.len()) as u64, &self.before.settings.wavelet);
        let observer = clock.observer;
        clock.time(Phase::Wavelet, pairs, "pairs of quads", || {
            wavelet_transport(scene, patches, intersector, settings, observer).map(Some)
        })
    }

    /// The quads after the edit, each by the largest triangle on it.
    fn carried_patches(&self, patches: &[ReflectingPatch]) -> Vec<Patch> {
        let [before, now] = &self.shown_meshes();
        let quads: Vec<Patch> = patches.iter().map(|reflecting| reflecting.patch).collect();
        let mut largest = vec![None::<(f32, usize)>; quads.len()];
        for (triangle, patch) in patch_of_triangles(before, &quads).into_iter().enumerate() {
            let Some(known) = patch.map(|patch| &mut largest[patch as usize]) else { continue };
            let area = before.area_vector(triangle).length();
            if known.is_none_or(|(most, _)| area > most) {
                *known = Some((area, triangle));
            }
        }
        let carried = |(patch, largest): (Patch, Option<(f32, usize)>)| {
            largest.map_or(patch, |(_, on)| patch.carried(before.corners(on), now.corners(on)))
        };
        quads.into_iter().zip(largest).map(carried).collect()
    }

    fn surface(&self) -> MeshSurface<'_> {
        let Geometry { scene, intersector, sides, .. } = self.geometry;
        MeshSurface::new(&scene.mesh, intersector, &sides.two_sided, &|_| Vec3::ZERO)
    }
}

/// A source on its triangle in another mesh.
fn carried(source: &Source, [before, now]: &[Cow<Mesh>; 2]) -> Source {
    let triangle = source.surfel.place.triangle as usize;
    if before.corners(triangle) == now.corners(triangle) {
        return *source;
    }
    let back = before.area_vector(triangle).dot(source.surfel.normal) < 0.0;
    let growth = now.area_vector(triangle).length() / before.area_vector(triangle).length().max(f32::MIN_POSITIVE);
    Source {
        surfel: now.surfel(triangle as u32, source.surfel.place.barycentric, back),
        area: source.area * growth,
        spacing: source.spacing * growth.sqrt(),
    }
}

/// Whether a source lies on a hidden object of a scene.
fn is_of_hidden(scene: &Scene, source: &Source) -> bool {
    scene.hidden.contains_key(&scene.mesh.triangle_object[source.surfel.place.triangle as usize])
}

/// The cuts of all points of a maker, timed.
fn renewed<M: CutMaker>(maker: &M, phase: Phase, clock: &mut Clock) -> Result<PointCuts<'static>, BakeError> {
    let observer = clock.observer;
    let chunk =
        clock.time(phase, maker.points() as u64, "points", || bake_chunk(maker, 0..maker.points(), observer))?;
    let mut cuts = PointCuts::new(maker.height());
    cuts.push(chunk);
    Ok(cuts)
}

#[cfg(test)]
mod tests;
