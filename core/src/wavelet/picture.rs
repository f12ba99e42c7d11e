//! Radiance on patches as textures, synthesized from the basis (wavelet paper, 5.3 and 5.4).
//!
//! A border of texels makes light continuous from patch to patch. Departure: the paper's textures hold light that is reflected to the
//! eye, so it culls by view. These hold light that arrives, and a moved eye needs no other ones.

use super::{
    operator::RadianceBasis,
    patch::Patch,
    reflecting::ReflectingPatch,
    square::{Function, Node},
};
use crate::{ray::Intersector, sphere::concentric::HemisphereCells};
use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;
use std::{collections::BTreeMap, f32::consts::PI};

/// Radiance that arrives on a patch: a texture with the mean over each cell of directions, and with a border.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchTexture {
    /// Texels along an edge without the border, a power of two.
    side: u32,
    cells: HemisphereCells,
    /// Texel by texel, row by row, the border's too; for each its cells.
    radiance: Vec<Vec3>,
}

impl PatchTexture {
    /// The textures of all patches for coefficients of the basis. A texture is as fine as the finest function of its patch. `neighbors`
    /// of each patch continue it, see [`neighbors`].
    pub fn all(
        patches: &[ReflectingPatch],
        neighbors: &[Vec<u32>],
        basis: &RadianceBasis,
        coefficients: &[Vec3],
    ) -> Vec<Self> {
        let of_patch = |(index, reflecting): (usize, &ReflectingPatch)| {
            let functions = basis.functions();
            let start = functions.partition_point(|function| function.patch < index as u32);
            let end = functions.partition_point(|function| function.patch <= index as u32);
            let mut by_angle = BTreeMap::<Function, Vec<(Function, Vec3)>>::new();
            let own = functions[start..end].iter().zip(&coefficients[start..end]);
            own.filter(|(_, value)| **value != Vec3::ZERO).for_each(|(function, value)| {
                by_angle.entry(function.angle).or_default().push((function.space, *value))
            });
            Self::of(by_angle, 1.0 / (PI * reflecting.patch.area).sqrt(), reflecting.cells)
        };
        let alone: Vec<Self> = patches.par_iter().enumerate().map(of_patch).collect();
        let bordered = |(texture, (patch, of_patch)): (&Self, (&ReflectingPatch, &Vec<u32>))| {
            let others = of_patch.iter().map(|&other| (&patches[other as usize].patch, &alone[other as usize]));
            texture.beside(&patch.patch, &others.collect::<Vec<_>>())
        };
        alone.par_iter().zip(patches.par_iter().zip(neighbors)).map(bordered).collect()
    }

    /// With light of the patches that continue this one in its border.
    fn beside(&self, patch: &Patch, others: &[(&Patch, &Self)]) -> Self {
        let mut bordered = self.clone();
        for (texel, square) in border(self.side).filter(|_| !others.is_empty()) {
            let point = patch.point(square);
            let found = others.iter().map(|(other, texture)| (other.square_of(point), texture));
            if let Some((square, texture)) = found.into_iter().find(|(square, _)| is_within(*square)) {
                let first = texel as usize * self.cells.len();
                bordered.radiance[first..first + self.cells.len()].copy_from_slice(&texture.at(square));
            }
        }
        bordered
    }

    /// Space first, then angle (Fig. 5).
    fn of(by_angle: BTreeMap<Function, Vec<(Function, Vec3)>>, norm: f32, cells: HemisphereCells) -> Self {
        let finest = by_angle.values().flatten().map(|(space, _)| finest_level(*space)).max().unwrap_or(0);
        let side = 1 << finest;
        let mut radiance = vec![Vec3::ZERO; (side * side) as usize * cells.len()];
        for (angle, terms) in by_angle {
            let mut texture = vec![Vec3::ZERO; (side * side) as usize];
            terms.iter().for_each(|(space, value)| add(&mut texture, side, *space, *value * norm));
            let mut of_cells = vec![0.0; cells.len()];
            add(&mut of_cells, cells.side as u32, angle, 1.0);
            for (texel, value) in radiance.chunks_mut(cells.len()).zip(&texture) {
                texel.iter_mut().zip(&of_cells).for_each(|(cell, height)| *cell += *value * *height);
            }
        }
        Self { side, cells, radiance: with_border(&radiance, side, cells.len()) }
    }

    /// Texels along an edge, without the border.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Cells of directions of each texel, in the frame of the patch.
    pub fn cells(&self) -> HemisphereCells {
        self.cells
    }

    /// Mean radiance in each cell, texel by texel, row by row, with a texel more on each side.
    pub fn radiance(&self) -> &[Vec3] {
        &self.radiance
    }

