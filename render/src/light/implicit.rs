//! Light changes of posed objects, by implicit visibility (Dong et al. 2007): shadows and bounces follow at once, without a new
//! bake.
//!
//! Unmoved surfaces show their baked light times `E(posed) / E(as baked)` of the environment, plus the difference of the bounces.
//! Both come from the same bins, so the picture equals the baked one bit for bit where nothing changed. Moved surfaces have
//! visibility cuts made from their bins, and their own bounced light. What they covered as baked has such cuts, too.

pub(crate) mod covered;
mod cuts;
pub(crate) mod detail;
pub(crate) mod gloss;
mod gpu_sight;
mod posed_light;
pub(crate) mod seen;
mod vertices;

use crate::{
    baked::Baked,
    device::{
        Compute, DeviceCuts, SeenLight, VertexPlanes,
        layout::constants::{VERTEX_HAS_NEW_CUT, VERTEX_IS_MOVED},
    },
    light::{
        bounce::LitPoints,
        situation::{Changes, Relight, Situation},
        sky::SkyGrid,
    },
};
use covered::{Covered, Open};
use cuts::NewCuts;
use detail::ImplicitDetail;
use glam::Vec3;
use gloss::{Gloss, Received, SeenLeaves, sent_by};
use lapidary_core::{
    implicit::forest::SurfelForest,
    scene::{Mesh, pose::Poses},
};
pub use posed_light::{DeviceLight, PosedLight, PosedLighting, Sides};
use rayon::prelude::*;
use seen::{LeafSight, Reflection, VertexLighting, sight};
use std::{collections::BTreeSet, sync::Arc};
use vertices::VertexLeaves;

/// Samples of an area light along each of its sides, at each leaf.
const AREA_SAMPLES: u32 = 2;

/// Upper limit of the growth of a vertex's light.
pub(crate) const MOST_GROWTH: f32 = 2.0;

/// Lights a scene under one pose after another.
pub struct PoseRig {
    detail: ImplicitDetail,
    as_baked: Seen,
    /// Vertex light as baked; a drag of an object does not change it.
    lit_as_baked: Option<(Asked, [Sides; 2])>,
    /// The same on the device that lights poses.
    lit_there: Option<(Asked, VertexPlanes)>,
    vertices: VertexLeaves,
    posed: Seen,
    poses: Poses,
    covered: Covered,
    is_moved: Arc<[bool]>,
    /// Vertices with new cuts: moved ones, and the footprints of moved objects.
    has_new_cut: Vec<bool>,
    sky: SkyGrid,
    gloss: Gloss,
    eye: Vec3,
}

/// A scene under one pose and the visibility of its leaves.
struct Seen {
    forest: SurfelForest,
    sight: Box<dyn LeafSight>,
    points: LitPoints,
    /// Surfaces that nothing covers.
    open: Open,
    /// How many bounces the light of the leaves has, and that light unless it stays where visibility is; another eye does not change it.
    lit: Option<(u32, Option<SeenLight>)>,
}

/// What is asked of the vertices' light.
#[derive(Clone, Copy, PartialEq)]
struct Asked {
    bounces: u32,
    /// Whether glossy surfaces reflect bounced light as such.
    has_glossy_bounces: bool,
    /// Position of the eye in meters.
    eye: Vec3,
}

impl Seen {
    /// Irradiance of the vertices from the sky, and from all bounces. Glossy ones have that of a diffuse surface which reflects as much
    /// toward the eye.
    fn lit(&mut self, sky: &SkyGrid, asked: Asked, vertices: &VertexLeaves, gloss: &Gloss) -> [Sides; 2] {
        let known = self.lit.take().filter(|(known, _)| *known == asked.bounces).and_then(|(_, light)| light);
        let light = known.unwrap_or_else(|| self.light(sky, asked.bounces));
        let light = self.lit.insert((asked.bounces, None)).1.insert(light);
        // The bins treat emissive surfaces as lamps; the picture counts them as bounced light.
        let others = light.direct.iter().zip(&light.of_sky).zip(&light.bounced);
        let others = others.map(|((direct, sky), bounced)| *direct - *sky + *bounced);
        let (mut others, mut of_sky): (Vec<Vec3>, _) = (others.collect(), light.of_sky.clone());
        let (forest, points, radiance) = (self.forest.discs(), &self.points, |direction| sky.radiance(direction));
        let sent = || sent_by(forest, &points.lighting(&points.irradiance(), &radiance), light);
        let sent = asked.has_glossy_bounces.then(sent);
        if asked.reflects(gloss, sky) {
            let (mesh, surfels, eye) = (points.mesh(), points.points(), asked.eye);
            let seen = SeenLeaves { forest, mesh, surfels, eye, sent: sent.as_deref(), sky: &radiance };
            let reflected = gloss.reflected(&seen, &self.sight.views(forest, gloss.span()));
            gloss.toward_eye(&reflected, Received { from_sky: &mut of_sky, from_leaves: &mut others });
        }
        [of_sky, others].map(|leaves| self.at_vertices(vertices, &leaves, gloss))
    }

