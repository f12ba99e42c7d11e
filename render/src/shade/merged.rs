//! The nodes that a pixel sums: nodes of the merged cut, or their descendants where the BRDF needs more directions.
//!
//! Cuts are merged node by node; lit cuts once for consecutive pixels of one triangle. Nodes are tested eight at a time from the
//! pixel. Each node that is too wide is split, and its halves wait for the next eight, so the order of terms is not the tree's.

use super::{
    merge::{Shader, Term},
    mirror::Mirror,
    node_field::NodeField,
    refine::{Refinement, are_too_wide_for_a_cosine},
    surface::SurfacePoint,
};
use crate::sampling::BrdfSampling;
use glam::Vec3;
use lapidary_core::{
    cut::{
        lit::LitNode,
        merge::{Interval, merge, merge_within},
        packed::{CutPlace, PackedCursor, PackedCuts},
    },
    simd::{Lanes, Vec3x8},
};

/// Nodes of one pixel; the buffers are reused for the next.
#[derive(Default)]
pub(super) struct Found {
    lit: LitNodes,
    /// Nodes still to be tested.
    open: Terms,
    /// Terms of the sum.
    pub terms: Terms,
}

/// A list of terms.
#[derive(Default)]
pub(super) struct Terms {
    /// Items after `len` are spare room.
    items: Vec<Term>,
    len: usize,
}

impl Terms {
    #[inline(always)]
    fn clear(&mut self) {
        self.len = 0;
    }

    /// Number of terms.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The terms in groups of eight, padded.
    #[inline(always)]
    pub fn eights(&mut self) -> &[[Term; 8]] {
        self.make_room(8);
        self.items[self.len..self.len + 8].fill(Term::PADDING);
        self.items[..self.len.next_multiple_of(8)].as_chunks().0
    }

    #[inline(always)]
    fn make_room(&mut self, more: usize) {
        if self.items.len() < self.len + more {
            self.items.resize(self.len + more.max(64), Term::PADDING);
        }
    }

    /// Appends a term if `is_kept`; there must be room. It does not branch, because `is_kept` is hard to predict.
    #[inline(always)]
    fn put(&mut self, term: Term, is_kept: bool) {
        self.items[self.len] = term;
        self.len += usize::from(is_kept);
    }

    #[inline(always)]
    fn push(&mut self, term: Term) {
        self.make_room(1);
        self.put(term, true);
    }

    /// Removes up to eight from the end, padded to eight, and returns their number.
    #[inline(always)]
    fn pop_eight(&mut self) -> ([Term; 8], usize) {
        let count = self.len.min(8);
        self.len -= count;
        let mut eight = [Term::PADDING; 8];
        eight[..count].copy_from_slice(&self.items[self.len..self.len + count]);
        (eight, count)
    }
}

/// The merged lit cuts of a triangle.
#[derive(Default)]
struct LitNodes {
    /// Vertices of the triangle; `None` at first.
    vertices: Option<[u32; 3]>,
    eights: Vec<EightLitNodes>,
    count: usize,
}

/// Eight nodes of merged lit cuts, with the positions of the cuts there. Padding has no leaves and no light.
#[derive(Clone, Copy)]
struct EightLitNodes {
    nodes: [usize; 8],
    firsts: [u32; 8],
    leaves: [u32; 8],
    /// Values at the three vertices.
    values: [[f32; 8]; 3],
    places: [[CutPlace; 3]; 8],
}

impl EightLitNodes {
    const PADDING: Self = Self {
        nodes: [1; 8],
        firsts: [0; 8],
        leaves: [0; 8],
        values: [[0.0; 8]; 3],
        places: [[CutPlace::START; 3]; 8],
    };
}

/// Tests of eight nodes, one bit each.
struct Looks {
    /// Some lobe needs several directions.
    in_lobe: u32,
    /// The lobe or the cosine needs several directions.
    too_wide: u32,
    /// The node reaches into the window of a mirror.
    in_window: u32,
}

/// The merged cut of one point.
pub(super) struct Merged<'a, 'p, F> {
    field: F,
    cuts: &'a PackedCuts,
    height: u32,
    sampling: BrdfSampling,
    point: &'p SurfacePoint,
    refinement: Refinement,
    /// Mirror direction of the eye, in world space.
    mirrored: Vec3,
    /// Mirror that also needs nodes without visible light.
    mirror: Option<&'p Mirror>,
}

impl<'a, 'p, F: NodeField> Merged<'a, 'p, F> {
    #[inline(always)]
    pub fn new(shader: &Shader<'a, F>, point: &'p SurfacePoint, mirror: Option<&'p Mirror>) -> Self {
        let &Shader { field, cuts, sampling, .. } = shader;
        let mirrored = point.world_from_local * Vec3::new(-point.wo.x, -point.wo.y, point.wo.z);
        let refinement = Refinement::new(point.lobes());
        Self { field, cuts, height: field.tree().height(), sampling, point, refinement, mirrored, mirror }
    }

