// Bounced light of meshless functions: each pixel looks up the functions that reach it in a hash grid, and normalizes their sum
// level by level. This inverts the splatting of the meshless paper (4.1), without blending. Twin of `MeshlessLight::at` and
// core/src/meshless/{functions,grid}.rs; the views are twins of `Painter::basis_value` in render/src/shade/painter.rs.

struct BasisLevel {
    cells_per_metre: f32,
    // Radius of its functions' support, in meters.
    radius: f32,
    // One past its last function.
    end: u32,
    padding: u32,
}

struct BasisUniforms {
    levels: array<BasisLevel, MOST_BASIS_LEVELS>,
    level_count: u32,
    // Number of slots minus one. It is a mask, because their number is a power of two.
    last_slot: u32,
    // Level and function shown by the views.
    shown_level: u32,
    shown_function: u32,
    // Whether the functions are those of objects: each object finds its own alone, and levels hold absolute values.
    of_objects: u32,
    // Number of levels, the coarsest, whose light is known by direction; 0 for none.
    directional_levels: u32,
}

// A cell of a level, or of a level of an object: its key.
struct Cell {
    place: vec3<i32>,
    level: u32,
    // Its first entry.
    first: u32,
    // Number of entries; 0 in an empty slot.
    count: u32,
    padding: vec2<u32>,
}

struct BasisFunction {
    position: vec3<f32>,
    normal: vec3<f32>,
}

const MOST_BASIS_LEVELS: u32 = 16u;
// See core/src/surfel/distance.rs.
const SQUASH: f32 = 2.0;
const STRETCH: f32 = (1.0 + SQUASH) * (1.0 + SQUASH) - 1.0;
const LAYERS: f32 = 8.0;
const LEAST_WEIGHT: f32 = 0.02;
// See render/src/light/bounce/meshless/functions.rs and render/src/shade/painter.rs.
const POINT_RADIUS: f32 = 0.08;
const BASIS_GREY: f32 = 0.4;

@group(2) @binding(0) var<uniform> basis: BasisUniforms;
@group(2) @binding(1) var<storage, read> slots: array<Cell>;
// Functions, cell by cell.
@group(2) @binding(2) var<storage, read> entries: array<u32>;
@group(2) @binding(3) var<storage, read> functions: array<BasisFunction>;
@group(2) @binding(4) var<storage, read> coefficients: array<Coefficient>;
// Where each vertex was as baked, and its object, row by row; a single texel for functions that are not of objects.
@group(2) @binding(5) var places: texture_2d<f32>;

// Coefficients by direction, nine texels a function, row by row.
@group(2) @binding(6) var harmonics: texture_2d<f32>;

// First key of the grid for the pixel: that of level 0 of its object.
var<private> first_key: u32 = 0u;

@group(3) @binding(5) var environment_map: texture_2d<f32>;
@group(3) @binding(6) var mirrored_map: texture_2d<f32>;

fn written_at(texel: vec2<u32>) -> Sums {
    let begun = begin(texel * frame.stride);
    if !begun.has_surface {
        return without_surface(begun, vec3(0.0));
    }
    let is_behind = (begun.g.w & FLAG_BACK) != 0u;
    let value = value_at(begun_point(begun), bitcast<vec2<f32>>(begun.g.yz), is_behind);
    return with_sample(begun, vec4(value, 0.0), NO_WORK);
}

fn value_at(point: SurfacePoint, bc: vec2<f32>, from_behind: bool) -> vec3<f32> {
    let among = among_functions(point, bc, from_behind);
    if frame.view_mode == VIEW_SHADED {
        let reflected = reflectance(point, among) * irradiance_at(among, from_behind) * FRAC_1_PI;
        return with_posed_bounce(point, from_behind, reflected);
    }
    return basis_value(among);
}

// The share of the irradiance that goes toward the eye, over that of a white diffuse surface, without what rays of mirrors give.
fn reflectance(point: SurfacePoint, among: SurfacePoint) -> vec3<f32> {
    let rough = rough_albedo(point, true);
    if basis.directional_levels == 0u || all(narrowest_widths(lobes_of(point.brdf)) == vec3(0.0)) {
        return rough;
    }
    return glossy_reflectance(point, among) * rough / max(albedo_of(point.brdf), vec3(1e-6));
}

fn narrowest_widths(lobes: mat3x2<f32>) -> vec3<f32> {
    return vec3(min(lobes[0].x, lobes[0].y), min(lobes[1].x, lobes[1].y), min(lobes[2].x, lobes[2].y));
}

