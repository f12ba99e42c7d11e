//! Thousands of local lights: all shine, and what has no shadow map is told.

use super::*;
use crate::Components;

#[test]
fn thousands_of_lights_agree_with_the_loop_and_what_has_no_shadow_is_told() {
    let renderer = Renderer::new(scene());
    let Some(mut rig) = Rig::new(Renderer::new(renderer.dataset().clone())) else { return };
    let view = dark_view(view(ViewMode::Shaded).camera, [32, 24]);
    let mut random = fastrand::Rng::with_seed(3);
    let mut lamp = || {
        let position = [3.0 * random.f32() - 1.5, 0.3 + 2.0 * random.f32(), 3.0 * random.f32() - 1.5];
        Light { intensity: Vec3::splat(0.01 * random.f32()), ..light(Emission::Point, position, [0.0; 3]) }
    };
    let lights: Vec<Light> = (0..2000).map(|_| lamp()).collect();
    let gpu = rig.lit_by(&view, &lights, NO_ROOM);
    let points = receivers(&rig.gpu, &renderer, &view);
    let expected = twin(&points, &view, &lights);
    assert!(agrees(&gpu, &expected), "{:?}", difference(&gpu, &expected));
    assert!(!agrees(&gpu, &twin(&points, &view, &lights[..1990])), "negative control: ten of them");
    rig.gpu.limit_shadows(ROOM);
    let unseen = LocalLighting { components: Components { direct: false, ..Components::ALL }, ..local(&lights) };
    assert!(rig.gpu.set_local_lighting(&unseen).unwrap().is_empty(), "nothing is said of what is not shown");
    let remarks = rig.gpu.set_local_lighting(&local(&lights)).unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("1958 of 2000"), "{remarks:?}");
    let shadowed = rig.picture(&view);
    let darker = shadowed.pixels.iter().zip(&gpu.pixels).all(|(a, b)| a.cmple(1.0001 * *b).all() && a.is_finite());
    assert!(darker && difference(&shadowed, &gpu).0 > 1e-3, "some light is blocked, none is added");
}