    /// Finds the terms, and passes nodes without visible light to `dark`, left to right. Returns the number of nodes in the merged
    /// cut.
    #[inline(always)]
    pub fn find<L: Lanes>(&self, found: &mut Found, dark: impl FnMut(Interval)) -> u64 {
        found.terms.clear();
        match self.sampling {
            BrdfSampling::Once => self.stored(&mut found.terms, dark),
            BrdfSampling::Refine => {
                let count = self.stored(&mut found.open, dark);
                self.settle::<L>(found);
                count
            }
            BrdfSampling::Lit => {
                self.merge_lit(&mut found.lit);
                let count = self.lit::<L>(found, dark);
                self.settle::<L>(found);
                count
            }
        }
    }

    #[inline(always)]
    fn leaves(&self) -> u32 {
        1 << self.height
    }

    /// Interpolated value of the three vertices.
    #[inline(always)]
    fn interpolated(&self, codes: impl Fn(usize) -> u16) -> f32 {
        let value = |i: usize| self.point.weights[i] * self.field.cut_value(codes(i));
        value(0) + value(1) + value(2)
    }

    #[inline(always)]
    fn term(&self, interval: Interval, visibility: f32, is_lit: bool) -> Term {
        Term { node: interval.heap_index(self.leaves()), leaves: interval.size() as f32, visibility, is_lit }
    }

    #[inline(always)]
    fn stored_cursors(&self) -> [PackedCursor<'a>; 3] {
        self.point.vertices.map(|v| PackedCursor::new(self.height, self.cuts.nodes_from(v)))
    }

    /// Merges the stored cuts with the illumination cut. Returns the number of nodes.
    #[inline(always)]
    fn stored(&self, open: &mut Terms, mut dark: impl FnMut(Interval)) -> u64 {
        let ([a, b, c], mut count) = (self.stored_cursors(), 0);
        let mut cursors = [a, b, c, PackedCursor::new(self.height, &self.field.tree().cut)];
        merge(
            self.leaves(),
            &mut cursors,
            #[inline(always)]
            |interval, cursors| {
                count += 1;
                self.add_stored(interval, cursors, open, &mut dark);
            },
        );
        count
    }

    /// Adds a node of the merged stored cuts, or passes it to `dark`. The first three of `cursors` are the vertices' cursors.
    #[inline(always)]
    fn add_stored(
        &self,
        interval: Interval,
        cursors: &[PackedCursor],
        open: &mut Terms,
        dark: &mut impl FnMut(Interval),
    ) {
        let visibility = self.interpolated(|i| cursors[i].stored_value());
        let is_dark = !(visibility > 0.0);
        if is_dark {
            dark(interval);
        }
        if !is_dark || self.mirror.is_some() {
            open.push(self.term(interval, visibility, false));
        }
    }

    #[inline(always)]
    fn lit_cursors(&self) -> [PackedCursor<'_, LitNode>; 3] {
        let lit = &self.field.tree().lit;
        self.point.vertices.map(|v| PackedCursor::new(self.height, lit.of(self.cuts, v)))
    }

    /// Merges the lit cuts of the point's triangle, unless already done.
    #[inline(always)]
    fn merge_lit(&self, lit: &mut LitNodes) {
        if lit.vertices == Some(self.point.vertices) {
            return;
        }
        let LitNodes { vertices, eights, count } = lit;
        (*vertices, *count) = (Some(self.point.vertices), 0);
        merge(
            self.leaves(),
            &mut self.lit_cursors(),
            #[inline(always)]
            |interval, cursors| {
                let (place, lane) = (*count / 8, *count % 8);
                if lane == 0 {
                    eights.truncate(place);
                    eights.push(EightLitNodes::PADDING);
                }
                let eight = &mut eights[place];
                eight.nodes[lane] = interval.heap_index(self.leaves()) as usize;
                (eight.firsts[lane], eight.leaves[lane]) = (interval.first, interval.size());
                for ((values, place), cursor) in eight.values.iter_mut().zip(&mut eight.places[lane]).zip(cursors) {
                    values[lane] = self.field.cut_value(cursor.stored_value());
                    *place = cursor.place();
                }
                *count += 1;
            },
        );
    }