    /// Whether the vertices are lit where visibility is.
    fn lights_vertices(&mut self, gloss: &Gloss) -> bool {
        self.sight.lights_vertices(gloss, self.points.mesh(), self.points.points())
    }

    /// The light of [`Self::lit`] where visibility is, of vertices in some states; or what differs in it from that as baked.
    fn lit_there(
        &mut self,
        sky: &SkyGrid,
        asked: Asked,
        (beside, states): (&VertexLeaves, &[u32]),
        gloss: &Gloss,
        as_baked: Option<&VertexPlanes>,
    ) -> Option<VertexPlanes> {
        let known = self.lit.take().filter(|(known, _)| *known == asked.bounces);
        let received = known.is_none().then(|| self.points.irradiance());
        let radiance = |direction| sky.radiance(direction);
        let lighting = |received| (self.points.lighting(received, &radiance), asked.bounces);
        let reflection = Reflection { eye: asked.eye, has_sent: asked.has_glossy_bounces };
        let made = self.sight.at_vertices(
            self.forest.discs(),
            &VertexLighting {
                relight: received.as_deref().map(lighting),
                beside,
                open: &self.open,
                states,
                gloss,
                mesh: self.points.mesh(),
                surfels: self.points.points(),
                reflection: asked.reflects(gloss, sky).then_some(reflection),
                as_baked,
            },
        )?;
        self.lit = Some(known.unwrap_or((asked.bounces, None)));
        Some(made)
    }

    /// Values of the leaves at the vertices. Beside gloss they count by what they reflect, since a dark leaf may reflect much more than
    /// its albedo says.
    fn at_vertices(&self, vertices: &VertexLeaves, leaves: &[Vec3], gloss: &Gloss) -> Sides {
        if gloss.is_empty() {
            return self.open.at_vertices(vertices, leaves);
        }
        let albedo = self.points.albedo();
        let reflected: Vec<Vec3> = leaves.iter().zip(albedo).map(|(e, albedo)| *e * *albedo).collect();
        let [reflected, albedo] = [&reflected, albedo].map(|leaves| self.open.at_vertices(vertices, leaves));
        let share = |_, reflected: Vec3, albedo: Vec3| {
            Vec3::select(albedo.cmpgt(Vec3::ZERO), reflected / albedo.max(Vec3::splat(f32::MIN_POSITIVE)), Vec3::ZERO)
        };
        combined(&reflected, &albedo, share)
    }

    /// Light of the leaves.
    fn light(&mut self, sky: &SkyGrid, bounces: u32) -> SeenLight {
        let (received, radiance) = (self.points.irradiance(), |direction| sky.radiance(direction));
        self.sight.light(self.forest.discs(), &self.points.lighting(&received, &radiance), bounces)
    }
}

impl Asked {
    /// Whether glossy leaves reflect anything toward the eye.
    fn reflects(&self, gloss: &Gloss, sky: &SkyGrid) -> bool {
        !gloss.is_empty() && (sky.shines() || self.has_glossy_bounces)
    }
}

impl PoseRig {
    /// Creates a rig for a scene as baked. The cores or an adapter find visibility; this takes some tenths of a second, or some
    /// seconds at the finest detail.
    pub fn new(baked: &Baked, compute: &Compute, detail: ImplicitDetail) -> Self {
        let dataset = &baked.dataset;
        // Objects that the bake hid have leaves too, for they may be shown again.
        let (shown, hidden) = (dataset.scene.shown_mesh(), &dataset.scene.hidden);
        let mut forest = SurfelForest::new(&shown, &dataset.two_sided, detail.surfels());
        let vertices = VertexLeaves::new(forest.discs(), &shown, &dataset.two_sided);
        forest.update(&dataset.scene.mesh.positions, &|object| hidden.contains_key(&object));
        let covered = Covered::new(dataset, &forest);
        let seen = |positions: &[Vec3]| {
            let mut sight = sight(compute, &forest, positions.len(), detail.layout());
            sight.look(&forest, positions, &BTreeSet::new());
            Seen {
                points: LitPoints::new(baked, forest.surfels().collect(), AREA_SAMPLES),
                open: covered.as_baked(&vertices),
                forest: forest.clone(),
                sight,
                lit: None,
            }
        };
        let positions = &dataset.scene.mesh.positions;
        Self {
            detail,
            posed: seen(positions),
            as_baked: seen(positions),
            lit_as_baked: None,
            lit_there: None,
            poses: Poses::default(),
            is_moved: vec![false; dataset.scene.mesh.positions.len()].into(),
            has_new_cut: vec![false; dataset.scene.mesh.positions.len()],
            sky: SkyGrid::new(None),
            gloss: Gloss::default(),
            eye: Vec3::ZERO,
            vertices,
            covered,
        }
    }

