// Contents of a bin: a number that is smaller for nearer nodes. Twin of core/src/implicit/direct/key.rs.

const NODE_BITS: u32 = 20u;
const LARGEST_CODE: u32 = 4095u;
const DROPPED_BITS: u32 = 16u;
const BITS_OF_ONE: u32 = 0x3f800000u;

// The key of a node, 12 bits of distance above its number. `scale` is in 1/m2.
fn distance_key(distance_sq: f32, node: u32, scale: f32) -> u32 {
    let last = BITS_OF_ONE >> DROPPED_BITS;
    let code = LARGEST_CODE + (bitcast<u32>(distance_sq * scale) >> DROPPED_BITS);
    return (min(max(code, last) - last, LARGEST_CODE) << NODE_BITS) | node;
}

fn node_of(key: u32) -> u32 {
    return key & ((1u << NODE_BITS) - 1u);
}
