//! The origin of a pixel's radiance: its surface point, the cuts of the three vertices, and every node of the merged
//! cut with its radiance, visibility and BRDF (paper, 4.2).
//!
//! The nodes come from [`crate::shade::merge`], by the same traversal. Sharp lobes read the map in place of some nodes
//! ([`crate::shade::mirror`]); with that light, the contributions sum to the rendered radiance.

pub(crate) mod cut_map;

use crate::{
    light::environment::Illumination,
    measure::cut_light::{CutLight, FieldJob, NoCuts, TreeOf},
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::Backdrop,
        direct::{DirectLights, pixel_shift},
        merge::{EightTerms, Shader},
        mirror::rays::RayLobes,
        node_field::NodeField,
        pixel_sampler::PixelSampler,
        surface::{FirstHit, SurfacePoint},
    },
    view::View,
};
use glam::Vec3;
use lapidary_core::{color::luminance, cut::packed::PackedCuts, lights::Emission};
use serde::Serialize;
use std::ops::Range;
use thiserror::Error;

/// Why a pixel cannot be explained.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ExplainError {
    /// The pixel lies outside the picture.
    #[error(
        "pixel {},{} lies outside the picture of {} x {} pixels; columns and rows count from 0 at the top left",
        pixel[0], pixel[1], size[0], size[1]
    )]
    Outside {
        /// Column and row.
        pixel: [u32; 2],
        /// Width and height of the picture.
        size: [u32; 2],
    },
    /// The pixel shows the background.
    #[error("pixel {},{} shows the background, where no cut is merged; choose a pixel on a surface", pixel[0], pixel[1])]
    Background {
        /// Column and row.
        pixel: [u32; 2],
    },
    /// The pixel shows the back of a one-sided surface.
    #[error(
        "pixel {},{} shows the back of a one-sided surface, which is black; choose another, or make its material double-sided and bake again",
        pixel[0], pixel[1]
    )]
    Back {
        /// Column and row.
        pixel: [u32; 2],
    },
    /// The dataset lacks the cuts.
    #[error(transparent)]
    NoCuts(#[from] NoCuts),
}

/// One of the three vertices whose cuts are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExplainedVertex {
    /// Index in the mesh.
    pub index: u32,
    /// Position in meters.
    pub position: Vec3,
    /// Weight in the interpolation; zero if the vertex is buried.
    pub weight: f32,
    /// Nodes of the stored cut.
    pub cut_nodes: usize,
    /// Nodes of the lit cut, if lit cuts are merged.
    pub lit_nodes: Option<usize>,
}

/// One term of the radiance sum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExplainedNode {
    /// Heap index in the tree: the root is 1, the children of `i` are `2i` and `2i + 1`.
    pub heap_index: u32,
    /// Depth in the tree; the root has 0.
    pub depth: u32,
    /// Leaves below the node.
    pub leaves: u32,
    /// Solid angle in steradians. For the environment: the node's, hidden or not. For surface sources: the interpolated visible
    /// solid angle, as the vertices' cuts hold it.
    pub solid_angle: f32,
    /// Unit direction to the node's light, in world space.
    pub direction: Vec3,
    /// Center of its light in meters; `None` if infinitely far.
    pub center: Option<Vec3>,
    /// Mean radiance.
    pub radiance: Vec3,
    /// Whether it comes from lit cuts: its visibility is then a light-weighted mean.
    pub is_lit: bool,
    /// Interpolated visibility, 0 to 1; 1 for surface sources, whose solid angles include it.
    pub visibility: f32,
    /// BRDF times cosine; zero below the smooth normal's horizon.
    pub brdf_cos: Vec3,
    /// Light reflected to the eye: radiance times BRDF and cosine times visibility times solid angle.
    pub contribution: Vec3,
}

/// Light of a sun. A sun is not a node: rays from the pixel find its shadow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExplainedSun {
    /// Unit direction to its center in world space.
    pub direction: Vec3,
    /// Angular diameter in degrees.
    pub angle_degrees: f32,
    /// Light reflected to the eye.
    pub contribution: Vec3,
}