    fn pose(&mut self, scene: &Baked, poses: &Poses) {
        let mesh = &scene.dataset.scene.mesh;
        let changed: BTreeSet<u32> = self.poses.differing(poses).collect();
        if !changed.is_empty() {
            let seen = &mut self.posed;
            seen.forest.update(&mesh.positions, &|object| changed.contains(&object));
            seen.sight.look(&seen.forest, &mesh.positions, &changed);
            seen.points.pose(scene, seen.forest.surfels().collect());
            let (left, discs) = (self.covered.left(poses, scene), seen.forest.discs().discs());
            seen.open = self.covered.open(&self.vertices, discs, &left);
            (self.poses, self.is_moved) = (poses.clone(), moved_vertices(mesh, poses));
            let footprint = self.covered.footprint(&self.vertices, discs, &left, &seen.open);
            self.has_new_cut = self.is_moved.iter().zip(footprint).map(|(&moved, within)| moved || within).collect();
        }
    }

    /// The scene in the rig's pose, with the new visibility cuts; or as it is, and the new cuts on the device that saw them.
    pub fn with_cuts(&mut self, scene: &Baked) -> (Baked, Option<DeviceCuts>) {
        let forest = self.posed.forest.discs();
        let vertices = (0..self.has_new_cut.len() as u32).filter(|&vertex| self.has_new_cut[vertex as usize]);
        let new = NewCuts {
            dataset: &scene.dataset,
            beside: &self.vertices,
            vertices: vertices.collect(),
            is_moved: &self.is_moved,
            open: self.posed.open.leaves(),
        };
        if let Some(cuts) = self.posed.sight.cuts(forest, &new) {
            return (scene.clone(), Some(cuts));
        }
        let views = self.posed.sight.views(forest, self.vertices.span(&new.vertices));
        let cuts = new.of_bins(forest, &views);
        (scene.clone().with_cuts(cuts), None)
    }

    /// Whether any surface is glossy, so that its light depends on the eye.
    pub fn is_glossy(&self) -> bool {
        !self.gloss.is_empty()
    }

    /// ImplicitDetail of the surfels, bins and bounces.
    pub fn detail(&self) -> ImplicitDetail {
        self.detail
    }

    /// Whether each vertex has a new cut: it moved, or an object that moved covered it.
    #[cfg(test)]
    pub fn has_new_cut(&self) -> &[bool] {
        &self.has_new_cut
    }

    /// Whether adapters light the vertices of both poses.
    pub(crate) fn lights_vertices(&mut self) -> bool {
        let Self { gloss, posed, as_baked, .. } = self;
        [posed, as_baked].into_iter().all(|seen| seen.lights_vertices(gloss))
    }

    /// Light of the vertices in the pose; that as baked is known from then on.
    fn lit(&mut self, asked: Asked) -> [Sides; 2] {
        let Self { sky, vertices, gloss, posed, as_baked, lit_as_baked, .. } = self;
        let lit = |seen: &mut Seen| seen.lit(sky, asked, vertices, gloss);
        if lit_as_baked.as_ref().is_none_or(|(known, _)| *known != asked) {
            *lit_as_baked = Some((asked, lit(as_baked)));
        }
        lit(posed)
    }

    /// Light of the posed scene. It has `bounces` bounces, or fewer if the detail follows fewer. Glossy surfaces reflect them as such
    /// if they do so as baked.
    pub fn light(&mut self, bounces: u32, has_glossy_bounces: bool) -> PosedLighting {
        let bounces = bounces.min(self.detail.bounces());
        let asked = Asked { bounces, has_glossy_bounces, eye: self.eye };
        match self.light_there(asked) {
            Some(planes) => PosedLighting::on_device(planes, self.is_moved.clone()),
            None => PosedLighting::OnCores(self.light_by_cores(asked)),
        }
    }

