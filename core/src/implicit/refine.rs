//! Refinement and push-down of links, and light through them (implicit visibility, 4.2.3 to 4.4).

use super::{
    gather::Sky,
    links::{Link, Links, UNLINKED},
};
use crate::implicit::{
    disc_forest::DiscForest,
    forest::{
        nodes::Node,
        quadtrees::{CHILDREN, Slot},
    },
};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

impl Links {
    /// Takes all links down to the leaves, from the roots: refinement (4.2.3) and push-down (4.2.4) in one pass, as the
    /// paper proposes. Where a node and its ancestor have links in one bin, the shorter stays.
    pub fn refine_and_push_down(&mut self, forest: &DiscForest) {
        self.push_down(forest, |above, below| above.distance < below.distance);
    }

    /// Push-down alone, against which Fig. 4 warns: links of nodes replace all links below them, whatever their lengths.
    pub fn push_down_unrefined(&mut self, forest: &DiscForest) {
        self.push_down(forest, |above, _| *above != UNLINKED);
    }

    /// From the roots down, children take the links of their parent for which `replaces` holds.
    fn push_down(&mut self, forest: &DiscForest, replaces: impl Fn(&Link, &Link) -> bool) {
        let bins = self.bins.len();
        for block in 0..forest.shape().blocks() as u32 {
            let Some(parent) = forest.shape().parent(block) else { continue };
            let (above, below) = self.links.split_at_mut(block as usize * CHILDREN * bins);
            let of_parent = &mut above[parent as usize * bins..][..bins];
            for node in forest.shape().nodes_of(block) {
                let of_child = &mut below[(node as usize % CHILDREN) * bins..][..bins];
                for (link, pushed) in of_child.iter_mut().zip(of_parent.iter()) {
                    if replaces(pushed, link) {
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
        let bin = |(texel, link): (usize, &Link)| {
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
    use crate::implicit::{bins::CubeBins, links::VertexForest, room::room_of_grids};

    fn forest() -> VertexForest {
        VertexForest::new(&room_of_grids(10))
    }

    #[test]
    fn refined_links_are_those_of_all_pairs() {
        let VertexForest { discs, .. } = forest();
        for side in [8, 12] {
            let mut links = Links::create(&discs, CubeBins { side });
            let mut unrefined = links.clone();
            links.refine_and_push_down(&discs);
            unrefined.push_down_unrefined(&discs);
            let [wrong, without] = [&links, &unrefined].map(|links| links.share_of_wrong(&discs, 7));
            assert!(wrong < 0.01, "{wrong}");
            assert!(without > 0.01, "negative control: without refinement (Fig. 4), {without}");
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
        // From one wall of an empty cube the five others receive a fifth of its light each.
        let flux: f32 = received.iter().zip(discs.discs()).map(|(e, d)| e.x * d.area).sum();
        let energy = flux / (std::f32::consts::PI * 4.0);
        assert!((0.3..0.9).contains(&energy), "{energy}");
        let sky = links.irradiance(&discs, &discs.pull(&sent), &|_| Vec3::ONE);
        assert!(sky.iter().zip(&received).any(|(a, b)| a.x > b.x), "and some see the sky");
    }
}
