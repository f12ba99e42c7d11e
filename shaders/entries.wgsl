// The entry points of a pass, which give each texel what `written_at` returns: by fragments, or by invocations of a kernel. A line that
// begins with `//=` is replaced by lines for the textures that are written: see render/src/device/output.rs.

@fragment
//= fragment
    return written_at(vec2<u32>(position.xy));
}

const MOST_AREAS: u32 = 256u;
const TILE_SIDE: u32 = 8u;

// Where a kernel writes: first column and row of each area, and their numbers. A layer of the grid is one of them.
@group(0) @binding(1) var<uniform> areas: array<vec4<u32>, MOST_AREAS>;
//= textures

@compute @workgroup_size(TILE_SIDE, TILE_SIDE)
fn compute(@builtin(global_invocation_id) id: vec3<u32>) {
    let area = areas[id.z];
    if any(id.xy >= area.zw) {
        return;
    }
    let texel = area.xy + id.xy;
    let value = written_at(texel);
//= stores
}
