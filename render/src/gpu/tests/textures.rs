//! Maps with many texels in a pixel: levels, taps along footprints, and slopes, as on the CPU.

use super::twin::{Rig, agrees, appearance, difference, noise, on_the_cpu, parameters, view};
use crate::{
    Appearance, BrdfSampling, View, ViewMode,
    test_scenes::{self, from_above, mesh},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::GgxParameters,
    dataset::Dataset,
    material::{BrdfModel, MaterialMaps},
    texture::{Channel, ColorSpace, Pattern, Procedural, Texels, Texture, TextureSlot, UvSet, Wrap},
};
use std::{f32::consts::PI, sync::Arc};

/// Bits per component of color codes and normals.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bits {
    Eight,
    Sixteen,
}

impl Bits {
    fn texels(self, texels: Vec<[u8; 4]>) -> Texels {
        // Sixteen bits have codes between those of eight.
        let deep = |texel: [u8; 4]| texel.map(|code| 257 * u16::from(code) - u16::from(code) / 3);
        match self {
            Self::Eight => Texels::U8(texels),
            Self::Sixteen => Texels::U16(texels.into_iter().map(deep).collect()),
        }
    }
}

/// Colors, heights, and normals of sizes that are no powers of two.
fn fine_textures(bits: Bits) -> Vec<Arc<Texture>> {
    let codes = (0..96 * 64).map(|i| std::array::from_fn(|c| noise(4 * i + c as u32))).collect();
    let floats = (0..64 * 33).map(|i| [f32::from(noise(i)) / 255.0; 4]).collect();
    let normals = (0..70 * 70).map(|i| [noise(2 * i) / 2 + 64, noise(2 * i + 1) / 3 + 80, 250, 255]).collect();
    let texture = |size, texels| Arc::new(Texture::new("fine", size, texels));
    vec![
        texture([96, 64], bits.texels(codes)),
        texture([64, 33], Texels::F32(floats)),
        texture([70, 70], bits.texels(normals)),
    ]
}

fn look(dataset: &Dataset, names: &[&str], bits: Bits) -> Appearance {
    scaled_look(dataset, names, bits, Vec2::new(0.9, 2.3))
}

fn scaled_look(dataset: &Dataset, names: &[&str], bits: Bits, scale: Vec2) -> Appearance {
    let slot = |texture: u32, color_space, channel, strength| TextureSlot {
        texture,
        wrap: [0, 1].map(|axis| Wrap::ALL[(texture as usize + axis) % 3]),
        color_space,
        channel,
        strength,
        scale,
        offset: Vec2::new(0.3, -1.2),
        rotation: 0.4,
        flip_y: true,
        ..Default::default()
    };
    let mut maps = MaterialMaps::from([
        ("base_color", slot(0, ColorSpace::Srgb, Channel::R, 1.0)),
        ("roughness", slot(1, ColorSpace::Linear, Channel::G, 1.0)),
        ("metalness", slot(0, ColorSpace::Linear, Channel::B, 1.0)),
        ("normal", slot(2, ColorSpace::Linear, Channel::R, 0.8)),
        ("bump", slot(1, ColorSpace::Linear, Channel::R, 0.003)),
    ]);
    maps.retain(|name, _| names.contains(&name));
    let parameters = GgxParameters { roughness: 0.5, ..parameters(0.5, 0.3) };
    let looks = appearance(dataset, BrdfModel::Ggx, parameters, maps);
    Appearance { textures: fine_textures(bits), ..looks }
}

/// All maps, at this scale.
pub(super) fn look_of_all_maps(dataset: &Dataset, scale: Vec2) -> Appearance {
    scaled_look(dataset, &ALL, Bits::Eight, scale)
}

const ALL: [&str; 5] = ["base_color", "roughness", "metalness", "normal", "bump"];

#[test]
fn maps_are_filtered_as_on_the_cpu_alone_and_together_and_by_the_footprint_of_the_sample() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let eight = [&ALL[..], &["base_color"], &["normal"], &["bump"]].map(|names| (names, Bits::Eight));
    let sixteen = [&ALL[..], &["base_color"]].map(|names| (names, Bits::Sixteen));
    for (names, bits) in eight.into_iter().chain(sixteen) {
        rig.look(look(&dataset, names, bits));
        for mode in [ViewMode::Shaded, ViewMode::Normals, ViewMode::Albedo] {
            let view = view(mode);
            let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
            assert!(agrees(&gpu, &cpu), "{names:?} {bits:?} {mode:?}: {:?}", difference(&gpu, &cpu));
            let finer = View { aa: 2, ..view };
            let other = on_the_cpu(&rig.gpu, &rig.renderer, &finer, rig.lit(), BrdfSampling::Refine);
            let shows = match mode {
                ViewMode::Normals => names.iter().any(|name| matches!(*name, "normal" | "bump")),
                ViewMode::Albedo => names.contains(&"base_color"),
                _ => true,
            };
            assert_eq!(agrees(&gpu, &other), !shows, "negative control, {names:?} {mode:?}");
        }
    }
}

