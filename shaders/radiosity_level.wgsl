// A level of functions, and which of them gather: those whose parents' light is not enough. Twin of `Radiosity::active` in
// core/src/meshless/radiosity/transport.rs.

struct LevelUniforms {
    // First function of the level, and one past its last.
    first: u32,
    end: u32,
    // Difference from the parents above which a function splits.
    enough: f32,
}

// States of a function. In any but the first it tells its children little.
const OPEN: u32 = 0u;
const COVERED: u32 = 1u;
const SPLIT: u32 = 2u;

@group(1) @binding(0) var<uniform> level: LevelUniforms;
// First parent of each function, and the end of the last.
@group(1) @binding(1) var<storage, read> parent_starts: array<u32>;
// Each parent and its weight.
@group(1) @binding(2) var<storage, read> parents: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read_write> states: array<u32>;
// For each function the place of its rays plus 1; 0 if they are unknown.
@group(1) @binding(4) var<storage, read> slots: array<u32>;

fn is_active(function: u32) -> bool {
    let start = parent_starts[function];
    let end = parent_starts[function + 1u];
    if states[function] == COVERED {
        return false;
    }
    for (var i = start; i < end; i++) {
        if states[parents[i].x] != OPEN {
            return true;
        }
    }
    return start == end;
}

// Whether a function gathers, and whether its rays are unknown too, as numbers to add up.
fn marks_of(function: u32) -> vec2<u32> {
    if function >= level.end || !is_active(function) {
        return vec2(0u);
    }
    return vec2(1u, u32(slots[function] == 0u));
}
