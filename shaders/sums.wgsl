// A pixel's sums of one part of the light: environment, bounced light, what mirrors show, or local lights. An edit restarts only the parts that it
// changes. Twin of `Sum` in render/src/cpu/picture.rs.

struct Sums {
    // Sum of the values; and wireframe coverage or, in a picture with an alpha channel, the share of light that a ground transmits,
    // which the values also hold.
    @location(0) value: vec4<f32>,
    // Merged nodes, or the width of the widest sharp lobe times WIDTH_SCALE in the part of mirrors; BRDF evaluations; samples and, in the high half, surface samples; covered samples and, in the high half,
    // surfaces shaded since the picture was started or resumed.
    @location(1) work: vec4<u32>,
}

const WIDTH_SCALE: f32 = 100000.0;

fn sample_count(work: vec4<u32>) -> u32 {
    return work.z & 0xffffu;
}

fn covered_count(work: vec4<u32>) -> u32 {
    return work.w & 0xffffu;
}
