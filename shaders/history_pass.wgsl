// Keeps one part of a picture's light for the next picture.

// Another part to add to this one, or a texel of zeros.
@group(2) @binding(0) var added_value: texture_2d<f32>;
@group(2) @binding(1) var added_work: texture_2d<u32>;
// Sets of the samples' materials and patches.
@group(2) @binding(2) var marks: texture_2d<u32>;

fn written_at(pixel: vec2<u32>) -> Past {
    let g = textureLoad(geometry, pixel, 0);
    let sums = previous_sums(pixel);
    if !is_surface(g) || !sees_one_surface(sums.work, textureLoad(marks, pixel, 0)) {
        return Past(vec4(0.0, 0.0, 0.0, -1.0), vec4(0u));
    }
    let seen = guide(g, pixel);
    let added = Sums(textureLoad(added_value, pixel, 0), textureLoad(added_work, pixel, 0));
    return past_at((mean(sums) + mean(added)) / seen.divisor, seen);
}

fn mean(sums: Sums) -> vec3<f32> {
    return sums.value.xyz / f32(max(sample_count(sums.work), 1u));
}

// Whether all samples see a surface of one material; otherwise the mean does not represent the light.
fn sees_one_surface(work: vec4<u32>, marks: vec4<u32>) -> bool {
    let materials = countOneBits(marks.x) + countOneBits(marks.y);
    return work.z >> 16u == sample_count(work) && materials == 1u;
}
