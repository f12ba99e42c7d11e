// The merge (paper, 3.2 and 4.2): three visibility cuts, interpolated, and the illumination cut in one traversal, with
// the BRDF evaluated on each node. Twin of render/src/shade/merge.rs. A picture takes one pass for each tree of lights, the
// environment's and that of the sources on surfaces; each adds to the sum of those before it.
//
// B = sum |C| <l> <rho> (w1 <v1> + w2 <v2> + w3 <v3>) over the merged cut. All cuts partition the same leaves and their
// nodes are nested: with the current leaf p, the finest node is [p, e) where e is the smallest end.

// The sum of all samples and passes so far.
@group(3) @binding(4) var previous_sum: texture_2d<f32>;
@group(3) @binding(5) var previous_work: texture_2d<f32>;

struct Sample {
    // Value of the view mode, and coverage.
    @location(0) value: vec4<f32>,
    // Merged nodes, BRDF evaluations, wireframe coverage, 1 for a surface.
    @location(1) work: vec4<f32>,
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> Sample {
    let texel = vec2<u32>(position.xy);
    let pixel = texel * frame.stride;
    let sample = shade_pixel(pixel);
    let sum = textureLoad(previous_sum, texel, 0);
    let work = textureLoad(previous_work, texel, 0);
    return Sample(sum + sample.value, work + sample.work);
}

// Adds nothing that an earlier pass has already added for this sample: values without a merge, and coverage.
override IS_FIRST: bool = true;

fn shade_pixel(pixel: vec2<u32>) -> Sample {
    let g = textureLoad(geometry, pixel, 0);
    let direction = ray_direction(pixel);
    if !IS_FIRST {
        return further_light(g, pixel, direction);
    }
    if g.x == 0u {
        let shown = select(vec3(0.0), background_radiance(direction), frame.view_mode == VIEW_SHADED);
        return Sample(vec4(shown, 0.0), vec4(0.0));
    }
    if (g.w & FLAG_BLACK) != 0u {
        return Sample(vec4(0.0, 0.0, 0.0, 1.0), vec4(0.0));
    }
    let point = surface_point(g, pixel, direction);
    var shaded = Shaded(vec3(0.0), 0u, 0u);
    if FIELD != FIELD_NONE && needs_merge() {
        shaded = merge_cuts(point);
    }
    let wire = select(0.0, wireframe_coverage(pixel, point.vertices), frame.wireframe != 0u);
    let work = vec4(f32(shaded.merged_nodes), f32(shaded.brdf_evaluations), wire, 1.0);
    return Sample(vec4(view_value(point, pixel, shaded), 1.0), work);
}

fn further_light(g: vec4<u32>, pixel: vec2<u32>, direction: vec3<f32>) -> Sample {
    if g.x == 0u || (g.w & FLAG_BLACK) != 0u || !needs_merge() {
        return Sample(vec4(0.0), vec4(0.0));
    }
    let point = surface_point(g, pixel, direction);
    let shaded = merge_cuts(point);
    let work = vec4(f32(shaded.merged_nodes), f32(shaded.brdf_evaluations), 0.0, 0.0);
    return Sample(vec4(view_value(point, pixel, shaded), 0.0), work);
}

fn needs_merge() -> bool {
    return frame.view_mode == VIEW_SHADED || frame.view_mode >= VIEW_MERGED_CUT;
}

// Value of a surface in the view mode.
fn view_value(point: SurfacePoint, pixel: vec2<u32>, shaded: Shaded) -> vec3<f32> {
    switch frame.view_mode {
        case VIEW_NORMALS: { return point.world_from_local[2] * 0.5 + 0.5; }
        case VIEW_ALBEDO: { return textureLoad(color_roughness, pixel, 0).xyz; }
        case VIEW_ROUGHNESS: { return vec3(textureLoad(color_roughness, pixel, 0).w); }
        case VIEW_VISIBILITY_CUT: { return vec3(interpolated_cut_len(point)); }
        case VIEW_MERGED_CUT: { return vec3(f32(shaded.merged_nodes)); }
        case VIEW_BRDF_EVALUATIONS: { return vec3(f32(shaded.brdf_evaluations)); }
        default: { return shaded.radiance; }
    }
}

fn interpolated_cut_len(point: SurfacePoint) -> f32 {
    let v = point.vertices;
    return dot(point.weights, vec3(f32(vertices[v.x].cut_len), f32(vertices[v.y].cut_len), f32(vertices[v.z].cut_len)));
}

struct Shaded {
    radiance: vec3<f32>,
    merged_nodes: u32,
    brdf_evaluations: u32,
}

// Threads of a group diverge least if each first searches for its next node with visible light: the inner loop skips
// the others, and the outer one evaluates one node per iteration.
fn merge_cuts(point: SurfacePoint) -> Shaded {
    let leaves = 1u << tree_height();
    var a = visibility_cursor(cut_offset(point.vertices.x));
    var b = visibility_cursor(cut_offset(point.vertices.y));
    var c = visibility_cursor(cut_offset(point.vertices.z));
    var l = illumination_cursor();
    let w = point.weights;
    let lobe = select(0.0, max(point.brdf.lobe, NARROWEST), point.brdf.lobe > 0.0);
    var first = 0u;
    var visibility = 0.0;
    // The node of the merged cut, and the part of it that is looked at.
    var root = 0u;
    var node = 0u;
    var sum = vec3(0.0);
    var merged = 0u;
    var evaluations = 0u;
    loop {
        while node == 0u && first < leaves {
            let end = min(min(a.end, b.end), min(c.end, l.end));
            visibility = w.x * cursor_value(a) + w.y * cursor_value(b) + w.z * cursor_value(c);
            merged += 1u;
            if visibility > 0.0 {
                root = (leaves + first) >> firstTrailingBit(end - first);
                node = root;
            }
            first = end;
            if end < leaves {
                if a.end == end { advance_visibility(&a); }
                if b.end == end { advance_visibility(&b); }
                if c.end == end { advance_visibility(&c); }
                if l.end == end { advance_illumination(&l); }
            }
        }
        if node == 0u { break; }
        var cone = cone_of(node, point.position);
        var wi = cone.direction * point.world_from_local;
        while REFINE && node < leaves && wants_halves(lobe, cone.radius, cone.tan_half_radius, wi, point.wo) {
            node = 2u * node;
            cone = cone_of(node, point.position);
            wi = cone.direction * point.world_from_local;
        }
        evaluations += 1u;
        sum += evaluate(point, cone, wi, visibility * node_size(node)) * nodes[node].radiance;
        node = next_node(node, root);
    }
    return Shaded(sum * leaf_solid_angle(), merged, evaluations);
}

// First texel of a vertex's cut over the tree that is merged.
fn cut_offset(vertex: u32) -> u32 {
    return select(vertices[vertex].cut_offset, vertices[vertex].source_cut_offset, FIELD == FIELD_SOURCES);
}

// Leaves below a node.
fn node_size(node: u32) -> f32 {
    return f32(1u << (tree_height() - firstLeadingBit(node)));
}

// The largest node of `root` that begins where `node` ends; 0 at the end of `root`.
fn next_node(node: u32, root: u32) -> u32 {
    let left = node >> countTrailingZeros(~node);
    return select(left + 1u, 0u, left <= root);
}

// Light that reaches the eye from a node of radiance 1.
fn evaluate(point: SurfacePoint, cone: Cone, wi: vec3<f32>, weight: f32) -> vec3<f32> {
    let inv_kappa = select(0.0, cone.inv_kappa, REFINE);
    let received = select(0.0, weight, dot(cone.direction, point.smooth_normal) > 0.0);
    return brdf_cos(point.brdf, wi, point.wo, inv_kappa) * received;
}
