// The merge (paper, 3.2 and 4.2): three visibility cuts, interpolated, in one traversal, with the BRDF evaluated on each node. Twin
// of render/src/shade/merge.rs. A picture takes one pass per tree of lights, for the environment and for the surface sources; each
// has its own sums.
//
// B = sum |C| <l> <rho> (w1 <v1> + w2 <v2> + w3 <v3>) over the merged cut. All cuts partition the same leaves and their
// nodes are nested: with the current leaf p, the finest node is [p, e) where e is the smallest end.

@group(3) @binding(5) var environment_map: texture_2d<f32>;
// The distant lights' map, an atlas of its levels.
@group(3) @binding(6) var mirrored_map: texture_2d<f32>;

fn written_at(texel: vec2<u32>) -> Sums {
    // Its start and its ends are written out, as they were when it took 183 ms on an H200; a start and an end that passes share
    // took 231 ms there.
    let pixel = texel * frame.stride;
    let sums = previous_sums(pixel);
    if !lacks_sample(sums) {
        return sums;
    }
    let g = textureLoad(geometry, pixel, 0);
    let direction = seen_along(pixel);
    if !is_surface(g) {
        return with_background(Begun(pixel, sums, g, false, false), direction);
    }
    let point = surface_point(g, pixel, direction);
    var shaded = no_light();
    if FIELD != FIELD_NONE && needs_merge() {
        shaded = merge_cuts(texel, point);
    }
    let begun = begun_again(texel, shaded.merged_nodes);
    let work = vec2(shaded.merged_nodes, shaded.brdf_evaluations);
    // The first part also has values that need no merge.
    if !IS_FIRST {
        let value = select(vec3(0.0), view_value(begun, point, shaded), needs_merge());
        return with_sample(begun, vec4(value, 0.0), work);
    }
    let wire = select(0.0, wireframe_coverage(begun.pixel, corners_of(begun.g)), frame.wireframe != 0u);
    return with_sample(begun, vec4(view_value(begun, point, shaded), wire), work);
}

// A pixel after its merge. What the merge does not need is read or computed again, from a place of which compilers do not know that it
// is the same: as much would otherwise wait in registers.
fn begun_again(texel: vec2<u32>, merged_nodes: u32) -> Begun {
    let pixel = pixel_again(texel, merged_nodes);
    return Begun(pixel, previous_sums(pixel), textureLoad(geometry, pixel, 0), false, true);
}

// The pixel of a texel, unknown to compilers.
fn pixel_again(texel: vec2<u32>, merged_nodes: u32) -> vec2<u32> {
    return (texel + select(0u, 1u, merged_nodes == 0xffffffffu)) * frame.stride;
}

fn corners_of(g: vec4<u32>) -> vec3<u32> {
    return triangles[g.x - 1u].vertices;
}

fn needs_merge() -> bool {
    let mode = frame.view_mode;
    return mode == VIEW_SHADED || is_work(mode) || (mode == VIEW_GLOSS && BY_DIRECTION);
}

fn is_work(mode: u32) -> bool {
    return mode == VIEW_MERGED_CUT || mode == VIEW_BRDF_EVALUATIONS;
}

// Value of a surface in the view mode, of its point by what the merge needs, too. Values of the meshless basis belong to bounced light.
fn view_value(begun: Begun, point: SurfacePoint, shaded: Shaded) -> vec3<f32> {
    switch frame.view_mode {
        case VIEW_NORMALS: { return point.world_from_local[2] * 0.5 + 0.5; }
        case VIEW_ALBEDO: { return textureLoad(color_roughness, begun.pixel, 0).xyz; }
        case VIEW_ROUGHNESS: { return vec3(textureLoad(color_roughness, begun.pixel, 0).w); }
        case VIEW_VISIBILITY_CUT: { return vec3(interpolated_cut_len(begun.g, point.weights)); }
        case VIEW_MERGED_CUT: { return vec3(f32(shaded.merged_nodes)); }
        case VIEW_BRDF_EVALUATIONS: { return vec3(f32(shaded.brdf_evaluations)); }
        case VIEW_GLOSS: { return signed_light(luminance(shaded.radiance)); }
        case VIEW_BASIS_LEVEL, VIEW_BASIS_FUNCTION, VIEW_BASIS_COEFFICIENTS: { return vec3(0.0); }
        default: { return light_value(begun, shaded.radiance); }
    }
}

