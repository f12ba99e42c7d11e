//! Direct light of local lights on patches, projected to the basis at run time (wavelet paper, 5.1).
//!
//! A patch is as finely projected as its share of the light's power asks for. Rays stand in for the paper's occlusion queries.
//! Departures: light lies in the cell of directions that it comes from, where the basis has one. The paper takes it as diffuse. Lights
//! with an extent are sampled at four of their points.

use super::{
    operator::{RadianceBasis, RadianceFunction},
    patch::Patch,
    reflecting::ReflectingPatch,
    square::{Function, Node, transform_products},
};
use crate::{
    lights::{Light, LightSample},
    offset,
    ray::{EightRays, Intersector},
};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::{array::from_fn, f32::consts::PI};

/// Projection of direct light.
#[derive(Clone, Copy)]
pub struct DirectProjection<'a> {
    /// The patches.
    pub patches: &'a [ReflectingPatch],
    /// What casts shadows.
    pub rays: &'a Intersector,
    /// Distance of the ends of rays from surfaces, in meters.
    pub offset: f32,
    /// Halvings of a patch at most.
    pub levels: u32,
}

/// Largest share of a light's power on a node. Nodes that get more are halved.
const LARGEST_SHARE: f32 = 1e-3;

/// Shadow rays along an edge of a node.
const RAYS_ALONG: u32 = 2;

