//! Maps with many texels in a pixel: levels, taps along footprints, and slopes, as on the CPU.

use super::twin::{Rig, agrees, appearance, difference, noise, on_the_cpu, parameters, view};
use crate::{Appearance, BrdfSampling, View, ViewMode};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::GgxParameters,
    dataset::Dataset,
    material::{BrdfModel, MaterialMaps},
    texture::{Channel, ColorSpace, Pattern, Procedural, Texels, Texture, TextureSlot},
};
use std::sync::Arc;

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
    let slot = |texture, color_space, channel, strength| TextureSlot {
        texture,
        color_space,
        channel,
        strength,
        scale: Vec2::new(0.9, 2.3),
        offset: Vec2::new(0.3, -1.2),
        rotation: 0.4,
        flip_y: true,
        procedural: None,
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

#[test]
fn maps_are_filtered_as_on_the_cpu_alone_and_together_and_by_the_footprint_of_the_sample() {
    let Some(mut rig) = Rig::new(64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let all = ["base_color", "roughness", "metalness", "normal", "bump"];
    let eight = [&all[..], &["base_color"], &["normal"], &["bump"]].map(|names| (names, Bits::Eight));
    let sixteen = [&all[..], &["base_color"]].map(|names| (names, Bits::Sixteen));
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
