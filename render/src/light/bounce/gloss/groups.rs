//! Groups of surface sources that gather light together: those below a node of their tree that lie in one part of an object and face
//! nearly alike. The rays of a group start at one of its sources.

use super::{
    KNOTS,
    reflection::{CELLS, RAYS_OF_A_CELL},
};
use crate::{baked::Baked, light::bounce::ends::SurfaceRays};
use glam::{Mat3, Vec2, Vec3};
use lapidary_core::{
    meshless::{Owner, RayEnd as End},
    scene::Mesh,
    sources::{Source, owners},
    sphere::{frame_around, octahedron},
    surfel::{GradedGrid, Surfel},
};
use rayon::prelude::*;

/// Depth of the nodes that are parted into groups.
const DEPTH: u32 = 12;
/// Least cosine between the normals of a group.
const ALIKE: f32 = 0.9;
/// Groups whose rays are traced at once, in some tenths of a second.
const GROUPS_OF_A_STEP: usize = 512;
/// Rays of a group.
const RAYS: usize = CELLS.len() * RAYS_OF_A_CELL;

/// Sources that gather together.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The source at which its rays start.
    pub source: u32,
}

/// The end of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// A surface that sends nothing.
    Dark,
    /// The sky, in this direction.
    Sky(Vec3),
    /// A source, seen from near a knot of directions.
    Source { source: u32, knot: u32 },
}

/// The end of a ray in four bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Packed(u32);

impl Packed {
    const DARK: Self = Self(u32::MAX);
    /// Added to a cell of the sky.
    const SKY: u32 = 1 << 31;

    fn sky(direction: Vec3) -> Self {
        Self(Self::SKY | octahedron::cell_of(direction) as u32)
    }

    fn source(source: u32, knot: usize) -> Self {
        Self(source * KNOTS.len() as u32 + knot as u32)
    }

    fn end(self) -> RayEnd {
        match self {
            Self::DARK => RayEnd::Dark,
            Self(sky) if sky >= Self::SKY => RayEnd::Sky(octahedron::direction_of((sky & !Self::SKY) as usize)),
            Self(sent) => RayEnd::Source { source: sent / KNOTS.len() as u32, knot: sent % KNOTS.len() as u32 },
        }
    }
}

/// All groups with their rays.
pub struct Groups {
    all: Vec<Group>,
    /// The group of each source.
    of_sources: Vec<u32>,
    /// [`RAYS`] a group, cell by cell, of the groups traced so far.
    ends: Vec<Packed>,
    /// What finds the source that a ray meets, until all are traced.
    owners: Option<(Vec<u32>, GradedGrid)>,
}

impl Groups {
    /// Groups without rays.
    pub fn of(sources: &[Source], mesh: &Mesh) -> Self {
        Self::below(sources, mesh, DEPTH)
    }

    /// Groups of the nodes at a depth of the tree.
    pub fn below(sources: &[Source], mesh: &Mesh, depth: u32) -> Self {
        let size = (sources.len() >> depth).max(1);
        let mut groups = Self { all: Vec::new(), of_sources: vec![0; sources.len()], ends: Vec::new(), owners: None };
        for (node, leaves) in sources.chunks(size).enumerate() {
            groups.part((node * size) as u32, leaves, mesh);
        }
        groups
    }

    /// Parts the sources of a node, which begin at `first`.
    fn part(&mut self, first: u32, leaves: &[Source], mesh: &Mesh) {
        let begun = self.all.len();
        let mut members: Vec<Vec<u32>> = Vec::new();
        let mut leaders: Vec<(Owner, Vec3)> = Vec::new();
        for (source, leaf) in (first..).zip(leaves) {
            let (owner, normal) = (Owner::on(mesh, &leaf.surfel), leaf.surfel.normal);
            let found = leaders.iter().position(|&(of, facing)| of == owner && facing.dot(normal) > ALIKE);
            let group = found.unwrap_or_else(|| {
                leaders.push((owner, normal));
                members.push(Vec::new());
                leaders.len() - 1
            });
            members[group].push(source);
            self.of_sources[source as usize] = (begun + group) as u32;
        }
        let at = |source: u32| leaves[(source - first) as usize].surfel.position;
        for members in members {
            let middle = members.iter().map(|&source| at(source)).sum::<Vec3>() / members.len() as f32;
            let apart = |source: &u32| at(*source).distance_squared(middle);
            let source =
                members.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("a group has a source");
            self.all.push(Group { source });
        }
    }