// The light of this part in the current poses, from the baked light.
fn light_value(begun: Begun, as_baked: vec3<f32>) -> vec3<f32> {
    var light = as_baked;
    if POSED {
        light = posed_light(begun, as_baked);
    }
    if IS_FIRST && HAS_EMISSION && frame.shows_emission != 0u {
        light += begun_point(begun).emission;
    }
    return light;
}

// Whether vertices have light beside that of the tree. Without it the kernel has up to 32 vector registers less on RDNA 2.
override POSED: bool = true;

fn posed_light(begun: Begun, as_baked: vec3<f32>) -> vec3<f32> {
    let point = begun_point(begun);
    let from_behind = (begun.g.w & FLAG_BACK) != 0u;
    if IS_FIRST {
        return with_posed_ratio(point, from_behind, as_baked);
    }
    return with_posed_bounce(point, from_behind, as_baked);
}

fn interpolated_cut_len(g: vec4<u32>, weights: vec3<f32>) -> f32 {
    let v = corners_of(g);
    return dot(weights, vec3(f32(vertices[v.x].cut_len), f32(vertices[v.y].cut_len), f32(vertices[v.z].cut_len)));
}

struct Shaded {
    radiance: vec3<f32>,
    merged_nodes: u32,
    brdf_evaluations: u32,
    // Light in the window of a mirror: visible, and total.
    window_seen: vec3<f32>,
    window_all: vec3<f32>,
}

fn no_light() -> Shaded {
    return Shaded(vec3(0.0), 0u, 0u, vec3(0.0), vec3(0.0));
}

// What sharp lobes do: no lobe is sharp, they read the map, or cuts give none of their light, because they have rays.
override MIRRORS: u32 = 1u;

const NO_MIRRORS: u32 = 0u;
const MIRRORS_READ_MAP: u32 = 1u;
const MIRRORS_HAVE_RAYS: u32 = 2u;

// Whether lit cuts replace the stored cuts and the illumination cut.
override LIT: bool = true;

// Threads of a group diverge least if each first searches for its next node with visible light: the inner loop skips others, and
// the outer one evaluates one node per iteration.
fn merge_cuts(texel: vec2<u32>, point: SurfacePoint) -> Shaded {
    let leaves = 1u << tree_height();
    var a = cut_begin(point.vertices.x);
    var b = cut_begin(point.vertices.y);
    var c = cut_begin(point.vertices.z);
    var l = Cursor(0u, 0u);
    if !LIT {
        l = illumination_cursor(0u);
    }
    // Below a lit node too wide for the lobe the stored cuts are merged, up to this leaf; 0 elsewhere. There the lit cuts go on.
    var stored_end = 0u;
    var resumed = vec3(0u);
    let w = point.weights;
    let lobes = lobes_to_follow(point);
    let mirror = mirror_at(point);
    var first = 0u;
    // The node of the merged cut, which ends before leaf `first`, and the part being tested.
    var is_lit = false;
    var visibility = 0.0;
    var root = 0u;
    var node = 0u;
    var shaded = no_light();
    loop {
        while node == 0u && first < leaves {
            is_lit = LIT && stored_end == 0u;
            let ends = vec3(end_of(a.node, first), end_of(b.node, first), end_of(c.node, first));
            let last = select(end_of(l.node, first), select(stored_end, leaves, is_lit), LIT);
            let end = min(min(ends.x, ends.y), min(ends.z, last));
            visibility = w.x * cursor_value(a) + w.y * cursor_value(b) + w.z * cursor_value(c);
            shaded.merged_nodes += 1u;
            root = (leaves + first) >> firstTrailingBit(end - first);
            if visibility > 0.0 || shows_in_window(point, mirror, root) {
                node = root;
            }
            first = end;
            if end == leaves { break; }
            if LIT && end == stored_end {
                a = lit_cursor(resumed.x);
                b = lit_cursor(resumed.y);
                c = lit_cursor(resumed.z);
                stored_end = 0u;
                continue;
            }
            if ends.x == end { a = cut_cursor(a.position + 1u, is_lit); }
            if ends.y == end { b = cut_cursor(b.position + 1u, is_lit); }
            if ends.z == end { c = cut_cursor(c.position + 1u, is_lit); }
            if !LIT && last == end { l = illumination_cursor(l.position + 1u); }
        }
        if node == 0u { break; }
        let whole = seen_from(point, node);
        let is_wide = shows_in_lobe(whole, lobes);
        if LIT && is_wide && is_lit && visibility > 0.0 && node == root {
            stored_end = first;
            first = first_leaf(root);
            resumed = vec3(a.position, b.position, c.position);
            // Too seldom for the vertices to wait in registers.
            let corners = corners_of(textureLoad(geometry, pixel_again(texel, shaded.merged_nodes), 0));
            a = stored_below(a, cut_offset(corners.x), first, stored_end);
            b = stored_below(b, cut_offset(corners.y), first, stored_end);
            c = stored_below(c, cut_offset(corners.z), first, stored_end);
            shaded.merged_nodes -= 1u;
            node = 0u;
            continue;
        }
        let part = first_fine(point, whole, is_wide, lobes);
        add_light(&shaded, point, part, visibility, mirror);
        node = next_node(part.node, root);
    }
    finish(&shaded, point, mirror);
    return shaded;
}

