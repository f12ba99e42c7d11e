//! Quadtrees over discs, the input of implicit visibility.

use super::forest::{
    nodes::{Block, Disc, Node},
    quadtrees::{CHILDREN, Quadtrees, Slot, Tree},
};
use crate::bounds::Bounds;
use rayon::prelude::*;
use std::ops::Range;

/// A quadtree of discs for each object; see [`Quadtrees`] for the numbers of nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscForest {
    shape: Quadtrees,
    /// The discs in the order of the leaves.
    discs: Vec<Disc>,
    blocks: Vec<Block>,
    /// Diagonal as built, in meters.
    diagonal: f32,
}

impl DiscForest {
    /// `leaves` has the number of discs of each object. `discs` are sorted by object, with neighbors adjacent.
    pub fn new(leaves: &[u32], discs: Vec<Disc>) -> Self {
        let shape = Quadtrees::new(leaves);
        assert_eq!(shape.leaves(), discs.len(), "one disc for each leaf");
        let below = |node: u32| if let Slot::Inner(block) = shape.slot(node) { block } else { 0 };
        let block = |block: usize| Block {
            below: std::array::from_fn(|slot| below((block * CHILDREN + slot) as u32)),
            ..Block::default()
        };
        let diagonal = Bounds::around(discs.iter().map(|disc| disc.position)).diagonal();
        let mut forest = Self { blocks: (0..shape.blocks()).map(block).collect(), shape, discs, diagonal };
        forest.update(&|_| true, &|_, disc| disc);
        forest
    }

    /// Moves the discs of the objects for which `moved` holds, and updates the nodes above. `posed` gets the number of
    /// a leaf and its disc.
    pub fn update(&mut self, moved: &dyn Fn(u32) -> bool, posed: &(dyn Fn(u32, Disc) -> Disc + Sync)) {
        for object in (0..self.shape.trees().len() as u32).filter(|&object| moved(object)) {
            let Tree { leaves, blocks } = self.shape.trees()[object as usize].clone();
            let range = |r: &Range<u32>| r.start as usize..r.end as usize;
            let discs = &mut self.discs[range(&leaves)];
            discs.par_iter_mut().zip(leaves).with_min_len(256).for_each(|(disc, leaf)| *disc = posed(leaf, *disc));
            let Self { shape, discs, blocks: all, .. } = self;
            let node = |number: u32| Node::around(&discs[range(&shape.span(number))]);
            all[object as usize / CHILDREN].set(object as usize % CHILDREN, &node(object));
            let of_object = all[range(&blocks)].par_iter_mut().zip(blocks);
            of_object.with_min_len(32).for_each(|(block, number)| {
                shape.nodes_of(number).for_each(|n| block.set(n as usize % CHILDREN, &node(n)));
            });
        }
    }

    /// The nodes and their links.
    pub fn shape(&self) -> &Quadtrees {
        &self.shape
    }

    /// The discs, leaf by leaf.
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// Diagonal of the box around the centers of the discs as the forest was built, in meters: a scale that stays while
    /// objects move.
    pub fn diagonal(&self) -> f32 {
        self.diagonal
    }

    /// The nodes, four by four.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// A node by its number.
    pub fn node(&self, number: u32) -> Node {
        self.blocks[number as usize / CHILDREN].get(number as usize % CHILDREN)
    }

    /// The leaves of an object; none for one without discs.
    pub fn leaves_of(&self, object: u32) -> Range<u32> {
        self.shape.trees().get(object as usize).map_or(0..0, |tree| tree.leaves.clone())
    }

    /// Values of all nodes by node number: area-weighted means of leaf values ("pull" of implicit visibility, 4.3).
    pub fn pull<T>(&self, leaves: &[T]) -> Vec<T>
    where
        T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let mut nodes = vec![T::default(); self.shape.nodes()];
        self.shape
            .leaf_nodes()
            .iter()
            .for_each(|&node| nodes[node as usize] = leaves[self.shape.span(node).start as usize]);
        for block in (0..self.shape.blocks() as u32).rev() {
            if let Some(parent) = self.shape.parent(block) {
                let whole = self.node(parent).area;
                let area = |node: u32| self.blocks[block as usize].area[node as usize % CHILDREN];
                let share = |node: u32| if whole > 0.0 { area(node) / whole } else { 0.0 };
                let weighted = self.shape.nodes_of(block).map(|node| nodes[node as usize] * share(node));
                nodes[parent as usize] = weighted.fold(T::default(), |sum, value| sum + value);
            }
        }
        nodes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::sphere_points;
    use glam::Vec3;

    fn forest() -> DiscForest {
        let disc = |(i, p): (usize, crate::surfel::Surfel)| Disc {
            position: p.position,
            normal: p.normal,
            area: 0.01 * (1.0 + (i % 5) as f32),
        };
        DiscForest::new(&[60, 40], sphere_points(100, 1.0).into_iter().enumerate().map(disc).collect())
    }

    #[test]
    fn nodes_stand_for_the_discs_below_them() {
        let forest = forest();
        for number in (0..forest.shape().nodes() as u32).filter(|&n| forest.shape().slot(n) != Slot::Empty) {
            let span = forest.shape().span(number);
            let discs = &forest.discs()[span.start as usize..span.end as usize];
            assert_eq!(forest.node(number), Node::around(discs));
        }
    }

    #[test]
    fn an_object_moves_alone() {
        let still = forest();
        let up = |_, disc: Disc| Disc { position: disc.position + Vec3::Y, ..disc };
        let mut moved = still.clone();
        moved.update(&|object| object == 1, &up);
        assert_eq!(moved.node(0), still.node(0));
        assert!((moved.node(1).center - still.node(1).center - Vec3::Y).length() < 1e-6);
        let all = DiscForest::new(&[60, 40], moved.discs().to_vec());
        assert_eq!((moved.discs(), moved.blocks()), (all.discs(), all.blocks()), "as built anew");
        moved.update(&|_| true, &|leaf, _| still.discs()[leaf as usize]);
        assert_eq!(moved, still, "there and back, bit for bit");
    }

    #[test]
    fn what_is_pulled_up_is_the_mean_by_area() {
        let forest = forest();
        let values: Vec<f32> = (0..100).map(|i| (i % 7) as f32).collect();
        let nodes = forest.pull(&values);
        let mean = |range: Range<usize>, weight: &dyn Fn(usize) -> f32| {
            let sum: f32 = range.clone().map(|i| values[i] * weight(i)).sum();
            sum / range.map(weight).sum::<f32>()
        };
        let by_area = |i: usize| forest.discs()[i].area;
        assert!((nodes[0] - mean(0..60, &by_area)).abs() < 1e-4);
        assert!((nodes[1] - mean(60..100, &by_area)).abs() < 1e-4);
        assert!((nodes[0] - mean(0..60, &|_| 1.0)).abs() > 1e-3, "negative control: areas differ");
    }

    #[test]
    fn discs_without_area_are_left_out_of_what_is_pulled_up() {
        let mut forest = forest();
        forest.update(&|_| true, &|leaf, disc| if leaf < 30 { Disc { area: 0.0, ..disc } } else { disc });
        let nodes = forest.pull(&[1.0; 100]);
        assert!((nodes[0] - 1.0).abs() < 1e-4 && nodes.iter().all(|value| value.is_finite()));
        let without = (0..forest.shape().nodes() as u32).filter(|&node| forest.node(node).area == 0.0).count();
        assert!(without > 10, "negative control: inner nodes have none, {without}");
    }
}