#[test]
fn colors_of_given_primaries_are_those_of_the_cpu_at_any_depth() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let view = view(ViewMode::Albedo);
    for (bits, texture) in [(Bits::Eight, 0), (Bits::Sixteen, 0), (Bits::Eight, 1)] {
        let look = |color_space| {
            let mut look = look(&dataset, &["base_color"], bits);
            let slot = look.materials.iter().find_map(|m| m.maps.get("base_color").cloned()).expect("a map");
            let slot = TextureSlot { color_space, texture, ..slot };
            look.materials.iter_mut().for_each(|m| m.maps.set("base_color", Some(slot.clone())));
            look
        };
        rig.look(look(ColorSpace::Rec2020));
        let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
        assert!(agrees(&gpu, &cpu), "{bits:?} {texture}: {:?}", difference(&gpu, &cpu));
        rig.renderer.set_appearance(look(ColorSpace::Linear));
        let other = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
        // Gray floats stay gray.
        assert_eq!(agrees(&gpu, &other), texture == 1, "negative control, {bits:?}");
    }
}

#[test]
fn patterns_are_those_of_the_cpu_as_values_and_as_heights() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let look = |pattern, scale, map| {
        let (low, high) = (Vec3::new(0.1, 0.7, 0.2), Vec3::new(0.9, 0.2, 0.6));
        let procedural = Some(Procedural { pattern, low, high, octaves: 6 });
        let (scale, strength) = (Vec2::new(scale, 0.7 * scale), 0.05 / scale);
        let slot = TextureSlot { procedural, scale, strength, rotation: 0.3, ..Default::default() };
        appearance(&dataset, BrdfModel::Ggx, parameters(0.6, 0.3), MaterialMaps::from([(map, slot)]))
    };
    for (i, pattern) in Pattern::ALL.into_iter().enumerate() {
        for (map, scale, mode) in [
            ("base_color", 0.6, ViewMode::Albedo),
            ("base_color", 5.0, ViewMode::Albedo),
            ("base_color", 5.0, ViewMode::Shaded),
            ("bump", 0.9, ViewMode::Shaded),
            ("bump", 9.0, ViewMode::Shaded),
        ] {
            // Edges as heights are as steep as the difference of two lookups makes them.
            if map == "bump" && pattern != Pattern::Noise {
                continue;
            }
            rig.look(look(pattern, scale, map));
            let [gpu, cpu] = rig.both(&view(mode), BrdfSampling::Refine);
            assert!(agrees(&gpu, &cpu), "{pattern:?} {map} {scale} {mode:?}: {:?}", difference(&gpu, &cpu));
            rig.renderer.set_appearance(look(Pattern::ALL[(i + 1) % 3], scale, map));
            let other = on_the_cpu(&rig.gpu, &rig.renderer, &view(mode), rig.lit(), BrdfSampling::Refine);
            assert!(!agrees(&gpu, &other), "negative control, {pattern:?} {map} {scale}");
        }
    }
}

/// Normals that lean along the picture's u on a floor, whose u and v run along +X and +Z.
#[test]
fn normal_maps_turn_and_are_mirrored_with_their_slot_near_and_far() {
    let floor = test_scenes::dataset(mesh(4, false), GgxParameters::default());
    let Some(mut rig) = Rig::of(Arc::new(floor), 16) else { return };
    let dataset = rig.renderer.dataset().clone();
    let texel = (0.5 * Vec3::new(0.6, 0.0, 0.8) + 0.5).extend(1.0).to_array();
    let texture = Arc::new(Texture::new("leaning", [4; 2], Texels::F32(vec![texel; 16])));
    let look = |slot: TextureSlot| {
        let maps = MaterialMaps::from([("normal", slot)]);
        let looks = appearance(&dataset, BrdfModel::Ggx, parameters(0.5, 0.0), maps);
        Appearance { textures: vec![texture.clone()], ..looks }
    };
    let view = View { mode: ViewMode::Normals, ..from_above(48) };
    let mirrored = Vec2::new(-1.0, 1.0);
    for (rotation, sign) in [(0.0, Vec2::ONE), (0.5 * PI, Vec2::ONE), (PI, Vec2::ONE), (0.0, mirrored)] {
        let along = Vec3::new(sign.x * rotation.cos(), 0.0, rotation.sin());
        let expected = 0.5 * (0.6 * along + 0.8 * Vec3::Y) + 0.5;
        // A texel covers many pixels, or a pixel many texels.
        for size in [0.02, 30.0] {
            let upright = TextureSlot { scale: Vec2::splat(size), ..Default::default() };
            rig.look(look(TextureSlot { rotation, scale: size * sign, ..upright.clone() }));
            let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
            assert!(agrees(&gpu, &cpu), "{rotation} {sign} {size}: {:?}", difference(&gpu, &cpu));
            let shown: Vec<Vec3> = gpu.pixels.iter().copied().filter(|pixel| *pixel != Vec3::ZERO).collect();
            let farthest = shown.iter().map(|n| (*n - expected).length()).fold(0.0, f32::max);
            assert!(shown.len() > 1000 && farthest < 4e-3, "{rotation} {sign} {size}: {farthest}");
            rig.renderer.set_appearance(look(upright));
            let unturned = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
            let is_upright = along.x > 0.9;
            assert_eq!(agrees(&gpu, &unturned), is_upright, "negative control, {rotation} {sign} {size}");
        }
    }
}