    /// The groups.
    pub fn all(&self) -> &[Group] {
        &self.all
    }

    /// The group of each source.
    pub fn of_sources(&self) -> &[u32] {
        &self.of_sources
    }

    /// The ends of the rays of each group, by cell.
    pub fn cells(&self) -> impl IndexedParallelIterator<Item = CellsOfRays<'_>> {
        self.ends.par_chunks(RAYS).map(CellsOfRays)
    }

    /// Traces the rays of some groups, and returns whether others have none yet.
    pub fn trace_some(&mut self, baked: &Baked) -> bool {
        let traced = self.ends.len() / RAYS;
        let next = &self.all[traced..(traced + GROUPS_OF_A_STEP).min(self.all.len())];
        if next.is_empty() {
            return false;
        }
        let sources = &baked.dataset.indirect.as_ref().expect("its sources").sources;
        let (members, grid) = self.owners.get_or_insert_with(|| owners(sources));
        let owner = |at: &Surfel| grid.nearest(at).map(|i| members[i]);
        let rays = SurfaceRays::new(baked);
        let rays_of = |group: &Group| {
            let at = &sources[group.source as usize].surfel;
            let directions = directions(frame_around(at.normal), group.source);
            let ends = rays.ends(at, &directions);
            let packed = |(direction, end): (Vec3, End)| match end {
                End::Sky => Packed::sky(direction),
                End::Dark(_) => Packed::DARK,
                End::Surface(at) => owner(&at).map_or(Packed::DARK, |i| Packed::source(i, KNOTS.nearest(-direction))),
            };
            directions.into_iter().zip(ends).map(packed).collect::<Vec<Packed>>()
        };
        let ends: Vec<Vec<Packed>> = next.par_iter().map(rays_of).collect();
        self.ends.extend(ends.into_iter().flatten());
        let is_unfinished = self.ends.len() < self.all.len() * RAYS;
        self.owners.take_if(|_| !is_unfinished);
        is_unfinished
    }
}

/// The rays of a group.
pub struct CellsOfRays<'a>(&'a [Packed]);

impl CellsOfRays<'_> {
    /// Means over the rays of each cell.
    pub fn map(self, radiance: impl Fn(RayEnd) -> Vec3) -> [Vec3; CELLS.len()] {
        let rays = |cell: usize| &self.0[cell * RAYS_OF_A_CELL..][..RAYS_OF_A_CELL];
        let mean = |cell| rays(cell).iter().map(|ray| radiance(ray.end())).sum::<Vec3>() / RAYS_OF_A_CELL as f32;
        std::array::from_fn(mean)
    }
}

/// Unit directions of the rays, cell by cell. Within the cells, those of each source are shifted by a number of its own.
fn directions(world_from_cells: Mat3, source: u32) -> Vec<Vec3> {
    let mut random = fastrand::Rng::with_seed(source.into());
    let shift = Vec2::new(random.f32(), random.f32());
    let within = |ray: usize| {
        let place = Vec2::new(ray as f32 / RAYS_OF_A_CELL as f32, van_der_corput(ray as u32));
        (place + shift).fract()
    };
    let of_cell =
        |cell| (0..RAYS_OF_A_CELL).map(move |ray| world_from_cells * CELLS.direction_within(cell, within(ray)));
    (0..CELLS.len()).flat_map(of_cell).collect()
}

/// The digits of a number mirrored at the point.
fn van_der_corput(i: u32) -> f32 {
    i.reverse_bits() as f32 / 2.0_f32.powi(32)
}
