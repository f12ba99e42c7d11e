use super::*;
use lapidary_core::{
    brdf::GgxParameters,
    light_tree::LightTree,
    material::{BrdfModel, MaterialMaps},
    texture::{Texels, TextureSlot},
};
use lapidary_render::SceneLighting;

const LEAVES: usize = 4096;

fn ball(material: Material, radiance: impl Fn(Vec3) -> Vec3) -> Ball {
    let tree = LightTree::geometric(LEAVES).unwrap();
    let leaves: Vec<Vec3> = tree.leaf_directions().iter().map(|&d| radiance(d)).collect();
    Ball { material, textures: Vec::new(), lighting: SceneLighting::new(&tree, &leaves, 128).into() }
}

fn lambert(base_color: Vec3) -> Material {
    let parameters = GgxParameters { base_color, ..Default::default() };
    Material { model: BrdfModel::Lambert, parameters: parameters.into(), ..Default::default() }
}

fn texture(texels: Vec<[u8; 4]>, size: [u32; 2]) -> Arc<Texture> {
    Texture::new("t", size, Texels::U8(texels)).into()
}

fn mean(pixels: &[BallPixel]) -> Vec3 {
    let weight: f32 = pixels.iter().map(|p| p.1).sum();
    pixels.iter().map(|p| p.0 * p.1).sum::<Vec3>() / weight
}

#[test]
fn a_white_ball_in_a_white_furnace_cannot_be_told_from_it() {
    let pixels = ball(lambert(Vec3::ONE), |_| Vec3::ONE).render(16);
    for (radiance, _) in pixels.iter().filter(|p| p.1 == 1.0) {
        assert!((radiance - 1.0).abs().max_element() < 0.03, "{radiance}");
    }
    let gray = ball(lambert(Vec3::splat(0.9)), |_| Vec3::ONE).render(16);
    assert!((mean(&gray).x - 1.0).abs() > 0.05, "negative control: nine tenths are not all");
}

#[test]
fn the_corners_are_empty_and_the_ball_fills_its_disc() {
    let pixels = ball(lambert(Vec3::ONE), |_| Vec3::ONE).render(32);
    assert_eq!((pixels[0].1, pixels[31].1, pixels[16 * 32 + 16].1), (0.0, 0.0, 1.0));
    let area: f32 = pixels.iter().map(|p| p.1).sum::<f32>() / 1024.0;
    assert!((area - PI / (4.0 * MARGIN * MARGIN)).abs() < 0.01, "{area}");
}

#[test]
fn black_stays_black() {
    let pixels = ball(lambert(Vec3::ZERO), |_| Vec3::ONE).render(8);
    assert!(pixels.iter().all(|p| p.0 == Vec3::ZERO));
    let white_unlit = ball(lambert(Vec3::ONE), |_| Vec3::ZERO).render(8);
    assert!(white_unlit.iter().all(|p| p.0 == Vec3::ZERO));
}

#[test]
fn the_side_toward_a_lamp_is_brighter() {
    let lamp_at =
        |lamp: Vec3| ball(lambert(Vec3::ONE), move |d| Vec3::splat(if d.dot(lamp) > 0.95 { 50.0 } else { 0.0 }));
    let halves = |pixels: &[BallPixel]| {
        let half = |right: bool| {
            let chosen = (0..256).filter(|i| (i % 16 >= 8) == right).map(|i| pixels[i].0.x * pixels[i].1);
            chosen.sum::<f32>()
        };
        (half(false), half(true))
    };
    let (left, right) = halves(&lamp_at(Vec3::X).render(16));
    assert!(right > 5.0 * left, "{left} {right}");
    let (left, right) = halves(&lamp_at(Vec3::Y).render(16));
    assert!((right / left - 1.0).abs() < 0.1, "negative control: a lamp above favours neither: {left} {right}");
}

#[test]
fn maps_multiply_and_missing_textures_do_nothing() {
    let mut ball = ball(lambert(Vec3::ONE), |_| Vec3::ONE);
    ball.material.maps.set("base_color", Some(TextureSlot::default()));
    let without = mean(&ball.render(8));
    ball.textures = vec![texture(vec![[51, 255, 255, 255]], [1, 1])];
    let with = mean(&ball.render(8));
    assert!((with.x / without.x - 0.2).abs() < 1e-3, "{with} of {without}");
    assert_eq!(with.y, without.y);
}

#[test]
fn flipping_a_normal_map_mirrors_the_light_from_above() {
    // Normals that lean up; the lamp is above.
    let slot = TextureSlot::default();
    let mut ball = ball(lambert(Vec3::ONE), |d| Vec3::splat(if d.y > 0.9 { 20.0 } else { 0.0 }));
    ball.textures = vec![texture(vec![[128, 200, 210, 255]], [1, 1])];
    let mut light = |maps: MaterialMaps| {
        ball.material.maps = maps;
        mean(&ball.render(16)).x
    };
    let plain = light(MaterialMaps::default());
    let up = light(MaterialMaps::from([("normal", slot.clone())]));
    let down = light(MaterialMaps::from([("normal", TextureSlot { flip_y: true, ..slot })]));
    assert!(up > 1.1 * plain && down < 0.9 * plain, "{up} {plain} {down}");
}

#[test]
fn a_bump_that_rises_downward_is_as_a_slope_that_faces_up() {
    // Heights grow with v, which runs down the ball, except where the picture repeats.
    let texels: Vec<[u8; 4]> = (0..64).map(|i| [(i * 4) as u8, 0, 0, 255]).collect();
    let slot = |strength| Some(TextureSlot { strength, ..Default::default() });
    let mut ball = ball(lambert(Vec3::ONE), |d| Vec3::splat(if d.y > 0.9 { 20.0 } else { 0.0 }));
    ball.textures = vec![texture(texels, [1, 64])];
    let mut light = |strength: f32| {
        ball.material.maps.set("bump", slot(strength));
        mean(&ball.render(32)).x
    };
    let (raised, flat, sunk) = (light(0.03), light(0.0), light(-0.03));
    assert!(raised > 1.02 * flat && sunk < 0.98 * flat, "{raised} {flat} {sunk}");
}
