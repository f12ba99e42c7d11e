//! A dataset with its ray hierarchies, built once and shared by the CPU renderer, the references and picking.

use glam::Vec3;
use lapidary_core::{
    cut::packed::PackedCuts,
    dataset::Dataset,
    opacity::Opacities,
    ray::{Intersector, Posable},
    scene::{
        MeshError,
        pose::{Objects, Poses},
    },
};
use rayon::prelude::*;
use std::{
    collections::BTreeSet,
    sync::{Arc, OnceLock},
};

/// A dataset ready for rendering. Cloning is cheap.
#[derive(Clone)]
pub struct Baked {
    /// The dataset.
    pub dataset: Arc<Dataset>,
    rays: Arc<Rays>,
    patches: Arc<OnceLock<Arc<[u8]>>>,
}

/// Hierarchies of the mesh.
#[derive(Default)]
struct Rays {
    /// Built within about a second.
    quick: OnceLock<Intersector>,
    /// For many rays.
    thorough: OnceLock<Intersector>,
}

impl std::fmt::Debug for Baked {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Baked").field("report", &self.dataset.report).finish_non_exhaustive()
    }
}

impl<D: Into<Arc<Dataset>>> From<D> for Baked {
    fn from(dataset: D) -> Self {
        Self { dataset: dataset.into(), rays: Arc::default(), patches: Arc::default() }
    }
}

impl Baked {
    /// Starts to build the ray hierarchies on a thread: the quick one is then ready or nearly so when needed, the thorough one
    /// later.
    pub fn begun(dataset: impl Into<Arc<Dataset>>) -> Self {
        let baked = Self::from(dataset);
        baked.begin();
        baked
    }

    /// Baked opacities of the hierarchies.
    pub fn opacities(&self) -> Opacities {
        Opacities::of_scene(&self.dataset.scene)
    }

    /// Whether the scene stands on a ground.
    pub fn has_ground(&self) -> bool {
        self.dataset.scene.mesh.ground.is_some()
    }

    /// Starts to build missing hierarchies.
    pub fn begin(&self) {
        let builds = self.clone();
        std::thread::spawn(move || {
            builds.intersector();
            builds.refine();
        });
    }

    /// Casts rays on the mesh by the best existing hierarchy. All hierarchies give the same hits except along edges; see
    /// [`Intersector::quick`]. If none exists, the quick one is built and other callers wait for it: call this from a thread that
    /// may wait.
    pub fn intersector(&self) -> &Intersector {
        let quick = || {
            let scene = &self.dataset.scene;
            self.rays.quick.get_or_init(|| Intersector::quick(&scene.mesh, &self.opacities()))
        };
        self.rays.thorough.get().unwrap_or_else(quick)
    }

    /// [`Self::intersector`] if one has been built.
    pub fn intersector_if_ready(&self) -> Option<&Intersector> {
        self.rays.thorough.get().or_else(|| self.rays.quick.get())
    }

    /// Builds the thorough hierarchy, for many rays; takes seconds for a million triangles.
    pub fn refine(&self) {
        self.rays.thorough.get_or_init(|| Intersector::of_scene(&self.dataset.scene));
    }

    /// The scene with its objects posed; see [`Posing`].
    ///
    /// # Errors
    /// Objects out of range.
    pub fn posed(&self, poses: &Poses) -> Result<Self, MeshError> {
        match poses.is_empty() {
            true => Ok(self.clone()),
            false => Posing::new(self).posed(poses),
        }
    }

    /// The same scene with other visibility cuts.
    pub(crate) fn with_cuts(self, cuts: PackedCuts) -> Self {
        Self { dataset: Dataset { cuts, ..Arc::unwrap_or_clone(self.dataset) }.into(), ..self }
    }

    /// The patch of each vertex, 0 to 63: equal numbers of neighboring vertices. Computed at the first call.
    pub fn patches(&self) -> Arc<[u8]> {
        self.patches.get_or_init(|| patches(&self.dataset.scene.mesh.positions).into()).clone()
    }

