// What a pixel has of one part of the light: the environment's, bounced light, or that of local lights. A part that an
// edit changes begins anew by itself. Twin of `Sum` in render/src/cpu/picture.rs.

struct Sums {
    // Sum of the values; and coverage by the lines of a wireframe, or in a picture with an alpha channel the share of the light
    // behind it that a ground lets through, which the values have as well.
    @location(0) value: vec4<f32>,
    // Merged nodes; BRDF evaluations; samples and, in the high half, those of surfaces; samples that are covered and, in
    // the high half, surfaces that were shaded since the picture was begun or resumed.
    @location(1) work: vec4<u32>,
}

fn sample_count(work: vec4<u32>) -> u32 {
    return work.z & 0xffffu;
}

fn covered_count(work: vec4<u32>) -> u32 {
    return work.w & 0xffffu;
}
