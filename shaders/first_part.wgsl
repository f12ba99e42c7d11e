// Values of the first part besides light: the background and wireframe lines.

// Whether a pass renders the first part.
override IS_FIRST: bool = true;

// Ends a pixel without a surface to shade. The environment is not a count, and backs are black.
fn with_background(begun: Begun, direction: vec3<f32>) -> Sums {
    var shown = vec3(0.0);
    if IS_FIRST && !begun.is_done && begun.g.x == 0u && frame.view_mode == VIEW_SHADED {
        shown = background_radiance(direction);
    }
    return without_surface(begun, shown);
}

// Coverage of the sample by lines.
fn lines_at(pixel: vec2<u32>, corners: vec3<u32>) -> f32 {
    if !IS_FIRST || frame.wireframe == 0u {
        return 0.0;
    }
    return wireframe_coverage(pixel, corners);
}
