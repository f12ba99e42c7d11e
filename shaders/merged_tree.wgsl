// Height of the tree that a pass merges. Kernels define their own.

fn tree_height() -> u32 {
    return select(frame.tree_height, frame.source_tree_height, FIELD == FIELD_SOURCES);
}

// Solid angle of a leaf with a cut value of one.
fn leaf_solid_angle() -> f32 {
    return select(frame.leaf_solid_angle, 1.0, FIELD == FIELD_SOURCES);
}
