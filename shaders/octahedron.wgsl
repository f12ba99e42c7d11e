// All directions in cells of an octahedron unfolded to a square. Twin of core/src/sphere/octahedron.rs.

// Cells along an edge of the square.
const OCTAHEDRON_SIDE: u32 = 48u;

fn octahedron_cell(direction: vec3<f32>) -> u32 {
    let p = direction.xy / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    let place = select(folded, p, direction.z >= 0.0);
    let cell = vec2<u32>(clamp((0.5 + 0.5 * place) * f32(OCTAHEDRON_SIDE), vec2(0.0), vec2(f32(OCTAHEDRON_SIDE - 1u))));
    return cell.y * OCTAHEDRON_SIDE + cell.x;
}
