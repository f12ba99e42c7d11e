//! Sources that send by direction: of a wall with known light, against its BRDF. Each test has a negative control.

use super::{reflection::Glossy, *};
use crate::{
    Renderer,
    test_scenes::{Edited, floor_and_wall, illumination, point_light},
};
use lapidary_core::{
    brdf::GgxParameters, dataset::Dataset, lights::LightSampler, material::BrdfModel, sphere::cosine_direction,
    surfel::Surfel,
};
use std::f32::consts::PI;

/// A floor and a metal wall with sources.
fn metal_wall(roughness: f32) -> Dataset {
    let mut dataset = floor_and_wall(4);
    dataset.scene.materials[1].model = BrdfModel::Ggx;
    dataset.scene.materials[1].parameters = metal(roughness).into();
    dataset
}

fn metal(roughness: f32) -> GgxParameters {
    GgxParameters { base_color: Vec3::new(0.9, 0.6, 0.3), roughness, metalness: 1.0, ..Default::default() }
}

struct Stage {
    sources: Edited<SourceRig>,
    gloss: GlossRig,
}

impl Stage {
    fn new(dataset: Dataset) -> Self {
        let baked = Baked::from(dataset);
        let mut gloss = GlossRig::new(&baked).unwrap();
        while gloss.trace_some() {}
        let mut sources = Edited::new(&baked, SourceRig::new(&baked).unwrap());
        sources.set_lights(&[point_light(LAMP, 3.0)]);
        Self { sources, gloss }
    }

    fn with_environment(mut self) -> Self {
        let dataset = self.sources.situation.scene.dataset.clone();
        let sky = illumination([16, 8], |_, y| Vec3::splat(if y < 4 { 1.0 } else { 0.1 }));
        self.sources.set_environment(Some(Renderer::new(dataset).lighting(&sky, 256)));
        self
    }

    fn sent(&self, further: f32) -> SentByDirection {
        let further = vec![Vec3::splat(further); self.sources.tree().len()];
        self.gloss.sent(&self.sources, &further, &self.sources.situation)
    }

    fn glossy(&self, source: u32) -> Glossy {
        let Stage { sources, gloss } = self;
        let appearance = ResolvedAppearance::from((*sources.situation.appearance).clone());
        let mesh = &gloss.baked.dataset.scene.mesh;
        let surfel = &sources.tree().sources()[source as usize].surfel;
        let brdf = appearance.at_place(mesh, surfel.place).brdf;
        Glossy::new(brdf, mesh.frame(surfel), surfel.normal)
    }
}

const LAMP: Vec3 = Vec3::new(-1.0, 1.2, 0.1);

#[test]
fn diffuse_sources_send_to_all_sides_alike() {
    // The largest difference to the light of diffuse sources, over its brightest channel.
    let off = |stage: &Stage| {
        let (sent, further) = (stage.sent(0.7), vec![Vec3::splat(0.7); stage.sources.tree().len()]);
        let means = stage.sources.lighting_with(&further, 64).nodes.radiance;
        let toward = |node: usize, knot| (sent.toward(node, knot) - means[node] / means[node].max_element()).abs();
        let of_node = |node: usize| (0..KNOTS.len()).map(|knot| toward(node, knot).max_element()).fold(0.0, f32::max);
        (1..sent.codes().len()).map(of_node).fold(0.0, f32::max)
    };
    let diffuse = Stage::new(floor_and_wall(4)).with_environment();
    assert!(off(&diffuse) < 0.003, "{}", off(&diffuse));
    let glossy = Stage::new(metal_wall(0.45)).with_environment();
    assert!(off(&glossy) > 1.0, "negative control");
}

