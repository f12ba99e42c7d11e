//! Light with the help of cuts against light by rays alone.

use super::*;
use crate::{
    Renderer, View,
    light::direct::{DirectLights, pixel_shift},
    shade::{background::Backdrop, differentials::Differentials, pixel_sampler::PixelSampler, surface::FirstHit},
    test_scenes::{dataset, from_the_side, light, mesh, plates, white},
};
use lapidary_core::scene::Mesh;

fn sun(toward: Vec3) -> Light {
    light(Emission::Directional { angle_degrees: 2.0 }, toward, Vec3::ZERO, 3.0)
}

/// Pixels whose triangle tells what is seen of `lights`, and those of another light than by rays, if the cuts are asked of `asked`.
fn told_and_wrong(mesh: Mesh, view: &View, lights: &[Light; 1], asked: &[Light; 1]) -> [usize; 2] {
    let renderer = Renderer::new(dataset(mesh, white()));
    let (mut sights, differentials) = (DistantSights::default(), Differentials::of(view));
    sights.update(renderer.dataset(), asked);
    // A lie: what is seen of another light.
    sights.0[0].forward = lights[0].forward().unwrap();
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(&renderer, view, &backdrop);
    let rays = DirectLights::by_rays(lights, renderer.intersector());
    let cuts = DirectLights { sights: Some((&sights, differentials)), ..rays };
    let (mut told, mut wrong) = (0, 0);
    for (x, y) in (0..view.size[1]).flat_map(|y| (0..view.size[0]).map(move |x| (x, y))) {
        let FirstHit::Surface(point) = sampler.sight(x, y, 0).seen else { continue };
        let shift = pixel_shift(x, y, 0);
        told += usize::from(sights.sees(&point, differentials.pixel_at(point.position), &lights[0]).is_some());
        wrong += usize::from(cuts.reflected(&point, shift) != rays.reflected(&point, shift));
    }
    [told, wrong]
}

#[test]
fn cuts_save_rays_and_change_no_pixel() {
    let [lights, others] = [Vec3::new(0.5, 1.0, 0.3), Vec3::new(-0.5, 1.0, -0.3)].map(|toward| [sun(toward)]);
    let view = from_the_side(96);
    let [told, wrong] = told_and_wrong(mesh(48, true), &view, &lights, &lights);
    assert!(told > 96 * 96 / 4 && wrong == 0, "{told} told, {wrong} wrong");
    let [_, wrong] = told_and_wrong(mesh(48, true), &view, &lights, &others);
    assert!(wrong > 50, "negative control: cuts that are asked for another sun, {wrong} wrong");
}

#[test]
fn large_triangles_are_not_asked_since_shadows_fit_between_their_vertices() {
    let lights = [sun(Vec3::new(-1.0, 1.0, 0.0))];
    assert_eq!(told_and_wrong(plates(), &from_the_side(96), &lights, &lights), [0, 0]);
}
