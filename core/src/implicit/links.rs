//! The link structure of the paper (implicit visibility, 4.1 and 4.2.2): the oracle of the walk, and the subject of its Table 1.
//!
//! The paper leaves the solid angle of a node open. Here it is area over squared distance, an upper bound for any tilt
//! of its discs. If both ends of a link are too large, the larger is subdivided. Centers are means weighted by area.

use super::bins::CubeBins;
use crate::{
    implicit::{
        disc_forest::DiscForest,
        forest::{
            nodes::{Disc, Node},
            quadtrees::Slot,
        },
    },
    light_tree::{Features, cluster_order},
    mesh::Mesh,
};
use glam::Vec3;

/// Discs around the vertices of a mesh: a third of the area of all triangles that share them (4.1).
pub fn vertex_discs(mesh: &Mesh) -> Vec<Disc> {
    let disc = |(&position, &normal)| Disc { position, normal, area: 0.0 };
    let mut discs: Vec<Disc> = mesh.positions.iter().zip(&mesh.normals).map(disc).collect();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let third = 0.5 * mesh.area_vector(triangle).length() / 3.0;
        corners.iter().for_each(|&vertex| discs[vertex as usize].area += third);
    }
    discs
}

/// Quadtrees over vertices, one per segment: a set of triangles that share vertices. The texture of a model splits
/// vertices where its segments end.
#[derive(Clone, Debug)]
pub struct VertexForest {
    /// The trees; each segment is an object.
    pub discs: DiscForest,
    /// The vertex of each leaf.
    pub vertices: Vec<u32>,
}

impl VertexForest {
    /// The forest of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let discs = vertex_discs(mesh);
        let segments = segments(mesh);
        let vertices: Vec<u32> = segments.iter().flat_map(|segment| in_order(segment, &discs)).collect();
        let leaves: Vec<u32> = segments.iter().map(|segment| segment.len() as u32).collect();
        let in_trees = vertices.iter().map(|&vertex| discs[vertex as usize]).collect();
        Self { discs: DiscForest::new(&leaves, in_trees), vertices }
    }

    /// Moves all discs to the vertices of a posed mesh ("update elements", 4.2.1).
    pub fn update(&mut self, mesh: &Mesh) {
        let posed = vertex_discs(mesh);
        let vertices = &self.vertices;
        self.discs.update(&|_| true, &|leaf, _| posed[vertices[leaf as usize] as usize]);
    }
}

/// The vertices of each connected piece.
fn segments(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut smallest: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let root = |smallest: &[u32], mut vertex: u32| {
        while smallest[vertex as usize] != vertex {
            vertex = smallest[vertex as usize];
        }
        vertex
    };
    for corners in &mesh.triangles {
        let roots = corners.map(|vertex| root(&smallest, vertex));
        let least = roots.into_iter().min().unwrap_or(0);
        roots.into_iter().chain(*corners).for_each(|vertex| smallest[vertex as usize] = least);
    }
    let mut segments = vec![Vec::new(); mesh.positions.len()];
    (0..mesh.positions.len() as u32).for_each(|vertex| segments[root(&smallest, vertex) as usize].push(vertex));
    segments.retain(|segment| !segment.is_empty());
    segments
}

/// Sorts vertices so that near ones with similar normals are adjacent.
fn in_order(segment: &[u32], discs: &[Disc]) -> Vec<u32> {
    let row = |&vertex: &u32| {
        let Disc { position, normal, .. } = discs[vertex as usize];
        [position.to_array(), normal.to_array()].concat()
    };
    let features = Features::new(6, segment.iter().flat_map(row).collect());
    cluster_order(&features).into_iter().map(|i| segment[i as usize]).collect()
}

/// The shortest link of a node in a bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Distance in meters; infinite where there is none.
    pub distance: f32,
    /// The other end.
    pub node: u32,
}

/// No link.
pub const UNLINKED: Link = Link { distance: f32::INFINITY, node: u32::MAX };

