// All directions in cells of an octahedron unfolded to a square. Twin of core/src/sphere/octahedron.rs.

// Cells along an edge of the square.
const OCTAHEDRON_SIDE: u32 = 48u;

// The place of a direction in the square, from (0, 0) to (1, 1); of no direction the middle.
fn octahedron_place(direction: vec3<f32>) -> vec2<f32> {
    let p = direction.xy / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-20);
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return 0.5 + 0.5 * select(folded, p, direction.z >= 0.0);
}

fn octahedron_cell(direction: vec3<f32>) -> u32 {
    let place = octahedron_place(direction) * f32(OCTAHEDRON_SIDE);
    let cell = vec2<u32>(clamp(place, vec2(0.0), vec2(f32(OCTAHEDRON_SIDE - 1u))));
    return cell.y * OCTAHEDRON_SIDE + cell.x;
}
