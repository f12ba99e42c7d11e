//! What becomes of links before and while they carry light (implicit visibility, 4.2.3 to 4.4).

use super::{
    gather::Sky,
    links::{Links, UNLINKED},
};
use crate::surfel::{
    disc_forest::DiscForest,
    forest::{
        nodes::Node,
        quadtrees::{CHILDREN, Slot},
    },
};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

impl Links {
    /// Takes all links down to the leaves, from the roots on: refinement (4.2.3) and push-down (4.2.4) in one pass, as the paper
    /// proposes. Where a node and one above it have links in one bin, the shorter stays.
    pub fn refine_and_push_down(&mut self, forest: &DiscForest) {
        let bins = self.bins.len();
        for block in 0..forest.shape().blocks() as u32 {
            let Some(parent) = forest.shape().parent(block) else { continue };
            let (above, below) = self.links.split_at_mut(block as usize * CHILDREN * bins);
            let of_parent = &mut above[parent as usize * bins..][..bins];
            for node in forest.shape().nodes_of(block) {
                let of_child = &mut below[(node as usize % CHILDREN) * bins..][..bins];
                for (link, pushed) in of_child.iter_mut().zip(of_parent.iter()) {
                    if pushed.distance < link.distance {
                        *link = *pushed;
                    }
                }
            }
            of_parent.fill(UNLINKED);
        }
    }

    /// Irradiance of each leaf by Eq. 5 from the radiance of nodes; empty bins see the sky (4.4). All links are at the leaves.
    pub fn irradiance(&self, forest: &DiscForest, radiance: &[Vec3A], sky: Sky) -> Vec<Vec3> {
        let nodes: Vec<Node> = (0..forest.shape().nodes() as u32).map(|node| forest.node(node)).collect();
        let leaves = forest.shape().leaf_nodes().par_iter().map(|&node| self.gather(&nodes, node, radiance, sky));
        let mut by_leaf = vec![Vec3::ZERO; forest.discs().len()];
        for (&node, light) in forest.shape().leaf_nodes().iter().zip(leaves.collect::<Vec<_>>()) {
            if let Slot::Leaf(leaf) = forest.shape().slot(node) {
                by_leaf[leaf as usize] = light;
            }
        }
        by_leaf
    }

    fn gather(&self, nodes: &[Node], node: u32, radiance: &[Vec3A], sky: Sky) -> Vec3 {
        let receiver = &nodes[node as usize];
        let bin = |(texel, link): (usize, &super::links::Link)| {
            if *link == UNLINKED {
                let direction = self.bins.direction_of(texel);
                let cosine = receiver.axis.dot(direction).max(0.0);
                return if cosine > 0.0 { sky(direction) * cosine * self.bins.solid_angle(texel) } else { Vec3::ZERO };
            }
            let sender = &nodes[link.node as usize];
            let offset = sender.center - receiver.center;
            let cosines = receiver.axis.dot(offset).max(0.0) * (-sender.axis.dot(offset)).max(0.0);
            Vec3::from(radiance[link.node as usize]) * cosines * sender.area / offset.length_squared().powi(2)
        };
        self.of(node).iter().enumerate().map(bin).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::{bins::CubeBins, links::VertexForest, tests::tessellated};

    fn forest() -> VertexForest {
        VertexForest::new(&tessellated(10))
    }

    /// The nearest leaf in each bin by linking all with all (3.1): distances.
    fn by_all_pairs(forest: &DiscForest, leaf: usize, bins: CubeBins) -> Vec<f32> {
        let mut nearest = vec![f32::INFINITY; bins.len()];
        for (other, disc) in forest.discs().iter().enumerate().filter(|(other, _)| *other != leaf) {
            let offset = disc.position - forest.discs()[leaf].position;
            if offset != Vec3::ZERO && other != leaf {
                let texel = bins.texel_of(offset);
                nearest[texel] = nearest[texel].min(offset.length());
            }
        }
        nearest
    }

    /// Of the bins that both have filled, the share in which both are as far, to the size of a node.
    fn share_of_same(forest: &DiscForest, links: &Links) -> f32 {
        let (mut same, mut all) = (0, 0);
        for leaf in (0..forest.discs().len()).step_by(7) {
            let node = forest.shape().leaf_nodes().iter().find(|&&n| forest.shape().span(n).start as usize == leaf);
            let node = *node.expect("each leaf has a node");
            for (link, nearest) in links.of(node).iter().zip(by_all_pairs(forest, leaf, links.bins)) {
                if link.distance < f32::INFINITY && nearest < f32::INFINITY {
                    let size = forest.node(link.node).radius + forest.node(node).radius;
                    same += usize::from((link.distance - nearest).abs() <= 2.0 * size);
                    all += 1;
                }
            }
        }
        same as f32 / all as f32
    }

    #[test]
    fn refined_links_are_those_of_all_pairs() {
        let VertexForest { discs, .. } = forest();
        for side in [8, 12] {
            let mut links = Links::create(&discs, CubeBins { side });
            let mut unrefined = links.clone();
            links.refine_and_push_down(&discs);
            let share = share_of_same(&discs, &links);
            push_down_alone(&mut unrefined, &discs);
            let without = share_of_same(&discs, &unrefined);
            assert!(share > 0.99, "{share}");
            assert!(without < 0.99, "negative control: without refinement (Fig. 4), {without}");
        }
    }

    /// Links of nodes replace those of what is below them, whatever their lengths.
    fn push_down_alone(links: &mut Links, forest: &DiscForest) {
        let bins = links.bins.len();
        for block in 0..forest.shape().blocks() as u32 {
            let Some(parent) = forest.shape().parent(block) else { continue };
            for node in forest.shape().nodes_of(block) {
                for texel in 0..bins {
                    let pushed = links.links[parent as usize * bins + texel];
                    if pushed != UNLINKED {
                        links.links[node as usize * bins + texel] = pushed;
                    }
                }
            }
        }
    }

    #[test]
    fn as_printed_a_wall_sends_half_of_its_light() {
        let VertexForest { discs, .. } = forest();
        let mut links = Links::create(&discs, CubeBins { side: 12 });
        links.refine_and_push_down(&discs);
        let is_wall = |position: Vec3| position.x < -0.999;
        let sent: Vec<Vec3A> =
            discs.discs().iter().map(|d| Vec3A::splat(f32::from(u8::from(is_wall(d.position))))).collect();
        let received = links.irradiance(&discs, &discs.pull(&sent), &|_| Vec3::ZERO);
        // From one wall of an empty cube the five others receive a fifth each of what it sends.
        let flux: f32 = received.iter().zip(discs.discs()).map(|(e, d)| e.x * d.area).sum();
        let energy = flux / (std::f32::consts::PI * 4.0);
        assert!((0.3..0.9).contains(&energy), "{energy}");
        let sky = links.irradiance(&discs, &discs.pull(&sent), &|_| Vec3::ONE);
        assert!(sky.iter().zip(&received).any(|(a, b)| a.x > b.x), "and some see the sky");
    }
}