impl DirectProjection<'_> {
    /// Coefficients of the radiance that arrives from the lights, one for each function. What the basis lacks is left out:
    /// nothing more would come of it.
    pub fn project(&self, lights: &[Light], basis: &RadianceBasis) -> Vec<Vec3> {
        let mut coefficients = vec![Vec3::ZERO; basis.functions().len()];
        let of_patch = |(patch, reflecting): (usize, &ReflectingPatch)| {
            let products: Vec<_> = lights.iter().flat_map(|light| self.on_patch(light, reflecting)).collect();
            let found = |([space, angle], value): ([Function; 2], Vec3)| {
                let function = RadianceFunction { patch: patch as u32, space, angle };
                basis.index_of(&function).map(|index| (index, value))
            };
            transform_products(&products).into_iter().filter_map(found).collect::<Vec<_>>()
        };
        let of_patches: Vec<_> = self.patches.par_iter().enumerate().map(of_patch).collect();
        of_patches.into_iter().flatten().for_each(|(index, value)| coefficients[index as usize] += value);
        coefficients
    }

    /// Light of one lamp on the nodes of a patch, in smooth functions of places and directions.
    fn on_patch(&self, light: &Light, reflecting: &ReflectingPatch) -> Vec<([Node; 2], Vec3)> {
        let (patch, angle_level) = (&reflecting.patch, reflecting.angle_level());
        let level = self.level_for(light, patch);
        let area = patch.area / (1_u32 << (2 * level)) as f32;
        let samples = RAYS_ALONG * RAYS_ALONG;
        let place = |i: u32| (Vec2::new((i % RAYS_ALONG) as f32, (i / RAYS_ALONG) as f32) + 0.5) / RAYS_ALONG as f32;
        let places: Vec<(Node, Vec2)> =
            Node::all(level).flat_map(|node| (0..samples).map(move |i| (node, place(i)))).collect();
        let lit = |eight: &[(Node, Vec2)]| {
            let arriving = self.arriving(light, patch, eight);
            let lit = eight.iter().zip(arriving).filter_map(|(&(node, _), arriving)| {
                let (direction, irradiance) = arriving?;
                let angle = Node::at(angle_level, patch.square_of_direction(direction));
                // The mean over the samples, times the node's area and the heights of both functions.
                let height = 1.0 / (node.side() * angle.side() * (patch.area * PI).sqrt());
                Some(([node, angle], irradiance * (area * height / samples as f32)))
            });
            lit.collect::<Vec<_>>()
        };
        places.chunks(8).flat_map(lit).collect()
    }

    /// Direction of a light and its irradiance at up to eight places of nodes of a patch, where it arrives. A place also chooses a
    /// point of the light.
    fn arriving(&self, light: &Light, patch: &Patch, places: &[(Node, Vec2)]) -> [Option<(Vec3, Vec3)>; 8] {
        let sent: [Option<(Vec3, LightSample)>; 8] = from_fn(|i| {
            let (node, u) = places.get(i)?;
            let at = patch.point(node.point(*u)) + patch.normal() * self.offset;
            let sample = light.sample(at, *u)?;
            (sample.direction.dot(patch.normal()) > 0.0).then_some((at, sample))
        });
        let active = (0..8).map(|i| u8::from(sent[i].is_some()) << i).sum();
        let origins = sent.map(|sent| sent.map_or(Vec3::ZERO, |(at, _)| at));
        let directions = sent.map(|sent| sent.map_or(Vec3::Y, |(_, sample)| sample.direction));
        // A light may lie on a surface, which does not block it.
        let reaches = sent.map(|sent| sent.map_or(0.0, |(_, sample)| offset::REACH_OF_BOUNCE * sample.distance));
        let passed = self.rays.passed_before(&EightRays::new(origins, directions, active), reaches);
        from_fn(|i| {
            let (_, sample) = sent[i].filter(|_| passed[i] > 0.0)?;
            let cosine = sample.direction.dot(patch.normal());
            Some((sample.direction, sample.irradiance * (cosine * passed[i])))
        })
    }

    /// Halvings at which no node gets a larger share of the light's power than [`LARGEST_SHARE`]: solid angle times intensity (5.1).
    fn level_for(&self, light: &Light, patch: &Patch) -> u32 {
        let power = |square: Vec2| {
            let at = patch.point(square);
            let sample = light.sample(at, Vec2::splat(0.5))?;
            Some(sample.irradiance.max_element() * sample.direction.dot(patch.normal()).max(0.0))
        };
        // A grid may miss the narrow cone of a spot and the brightest place below a lamp.
        let to_plane = (patch.corner - light.position).dot(patch.normal());
        let along = light.forward().map(|forward| (forward, to_plane / forward.dot(patch.normal())));
        let aimed = along.filter(|(_, distance)| *distance > 0.0 && distance.is_finite());
        let aimed = aimed.map(|(forward, distance)| light.position + forward * distance);
        let brightest = [Some(light.position), aimed].into_iter().flatten();
        let on_patch = brightest.map(|point| patch.square_of(point).clamp(Vec2::ZERO, Vec2::ONE));
        let grid = (0..25).map(|i| Vec2::new((i % 5) as f32, (i / 5) as f32) / 4.0);
        let most = grid.chain(on_patch).filter_map(power).fold(0.0, f32::max);
        let share = most * patch.area / light.power_bound(patch.area.sqrt()).max(f32::MIN_POSITIVE);
        let halvings = 0.5 * (share / LARGEST_SHARE).max(1.0).log2();
        (halvings.ceil() as u32).min(self.levels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        brdf::BrdfModel,
        lights::Emission,
        material::Material,
        test_scenes::{floor, scene_of},
        wavelet::{
            operator::{Operator, TransportCoefficient},
            square::transform,
        },
    };

    /// All functions of a patch down to a level, with directions of one level.
    fn basis(level: u32, angle_level: u32) -> RadianceBasis {
        let of = |level: u32| {
            let mut smooth: Vec<_> = Node::all(level).zip((1..).map(|i: u16| f32::from(i))).collect();
            let mut functions = Vec::new();
            transform(&mut smooth, |function, _| functions.push(function));
            functions
        };
        let angles = of(angle_level);
        let all = of(level).into_iter().flat_map(|space| {
            angles.iter().map(move |&angle| RadianceFunction { patch: 0, space, angle }).collect::<Vec<_>>()
        });
        let coefficient = |function| TransportCoefficient { receiver: function, sender: function, value: Vec3::ONE };
        Operator::of(all.map(coefficient).collect()).0
    }

    /// A floor of a model.
    fn ground(model: BrdfModel) -> ReflectingPatch {
        let mut material = Material { model, ..Material::default() };
        material.parameters.set("roughness", 0.2);
        material.parameters.set("metalness", 1.0);
        let mut scene = scene_of(&floor(1.0, 0.0));
        scene.materials = vec![material];
        ReflectingPatch::of_scene(&scene).unwrap().remove(0)
    }

    fn projected(light: &Light, model: BrdfModel, blocker: bool) -> (RadianceBasis, Vec<Vec3>) {
        let ground = ground(model);
        let mut triangles = floor(1.0, 0.0).to_vec();
        if blocker {
            triangles.extend(floor(5.0, 0.3));
        }
        let rays = Intersector::new(&scene_of(&triangles).mesh);
        let basis = basis(5, ground.angle_level());
        let projection = DirectProjection { patches: &[ground], rays: &rays, offset: 1e-4, levels: 5 };
        let coefficients = projection.project(std::slice::from_ref(light), &basis);
        (basis, coefficients)
    }

    fn radiance(basis: &RadianceBasis, coefficients: &[Vec3], place: Vec2, direction: Vec2) -> f32 {
        let value = |(function, coefficient): (&RadianceFunction, &Vec3)| {
            function.space.at(place) * function.angle.at(direction) * coefficient.x / (4.0 * PI).sqrt()
        };
        basis.functions().iter().zip(coefficients).map(value).sum()
    }

    #[test]
    fn irradiance_of_a_lamp_comes_back() {
        let lamp = Light { position: Vec3::new(0.3, 1.0, -0.2), emission: Emission::Point, ..Light::default() };
        let (basis, coefficients) = projected(&lamp, BrdfModel::Lambert, false);
        let patch = ground(BrdfModel::Lambert).patch;
        for place in [Vec2::new(0.1, 0.9), Vec2::splat(0.5), Vec2::new(0.66, 0.4)] {
            let to = lamp.position - patch.point(place);
            let expected = to.y / to.length().powi(3);
            let found = PI * radiance(&basis, &coefficients, place, Vec2::splat(0.3));
            assert!((found / expected - 1.0).abs() < 0.06, "{found} for {expected}");
        }
        let (basis, coefficients) = projected(&lamp, BrdfModel::Lambert, true);
        assert_eq!(
            radiance(&basis, &coefficients, Vec2::splat(0.5), Vec2::splat(0.3)),
            0.0,
            "negative control: shadow"
        );
    }

    #[test]
    fn light_comes_from_where_the_lamp_is() {
        let lamp = Light { position: Vec3::new(0.0, 1.0, 0.0), emission: Emission::Point, ..Light::default() };
        let (basis, coefficients) = projected(&lamp, BrdfModel::Ggx, false);
        let (patch, place) = (ground(BrdfModel::Ggx).patch, Vec2::splat(0.6));
        let toward = patch.square_of_direction((lamp.position - patch.point(place)).normalize());
        let above = radiance(&basis, &coefficients, place, toward);
        let beside = radiance(&basis, &coefficients, place, Vec2::ONE - toward);
        assert!(above > 10.0 && beside.abs() < 0.01, "{above} {beside}");
        let mean = |coefficients: &[Vec3]| {
            let center = |i: u32| (Vec2::new((i % 16) as f32, (i / 16) as f32) + 0.5) / 16.0;
            (0..256).map(|i| radiance(&basis, coefficients, place, center(i))).sum::<f32>() / 256.0
        };
        let expected = 1.08_f32.powf(-1.5);
        assert!(
            (PI * mean(&coefficients) / expected - 1.0).abs() < 0.06,
            "{} for {expected}",
            PI * mean(&coefficients)
        );
        let higher = projected(&Light { position: 1.2 * Vec3::Y, ..lamp }, BrdfModel::Ggx, false).1;
        assert!((PI * mean(&higher) / expected - 1.0).abs() > 0.2, "negative control: a higher lamp");
    }

    #[test]
    fn a_narrow_cone_is_not_missed() {
        let lit = |target: Vec3| {
            let emission = Emission::Spot { cone_degrees: 3.0, penumbra_degrees: 1.0 };
            let spot = Light { position: Vec3::Y, target, emission, ..Light::default() };
            projected(&spot, BrdfModel::Lambert, false).1.iter().any(|value| *value != Vec3::ZERO)
        };
        assert!(lit(Vec3::new(0.33, 0.0, -0.21)));
        assert!(!lit(Vec3::new(4.0, 0.0, 0.0)), "negative control: aimed beside the floor");
    }
}