// Twin of `MeshlessLight::reflectance`.
fn glossy_reflectance(point: SurfacePoint, among: SurfacePoint) -> vec3<f32> {
    let arrives = arriving_by_direction(among);
    let weight = 1.0 / (FRAC_1_PI * f32(CELL_SIDE * CELL_SIDE));
    var received = vec3(0.0);
    var reflected = vec3(0.0);
    for (var cell = 0u; cell < CELL_SIDE * CELL_SIDE; cell++) {
        let wi = direction_of(cell, CELL_SIDE);
        let light = max(color_toward(arrives, point.world_from_local * wi), vec3(0.0));
        received += light;
        reflected += light * cell_brdf(point, wi, weight);
    }
    let share = reflected / (FRAC_1_PI * max(received, vec3(LEAST_RECEIVED)));
    return select(albedo_of(point.brdf), share, received > vec3(LEAST_RECEIVED));
}

// Cells along an edge of the hemisphere over which a BRDF is evaluated, as in render/src/light/bounce/meshless/gloss.rs.
const CELL_SIDE: u32 = 8u;
const LEAST_RECEIVED: f32 = 1.1754944e-38;

// Twin of `ArrivingByDirection`.
fn arriving_by_direction(point: SurfacePoint) -> array<vec3<f32>, 9> {
    var total: array<vec3<f32>, 9>;
    let width = textureDimensions(harmonics).x;
    for (var level = 0u; level < basis.directional_levels; level++) {
        let range = entries_around(level, point.position);
        var sum: array<vec3<f32>, 9>;
        var weights = 0.0;
        for (var i = range.x; i < range.y; i++) {
            let weight = weight_at(entries[i], level, point);
            if weight > 0.0 {
                weights += weight;
                for (var k = 0u; k < 9u; k++) {
                    let texel = entries[i] * 9u + k;
                    sum[k] += textureLoad(harmonics, vec2(texel % width, texel / width), 0).xyz * weight;
                }
            }
        }
        for (var k = 0u; k < 9u; k++) {
            total[k] += sum[k] * normalisation(weights);
        }
    }
    return total;
}

// Twin of `Harmonics::at` in core/src/sphere/harmonics.rs.
fn color_toward(c: array<vec3<f32>, 9>, d: vec3<f32>) -> vec3<f32> {
    return c[0] * 0.2820948
        + (c[1] * d.y + c[2] * d.z + c[3] * d.x) * 0.4886025
        + (c[4] * d.x * d.y + c[5] * d.y * d.z + c[7] * d.x * d.z) * 1.0925484
        + c[6] * (0.31539157 * (3.0 * d.z * d.z - 1.0))
        + c[8] * (0.5462742 * (d.x * d.x - d.y * d.y));
}

// The point where its functions are: those of objects lie on the scene as baked. Twin of `MeshlessLight::place`.
fn among_functions(point: SurfacePoint, bc: vec2<f32>, from_behind: bool) -> SurfacePoint {
    if basis.of_objects == 0u {
        return point;
    }
    let a = place_as_baked(point.vertices.x);
    let b = place_as_baked(point.vertices.y).xyz;
    let c = place_as_baked(point.vertices.z).xyz;
    first_key = u32(a.w) * basis.level_count;
    var among = point;
    among.position = a.xyz * (1.0 - bc.x - bc.y) + b * bc.x + c * bc.y;
    among.face_normal = normalize_or(cross(b - a.xyz, c - a.xyz), vec3(0.0)) * select(1.0, -1.0, from_behind);
    return among;
}

fn place_as_baked(vertex: u32) -> vec4<f32> {
    let width = textureDimensions(places).x;
    return textureLoad(places, vec2(vertex % width, vertex / width), 0);
}

// Irradiance on the surface after bump and normal map. Twin of `MeshlessLight::at`.
fn irradiance_at(point: SurfacePoint, from_behind: bool) -> vec3<f32> {
    // Without functions there is only vertex light.
    if basis.level_count == 0u {
        return vec3(0.0);
    }
    if basis.of_objects != 0u {
        return max(point.world_from_local[2] * finest_vector(point), vec3(0.0));
    }
    if from_behind && !reaches(basis.level_count - 1u, point) {
        return vec3(0.0);
    }
    var vector = mat3x3<f32>();
    for (var level = 0u; level < basis.level_count; level++) {
        vector += level_vector(level, point).vector;
    }
    return max(point.world_from_local[2] * vector, vec3(0.0));
}

// The finest level that reaches the point.
fn finest_vector(point: SurfacePoint) -> mat3x3<f32> {
    for (var level = basis.level_count; level > 0u; level--) {
        let of_level = level_vector(level - 1u, point);
        if of_level.is_reached {
            return of_level.vector;
        }
    }
    return mat3x3<f32>();
}

struct LevelVector {
    vector: mat3x3<f32>,
    is_reached: bool,
}

// Twin of `Functions::evaluate_in`.
fn level_vector(level: u32, point: SurfacePoint) -> LevelVector {
    let range = entries_around(level, point.position);
    var sum = mat3x3<f32>();
    var weights = 0.0;
    for (var i = range.x; i < range.y; i++) {
        let weight = weight_at(entries[i], level, point);
        if weight > 0.0 {
            sum += coefficients[entries[i]].vector * weight;
            weights += weight;
        }
    }
    return LevelVector(sum * normalisation(weights), weights > 0.0);
}