/// All terms of the radiance at the center of a pixel.
#[derive(Clone, Debug, Serialize)]
pub struct PixelExplanation {
    /// Column and row.
    pub pixel: [u32; 2],
    /// Tree of the explained light.
    pub tree: TreeOf,
    /// Surface position in meters.
    pub position: Vec3,
    /// Unit normal after bump and normal map.
    pub normal: Vec3,
    /// Vertices of the triangle.
    pub vertices: [ExplainedVertex; 3],
    /// Nodes of the illumination cut; 0 with lit cuts, which need none.
    pub illumination_nodes: usize,
    /// Number of nodes of the merged cut before BRDF refinement, including nodes without visible light.
    pub merged_nodes: u64,
    /// Nodes of the merged cut with visible light, after BRDF refinement, left to right in the tree.
    pub nodes: Vec<ExplainedNode>,
    /// Heap indices of the nodes of the merged cut without visible light, left to right.
    pub dark_nodes: Vec<u32>,
    /// Suns of the environment, see [`Renderer::explain_suns`].
    pub suns: Vec<ExplainedSun>,
    /// Light of the map in the window of a sharp lobe, minus the nodes' light there.
    pub mirror: Vec3,
    /// Whether rays of the picture replace all light of the sharp lobes' window: they show the scene, which cuts do not know.
    pub has_rays: bool,
    /// Sum of the contributions.
    pub radiance: Vec3,
    /// The shaded surface point.
    #[serde(skip)]
    point: Box<SurfacePoint>,
}

impl PixelExplanation {
    /// The shaded surface point.
    #[cfg(test)]
    pub(crate) fn surface_point(&self) -> &SurfacePoint {
        &self.point
    }

    /// Indices into [`Self::nodes`], by descending contribution.
    pub fn by_contribution(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.nodes.len()).collect();
        let share = |i: usize| luminance(self.nodes[i].contribution);
        order.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
        order
    }

    /// Index into [`Self::nodes`] for each of `leaves` leaves; `None` for nodes without visible light.
    #[cfg(test)]
    pub(crate) fn node_of_leaf(&self, leaves: usize) -> Vec<Option<u32>> {
        let mut nodes = vec![None; leaves];
        for (i, node) in self.nodes.iter().enumerate() {
            nodes[leaves_below(node.heap_index, leaves)].fill(Some(i as u32));
        }
        nodes
    }
}

/// The leaves below a node in a tree of `leaves`, counted from 0.
pub(crate) fn leaves_below(heap_index: u32, leaves: usize) -> Range<usize> {
    let size = leaves >> heap_index.ilog2();
    let first = heap_index as usize * size - leaves;
    first..first + size
}

impl Renderer {
    /// Explains the center of a pixel: its value for `light` in a picture with one sample per pixel.
    ///
    /// # Errors
    /// A pixel outside the picture or without a surface, or a dataset without cuts for this light.
    pub fn explain(
        &self,
        view: &View,
        pixel: [u32; 2],
        light: CutLight,
        sampling: BrdfSampling,
    ) -> Result<PixelExplanation, ExplainError> {
        let cuts = light.cuts_of(&self.dataset)?;
        let point = self.point_at(view, pixel)?;
        let solid_angle = self.dataset.tree.leaf_solid_angle();
        let shows_scene = view.mirrors && sampling != BrdfSampling::Once;
        let lobes = match light.tree() {
            TreeOf::Environment => RayLobes::of_map,
            TreeOf::Sources => RayLobes::at,
        };
        let has_rays = shows_scene && lobes(&point, solid_angle).is_some();
        Ok(light.with_field(Explain { pixel, tree: light.tree(), point, cuts, sampling, has_rays }))
    }

    /// Adds the suns of an environment to the explanation of its light.
    pub fn explain_suns(&self, explanation: &mut PixelExplanation, illumination: &Illumination) {
        let [x, y] = explanation.pixel;
        for sun in illumination.suns().into_iter().filter(|_| explanation.tree == TreeOf::Environment) {
            let Emission::Directional { angle_degrees } = sun.emission else { continue };
            let Some(forward) = sun.forward() else { continue };
            let sun = [sun];
            let light = DirectLights { lights: &sun, intersector: self.intersector() }.shader();
            let contribution = light.reflected(&explanation.point, pixel_shift(x, y, 0));
            explanation.suns.push(ExplainedSun { direction: -forward, angle_degrees, contribution });
            explanation.radiance += contribution;
        }
    }

