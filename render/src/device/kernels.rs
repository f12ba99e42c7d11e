//! The kernels: one compute step each, with its text and what it reads and writes in one place.

use super::{
    bindings::{GroupLayout, bind_groups},
    shaders::{MODELS_WITHOUT_MAPS, Program},
};

/// A kernel of one compute step.
#[derive(Clone, Copy, Debug)]
pub struct KernelProgram {
    /// Its text.
    pub program: Program,
    /// Groups 1, 2, ...: its data. Group 0 is [`Slice`].
    pub groups: &'static [GroupLayout],
}

impl KernelProgram {
    const fn new(name: &'static str, parts: [&'static [&'static str]; 2], groups: &'static [GroupLayout]) -> Self {
        Self { program: Program { name, parts, output: None }, groups }
    }
}

bind_groups! {
    /// What all kernels but that of rays begin with.
    Slice { slice: Uniform }

    /// A scene that rays meet.
    Hierarchy { nodes: Storage, corners: Storage }

    /// Rays from some origins.
    RayWork { rays: Uniform, directions: Storage, origins: Storage, open_words: Written }

    /// Boundaries from some origins.
    BoundaryWork {
        rays: Uniform,
        directions: Storage,
        tables: Storage,
        origins: Storage,
        states: Written,
        open_words: Written,
    }

    /// Rays of fans from some origins.
    FanWork { uniforms: Uniform, directions: Storage, fans: Storage, hits: Written }

    /// Rays to lights.
    ShadowRayWork { uniforms: Uniform, rays: Storage, open_words: Written }

    /// Leaves at positions of vertices.
    Leaves { positions: Storage, riders: Storage, discs: Written }

    /// Nodes above leaves.
    Nodes { discs: Storage, spans: Storage, blocks: Written }

    /// A walk of leaves through a forest.
    Walk {
        walk: Uniform,
        discs: Storage,
        blocks: Storage,
        directions: Storage,
        walked: Storage,
        kept: Storage,
        seen: Written,
    }

    /// The light of nodes from that of leaves.
    Pulled {
        uniforms: Uniform,
        discs: Storage,
        spans: Storage,
        lighting: Storage,
        light: Storage,
        radiance: Written,
    }

    /// The light of leaves from that of the nodes that they see.
    Gathered {
        uniforms: Uniform,
        discs: Storage,
        views: Storage,
        directions: Storage,
        radiance: Storage,
        lighting: Storage,
        sky: Storage,
        light: Written,
    }

    /// What glossy leaves reflect.
    Glossy {
        uniforms: Uniform,
        tables: Uniform,
        materials: Storage,
        values: Storage,
        discs: Storage,
        views: Storage,
        directions: Storage,
        sent: Storage,
        sky: Storage,
        reflected: Written,
    }

    /// Light of leaves as vertices take it.
    ValuedLeaves {
        uniforms: Uniform,
        lighting: Storage,
        light: Storage,
        reflected: Storage,
        open: Storage,
        values: Written,
    }

    /// Light of vertices from that of the leaves beside them.
    LitVertices {
        uniforms: Uniform,
        values: Storage,
        beside: Storage,
        starts: Storage,
        states: Storage,
        baked: Storage,
        texels: Written,
    }

    /// The sky that leaves see beside vertices.
    SkyBeside {
        cuts: Uniform,
        discs: Storage,
        views: Storage,
        directions: Storage,
        beside: Storage,
        open: Storage,
        cut_vertices: Storage,
    }

    /// Cuts of vertices as they are counted.
    CountedOthers { starts: Written, counts: Written }

    /// Cuts of vertices as they are written.
    WrittenOthers { starts: Storage, texels: Written }

    /// Vertices that get cuts.
    ReplacedCuts { cut_vertices: Storage, starts: Storage, counts: Storage, vertices: Written }

    /// A level of functions.
    FunctionLevel { level: Uniform, parent_starts: Storage, parents: Storage, states: Written, slots: Storage }

    /// The functions of a level that gather, as they are counted and listed.
    ListedReceivers { sums: Written, receivers: Written, unknown: Written }

    /// Rays by which receivers gather.
    GatheredRows {
        bound: Uniform,
        receivers: Storage,
        slots: Storage,
        rows: Storage,
        frames: Storage,
        directions: Storage,
        radiance: Storage,
        received: Written,
    }

    /// What functions receive.
    ReceivedLight { received: Written }

    /// Stored cuts, and the light of the tree that they are over.
    StoredCuts { nodes: Storage, brightness: Storage, visibility_cuts: Uint }

    /// Lit cuts as they are counted.
    CountedCuts { lit: Uniform, starts: Storage, whole_light: Written, offsets: Written, total: Written }

    /// Lit cuts as they are written.
    WrittenCuts { lit: Uniform, starts: Storage, whole_light: Storage, offsets: Storage, lit_nodes: Written }

    /// Samples of a turned map.
    TurnedLeaves {
        turned: Uniform,
        starts: Storage,
        cells: Storage,
        energy: Storage,
        plain: Storage,
        means: Written,
    }

    /// Means up a tree of lights.
    TurnedMeans { level: Uniform, means: Written }

    /// The nodes of a tree of distant lights.
    TurnedNodes { turned: Uniform, means: Storage, plain: Storage, nodes: Written, brightness: Written }
}

/// What programs of rays from some origins begin with.
const FROM_ORIGINS: &[&str] = &["ordered", "traverse", "hierarchy", "ray_origin"];

/// Rays for bakes. Its groups are [`Hierarchy`] and [`RayWork`]: it runs in no slices. Twin of `Intersector::trace_batch` in
/// core/src/ray/batch.rs.
pub const RAYS: Program = Program { name: "rays_pass", parts: [FROM_ORIGINS, &["rays_pass"]], output: None };

/// Boundaries for bakes. Its groups are [`Hierarchy`] and [`BoundaryWork`]: it runs in no slices. Twin of `BoundaryTracer::trace` in
/// core/src/ray/boundaries.
pub const BOUNDARIES: Program =
    Program { name: "boundaries_pass", parts: [FROM_ORIGINS, &["boundaries_pass"]], output: None };

/// First hits of the rays of receivers. Its groups are [`Hierarchy`] and [`FanWork`]: it runs in no slices. Twin of
/// `Intersector::closest_hits` in core/src/ray/closest.rs.
pub const FANS: Program =
    Program { name: "fans_pass", parts: [&[], &["ordered", "traverse", "hierarchy", "fans_pass"]], output: None };

/// Which rays to lights meet nothing. Its groups are [`Hierarchy`] and [`ShadowRayWork`]: it runs in no slices. Twin of
/// `Intersector::passed_before` in core/src/ray/eight.rs.
pub const SHADOW_RAYS: Program = Program {
    name: "shadow_rays_pass",
    parts: [&[], &["ordered", "traverse", "hierarchy", "shadow_rays_pass"]],
    output: None,
};

/// What kernels of implicit visibility begin with.
const FOREST: &[&str] = &["slice", "ordered", "forest"];

/// Discs of leaves. Twin of `Rider::disc` in core/src/implicit/forest.rs.
pub const IMPLICIT_UPDATE: KernelProgram =
    KernelProgram::new("implicit_update_kernel", [FOREST, &["implicit_update_kernel"]], &[Leaves::LAYOUT]);
/// The nodes above them. Twin of `Node::around` in core/src/implicit/forest/nodes.rs.
pub const IMPLICIT_NODES: KernelProgram =
    KernelProgram::new("implicit_nodes_kernel", [FOREST, &["implicit_nodes_kernel"]], &[Nodes::LAYOUT]);
/// What leaves see. Twin of `Visits::find` in core/src/implicit/.
pub const IMPLICIT_WALK: KernelProgram = KernelProgram::new(
    "implicit_walk_kernel",
    [FOREST, &["hemisphere", "distance_key", "implicit_visit", "implicit_cover", "implicit_walk_kernel"]],
    &[Walk::LAYOUT],
);
/// Radiance of nodes. Twin of `DiscForest::pull` in core/src/implicit/disc_forest.rs.
pub const IMPLICIT_PULL: KernelProgram =
    KernelProgram::new("implicit_pull_kernel", [FOREST, &["leaf_light", "implicit_pull_kernel"]], &[Pulled::LAYOUT]);
/// Irradiance of leaves. Twin of `LeafLight::new` in core/src/implicit/gather.rs.
pub const IMPLICIT_BOUNCE: KernelProgram = KernelProgram::new(
    "implicit_bounce_kernel",
    [FOREST, &["hemisphere", "octahedron", "leaf_light", "implicit_bounce_kernel"]],
    &[Gathered::LAYOUT],
);

/// What glossy leaves reflect toward the eye. Twin of `GlossyLeaf::reflected` in render/src/light/implicit/gloss.rs.
pub const IMPLICIT_GLOSS: KernelProgram = KernelProgram::new(
    "implicit_gloss_kernel",
    [
        FOREST,
        &[
            "hemisphere",
            "octahedron",
            "tables",
            "glossy_leaves",
            "brdf",
            MODELS_WITHOUT_MAPS,
            "reflected_light",
            "implicit_gloss_kernel",
        ],
    ],
    &[Glossy::LAYOUT],
);

/// Light of leaves as vertices take it. Twin of `Seen::lit` in render/src/light/implicit.rs.
pub const IMPLICIT_LEAVES: KernelProgram = KernelProgram::new(
    "implicit_leaves_kernel",
    [&["slice"], &["leaf_light", "reflected_light", "leaf_value", "implicit_leaves_kernel"]],
    &[ValuedLeaves::LAYOUT],
);
/// Light of vertices. Twin of `PoseRig::light_by_cores` in render/src/light/implicit.rs.
pub const IMPLICIT_VERTICES: KernelProgram = KernelProgram::new(
    "implicit_vertices_kernel",
    [&["slice"], &["leaf_beside", "leaf_value", "implicit_vertices_kernel"]],
    &[LitVertices::LAYOUT],
);

/// What kernels of cuts from bins begin with.
const CUTS_OF_BINS: &[&str] =
    &["slice", "ordered", "forest", "hemisphere", "cut_vertex", "leaf_beside", "implicit_cuts"];

/// How many nodes cuts from bins have. Twin of `NewCuts::of_bins` in render/src/light/implicit/cuts.rs.
pub const IMPLICIT_CUTS_COUNT: KernelProgram = KernelProgram::new(
    "implicit_cuts_count_kernel",
    [CUTS_OF_BINS, &["implicit_cuts_count_kernel"]],
    &[SkyBeside::LAYOUT, CountedOthers::LAYOUT],
);
/// The nodes of cuts from bins. Its twin is the same.
pub const IMPLICIT_CUTS_WRITE: KernelProgram = KernelProgram::new(
    "implicit_cuts_write_kernel",
    [CUTS_OF_BINS, &["implicit_cuts_write_kernel"]],
    &[SkyBeside::LAYOUT, WrittenOthers::LAYOUT],
);
/// Vertices with these cuts.
pub const REPLACED_CUTS: KernelProgram = KernelProgram::new(
    "replaced_cuts_kernel",
    [&["slice", "cut_vertex"], &["replaced_cuts_kernel"]],
    &[ReplacedCuts::LAYOUT],
);

/// What kernels that list the functions of a level begin with.
const LISTS: &[&str] = &["slice", "radiosity_level", "prefix_sums"];
/// What they read and write.
const LISTED: &[GroupLayout] = &[FunctionLevel::LAYOUT, ListedReceivers::LAYOUT];

/// How many functions of a level gather, block by block. Twin of `Radiosity::active` in
/// core/src/meshless/radiosity/transport.rs, as the next two.
pub const RADIOSITY_COUNT: KernelProgram =
    KernelProgram::new("radiosity_count_kernel", [LISTS, &["radiosity_count_kernel"]], LISTED);
/// How many gather in all blocks before each.
pub const RADIOSITY_SCAN: KernelProgram =
    KernelProgram::new("radiosity_scan_kernel", [LISTS, &["radiosity_scan_kernel"]], LISTED);
/// The functions of a level that gather.
pub const RADIOSITY_WRITE: KernelProgram =
    KernelProgram::new("radiosity_write_kernel", [LISTS, &["radiosity_write_kernel"]], LISTED);
/// What functions gather. Twin of `Gather::of` in core/src/meshless/radiosity/transport.rs.
pub const RADIOSITY_GATHER: KernelProgram = KernelProgram::new(
    "radiosity_gather_kernel",
    [&["slice", "coefficient"], &["radiosity_gather_kernel"]],
    &[GatheredRows::LAYOUT],
);
/// What other functions take of their parents, and which functions split. Twin of `Radiosity::end_level` in
/// core/src/meshless/radiosity/transport.rs.
pub const RADIOSITY_PULL: KernelProgram = KernelProgram::new(
    "radiosity_pull_kernel",
    [&["slice", "coefficient", "radiosity_level"], &["radiosity_pull_kernel"]],
    &[FunctionLevel::LAYOUT, ReceivedLight::LAYOUT],
);

/// What kernels of lit cuts begin with.
const LIT: &[&str] = &["slice", "color", "node", "tree", "cut", "lit_parts"];

/// How many nodes lit cuts have. Twin of `LitCuts` in core/src/cut/lit.rs.
pub const LIT_COUNT: KernelProgram =
    KernelProgram::new("lit_count_kernel", [LIT, &["lit_count_kernel"]], &[CountedCuts::LAYOUT, StoredCuts::LAYOUT]);
/// The nodes of lit cuts. Twin of `LitCuts` in core/src/cut/lit.rs.
pub const LIT_WRITE: KernelProgram =
    KernelProgram::new("lit_write_kernel", [LIT, &["lit_write_kernel"]], &[WrittenCuts::LAYOUT, StoredCuts::LAYOUT]);

/// Radiance of light samples under a turned map. Twin of `EnvironmentSampler::leaf_radiance` in core/src/light_tree/radiance.rs.
pub const TURNED_LEAVES: KernelProgram = KernelProgram::new(
    "turned_leaves_kernel",
    [&["slice", "color", "turned"], &["turned_leaves_kernel"]],
    &[TurnedLeaves::LAYOUT],
);
/// Means up the tree of the samples. Twin of `means_up_the_tree` in core/src/light_tree.rs.
pub const TURNED_MEANS: KernelProgram =
    KernelProgram::new("turned_means_kernel", [&["slice", "turned"], &["turned_means_kernel"]], &[TurnedMeans::LAYOUT]);
/// Its nodes. Twin of `NodeLight::distant` in core/src/light_tree/node_light.rs.
pub const TURNED_NODES: KernelProgram = KernelProgram::new(
    "turned_nodes_kernel",
    [&["slice", "ordered", "color", "node", "turned"], &["turned_nodes_kernel"]],
    &[TurnedNodes::LAYOUT],
);

/// Those that run in slices.
#[cfg(test)]
pub const SLICED: [KernelProgram; 21] = [
    IMPLICIT_UPDATE,
    IMPLICIT_NODES,
    IMPLICIT_WALK,
    IMPLICIT_PULL,
    IMPLICIT_BOUNCE,
    IMPLICIT_GLOSS,
    IMPLICIT_LEAVES,
    IMPLICIT_VERTICES,
    IMPLICIT_CUTS_COUNT,
    IMPLICIT_CUTS_WRITE,
    REPLACED_CUTS,
    RADIOSITY_COUNT,
    RADIOSITY_SCAN,
    RADIOSITY_WRITE,
    RADIOSITY_GATHER,
    RADIOSITY_PULL,
    LIT_COUNT,
    LIT_WRITE,
    TURNED_LEAVES,
    TURNED_MEANS,
    TURNED_NODES,
];

/// All texts of one compute step.
#[cfg(test)]
pub fn programs() -> impl Iterator<Item = Program> {
    SLICED.into_iter().map(|kernel| kernel.program).chain([RAYS, BOUNDARIES, FANS, SHADOW_RAYS])
}