// The first node of a vertex's cut.
fn cut_begin(vertex: u32) -> Cursor {
    let offset = cut_offset(vertex);
    if LIT {
        return lit_cursor(lit_offsets[offset]);
    }
    return visibility_cursor(offset << 3u);
}

// A node of a lit or a stored cut.
fn cut_cursor(position: u32, is_lit: bool) -> Cursor {
    if is_lit {
        return lit_cursor(position);
    }
    return visibility_cursor(position);
}

// First texel of a vertex's cut over the merged tree.
fn cut_offset(vertex: u32) -> u32 {
    return select(vertices[vertex].cut_offset, vertices[vertex].source_cut_offset, FIELD == FIELD_SOURCES);
}

// Widths of all lobes, widened by the slopes within the sample. Twin of `SurfacePoint::lobes`.
fn widened_lobes(point: SurfacePoint) -> mat3x2<f32> {
    var lobes = lobes_of(point.brdf);
    let added = max(point.slopes.xz - abs(point.slopes.y), vec2(0.0));
    for (var i = 0u; i < 3u; i += 1u) {
        lobes[i] = select(lobes[i], sqrt(lobes[i] * lobes[i] + added), any(lobes[i] != NO_LOBE));
    }
    return lobes;
}

// Widths of the lobes that refinement follows; 0 for none.
fn lobes_to_follow(point: SurfacePoint) -> vec3<f32> {
    let all = widened_lobes(point);
    let lobes = vec3(min(all[0].x, all[0].y), min(all[1].x, all[1].y), min(all[2].x, all[2].y));
    return select(vec3(0.0), max(lobes, vec3(NARROWEST)), vec3(REFINE) & (lobes > vec3(0.0)));
}

// First leaf below a node.
fn first_leaf(node: u32) -> u32 {
    return (node << (tree_height() - firstLeadingBit(node))) - (1u << tree_height());
}

// Leaves below a node.
fn node_size(node: u32) -> f32 {
    return f32(1u << (tree_height() - firstLeadingBit(node)));
}

// The largest node of `root` that begins at the end of `node`; 0 at the end of `root`.
fn next_node(node: u32, root: u32) -> u32 {
    let left = node >> countTrailingZeros(~node);
    return select(left + 1u, 0u, left <= root);
}

// A node seen from a point.
struct SeenNode {
    node: u32,
    cone: Cone,
    // Its direction in the local frame.
    wi: vec3<f32>,
    // Cosine to the mirror direction of the eye.
    to_mirrored: f32,
}

fn seen_from(point: SurfacePoint, node: u32) -> SeenNode {
    let cone = cone_of(node, point.position);
    let wi = cone.direction * point.world_from_local;
    return SeenNode(node, cone, wi, wi.z * point.wo.z - dot(wi.xy, point.wo.xy));
}

// Whether a lobe needs several directions for the node.
fn shows_in_lobe(seen: SeenNode, lobes: vec3<f32>) -> bool {
    return is_too_wide(lobes, seen.to_mirrored, seen.cone.radius, brightness[seen.node]);
}

// The node, or its first descendant that is fine enough for the BRDF. `is_wide` tells that the node shows in a lobe.
fn first_fine(point: SurfacePoint, whole: SeenNode, is_wide: bool, lobes: vec3<f32>) -> SeenNode {
    let leaves = 1u << tree_height();
    var part = whole;
    var is_part_wide = is_wide;
    while part.node < leaves && (is_part_wide || is_too_wide_for_a_cosine(part.wi.z, part.cone.radius)) {
        part = seen_from(point, 2u * part.node);
        is_part_wide = shows_in_lobe(part, lobes);
    }
    return part;
}

