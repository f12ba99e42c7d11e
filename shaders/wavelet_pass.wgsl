// Bounced light of wavelet transport: each pixel finds its quad and the radiance that arrives there by cells of directions, and
// evaluates its BRDF. Twin of `PatchLight::reflected` in render/src/light/bounce/wavelet.rs, and of
// core/src/wavelet/{patch,picture}.rs.

struct LitQuad {
    corner: vec3<f32>,
    // Its first value among the radiance.
    first: u32,
    // A point's place in the unit square, from its offset from the corner.
    square_u: vec3<f32>,
    // Texels along an edge, without the border.
    side: u32,
    square_v: vec3<f32>,
    // Cells of directions along an edge.
    cells: u32,
    // Tangent, bitangent and normal.
    frame: mat3x3<f32>,
}

const NO_QUAD: u32 = 0xffffffffu;
// See LEAST_SIDE in render/src/light/bounce/wavelet.rs.
const LEAST_SIDE: u32 = 8u;

@group(2) @binding(0) var<storage, read> quads: array<LitQuad>;
@group(2) @binding(1) var<storage, read> quad_of_triangles: array<u32>;
// Texel by texel, row by row; for each its cells.
@group(2) @binding(2) var<storage, read> radiance: array<vec4<f32>>;

@group(3) @binding(5) var environment_map: texture_2d<f32>;
@group(3) @binding(6) var mirrored_map: texture_2d<f32>;

fn written_at(texel: vec2<u32>) -> Sums {
    let begun = begin(texel * frame.stride);
    if !begun.has_surface {
        return without_surface(begun, vec3(0.0));
    }
    let is_behind = (begun.g.w & FLAG_BACK) != 0u;
    let point = begun_point(begun);
    let quad = quad_of_triangles[begun.g.x - 1u];
    var as_baked = vec3(0.0);
    if quad != NO_QUAD && !is_behind {
        as_baked = reflected(point, quad) * rough_albedo(point, true) / max(albedo_of(point.brdf), vec3(1e-6));
    }
    return with_sample(begun, vec4(with_posed_bounce(point, is_behind, as_baked), 0.0), NO_WORK);
}

fn reflected(point: SurfacePoint, index: u32) -> vec3<f32> {
    let quad = quads[index];
    let texels = texels_around(quad, point.position);
    let patch_from_local = transpose(quad.frame) * point.world_from_local;
    let side = max(quad.cells, LEAST_SIDE);
    let cells = side * side;
    // The integral of the cosine over a cell.
    let weight = 1.0 / (FRAC_1_PI * f32(cells));
    var sum = vec3(0.0);
    for (var cell = 0u; cell < cells; cell++) {
        let wi = direction_of(cell, side);
        let arrives = patch_from_local * wi;
        if arrives.z > 0.0 {
            sum += arriving(texels, cell_of(arrives, quad.cells)) * cell_brdf(point, wi, weight);
        }
    }
    return max(sum * weight, vec3(0.0));
}

// The first values of the four texels around a point, and their weights.
struct Texels {
    first: vec4<u32>,
    weights: vec4<f32>,
}

// Twin of `PatchTexture::at`.
fn texels_around(quad: LitQuad, position: vec3<f32>) -> Texels {
    let offset = position - quad.corner;
    let square = clamp(vec2(dot(quad.square_u, offset), dot(quad.square_v, offset)), vec2(0.0), vec2(1.0));
    let place = square * f32(quad.side) - 0.5;
    let low = floor(place);
    let part = place - low;
    let last = vec2(f32(quad.side + 1u));
    let a = vec2<u32>(clamp(low + 1.0, vec2(0.0), last));
    let b = vec2<u32>(clamp(low + 2.0, vec2(0.0), last));
    let cells = quad.cells * quad.cells;
    let rows = vec2(a.y, b.y) * (quad.side + 2u);
    let first = vec4(rows.x + a.x, rows.x + b.x, rows.y + a.x, rows.y + b.x) * cells + quad.first;
    let rest = 1.0 - part;
    return Texels(first, vec4(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y));
}

fn arriving(texels: Texels, cell: u32) -> vec3<f32> {
    return radiance[texels.first.x + cell].xyz * texels.weights.x
        + radiance[texels.first.y + cell].xyz * texels.weights.y
        + radiance[texels.first.z + cell].xyz * texels.weights.z
        + radiance[texels.first.w + cell].xyz * texels.weights.w;
}

// Twin of `HemisphereCells::cell_of`.
fn cell_of(direction: vec3<f32>, side: u32) -> u32 {
    let square = 0.5 + 0.5 * square_from_disc(direction.xy);
    let cell = min(vec2<u32>(max(square * f32(side), vec2(0.0))), vec2(side - 1u));
    return cell.y * side + cell.x;
}
