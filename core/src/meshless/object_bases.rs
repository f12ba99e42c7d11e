//! Bases of objects (meshless radiosity, 5 and 6): each object has levels of its own, so that its functions go wherever it goes.
//!
//! Functions lie on the surface as baked. A point of a moved, scaled or deformed object is found by its place on the mesh, so no
//! pose is needed to evaluate them. All levels hold absolute values: each is a flat solution, finer than the one before.

use super::{FunctionPlace, Functions};
use crate::{
    mesh::Mesh,
    meshless::BasisError,
    ray::Fan,
    sparse::SparseRows,
    surfel::{Surface, Surfel},
    transport::Coefficient,
};
use glam::Vec3;
use std::{fmt, ops::Range};

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// Nowhere: it sees the sky.
    Sky,
    /// At a surface that sends no light and hides the sky, as the back of a one-sided one.
    Dark(Surfel),
    /// At a surface.
    Surface(Surfel),
}

/// A surface that carries functions. By itself it stands still, and each ray that meets none of it sees the sky.
pub trait Carrier: Surface {
    /// The ends of rays from one origin off any surface.
    fn ends(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[RayEnd; 8]> {
        let end = |hit: Option<Surfel>| hit.map_or(RayEnd::Sky, RayEnd::Surface);
        self.first_hits(origin, directions).into_iter().map(|eight| eight.map(end)).collect()
    }

    /// Whether a device traces rays of fans.
    fn traces_fans(&self) -> bool {
        false
    }

    /// The ends of the rays of several fans at once, fan by fan, if a device traces them.
    fn ends_of_fans(&self, _fans: &[Fan], _directions: &[Vec3]) -> Option<Vec<RayEnd>> {
        None
    }

    /// The side of a part of an object that a point of the surface belongs to.
    fn owner(&self, at: &Surfel) -> Owner;

    /// A point of the surface where it was as baked.
    fn as_baked(&self, at: &Surfel) -> Surfel {
        *at
    }

    /// A point of the surface as baked where it is now.
    fn now(&self, as_baked: &Surfel) -> Surfel {
        *as_baked
    }

    /// The unit normal by which a point of the surface receives light.
    fn shading_normal(&self, at: &Surfel) -> Vec3 {
        at.normal
    }
}

/// What a function stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Owner {
    /// Index of the object.
    pub object: u32,
    /// Index of the material of the mesh.
    pub material: u32,
    /// Whether it is the back of its triangles.
    pub back: bool,
}

impl Owner {
    /// The owner of a point of a mesh.
    pub fn on(mesh: &Mesh, at: &Surfel) -> Self {
        let triangle = at.place.triangle as usize;
        Self {
            object: mesh.triangle_object[triangle],
            material: mesh.triangle_material[triangle],
            back: mesh.area_vector(triangle).dot(at.normal) < 0.0,
        }
    }
}

/// The functions of all objects, level by level, and by object within a level.
#[derive(Clone)]
pub struct ObjectBases {
    /// Each object and level has a key of its own.
    functions: Functions,
    owners: Vec<Owner>,
    sender_level: usize,
    /// Number of objects with functions; those beyond have none.
    objects: u32,
    /// For each function: the functions of the level before in the same object that reach its point, with their values there.
    parents: SparseRows,
}

impl fmt::Debug for ObjectBases {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut all = f.debug_struct("ObjectBases");
        all.field("offsets", &self.offsets()).field("radii", &self.radii());
        all.field("sender_level", &self.sender_level).finish_non_exhaustive()
    }
}

impl ObjectBases {
    /// Bases of these levels, coarsest first. The points of a level are sorted by their owner's object. Light is sent at
    /// `sender_level`.
    ///
    /// # Errors
    /// [`BasisError`] for numbers that contradict each other.
    pub fn new(levels: &[Vec<(Surfel, Owner)>], radii: Vec<f32>, sender_level: usize) -> Result<Self, BasisError> {
        let mut offsets = vec![0];
        levels.iter().for_each(|level| offsets.push(offsets[offsets.len() - 1] + level.len() as u32));
        let (points, owners) = levels.iter().flatten().copied().unzip();
        Self::from_parts(points, owners, offsets, radii, sender_level)
    }

