// A leaf beside a vertex.
struct LeafBeside {
    leaf: u32,
    weight: f32,
}