#[test]
fn spreads_of_turned_and_mirrored_normals_are_those_of_the_cpu() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let look = |rotation, mirror: Vec2| {
        let scale = mirror * Vec2::new(11.0, 5.0);
        let slot = TextureSlot { texture: 2, rotation, scale, flip_y: true, ..Default::default() };
        let maps = MaterialMaps::from([("normal", slot)]);
        let looks = appearance(&dataset, BrdfModel::Ggx, parameters(0.35, 0.0), maps);
        Appearance { textures: fine_textures(Bits::Eight), ..looks }
    };
    let view = view(ViewMode::Shaded);
    for (rotation, mirror) in [(1.1, Vec2::new(-1.0, 1.0)), (-2.0, Vec2::new(1.0, -1.0)), (0.5 * PI, Vec2::ONE)] {
        rig.look(look(rotation, mirror));
        let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
        assert!(agrees(&gpu, &cpu), "{rotation} {mirror}: {:?}", difference(&gpu, &cpu));
        rig.renderer.set_appearance(look(rotation + 0.5 * PI, mirror));
        let other = on_the_cpu(&rig.gpu, &rig.renderer, &view, rig.lit(), BrdfSampling::Refine);
        assert!(!agrees(&gpu, &other), "negative control, {rotation} {mirror}");
    }
}

/// The floor with a second set of texture coordinates, turned and shifted against the first, and colors of its vertices.
fn with_second_uvs_and_colors() -> Dataset {
    let mut dataset = (*super::twin::scene()).clone();
    let mesh = &mut dataset.scene.mesh;
    mesh.second_uvs = mesh.uvs.iter().map(|uv| Vec2::new(0.4 - uv.y, 1.7 * uv.x)).collect();
    let color = |p: &Vec3| Vec3::new(0.5 + 0.5 * p.x.sin(), 0.5 + 0.5 * (2.0 * p.z).cos(), 0.25);
    mesh.colors = mesh.positions.iter().map(color).collect();
    dataset
}

#[test]
fn second_texture_coordinates_and_colors_of_vertices_are_as_on_the_cpu() {
    let dataset = with_second_uvs_and_colors();
    let Some(mut rig) = Rig::of(Arc::new(dataset.clone()), 64) else { return };
    let moved = |names: &[&str], uv_set, vertex_colors| {
        let mut looks = look(&dataset, names, Bits::Eight);
        for material in &mut looks.materials {
            material.vertex_colors = vertex_colors;
            material.maps.slots_mut().for_each(|slot| slot.uv_set = uv_set);
        }
        looks
    };
    for (names, mode) in [
        (&["base_color"][..], ViewMode::Albedo),
        (&[], ViewMode::Albedo),
        (&["normal"], ViewMode::Normals),
        (&["bump"], ViewMode::Normals),
        (&["base_color", "roughness", "metalness", "normal", "bump"], ViewMode::Shaded),
    ] {
        rig.look(moved(names, UvSet::Second, true));
        let [gpu, cpu] = rig.both(&view(mode), BrdfSampling::Refine);
        assert!(agrees(&gpu, &cpu), "{names:?} {mode:?}: {:?}", difference(&gpu, &cpu));
        for (uv_set, vertex_colors) in [(UvSet::First, true), (UvSet::Second, false)] {
            let shows = if uv_set == UvSet::First { !names.is_empty() } else { mode != ViewMode::Normals };
            rig.renderer.set_appearance(moved(names, uv_set, vertex_colors));
            let other = on_the_cpu(&rig.gpu, &rig.renderer, &view(mode), rig.lit(), BrdfSampling::Refine);
            assert_eq!(agrees(&gpu, &other), !shows, "negative control, {names:?} {mode:?} {uv_set:?}");
        }
    }
}