    /// Whether both are the same dataset, or both `None`.
    pub fn are_same(a: Option<&Self>, b: Option<&Self>) -> bool {
        match (a, b) {
            (Some(a), Some(b)) => a.is_same(b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// Whether both are bakes of one scene with the same vertices, as before and after a move.
    pub(crate) fn is_of_same_vertices(&self, other: &Self) -> bool {
        let key = |baked: &Self| (baked.dataset.scene_hash.clone(), baked.dataset.vertex_valid.len());
        key(self) == key(other) && self.dataset.scene.mesh.triangles == other.dataset.scene.mesh.triangles
    }

    /// Whether both are the same dataset, not merely equal.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.dataset, &other.dataset)
    }
}

/// Poses the objects of a scene repeatedly.
pub struct Posing {
    baked: Baked,
    objects: Objects,
    /// Rays for the objects that moved last.
    rays: Option<PosableRays>,
}

/// Rays on a scene with moving objects.
struct PosableRays {
    moving: BTreeSet<u32>,
    /// Whether they are built from the thorough hierarchy.
    is_thorough: bool,
    posable: Posable,
}

impl Posing {
    /// For a scene as baked.
    pub fn new(baked: &Baked) -> Self {
        Self { objects: Objects::of(&baked.dataset.scene), baked: baked.clone(), rays: None }
    }

    /// The scene under some poses: vertices and rays move, all else is as baked.
    ///
    /// # Errors
    /// Objects out of range.
    pub fn posed(&mut self, poses: &Poses) -> Result<Baked, MeshError> {
        let baked = self.baked.dataset.clone();
        let mesh = poses.pose(&baked.scene.mesh, &self.objects)?;
        let rays = self.rays(poses.moved().collect());
        let (posed, hierarchies) = (rays.posable.posed(&mesh), Rays::default());
        let place = if rays.is_thorough { &hierarchies.thorough } else { &hierarchies.quick };
        place.get_or_init(|| posed);
        Ok(Baked {
            dataset: baked.with_mesh(mesh).into(),
            rays: hierarchies.into(),
            patches: self.baked.patches.clone(),
        })
    }

    fn rays(&mut self, moving: BTreeSet<u32>) -> &PosableRays {
        let (baked, thorough) = (&self.baked, self.baked.rays.thorough.get());
        let is_thorough = thorough.is_some();
        let known = self.rays.take().filter(|rays| (&rays.moving, rays.is_thorough) == (&moving, is_thorough));
        let new = || {
            let hierarchy = thorough.unwrap_or_else(|| baked.intersector());
            let posable = Posable::new(hierarchy, &baked.dataset.scene, &moving);
            PosableRays { moving, is_thorough, posable }
        };
        self.rays.insert(known.unwrap_or_else(new))
    }
}

/// Equal parts of the positions along a Z curve (Morton 1966).
fn patches(positions: &[Vec3]) -> Vec<u8> {
    let (least, most) = positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
    let cells = |p: Vec3| ((p - least) / (most - least).max_element().max(f32::MIN_POSITIVE) * 1023.0).as_uvec3();
    let code = |p: Vec3| {
        let cell = cells(p).to_array();
        (0..30).fold(0_u32, |code, bit| code | (cell[bit % 3] >> (bit / 3) & 1) << bit)
    };
    let mut order: Vec<(u32, u32)> = positions.iter().zip(0..).map(|(&p, vertex)| (code(p), vertex)).collect();
    order.par_sort_unstable();
    let mut patches = vec![0; positions.len()];
    for (place, (_, vertex)) in order.into_iter().enumerate() {
        patches[vertex as usize] = (place * 64 / positions.len()) as u8;
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::scene::pose::Pose;

    #[test]
    fn a_posed_scene_is_the_baked_one_with_vertices_and_rays_elsewhere() {
        let baked = Baked::from(crate::test_scenes::linked_floor_and_wall());
        let mut poses = Poses::default();
        assert!(baked.posed(&poses).unwrap().is_same(&baked));
        poses.set(
            0,
            Pose { translate: Vec3::new(0.0, 0.5, 0.0), rotate_degrees: Vec3::Y * 30.0, scale: 1.5, ..Pose::AS_BAKED },
        );
        let posed = baked.posed(&poses).unwrap();
        let mesh = &posed.dataset.scene.mesh;
        let directions = lapidary_core::sphere::fibonacci_directions(500);
        let met = |rays: &Intersector| {
            let met = directions.iter().map(|&d| rays.closest_hit(Vec3::new(0.1, 0.9, 0.2), d));
            met.collect::<Vec<_>>()
        };
        assert_eq!(met(posed.intersector()), met(&Intersector::new(mesh)));
        assert_ne!(met(posed.intersector()), met(baked.intersector()), "negative control");
        assert_eq!((&posed.dataset.cuts, &posed.dataset.two_sided), (&baked.dataset.cuts, &baked.dataset.two_sided));
        poses.set(0, Pose { translate: Vec3::splat(1e30), ..Pose::AS_BAKED });
        assert!(baked.posed(&poses).is_err());
    }

    #[test]
    fn rays_meet_the_same_before_and_after_the_thorough_hierarchy_is_there() {
        let baked = Baked::from(crate::test_scenes::linked_floor_and_wall());
        let directions = lapidary_core::sphere::fibonacci_directions(500);
        let hits = || {
            let rays = directions.iter().map(|&d| baked.intersector().closest_hit(Vec3::new(0.1, 0.4, 0.2), d));
            rays.collect::<Vec<_>>()
        };
        assert!(baked.intersector_if_ready().is_none());
        let (before, quick) = (hits(), std::ptr::from_ref(baked.intersector()));
        assert!(before.iter().any(Option::is_some) && before.iter().any(Option::is_none));
        baked.refine();
        assert!(!std::ptr::eq(quick, baked.intersector()), "the thorough hierarchy is used");
        assert_eq!(before, hits());
    }

    #[test]
    fn patches_are_equally_many_vertices_close_to_each_other() {
        let at = |i: usize| Vec3::new((i * 37 % 64) as f32, 2.0, (i / 64) as f32);
        let positions: Vec<Vec3> = (0..64 * 64).map(at).collect();
        let patches = patches(&positions);
        for patch in 0..64 {
            let own: Vec<Vec3> = (0..positions.len()).filter(|&i| patches[i] == patch).map(|i| positions[i]).collect();
            assert_eq!(own.len(), 64);
            assert!(own.iter().all(|p| p.distance(own[0]) < 23.0), "within a quarter of the width");
        }
        assert!(super::patches(&[]).is_empty());
        assert_eq!(super::patches(&[Vec3::ONE]), [0], "without extent");
    }
}