// One over the weights, or 0 for no weights.
fn normalisation(weights: f32) -> f32 {
    return select(0.0, 1.0 / weights, weights > 0.0);
}

fn reaches(level: u32, point: SurfacePoint) -> bool {
    let range = entries_around(level, point.position);
    for (var i = range.x; i < range.y; i++) {
        if weight_at(entries[i], level, point) > 0.0 {
            return true;
        }
    }
    return false;
}

// Range of entries of the cell at a position: the first, and one past the last.
fn entries_around(level: u32, position: vec3<f32>) -> vec2<u32> {
    let place = vec3<i32>(floor(position * basis.levels[level].cells_per_metre));
    let key = first_key + level;
    var slot = cell_hash(place, key) & basis.last_slot;
    var cell = slots[slot];
    while cell.count != 0u && (any(cell.place != place) || cell.level != key) {
        slot = (slot + 1u) & basis.last_slot;
        cell = slots[slot];
    }
    return vec2(cell.first, cell.first + cell.count);
}

fn cell_hash(place: vec3<i32>, key: u32) -> u32 {
    let p = bitcast<vec3<u32>>(place) * vec3(73856093u, 19349663u, 83492791u);
    let mixed = p.x ^ p.y ^ p.z ^ (key * 2654435761u);
    return mixed ^ (mixed >> 15u);
}

// Weight of a function of a level. Functions lie on faces, so the face's normal is used.
fn weight_at(function: u32, level: u32, point: SurfacePoint) -> f32 {
    let normal = point.face_normal;
    let radius = basis.levels[level].radius;
    let center = functions[function];
    let facing = dot(normal, center.normal);
    let offset = point.position - center.position;
    let height = dot(offset, center.normal);
    let distance_sq = dot(offset, offset) + STRETCH * height * height;
    if !(facing > 0.0 && distance_sq < radius * radius) {
        return 0.0;
    }
    let step = 0.5 * abs(dot(offset, normal + center.normal)) / radius;
    let layer = LEAST_WEIGHT + (1.0 - LEAST_WEIGHT) * kernel(LAYERS * step);
    return kernel(sqrt(distance_sq) / radius) * layer * facing * facing;
}

fn kernel(distance: f32) -> f32 {
    let t = min(distance, 1.0);
    return (2.0 * t - 3.0) * t * t + 1.0;
}

fn basis_value(point: SurfacePoint) -> vec3<f32> {
    let gray = vec3(BASIS_GREY * point.wo.z);
    switch frame.view_mode {
        case VIEW_BASIS_LEVEL: { return level_part(point); }
        case VIEW_BASIS_FUNCTION: { return mix(gray, vec3(1.0, 0.0, 0.0), function_value(point)); }
        default: { return marked(point, gray); }
    }
}

// Twin of `MeshlessLight::level_part`.
fn level_part(point: SurfacePoint) -> vec3<f32> {
    if basis.shown_level >= basis.level_count {
        return vec3(0.0);
    }
    let received = point.world_from_local[2] * level_vector(basis.shown_level, point).vector;
    return signed_light(luminance(received) * FRAC_1_PI);
}

// Twin of `MeshlessLight::function_value`.
fn function_value(point: SurfacePoint) -> f32 {
    var level = 0u;
    while level < basis.level_count && basis.levels[level].end <= basis.shown_function {
        level++;
    }
    if level == basis.level_count {
        return 0.0;
    }
    let range = entries_around(level, point.position);
    var value = 0.0;
    var weights = 0.0;
    for (var i = range.x; i < range.y; i++) {
        let weight = weight_at(entries[i], level, point);
        value += select(0.0, weight, entries[i] == basis.shown_function);
        weights += weight;
    }
    return value * normalisation(weights);
}

// Twin of `MeshlessLight::marked_level` and `level_color`.
fn marked(point: SurfacePoint, otherwise: vec3<f32>) -> vec3<f32> {
    for (var level = basis.level_count; level > 0u; level--) {
        if has_mark(level - 1u, point) {
            let hue = f32(level - 1u) / f32(basis.level_count);
            return saturate(abs(fract(hue + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0);
        }
    }
    return otherwise;
}

fn has_mark(level: u32, point: SurfacePoint) -> bool {
    let reach = POINT_RADIUS * basis.levels[level].radius;
    let range = entries_around(level, point.position);
    for (var i = range.x; i < range.y; i++) {
        let function = entries[i];
        let offset = functions[function].position - point.position;
        let is_near = dot(offset, offset) < reach * reach && weight_at(function, level, point) > 0.0;
        if is_near && is_lit(coefficients[function].vector) {
            return true;
        }
    }
    return false;
}

fn is_lit(vector: mat3x3<f32>) -> bool {
    return any(vector[0] != vec3(0.0)) || any(vector[1] != vec3(0.0)) || any(vector[2] != vec3(0.0));
}