// Adds the node's light toward the eye, for leaves of unit solid angle.
fn add_light(shaded: ptr<function, Shaded>, point: SurfacePoint, seen: SeenNode, visibility: f32, mirror: Mirror) {
    // A node without visible light only matters for the window.
    if MIRRORS == MIRRORS_READ_MAP && !(visibility > 0.0) && !reaches_window(mirror, seen.to_mirrored, seen.cone.radius) {
        return;
    }
    let wi = seen.wi;
    var light = received_light(point, seen.cone.direction, wi, select(0.0, seen.cone.inv_kappa, REFINE));
    var window = 0.0;
    let radiance = radiance_along(seen.node, seen.cone.direction);
    if MIRRORS == MIRRORS_HAVE_RAYS {
        window = window_share(mirror, wi, point.wo);
        let rest = max(window_share(scene_mirror, wi, point.wo) - window, 0.0);
        window += rest * share_up_to(frame.brightest, luminance(radiance));
        light.inv_kappa = narrowed(mirror, wi, point.wo, light.inv_kappa);
    } else if MIRRORS == MIRRORS_READ_MAP && mirror.share > 0.0 {
        window = mirror_window(mirror, wi, point.wo);
        light.inv_kappa = mirror_spread(mirror, window, light.inv_kappa);
    }
    let unshadowed = reflection_of(point.brdf, light, point.wo) * radiance * node_size(seen.node);
    (*shaded).radiance += unshadowed * visibility;
    (*shaded).brdf_evaluations += 1u;
    if MIRRORS == MIRRORS_HAVE_RAYS || (MIRRORS == MIRRORS_READ_MAP && mirror.share > 0.0) {
        (*shaded).window_seen += unshadowed * (window * visibility);
        (*shaded).window_all += unshadowed * window;
    }
}

fn finish(shaded: ptr<function, Shaded>, point: SurfacePoint, mirror: Mirror) {
    (*shaded).radiance *= leaf_solid_angle();
    if MIRRORS == MIRRORS_HAVE_RAYS {
        let seen = (*shaded).window_seen * leaf_solid_angle();
        (*shaded).radiance = max((*shaded).radiance - seen, vec3(0.0));
        return;
    }
    // If no light of the window is visible, nothing is replaced.
    if MIRRORS == MIRRORS_READ_MAP && mirror.share > 0.0 && any((*shaded).window_seen > vec3(0.0)) {
        let seen = (*shaded).window_seen * leaf_solid_angle();
        let all = (*shaded).window_all * leaf_solid_angle();
        (*shaded).radiance = sharpened(mirror, (*shaded).radiance, seen, all, unshadowed_window(mirror, point));
    }
}

// Lobes that are sharp among sources, where they have rays.
var<private> scene_mirror: Mirror;

// Spread of a light for widening lobes that have rays.
fn narrowed(mirror: Mirror, wi: vec3<f32>, wo: vec3<f32>, inv_kappa: f32) -> f32 {
    if scene_mirror.share > 0.0 {
        return mirror_spread(scene_mirror, mirror_window(scene_mirror, wi, wo), inv_kappa);
    }
    if mirror.share > 0.0 {
        return mirror_spread(mirror, mirror_window(mirror, wi, wo), inv_kappa);
    }
    return inv_kappa;
}

// Sharp lobes of a point, if they read the map or have rays.
fn mirror_at(point: SurfacePoint) -> Mirror {
    var mirror = mirror_at_point(point);
    // In mirrors wider lobes have no rays.
    if MIRRORS == MIRRORS_HAVE_RAYS && FIELD == FIELD_SOURCES && !is_in_mirrors() {
        scene_mirror = ray_lobes(point).scene;
    }
    if MIRRORS == NO_MIRRORS || (MIRRORS == MIRRORS_READ_MAP && frame.mirrored_height == 0u) {
        mirror.share = 0.0;
    }
    return mirror;
}

// Whether a node without visible light reaches into the window of a mirror.
fn shows_in_window(point: SurfacePoint, mirror: Mirror, node: u32) -> bool {
    if MIRRORS != MIRRORS_READ_MAP || !(mirror.share > 0.0) {
        return false;
    }
    let seen = seen_from(point, node);
    return reaches_window(mirror, seen.to_mirrored, seen.cone.radius);
}