/// The shortest links of all nodes: 8 bytes for each node and bin.
#[derive(Clone, Debug, PartialEq)]
pub struct Links {
    /// The bins of a node.
    pub bins: CubeBins,
    pub(super) links: Vec<Link>,
}

impl Links {
    /// Links all nodes, from the roots down.
    pub fn create(forest: &DiscForest, bins: CubeBins) -> Self {
        let links = vec![UNLINKED; forest.shape().nodes() * bins.len()];
        let nodes = (0..forest.shape().nodes() as u32).map(|node| forest.node(node)).collect();
        let solid_angles = (0..bins.len()).map(|texel| bins.solid_angle(texel)).collect();
        let mut work = Linking { forest, nodes, solid_angles, waiting: Vec::new(), links: Self { bins, links } };
        work.run();
        work.links
    }

    /// Bytes of all links.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.links[..]) as u64
    }

    /// The links of a node, bin by bin.
    pub fn of(&self, node: u32) -> &[Link] {
        let first = node as usize * self.bins.len();
        &self.links[first..first + self.bins.len()]
    }

    /// Keeps a link if it is shorter than the link in its bin.
    fn offer(&mut self, from: u32, texel: usize, link: Link) {
        let kept = &mut self.links[from as usize * self.bins.len() + texel];
        if link.distance < kept.distance {
            *kept = link;
        }
    }
}

/// Links under construction.
struct Linking<'a> {
    forest: &'a DiscForest,
    nodes: Vec<Node>,
    solid_angles: Vec<f32>,
    waiting: Vec<[u32; 2]>,
    links: Links,
}

impl Linking<'_> {
    fn run(&mut self) {
        let roots: Vec<u32> = (0..self.forest.shape().trees().len() as u32).collect();
        self.pair_up(&roots);
        while let Some([a, b]) = self.waiting.pop() {
            match self.forest.shape().slot(a) {
                Slot::Inner(block) if a == b => self.pair_up(&self.forest.shape().nodes_of(block).collect::<Vec<_>>()),
                _ if a == b => {}
                _ => self.connect(a, b),
            }
        }
    }

    /// Links all pairs of some nodes, including each with itself.
    fn pair_up(&mut self, nodes: &[u32]) {
        for (i, &a) in nodes.iter().enumerate() {
            self.waiting.extend(nodes[i..].iter().map(|&b| [a, b]));
        }
    }

    /// Pairs a node with the children of another.
    fn split(&mut self, node: u32, other: u32) {
        let Self { forest, waiting, .. } = self;
        if let Slot::Inner(block) = forest.shape().slot(node) {
            waiting.extend(forest.shape().nodes_of(block).map(|child| [child, other]));
        }
    }

    /// Links two nodes, or one with the children of the other if the other is too large for its bin.
    fn connect(&mut self, a: u32, b: u32) {
        let [near, far] = [a, b].map(|node| self.nodes[node as usize]);
        let offset = far.center - near.center;
        let bins = self.links.bins;
        let texels = [bins.texel_of(offset), bins.texel_of(-offset)];
        let is_inner = |node| matches!(self.forest.shape().slot(node), Slot::Inner(_));
        let is_large = |node: &Node, texel: usize| {
            let distance_sq = offset.length_squared();
            node.area > self.solid_angles[texel] * distance_sq || distance_sq < node.radius * node.radius
        };
        let split = [is_inner(a) && is_large(&near, texels[1]), is_inner(b) && is_large(&far, texels[0])];
        match split {
            [false, false] => self.link([a, b], texels, offset),
            [true, other] if !other || near.area > far.area => self.split(a, b),
            _ => self.split(b, a),
        }
    }

    /// Vertices at one position, as along the edges of segments, do not see each other.
    fn link(&mut self, [a, b]: [u32; 2], texels: [usize; 2], offset: Vec3) {
        let distance = offset.length();
        if distance == 0.0 {
            return;
        }
        self.links.offer(a, texels[0], Link { distance, node: b });
        self.links.offer(b, texels[1], Link { distance, node: a });
    }
}