#[test]
fn lamps_are_reflected_by_the_brdf_of_each_source() {
    let stage = Stage::new(metal_wall(0.8));
    let (sent, tree) = (stage.sent(0.0), stage.sources.tree());
    let (leaves, means) = (tree.len(), stage.sources.lighting(64).nodes.radiance);
    let lamp = point_light(LAMP, 3.0);
    let lamp: LightSampler = lamp.sampler();
    let (mut worst, mut worst_of_mean) = (0.0_f32, 0.0_f32);
    for source in (0..leaves).step_by(37) {
        let surfel = &tree.sources()[source].surfel;
        let surface = stage.glossy(source as u32);
        let sample = lamp.sample(surfel.position, glam::Vec2::splat(0.5)).unwrap();
        for knot in (0..KNOTS.len()).filter(|&knot| KNOTS.direction_of(knot).dot(surfel.normal) > 0.2) {
            let expected = surface.one_lamp(sample.direction, KNOTS.direction_of(knot)) * sample.irradiance;
            let mean = means[leaves + source];
            let off = |found: Vec3| ((found - expected) / expected).abs().max_element();
            worst = worst.max(off(sent.toward(leaves + source, knot) * mean.max_element()));
            worst_of_mean = worst_of_mean.max(off(mean));
        }
    }
    // Lobes are as wide as a knot at least, and ratios are rounded.
    assert!(worst < 0.12, "{worst}");
    assert!(worst_of_mean > 0.5, "negative control: a diffuse wall, {worst_of_mean}");
}

#[test]
fn light_from_everywhere_is_reflected_by_the_albedo() {
    let of = |roughness: f32| {
        let surface = Stage::new(metal_wall(roughness)).glossy(0);
        let toward = surface.transfer().reflected(&[Vec3::ONE; CELLS.len()]);
        let knots = (0..KNOTS.len()).filter(|&knot| KNOTS.direction_of(knot).x > 0.25);
        let off = knots.map(|knot| {
            let direction = KNOTS.direction_of(knot);
            let samples = 64;
            let albedo = |i: usize| {
                let [u, v] = [i % samples, i / samples].map(|i| (i as f32 + 0.5) / samples as f32);
                let local = cosine_direction(u, v);
                let lamp = lapidary_core::sphere::frame_around(Vec3::X) * local;
                surface.one_lamp(lamp, direction) * (PI / local.z.max(1e-3))
            };
            let albedo = (0..samples * samples).map(albedo).sum::<Vec3>() / (samples * samples) as f32;
            (toward[knot].x / albedo.x - 1.0).abs()
        });
        off.fold(0.0, f32::max)
    };
    for (roughness, bound) in [(0.9, 0.03), (0.6, 0.08), (0.45, 0.12)] {
        assert!(of(roughness) < bound, "{roughness}: {}", of(roughness));
    }
}

#[test]
fn an_edited_material_sends_the_light_of_a_fresh_rig() {
    let mut stage = Stage::new(metal_wall(0.4)).with_environment();
    let before = stage.sent(0.5);
    let mut appearance = (*stage.sources.situation.appearance).clone();
    appearance.materials[1].parameters = metal(0.7).into();
    stage.sources.set_appearance(&appearance);
    let fresh = Stage::new(metal_wall(0.7)).with_environment();
    assert!(stage.sent(0.5).codes() == fresh.sent(0.5).codes(), "to the bit");
    assert!(before.codes() != fresh.sent(0.5).codes(), "negative control: the material before");
}

#[test]
fn light_of_other_surfaces_comes_from_their_side() {
    // A metal wall that mirrors a bright sky below and a dark one above sends light upward, away from its mirror image.
    let stage = Stage::new(metal_wall(0.35));
    let mut arriving = [Vec3::ZERO; CELLS.len()];
    let surface = stage.glossy(0);
    let below = |cell: usize| surface.world_of_cell(cell).y < -0.2;
    (0..CELLS.len()).filter(|&cell| below(cell)).for_each(|cell| arriving[cell] = Vec3::ONE);
    let toward = surface.transfer().reflected(&arriving);
    let mean = |up: f32| {
        let is_there = |knot: &usize| {
            let direction = KNOTS.direction_of(*knot);
            direction.x > 0.3 && direction.y * up > 0.4
        };
        let knots: Vec<usize> = (0..KNOTS.len()).filter(is_there).collect();
        knots.iter().map(|&knot| toward[knot].x).sum::<f32>() / knots.len() as f32
    };
    assert!(mean(1.0) > 4.0 * mean(-1.0), "{} {}", mean(1.0), mean(-1.0));
    // Negative control: a rough wall sends it back, too.
    let rough = Stage::new(metal_wall(1.0)).glossy(0).transfer().reflected(&arriving);
    let [up, down] = [0.6_f32, -0.6].map(|y| rough[KNOTS.nearest(Vec3::new(0.8, y, 0.0))].x);
    assert!(up < 3.0 * down, "{up} {down}");
}