    /// Radiance by cells at a point of the unit square, interpolated between the texels around it.
    pub fn at(&self, square: Vec2) -> Vec<Vec3> {
        let place = square * self.side as f32 - 0.5;
        let (low, part) = (place.floor(), place - place.floor());
        let mut sums = vec![Vec3::ZERO; self.cells.len()];
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let weight = (if x > 0.0 { part.x } else { 1.0 - part.x }) * (if y > 0.0 { part.y } else { 1.0 - part.y });
            let texel = (low + 1.0 + Vec2::new(x, y)).clamp(Vec2::ZERO, Vec2::splat((self.side + 1) as f32)).as_uvec2();
            let first = (texel.y * (self.side + 2) + texel.x) as usize * self.cells.len();
            sums.iter_mut().zip(&self.radiance[first..]).for_each(|(sum, value)| *sum += *value * weight);
        }
        sums
    }
}

/// Texels along an edge of a patch in whose border a wall is looked for.
const LOOKED_AT: u32 = 8;

/// For each patch the others that continue it: in its plane, with light of the same cells of directions, and with no wall between.
pub fn neighbors(patches: &[ReflectingPatch], basis: &RadianceBasis, rays: &Intersector, offset: f32) -> Vec<Vec<u32>> {
    let mut is_lit = vec![false; patches.len()];
    basis.functions().iter().for_each(|function| is_lit[function.patch as usize] = true);
    let continues = |own: usize, other: usize| {
        let [own_patch, other_patch] = [own, other].map(|index| &patches[index]);
        own != other
            && is_lit[other]
            && own_patch.cells == other_patch.cells
            && other_patch.patch.continues(&own_patch.patch, own_patch.cells.len() > 1)
            && is_open(&own_patch.patch, &other_patch.patch, rays, offset)
    };
    let of_patch = |own: usize| (0..patches.len()).filter(|&other| continues(own, other)).map(|i| i as u32).collect();
    (0..patches.len()).into_par_iter().map(of_patch).collect()
}

/// Whether two patches of a plane touch, with nothing that stands on their common edge.
fn is_open(patch: &Patch, other: &Patch, rays: &Intersector, offset: f32) -> bool {
    let above = patch.normal() * offset;
    let mut touching =
        border(LOOKED_AT).filter(|(_, square)| is_within(other.square_of(patch.point(*square)))).peekable();
    let is_free = |(_, square): (u32, Vec2)| {
        let inside = square.clamp(Vec2::splat(0.5 / LOOKED_AT as f32), Vec2::splat(1.0 - 0.5 / LOOKED_AT as f32));
        let (from, to) = (patch.point(inside), patch.point(square));
        !rays.occluded_before(from + above, (to - from).normalize(), from.distance(to))
    };
    touching.peek().is_some() && touching.all(is_free)
}

/// Texels of the border around a grid, with the places of their centers beside the unit square.
fn border(side: u32) -> impl Iterator<Item = (u32, Vec2)> {
    let rows = side + 2;
    let is_border = move |i: &u32| [i % rows, i / rows].iter().any(|&along| along == 0 || along == rows - 1);
    let center = move |i: u32| (Vec2::new((i % rows) as f32, (i / rows) as f32) - 0.5) / side as f32;
    (0..rows * rows).filter(is_border).map(move |i| (i, center(i)))
}

fn is_within(square: Vec2) -> bool {
    square.min_element() >= 0.0 && square.max_element() <= 1.0
}

/// Texels with a border that repeats the outermost ones.
fn with_border(texels: &[Vec3], side: u32, cells: usize) -> Vec<Vec3> {
    let within = |along: u32| along.clamp(1, side) - 1;
    let all = (0..side + 2).flat_map(|y| (0..side + 2).map(move |x| (within(y) * side + within(x)) as usize * cells));
    all.flat_map(|first| &texels[first..first + cells]).copied().collect()
}

/// The level of the cells on which a function is constant.
fn finest_level(function: Function) -> u32 {
    if function == Function::CONSTANT { 0 } else { function.support().level() + 1 }
}