    /// The bases of stored points with their owners, offsets of levels (with the end of the last) and radii.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_parts(
        points: Vec<Surfel>,
        owners: Vec<Owner>,
        offsets: Vec<u32>,
        radii: Vec<f32>,
        sender_level: usize,
    ) -> Result<Self, BasisError> {
        let levels = radii.len();
        let are_sorted = |ends: &[u32]| {
            let of_level = owners.get(ends[0] as usize..ends[1] as usize);
            of_level.is_some_and(|owners| owners.is_sorted_by_key(|owner| owner.object))
        };
        if levels == 0 || owners.len() != points.len() || !offsets.windows(2).all(are_sorted) {
            return Err(BasisError::Levels { points: points.len() });
        }
        if sender_level >= levels {
            return Err(BasisError::SenderLevels { sender_levels: sender_level + 1, levels });
        }
        let objects = owners.iter().map(|owner| owner.object + 1).max().unwrap_or(0);
        let functions = Functions::new(points, offsets, radii, |offsets| keys(&owners, offsets, objects))?;
        let mut bases = Self { functions, owners, sender_level, objects, parents: SparseRows::default() };
        bases.parents = SparseRows::build(bases.len(), |function, out| {
            let level = bases.level_of(function as u32);
            let (point, object) = (&bases.points()[function], bases.owners[function].object);
            level.checked_sub(1).into_iter().for_each(|above| bases.values(above, object, point, out));
        });
        Ok(bases)
    }

    /// The functions, with range queries.
    pub fn functions(&self) -> &Functions {
        &self.functions
    }

    /// Number of functions of all levels.
    pub fn len(&self) -> usize {
        self.points().len()
    }

    /// Whether there are no functions.
    pub fn is_empty(&self) -> bool {
        self.points().is_empty()
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.functions.levels()
    }

    /// The functions of a level.
    pub fn level(&self, level: usize) -> Range<usize> {
        self.functions.level(level)
    }

    /// First function of each level, and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        self.functions.offsets()
    }

    /// The level of a function.
    pub fn level_of(&self, function: u32) -> usize {
        self.offsets().partition_point(|&first| first <= function) - 1
    }

    /// Points on the surface as baked.
    pub fn points(&self) -> &[Surfel] {
        self.functions.points()
    }

    /// What each function stands for.
    pub fn owners(&self) -> &[Owner] {
        &self.owners
    }

    /// Radius of support of each level in meters.
    pub fn radii(&self) -> &[f32] {
        self.functions.radii()
    }

    /// The level whose functions send light.
    pub fn sender_level(&self) -> usize {
        self.sender_level
    }

    /// The functions of the level before that reach each function, with their values at its point.
    pub fn parents(&self) -> &SparseRows {
        &self.parents
    }

    /// A point of an object as baked among its functions; `None` if it has none.
    pub fn place(&self, object: u32, position: Vec3, normal: Vec3) -> Option<FunctionPlace> {
        let first_key = object as usize * self.levels();
        (object < self.objects).then_some(FunctionPlace { first_key, position, normal })
    }

    /// Appends the functions of a level of an object that are not zero at a point as baked, with their values there. The values sum to
    /// one, unless no function reaches the point.
    pub fn values(&self, level: usize, object: u32, at: &Surfel, out: &mut Vec<(u32, f32)>) {
        if let Some(at) = self.place(object, at.position, at.normal) {
            self.functions.values(level, &at, out);
        }
    }

    /// Values at a point as baked of the finest level that reaches it.
    pub fn finest_values(&self, object: u32, at: &Surfel, out: &mut Vec<(u32, f32)>) {
        let first = out.len();
        for level in (0..self.levels()).rev() {
            self.values(level, object, at, out);
            if out.len() > first {
                return;
            }
        }
    }

    /// The function with these coefficients at a point as baked.
    pub fn evaluate<T: Coefficient>(&self, object: u32, at: &Surfel, coefficients: &[T]) -> T {
        let mut values = Vec::new();
        self.finest_values(object, at, &mut values);
        values.iter().fold(T::ZERO, |sum, &(function, value)| sum + coefficients[function as usize] * value)
    }
}

/// The keys of a grid in which each object and level has its own cells: the level of each, and its functions.
fn keys(owners: &[Owner], offsets: &[u32], objects: u32) -> Vec<(usize, Range<usize>)> {
    let of = |(object, level): (u32, usize)| {
        let [first, end] = [offsets[level], offsets[level + 1]].map(|i| i as usize);
        let place = |object: u32| first + owners[first..end].partition_point(|owner| owner.object < object);
        (level, place(object)..place(object + 1))
    };
    (0..objects).flat_map(|object| (0..offsets.len() - 1).map(move |level| (object, level))).map(of).collect()
}