#[test]
fn groups_lie_in_one_surface_and_face_alike() {
    let dataset = floor_and_wall(4);
    let mesh = &dataset.scene.mesh;
    let mut sources = dataset.indirect.as_ref().unwrap().sources[..64].to_vec();
    let floor = mesh.surfel(0, glam::Vec2::splat(0.3), false);
    sources[3].surfel = floor;
    sources[9].surfel.normal = Vec3::new(1.0, 1.0, 0.0).normalize();
    let owner = |source: &Source| lapidary_core::meshless::Owner::on(mesh, &source.surfel);
    let of_nodes = |depth: u32| {
        let groups = Groups::below(&sources, mesh, depth);
        let leader = |i: usize| &sources[groups.all()[groups.of_sources()[i] as usize].source as usize];
        let alike = |i: &usize| {
            owner(leader(*i)) == owner(&sources[*i]) && leader(*i).surfel.normal.dot(sources[*i].surfel.normal) > 0.9
        };
        assert_eq!((0..sources.len()).filter(alike).count(), sources.len());
        groups.all().len()
    };
    assert_eq!([of_nodes(0), of_nodes(3), of_nodes(12)], [3, 10, 64], "one surface and two that differ");
}

#[test]
fn rays_end_at_the_sky_in_the_dark_and_at_the_source_that_they_meet() {
    let stage = Stage::new(metal_wall(0.5));
    // Upward, nothing stops a ray of the wall; downward, there is the floor, which has no sources.
    let kinds = |end: RayEnd| match end {
        RayEnd::Dark => Vec3::X,
        RayEnd::Sky(_) => Vec3::Y,
        RayEnd::Source { .. } => Vec3::Z,
    };
    let ends: Vec<[Vec3; CELLS.len()]> = stage.gloss.groups.cells().map(|cell| cell.map(kinds)).collect();
    let mean: Vec3 = ends.iter().flatten().sum::<Vec3>() / (ends.len() * CELLS.len()) as f32;
    assert!(mean.x > 0.15 && mean.y > 0.4 && mean.z < 0.1, "{mean}");

    // Seen from its front, the wall ends rays at its sources, toward where they came from.
    let mut dataset = metal_wall(0.5);
    let indirect = dataset.indirect.as_mut().unwrap();
    let at = indirect.sources[0].surfel.position + Vec3::X;
    indirect.sources[0].surfel = Surfel { position: at, normal: Vec3::NEG_X, ..indirect.sources[0].surfel };
    let stage = Stage::new(dataset);
    let (groups, sources) = (&stage.gloss.groups, stage.sources.tree().sources());
    let meets = |end: RayEnd| match end {
        RayEnd::Source { source, knot } => {
            let to_eye = (at - sources[source as usize].surfel.position).normalize();
            Vec3::new(1.0, f32::from(u8::from(KNOTS.direction_of(knot as usize).dot(to_eye) > 0.8)), 0.0)
        }
        _ => Vec3::ZERO,
    };
    let cells: Vec<[Vec3; CELLS.len()]> = groups.cells().map(|cell| cell.map(meets)).collect();
    let sum: Vec3 = cells[groups.of_sources()[0] as usize].iter().sum::<Vec3>() / CELLS.len() as f32;
    assert!(sum.x > 0.2 && sum.y > 0.95 * sum.x, "{sum}");
}

#[test]
fn lobes_that_are_widened_are_told() {
    let remark = |materials: &[(&str, f32)]| {
        let mut dataset = metal_wall(0.6);
        dataset.scene.materials.truncate(1);
        for &(name, roughness) in materials {
            let parameters = metal(roughness).into();
            let material = Material { name: name.into(), model: BrdfModel::Ggx, parameters, ..Default::default() };
            dataset.scene.materials.push(material);
        }
        remark_on_widened_lobes(&Appearance::of(&dataset.scene))
    };
    assert_eq!(remark(&[("Steel", 0.5)]), None, "wide enough");
    let one = remark(&[("Steel", 0.2)]).unwrap();
    assert!(one.starts_with("\"Steel\" sends bounced light as if of roughness 0.32"), "{one}");
    let three = remark(&[("Gold", 0.1), ("Rough", 0.6), ("Steel", 0.2), ("Tin", 0.25)]).unwrap();
    assert!(three.starts_with("\"Gold\" and 2 other materials send"), "{three}");
}
