// What the first part of the light has beside light: the background, and the lines of a wireframe.

// Whether a pass renders the first part.
override IS_FIRST: bool = true;

// Ends a pixel without a surface to shade. The environment is no count, and a back is black.
fn with_background(begun: Begun) -> Sums {
    var shown = vec3(0.0);
    if IS_FIRST && !begun.is_done && begun.g.x == 0u && frame.view_mode == VIEW_SHADED {
        shown = background_radiance(ray(begun.pixel, PINHOLE).direction);
    }
    return without_surface(begun, shown);
}

// How much of the sample a line covers.
fn lines_at(pixel: vec2<u32>, corners: vec3<u32>) -> f32 {
    if !IS_FIRST || frame.wireframe == 0u {
        return 0.0;
    }
    return wireframe_coverage(pixel, corners);
}
