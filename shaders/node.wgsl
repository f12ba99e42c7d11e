// A node of a tree of lights.

struct Node {
    // Mean radiance.
    radiance: vec3<f32>,
    // Distant: inverse concentration as a von Mises-Fisher lobe. Sources: radius in meters, weighted by radiance.
    spread: f32,
    // Distant: unit direction. Sources: center in meters. Weighted by radiance.
    place: vec3<f32>,
    // Distant: half-angle in radians of the cone of its leaves. Sources: their radius in meters.
    radius: f32,
}