    /// The light where visibility is. Both poses are lit by the same, so that light that is equal has equal bits.
    fn light_there(&mut self, asked: Asked) -> Option<VertexPlanes> {
        if !self.lights_vertices() {
            return None;
        }
        let Self { sky, vertices, gloss, posed, as_baked, lit_there, is_moved, has_new_cut, .. } = self;
        if lit_there.as_ref().is_none_or(|(known, _)| *known != asked) {
            let states = as_baked.open.states(|_| 0);
            *lit_there = Some((asked, as_baked.lit_there(sky, asked, (vertices, &states), gloss, None)?));
        }
        let states = posed.open.states(|vertex| {
            let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
            flag(is_moved[vertex], VERTEX_IS_MOVED) | flag(has_new_cut[vertex], VERTEX_HAS_NEW_CUT)
        });
        let (_, before) = lit_there.as_ref()?;
        posed.lit_there(sky, asked, (vertices, &states), gloss, Some(before))
    }

    /// The same by the cores. The twin is `implicit_vertices_kernel.wgsl`.
    fn light_by_cores(&mut self, asked: Asked) -> PosedLight {
        let [posed_sky, posed_bounce] = self.lit(asked);
        let (_, [baked_sky, baked_bounce]) = self.lit_as_baked.as_ref().expect("it was lit beside the pose");
        let (is_moved, has_new_cut) = (&self.is_moved, &self.has_new_cut);
        let growth = |vertex: usize, now: Vec3, before: Vec3| {
            if has_new_cut[vertex] { Vec3::ZERO } else { ratio(now, before) - 1.0 }
        };
        let more = |vertex: usize, now: Vec3, before: Vec3| if is_moved[vertex] { now } else { now - before };
        let rest = |vertex: usize, now: Vec3, before: Vec3| match has_new_cut[vertex] {
            true => Vec3::ZERO,
            false => (now - before * ratio(now, before)).max(Vec3::ZERO),
        };
        PosedLight {
            is_moved: is_moved.clone(),
            growth: combined(&posed_sky, baked_sky, growth),
            uncovered: combined(&posed_sky, baked_sky, rest),
            bounce: combined(&posed_bounce, baked_bounce, more),
        }
    }
}

impl PoseRig {
    /// Lights the leaves of both poses by rays of the same, so that unchanged light has its bits. The picture's rays to suns meet the posed
    /// scene on the device; for other lights alone it is not taken there.
    fn light_leaves(&mut self, situation: &Situation, changes: Changes) {
        let lights = [&*situation.lights, &*situation.suns].concat();
        let mut by = |compute: &Compute| {
            [&mut self.posed, &mut self.as_baked].map(|seen| {
                seen.points.update((&situation.appearance, &lights), compute, changes);
                seen.points.is_on_device()
            })
        };
        let [posed, as_baked] = by(if situation.suns.is_empty() { &Compute::Cores } else { &situation.compute });
        if posed != as_baked {
            by(&Compute::Cores);
        }
    }
}

impl Relight for PoseRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        if changes.poses {
            self.pose(&situation.scene, &situation.poses);
        }
        if changes.environment {
            self.sky = SkyGrid::of(situation);
        }
        if changes.appearance {
            self.gloss = Gloss::new(&situation.appearance, &self.as_baked.points);
        }
        self.eye = situation.eye;
        self.light_leaves(situation, changes);
        if changes.relight() {
            (self.lit_as_baked, self.lit_there, self.as_baked.lit) = (None, None, None);
        }
        if changes.relight() || changes.poses {
            self.posed.lit = None;
        }
    }
}

/// `now / before` per channel, within bounds; 1 where there was no light.
fn ratio(now: Vec3, before: Vec3) -> Vec3 {
    let of = |now: f32, before: f32| if before > 0.0 { (now / before).clamp(0.0, MOST_GROWTH) } else { 1.0 };
    Vec3::new(of(now.x, before.x), of(now.y, before.y), of(now.z, before.z))
}

fn combined(now: &Sides, before: &Sides, combine: impl Fn(usize, Vec3, Vec3) -> Vec3 + Sync) -> Sides {
    let side = |now: &[Vec3], before: &[Vec3]| {
        let vertices = now.par_iter().zip(before).enumerate().with_min_len(1024);
        vertices.map(|(vertex, (&now, &before))| combine(vertex, now, before)).collect()
    };
    Sides { front: side(&now.front, &before.front), back: side(&now.back, &before.back) }
}

fn moved_vertices(mesh: &Mesh, poses: &Poses) -> Arc<[bool]> {
    mesh.owners().into_iter().map(|object| !poses.is_as_baked(object)).collect()
}

#[cfg(test)]
pub(crate) mod tests;
