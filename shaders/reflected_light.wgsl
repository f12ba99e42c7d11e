// What a glossy leaf reflects toward the eye, as radiance. Twin of `ReflectedLight` in render/src/light/implicit/gloss.rs.
struct Reflected {
    sky: vec3<f32>,
    // 0 for a leaf that faces away from the eye, or is not glossy.
    faces_eye: u32,
    leaves: vec3<f32>,
    // Irradiance from the leaves that it sees.
    irradiance: vec3<f32>,
}
