//! Bounced light through the meshless basis. Direct light is sampled at the senders' points, and the transport operator adds
//! bounces. The result is evaluated at pixels for display, or at the surface sources as input of the bounce that cuts gather.

pub(crate) mod compared;
pub(crate) mod functions;
pub(crate) mod gloss;

use super::{irradiance::environment_irradiance_of, lit_points::LitPoints};
use crate::{
    appearance::narrowest_lobe,
    baked::Baked,
    light::{
        environment::EnvironmentLight,
        situation::{Changes, Relight, Situation},
    },
};
use functions::MeshlessLight;
use glam::{Mat3A, Vec3};
use gloss::LookingFunctions;
use lapidary_core::{
    dataset::Dataset,
    meshless::{Flattening, MeshlessBake, SenderSamples, Solution, SolveSettings, Solver, irradiance},
    offset,
    sources::Source,
    surfel::Surfel,
    transport::BounceEnergy,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Samples of an area light along each of its sides; a sender has several points.
const AREA_SAMPLES: u32 = 2;

/// Solves for the bounces of a dataset repeatedly and keeps results that an edit does not change.
pub struct MeshlessRig {
    baked: Baked,
    dataset: Arc<Dataset>,
    solver: Solver,
    samples: SenderSamples,
    /// Sender points under local lights.
    lit: LitPoints,
    /// Irradiance of the senders from the environment.
    environment: Option<Vec<Vec3>>,
    /// Weights of the surface sources, if the dataset has any; computed at the first use.
    at_sources: Option<Flattening>,
    solved: Option<Solution>,
    /// Radiance that the senders send after all bounces.
    sent: Vec<Vec3>,
    /// Rays of functions for glossy receivers; traced at the first use.
    looking: Option<LookingFunctions>,
    has_lobes: bool,
}

impl MeshlessRig {
    /// Starts with the baked materials and no light; `None` if the dataset has no meshless basis.
    pub fn new(baked: &Baked) -> Option<Self> {
        let dataset = baked.dataset.clone();
        let bake = dataset.meshless.as_deref()?;
        let normals = |sender: &Surfel| dataset.scene.mesh.shading_normal(sender);
        let solver = Solver::receiving_by(bake, bake.basis.sender_points().par_iter().map(normals).collect());
        let offset = offset::TRANSPORT * dataset.scene.mesh.bounds().diagonal();
        let intersector = baked.intersector();
        let is_free = |point: &Surfel, direction: Vec3, within: f32| {
            !intersector.occluded_before(point.position + point.normal * offset, direction, within)
        };
        let samples = SenderSamples::new(&bake.basis, &solver).by_openness(&bake.basis, is_free);
        let lit = LitPoints::new(baked, samples.points().to_vec(), AREA_SAMPLES).in_spatial_order();
        let (at_sources, solved, environment) = (None, None, None);
        let (baked, sent, looking, has_lobes) = (baked.clone(), Vec::new(), None, false);
        Some(Self { baked, dataset, solver, samples, lit, environment, at_sources, solved, sent, looking, has_lobes })
    }

    /// Light of all bounces, for any point.
    pub fn light(&mut self) -> MeshlessLight {
        let coefficients = self.solved().coefficients.clone();
        let light = MeshlessLight::new(&self.dataset, coefficients).expect("the dataset has a basis");
        if !self.has_lobes {
            return light;
        }
        let Self { baked, dataset, looking, sent, .. } = self;
        let basis = &bake(dataset).basis;
        let looking = looking.get_or_insert_with(|| LookingFunctions::new(baked, basis));
        light.arriving_from(looking.arriving(basis, sent))
    }

    /// Irradiance of all bounces at the surface sources.
    pub fn at_sources(&mut self, sources: &[Source]) -> Vec<Vec3> {
        self.solved();
        let Self { dataset, solved, at_sources, .. } = self;
        let MeshlessBake { basis, transport } = bake(dataset);
        let flattening = at_sources.get_or_insert_with(|| {
            let points: Vec<_> = sources.iter().map(|s| (s.surfel.position, s.surfel.normal)).collect();
            Flattening::new(basis, transport, &points)
        });
        let vectors = flattening.apply(&solved.as_ref().expect("it was solved").coefficients);
        let normal = |source: &Source| dataset.scene.mesh.shading_normal(&source.surfel);
        let received = |(vector, source): (&Mat3A, &Source)| irradiance(vector, normal(source)).max(Vec3::ZERO);
        vectors.par_iter().zip(sources).map(received).collect()
    }

    /// Energy of each bounce of the last solution; `None` if a change has not been solved for.
    pub fn energy(&self) -> Option<BounceEnergy> {
        self.solved.as_ref().map(Solution::energy)
    }

    fn solved(&mut self) -> &Solution {
        let Self { dataset, solver, samples, lit, environment, solved, sent, .. } = self;
        solved.get_or_insert_with(|| {
            let (mut direct, albedo) = samples.fit(solver, &lit.irradiance(), lit.albedo());
            let environment = environment.iter().flatten();
            direct.iter_mut().zip(environment).for_each(|(sum, part)| *sum += part);
            let emitted = samples.means(lit.emission());
            let solution =
                solver.solve_with_emission(bake(dataset), &direct, &albedo, &emitted, SolveSettings::default());
            *sent = solver.sent(&solution, &direct, &albedo, &emitted);
            solution
        })
    }
}

fn bake(dataset: &Dataset) -> &MeshlessBake {
    dataset.meshless.as_deref().expect("a rig is made with a basis")
}

impl Relight for MeshlessRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        self.lit.update((&situation.appearance, &situation.bouncing()), &situation.compute, changes);
        if changes.appearance {
            self.has_lobes = situation.appearance.materials.iter().any(|material| narrowest_lobe(material).is_finite());
        }
        if changes.environment {
            let senders = bake(&self.dataset).basis.sender_points();
            let shine = |lighting: &Arc<EnvironmentLight>| environment_irradiance_of(senders, &self.dataset, lighting);
            self.environment = situation.environment.as_ref().map(shine);
        }
        if changes.relight() {
            self.solved = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Appearance, Backend, BounceLight, BrdfSampling, Components, CpuBackend, Illumination, LocalLighting, LocalRig,
        Renderer, View,
        appearance::ResolvedAppearance,
        test_scenes::{Edited, LINK, from_above, illumination, linked, linked_floor_and_wall},
    };
    use lapidary_core::{
        camera::Camera,
        lights::Light,
        meshless::{Basis, FunctionPlace, Transport},
        sphere::{cosine_direction, frame_around},
        surfel::MeshPlace,
    };
    use std::f32::consts::FRAC_1_PI;

    fn lamp(intensity: f32) -> Arc<[Light]> {
        let position = Vec3::new(-1.0, 1.2, 0.1);
        [Light { position, intensity: Vec3::splat(intensity), ..Default::default() }].into()
    }

    fn basis_of(baked: &Baked) -> Edited<MeshlessRig> {
        Edited::new(baked, MeshlessRig::new(baked).expect("it has a basis"))
    }

    /// Vector irradiance on the upper side of a floor vertex.
    fn on_floor(rig: &mut Edited<MeshlessRig>) -> Mat3A {
        let light = rig.light();
        let mesh = &light.dataset().scene.mesh;
        let up = mesh.normals.iter().position(|n| *n == Vec3::Y).unwrap();
        light.at(&FunctionPlace::new(mesh.positions[up], Vec3::Y), false)
    }

    #[test]
    fn a_linked_wall_gives_the_floor_its_radiosity() {
        let baked = Baked::from(linked_floor_and_wall());
        let mut rig = basis_of(&baked);
        rig.set_lights(&lamp(3.0));
        let wall = baked.dataset.meshless.as_ref().unwrap().basis.points()[0].position;
        let to_light = lamp(3.0)[0].position - wall;
        let irradiance = 3.0 * to_light.x / to_light.length().powi(3);
        let albedo = ResolvedAppearance::from(Appearance::of(&baked.dataset.scene))
            .albedo(&baked.dataset.scene.mesh, rig.lit.points[0].place);
        let sent = albedo * irradiance * FRAC_1_PI;
        let found = rig.light();
        let mesh = &baked.dataset.scene.mesh;
        for (&position, &normal) in mesh.positions.iter().zip(&mesh.normals).filter(|(_, n)| **n == Vec3::Y) {
            let expected = LINK.dot(normal) * sent;
            let received = super::irradiance(&found.at(&FunctionPlace::new(position, normal), false), normal);
            assert!((received - expected).length() < 1e-3 * expected.length(), "{received} for {expected}");
        }
        let situation = rig.situation.clone();
        rig.update(&situation, Changes { gathering: true, ..Changes::NONE });
        assert!(rig.energy().is_some(), "the same light needs no other solution");
        rig.set_lights(&[]);
        assert!(rig.energy().is_none());
        assert!(on_floor(&mut rig) == Mat3A::ZERO, "negative control: no light");
    }

    #[test]
    fn a_linked_wall_that_shines_gives_the_floor_its_radiance() {
        let baked = Baked::from(linked_floor_and_wall());
        let mut rig = basis_of(&baked);
        let mut appearance = Appearance::of(&baked.dataset.scene);
        let wall = baked.dataset.scene.mesh.triangle_material[rig.lit.points[0].place.triangle as usize] as usize;
        appearance.materials[wall].parameters.set("emission_luminance", 2.5);
        rig.set_appearance(&appearance);
        let received = super::irradiance(&on_floor(&mut rig), Vec3::Y);
        let expected = Vec3::splat(2.5 * LINK.y);
        assert!((received - expected).length() < 1e-3 * expected.length(), "{received} for {expected}");
        rig.set_appearance(&Appearance::of(&baked.dataset.scene));
        assert!(on_floor(&mut rig) == Mat3A::ZERO, "negative control: no lamp");
    }

    #[test]
    fn senders_have_the_light_of_the_finer_points_under_them() {
        let mut dataset = linked_floor_and_wall();
        let meshless = Arc::make_mut(dataset.meshless.as_mut().unwrap());
        let [wall, floor] = [0, 1].map(|i| meshless.basis.points()[i]);
        let aside = |z: f32| Surfel { position: wall.position + Vec3::Z * z, ..wall };
        let finer = [-0.5, 0.5].map(aside);
        meshless.basis = Basis::new(&[vec![wall, floor], finer.to_vec()], 20.0, 1).unwrap();
        meshless.transport = Transport::from_rows(&[Vec::new(), vec![(0, LINK)], Vec::new(), Vec::new()], 2);
        let baked = Baked::from(dataset);
        let mut rig = basis_of(&baked);
        rig.set_lights(&lamp(3.0));
        let irradiance = |point: &Surfel| {
            let to_light = lamp(3.0)[0].position - point.position;
            3.0 * to_light.x / to_light.length().powi(3)
        };
        let mesh = &baked.dataset.scene.mesh;
        let reflected = ResolvedAppearance::from(Appearance::of(&baked.dataset.scene)).albedo(mesh, wall.place)
            * FRAC_1_PI
            * LINK.dot(Vec3::Y);
        let found = super::irradiance(&on_floor(&mut rig), Vec3::Y).x;
        // Only light from beyond a quarter of the functions' radius counts.
        let reach = 0.25 * baked.dataset.meshless.as_ref().unwrap().basis.radii()[0];
        let open = finer.map(|p| {
            let free = |i: &u32| {
                let direction = cosine_direction((*i as f32 + 0.5) / 32.0, (*i as f32 * 0.618_034).fract());
                let direction = frame_around(p.normal) * direction;
                !baked.intersector().occluded_before(p.position + 1e-4 * p.normal, direction, reach)
            };
            (0..32).filter(free).count() as f32
        });
        let mean = (open[0] * irradiance(&finer[0]) + open[1] * irradiance(&finer[1])) / (open[0] + open[1]);
        let expected = mean * reflected.x;
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected}");
        assert!((irradiance(&wall) * reflected.x / expected - 1.0).abs() > 0.02, "negative control: its own point");
    }

    #[test]
    fn the_environment_lights_the_senders() {
        let baked = Baked::from(linked_floor_and_wall());
        let mut rig = basis_of(&baked);
        let radiance = Vec3::new(1.0, 2.0, 0.5);
        let mesh = &baked.dataset.scene.mesh;
        let wall = baked.dataset.meshless.as_ref().unwrap().basis.points()[0];
        let mut under = |light: &Illumination| {
            rig.set_environment(Some(Renderer::new(baked.clone()).lighting(light, 256)));
            super::irradiance(&on_floor(&mut rig), Vec3::Y)
        };
        // Cosine-weighted light at the surrounding vertices that the floor does not block.
        let free = |vertex: u32, i: u32| {
            let direction = cosine_direction((i as f32 + 0.5) / 1024.0, (i as f32 * 0.618_034).fract());
            let origin = mesh.positions[vertex as usize] + 1e-4 * (wall.normal + Vec3::Y);
            u8::from(!baked.intersector().occluded(origin, frame_around(wall.normal) * direction))
        };
        let share = |vertex: u32| (0..1024).map(|i| f32::from(free(vertex, i))).sum::<f32>() / 1024.0;
        let open = mesh.triangles[wall.place.triangle as usize].map(share).iter().sum::<f32>() / 3.0;
        let albedo = ResolvedAppearance::from(Appearance::of(&baked.dataset.scene)).albedo(mesh, wall.place);
        let expected = open * albedo * radiance * LINK.dot(Vec3::Y);
        let found = under(&illumination([64, 32], |_, _| radiance));
        assert!((found / expected - 1.0).abs().max_element() < 0.05, "{found} for {expected}, {open}");
        // The wall faces +X; those directions are in the left half of the map.
        let behind = under(&illumination([64, 32], |x, _| radiance * f32::from(u8::from(x >= 32))));
        assert!(behind.max_element() < 0.02 * expected.max_element(), "negative control, from behind: {behind}");
        rig.set_environment(None);
        assert!(on_floor(&mut rig) == Mat3A::ZERO, "negative control: none");
    }

    #[test]
    fn further_bounces_arrive_by_smooth_normals() {
        const BACK: Vec3 = Vec3::new(0.3, -0.2, 0.1);
        // Both surfaces send. The light stands behind the wall and shines over it on the floor, so the wall receives only light
        // from the floor.
        let over_the_wall = Light { position: Vec3::new(-3.0, 5.0, 0.0), ..lamp(3.0)[0].clone() };
        let means = |wall_normal: Vec3| {
            let mut dataset = linked(Vec3::Y, LINK);
            let meshless = Arc::make_mut(dataset.meshless.as_mut().unwrap());
            meshless.transport = Transport::from_rows(&[vec![(1, BACK)], vec![(0, LINK)]], 2);
            dataset.scene.mesh.normals.iter_mut().filter(|n| **n == Vec3::X).for_each(|n| *n = wall_normal);
            let mut rig = basis_of(&Baked::from(dataset));
            rig.set_lights(std::slice::from_ref(&over_the_wall));
            rig.solved().mean_irradiance.clone()
        };
        let smooth = Vec3::new(0.8, -0.6, 0.0);
        let (by_face, by_smooth) = (means(Vec3::X), means(smooth));
        assert!(by_face[0] == by_smooth[0] && by_face[0].x > 0.0, "direct light on the floor alone");
        let (found, expected) = (by_smooth[1].x / by_face[1].x, BACK.dot(smooth) / BACK.dot(Vec3::X));
        assert!((found - expected).abs() < 1e-3 && expected > 1.1, "{found} for {expected}");
    }

    fn bounce_at_center(baked: &Baked, lighting: &LocalLighting, view: &View) -> Vec3 {
        let mut backend = CpuBackend::new();
        backend.set_scene(baked).unwrap();
        backend.set_local_lighting(lighting).unwrap();
        backend.begin(view, BrdfSampling::Refine).unwrap();
        backend.render_rows(0, 0..8).unwrap();
        backend.read(1).unwrap().0.pixels[27]
    }

    #[test]
    fn a_floor_whose_normals_point_away_is_lit_on_the_side_that_light_reaches() {
        let from_below =
            View { camera: Camera::look_at(Vec3::new(0.0, -6.0, 0.01), Vec3::ZERO, 30.0), ..from_above(8) };
        let shown = |normal: Vec3, view: &View| {
            let mut dataset = linked(normal, LINK * Vec3::new(1.0, normal.y, 1.0));
            dataset.two_sided.fill(true);
            let baked = Baked::from(dataset);
            let mut rig = Edited::new(&baked, LocalRig::new(&baked));
            rig.set_lights(&lamp(3.0));
            let indirect = Components { indirect: true, ..Components::NONE };
            let lighting = rig.lighting(indirect, crate::Solution::Meshless, 16);
            bounce_at_center(&baked, &lighting, view)
        };
        let above = shown(Vec3::Y, &from_above(8));
        let below = shown(Vec3::NEG_Y, &from_below);
        assert!(above.x > 0.0 && (below - above).length() < 1e-5 * above.length(), "{below} for {above}");
        assert_eq!(shown(Vec3::Y, &from_below), Vec3::ZERO, "negative control: no light below");
        assert_eq!(shown(Vec3::NEG_Y, &from_above(8)), Vec3::ZERO, "negative control: no light above");
    }

    #[test]
    fn pictures_show_it_times_the_albedo_and_only_changes_solve_again() {
        let baked = Baked::from(linked_floor_and_wall());
        let mut rig = Edited::new(&baked, LocalRig::new(&baked));
        let picture = |rig: &mut Edited<LocalRig>| {
            let indirect = Components { indirect: true, ..Components::NONE };
            let lighting = rig.lighting(indirect, crate::Solution::Meshless, 16);
            let Some(BounceLight::Functions(light)) = &lighting.bounce else { panic!("no functions") };
            (bounce_at_center(&baked, &lighting, &from_above(8)), light.clone())
        };
        rig.set_lights(&lamp(3.0));
        let (once, light) = picture(&mut rig);
        let (again, same) = picture(&mut rig);
        assert!(Arc::ptr_eq(&light, &same) && once == again);
        let floor = ResolvedAppearance::from(Appearance::of(&baked.dataset.scene))
            .albedo(&baked.dataset.scene.mesh, MeshPlace::default());
        let received = super::irradiance(&light.at(&FunctionPlace::new(Vec3::ZERO, Vec3::Y), false), Vec3::Y);
        let expected = floor * received * FRAC_1_PI;
        assert!((once - expected).length() < 1e-4 * expected.length() && once.x > 0.0, "{once} for {expected}");
        rig.set_lights(&lamp(6.0));
        let (twice, other) = picture(&mut rig);
        assert!(!Arc::ptr_eq(&light, &other) && (twice - 2.0 * once).length() < 1e-4 * once.length());
    }
}
