// A box hierarchy that compute passes traverse.

@group(0) @binding(0) var<storage, read> nodes: array<BoxNode>;
// Nine numbers per triangle, in the order of the hierarchy's leaves.
@group(0) @binding(1) var<storage, read> corners: array<f32>;