/// Adds a function to a grid that resolves it.
fn add<T: Copy + std::ops::AddAssign + std::ops::Mul<f32, Output = T>>(
    grid: &mut [T],
    side: u32,
    function: Function,
    value: T,
) {
    let parts: Vec<(Node, f32)> = match function == Function::CONSTANT {
        true => vec![(Node::ROOT, 1.0)],
        false => function.support().children().into_iter().zip(function.values()).collect(),
    };
    for (node, height) in parts {
        let size = side >> node.level();
        let UVec2 { x, y } = node.cell() * size;
        for row in y..y + size {
            let first = (row * side + x) as usize;
            grid[first..first + size as usize].iter_mut().for_each(|texel| *texel += value * height);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        test_scenes::{floor, quad, scene_of},
        wavelet::{
            operator::{Operator, RadianceFunction, TransportCoefficient},
            square::transform_products,
        },
    };

    #[test]
    fn light_goes_on_from_quad_to_quad() {
        // Two floors side by side, and a step up beside them.
        let at = |x: f32, y: f32| {
            quad(Vec3::new(x, y, 1.0), Vec3::new(x + 1.0, y, 1.0), Vec3::new(x + 1.0, y, 0.0), Vec3::new(x, y, 0.0))
        };
        let patches =
            ReflectingPatch::of_scene(&scene_of(&[at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.1)].concat())).unwrap();
        let of = |patch: u32| RadianceFunction { patch, space: Function::CONSTANT, angle: Function::CONSTANT };
        let coefficient = |patch| TransportCoefficient { receiver: of(patch), sender: of(patch), value: Vec3::ONE };
        let (basis, _) = Operator::of((0..3).map(coefficient).collect());
        let (without, _) = Operator::of([0, 2].map(coefficient).into());
        let coefficients = [1.0, 3.0, 9.0].map(|radiance| Vec3::splat(radiance * PI.sqrt()));
        let of_walls = |walls: &[[Vec3; 3]]| {
            let rays = Intersector::new(&scene_of(&[walls, &floor(9.0, -1.0)].concat()).mesh);
            let neighbors = neighbors(&patches, &basis, &rays, 1e-4);
            PatchTexture::all(&patches, &neighbors, &basis, &coefficients)
        };
        let textures = of_walls(&[]);
        let at = |patch: usize, x: f32| {
            let square = patches[patch].patch.square_of(Vec3::new(x, 0.0, 0.5));
            textures[patch].at(square)[0].x
        };
        assert!((at(0, 0.5) - 1.0).abs() < 1e-4 && (at(1, 1.5) - 3.0).abs() < 1e-4);
        assert!(
            (at(0, 1.0) - 2.0).abs() < 1e-4 && (at(1, 1.0) - 2.0).abs() < 1e-4,
            "the same on both sides of the edge"
        );
        assert!((at(0, 0.0) - 1.0).abs() < 1e-4, "no other at its free edge");
        assert!((at(1, 2.0) - 3.0).abs() < 1e-4, "negative control: the step does not continue it");
        let rays = Intersector::new(&scene_of(&floor(9.0, -1.0)).mesh);
        let of_all = |basis| neighbors(&patches, basis, &rays, 1e-4);
        assert_eq!((of_all(&basis)[0].len(), of_all(&without)[0].len()), (1, 0), "a hidden one has no light");
        let wall = quad(Vec3::X, Vec3::X + Vec3::Z, Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, 0.0));
        let behind = of_walls(&wall)[0].at(patches[0].patch.square_of(Vec3::new(1.0, 0.0, 0.5)))[0].x;
        assert!((behind - 1.0).abs() < 1e-4, "a wall between them: {behind}");
    }

    #[test]
    fn textures_have_the_radiance_of_their_functions() {
        let ground = ReflectingPatch::of_scene(&scene_of(&floor(1.0, 0.0))).unwrap().remove(0);
        let ground = ReflectingPatch { cells: HemisphereCells { side: 4 }, ..ground };
        let norm = (PI * ground.patch.area).sqrt();
        let node = |level, x, y| Node::of_cell(level, UVec2::new(x, y));
        // Radiance 2 on a quarter of the places from a sixteenth of the directions, and 1 everywhere.
        let quarter = 2.0 * norm * node(1, 1, 0).side() * node(2, 3, 1).side();
        let products = [([Node::ROOT; 2], Vec3::splat(norm)), ([node(1, 1, 0), node(2, 3, 1)], Vec3::splat(quarter))];
        let terms = transform_products(&products);
        let of = |[space, angle]: [Function; 2]| RadianceFunction { patch: 0, space, angle };
        let coefficient = |(functions, _): &([Function; 2], Vec3)| TransportCoefficient {
            receiver: of(*functions),
            sender: of(*functions),
            value: Vec3::ONE,
        };
        let (basis, _) = Operator::of(terms.iter().map(coefficient).collect());
        let mut coefficients = vec![Vec3::ZERO; basis.functions().len()];
        for (functions, value) in &terms {
            coefficients[basis.index_of(&of(*functions)).unwrap() as usize] = *value;
        }
        let patches = [ground];
        let texture = &PatchTexture::all(&patches, &[Vec::new()], &basis, &coefficients)[0];
        let cell = 3 + 4;
        let within = texture.at(Vec2::new(0.75, 0.25));
        assert!((within[cell].x - 3.0).abs() < 1e-4 && (within[0].x - 1.0).abs() < 1e-4, "{within:?}");
        assert!((texture.at(Vec2::new(0.25, 0.25))[cell].x - 1.0).abs() < 1e-4);
        let between = texture.at(Vec2::new(0.5, 0.25))[cell].x;
        assert!((between - 2.0).abs() < 1e-4, "half way between two texels: {between}");
        let dark = PatchTexture::all(&patches, &[Vec::new()], &basis, &vec![Vec3::ZERO; coefficients.len()]);
        assert_ne!(&dark[0], texture, "negative control");
    }
}