    /// Tests the merged lit cuts, and merges the stored cuts below nodes within a lobe. Returns the number of nodes.
    #[inline(always)]
    fn lit<L: Lanes>(&self, found: &mut Found, mut dark: impl FnMut(Interval)) -> u64 {
        let Found { lit, open, terms } = found;
        let (mut stored, mut count) = (None, lit.count as u64);
        for (eight, left) in lit.eights[..lit.count.div_ceil(8)].iter().zip((1..=lit.count).rev().step_by(8)) {
            let [a, b, c] = self.point.weights;
            let visibility = L::new(eight.values[0]) * L::splat(a)
                + L::new(eight.values[1]) * L::splat(b)
                + L::new(eight.values[2]) * L::splat(c);
            let looks = self.look::<L>(eight.nodes);
            let present = 0xff >> 8_usize.saturating_sub(left);
            let visible = visibility.simd_gt(L::splat(0.0)).to_bitmask();
            let fine = visible & !looks.too_wide;
            let visibility = visibility.to_array();
            let term = |lane: usize| Term {
                node: eight.nodes[lane] as u32,
                leaves: eight.leaves[lane] as f32,
                visibility: visibility[lane],
                is_lit: true,
            };
            terms.make_room(8);
            for lane in 0..8 {
                terms.put(term(lane), fine >> lane & 1 != 0);
            }
            for lane in lanes(present & !fine) {
                let is = |bits: u32| bits >> lane & 1 != 0;
                let interval = Interval { first: eight.firsts[lane], end: eight.firsts[lane] + eight.leaves[lane] };
                if !is(visible) {
                    dark(interval);
                    if is(looks.in_window) {
                        self.add(
                            Term { visibility: 0.0, is_lit: false, ..term(lane) },
                            is(looks.too_wide),
                            open,
                            terms,
                        );
                    }
                } else if is(looks.in_lobe) {
                    let (stored, at_first) = stored.get_or_insert_with(|| (self.stored_cursors(), self.lit_cursors()));
                    for ((stored, cursor), place) in stored.iter_mut().zip(at_first).zip(eight.places[lane]) {
                        let cursor = cursor.at(place);
                        stored.seek(cursor.node().stored(), cursor.first(), interval.first);
                    }
                    count += self.below(interval, stored, open, &mut dark) - 1;
                } else {
                    self.add(term(lane), true, open, terms);
                }
            }
        }
        count
    }

    /// Merges the stored cuts below one node.
    #[inline(always)]
    fn below(
        &self,
        within: Interval,
        stored: &mut [PackedCursor; 3],
        open: &mut Terms,
        dark: &mut impl FnMut(Interval),
    ) -> u64 {
        let mut count = 0;
        merge_within(
            within,
            stored,
            #[inline(always)]
            |interval, cursors| {
                count += 1;
                self.add_stored(interval, cursors, open, dark);
            },
        );
        count
    }

    /// Tests waiting nodes and their halves until none is too wide.
    #[inline(always)]
    fn settle<L: Lanes>(&self, found: &mut Found) {
        let Found { open, terms, .. } = found;
        while open.len() > 0 {
            let (eight, count) = open.pop_eight();
            let looks = self.look::<L>(nodes_of(&eight));
            let mut seen = looks.in_window;
            for (lane, term) in eight.iter().enumerate() {
                seen |= u32::from(term.visibility > 0.0) << lane;
            }
            seen &= 0xff >> (8 - count);
            let mut too_wide = 0;
            terms.make_room(8);
            for (lane, &term) in eight.iter().enumerate() {
                let is_wide = looks.too_wide >> lane & u32::from(term.node < self.leaves());
                too_wide |= is_wide << lane;
                terms.put(term, seen & !too_wide & 1 << lane != 0);
            }
            open.make_room(16);
            for lane in lanes(too_wide & seen) {
                let [left, right] = eight[lane].halves();
                open.put(left, true);
                open.put(right, true);
            }
        }
    }

    /// Adds a node to the sum, or its halves to the waiting nodes.
    #[inline(always)]
    fn add(&self, term: Term, is_too_wide: bool, open: &mut Terms, terms: &mut Terms) {
        if is_too_wide && term.node < self.leaves() {
            let [left, right] = term.halves();
            open.push(left);
            open.push(right);
        } else {
            terms.push(term);
        }
    }

    #[inline(always)]
    fn look<L: Lanes>(&self, nodes: [usize; 8]) -> Looks {
        let cones = self.field.cones::<L>(nodes, self.point.position);
        let cos = cones.direction.dot(Vec3x8::splat(self.mirrored));
        let in_lobe = self.refinement.are_too_wide(&cones, cos).to_bitmask();
        let for_cosine = are_too_wide_for_a_cosine(&cones, self.point.world_from_local.z_axis).to_bitmask();
        let in_window = match self.mirror {
            Some(mirror) => mirror.overlaps(cos, cones.radius).to_bitmask(),
            None => 0,
        };
        Looks { in_lobe, too_wide: in_lobe | for_cosine, in_window }
    }
}

/// Nodes of eight terms.
#[inline(always)]
fn nodes_of(eight: &[Term; 8]) -> [usize; 8] {
    let mut nodes = [1; 8];
    for (node, term) in nodes.iter_mut().zip(eight) {
        *node = term.node as usize;
    }
    nodes
}

/// The set lanes of a mask.
#[inline(always)]
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask.wrapping_sub(1);
            (lane < 8).then_some(lane)
        },
    )
}
