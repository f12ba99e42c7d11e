// The size of the tree that a pass merges. Kernels tell theirs themselves.

fn tree_height() -> u32 {
    return select(frame.tree_height, frame.source_tree_height, FIELD == FIELD_SOURCES);
}

// Solid angle of a leaf whose cut value is one.
fn leaf_solid_angle() -> f32 {
    return select(frame.leaf_solid_angle, 1.0, FIELD == FIELD_SOURCES);
}