    /// The surface at the center of a pixel.
    fn point_at(&self, view: &View, pixel: [u32; 2]) -> Result<Box<SurfacePoint>, ExplainError> {
        let size = view.size;
        if pixel[0] >= size[0] || pixel[1] >= size[1] {
            return Err(ExplainError::Outside { pixel, size });
        }
        match PixelSampler::new(self, view, &Backdrop::black()).sight(pixel[0], pixel[1], 0).seen {
            FirstHit::Surface(point) => Ok(point),
            FirstHit::Background => Err(ExplainError::Background { pixel }),
            FirstHit::Back => Err(ExplainError::Back { pixel }),
        }
    }
}

struct Explain<'a> {
    pixel: [u32; 2],
    tree: TreeOf,
    point: Box<SurfacePoint>,
    cuts: &'a PackedCuts,
    sampling: BrdfSampling,
    has_rays: bool,
}

impl FieldJob for Explain<'_> {
    type Output = PixelExplanation;

    fn run<F: NodeField + Sync>(self, field: F) -> PixelExplanation {
        let mut shader = Shader::new(field, self.cuts, self.sampling);
        let (mut nodes, mut dark_nodes) = (Vec::new(), Vec::new());
        let explained = |eight: &EightTerms, lane: usize| explained_node(&field, self.tree, eight, lane);
        shader.traverse(
            &self.point,
            |interval| dark_nodes.push(interval.heap_index(1 << field.tree().height())),
            |eight: &EightTerms| nodes.extend((0..8).filter_map(|lane| explained(eight, lane))),
        );
        nodes.sort_by_key(|node: &ExplainedNode| leaves_below(node.heap_index, 1 << field.tree().height()).start);
        let of_nodes: Vec3 = nodes.iter().map(|node| node.contribution).sum();
        let rendered = Shader::new(field, self.cuts, self.sampling).shade(&self.point);
        // Summing in another order differs by rounding.
        let is_mirror = !rendered.abs_diff_eq(of_nodes, 1e-5 * rendered.max_element());
        let mirror = if is_mirror { rendered - of_nodes } else { Vec3::ZERO };
        let is_lit = self.sampling == BrdfSampling::Lit;
        let vertex = |i: usize| ExplainedVertex {
            index: self.point.vertices[i],
            position: self.point.corners[i],
            weight: self.point.weights[i],
            cut_nodes: self.cuts.cut(field.tree().height(), self.point.vertices[i]).len(),
            lit_nodes: is_lit.then(|| field.tree().lit.of(self.cuts, self.point.vertices[i]).len()),
        };
        PixelExplanation {
            pixel: self.pixel,
            tree: self.tree,
            position: self.point.position,
            normal: self.point.world_from_local.z_axis,
            vertices: [0, 1, 2].map(vertex),
            illumination_nodes: if is_lit { 0 } else { field.tree().cut.len() },
            merged_nodes: shader.work.merged_nodes,
            mirror,
            has_rays: self.has_rays,
            radiance: of_nodes + mirror,
            nodes,
            dark_nodes,
            suns: Vec::new(),
            point: self.point,
        }
    }
}

/// One of eight terms; `None` for padding.
fn explained_node(field: &impl NodeField, tree: TreeOf, eight: &EightTerms, lane: usize) -> Option<ExplainedNode> {
    let term = eight.terms[lane];
    if !(term.visibility > 0.0) {
        return None;
    }
    let depth = term.node.ilog2();
    let leaves = 1 << (field.tree().height() - depth);
    let of_leaf = field.solid_angle();
    let (solid_angle, visibility) = match tree {
        TreeOf::Environment => (of_leaf * leaves as f32, term.visibility),
        TreeOf::Sources => (of_leaf * leaves as f32 * term.visibility, 1.0),
    };
    let is_received = eight.weight.to_array()[lane] > 0.0;
    Some(ExplainedNode {
        heap_index: term.node,
        depth,
        leaves,
        solid_angle,
        direction: eight.direction.lane(lane),
        center: field.center(term.node as usize),
        radiance: eight.radiance.lane(lane),
        is_lit: term.is_lit,
        visibility,
        brdf_cos: if is_received { eight.brdf_cos.lane(lane) } else { Vec3::ZERO },
        contribution: eight.reflected().lane(lane) * of_leaf,
    })
}

#[cfg(test)]
mod tests;
