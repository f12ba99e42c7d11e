//! Direct transport against known form factors, closed rooms and reflectances.

use super::*;
use crate::{
    observer::Silent,
    test_scenes::{cuboid, floor, quad, room, scene_of},
};
use lapidary_core::{
    brdf::{BrdfModel, SurfaceBrdf},
    material::{Material, ResolvedMaterial},
    mesh::Mesh,
    wavelet::{patch::patches, picture::PatchTexture, series::GlobalTransport, square::transform},
};

/// The BRDF of a gray material of a model.
fn brdf(model: BrdfModel, parameters: &[(&'static str, f32)], color: f32) -> SurfaceBrdf {
    let mut material = Material { model, ..Material::default() };
    material.parameters.set("base_color", Vec3::splat(color));
    parameters.iter().for_each(|&(name, value)| material.parameters.set(name, value));
    ResolvedMaterial::from(&material).at(Vec3::ONE, |_| glam::Vec4::ONE).brdf
}

fn diffuse(reflectance: f32) -> SurfaceBrdf {
    brdf(BrdfModel::Lambert, &[], reflectance)
}

struct Transported {
    patches: Vec<Patch>,
    reflecting: Vec<ReflectingPatch>,
    basis: RadianceBasis,
    operator: Operator,
}

impl Transported {
    /// The patches take the BRDFs in turn.
    fn of(mesh: &Mesh, rays: &Intersector, brdfs: &[&SurfaceBrdf], settings: &TransportSettings) -> Self {
        let patches = patches(mesh).unwrap();
        let brdfs = brdfs.iter().cycle().map(|&brdf| brdf.clone());
        let reflecting: Vec<_> =
            patches.iter().zip(brdfs).map(|(patch, brdf)| ReflectingPatch::new(*patch, brdf)).collect();
        let offset = 1e-5 * mesh.bounds().diagonal();
        let (basis, operator) = direct_transport(&reflecting, &|_| true, rays, offset, settings, &Silent).unwrap();
        Self { patches, reflecting, basis, operator }
    }

    fn new(triangles: &[[Vec3; 3]], brdfs: &[&SurfaceBrdf]) -> Self {
        let mesh = scene_of(triangles).mesh;
        Self::of(&mesh, &Intersector::new(&mesh), brdfs, &TransportSettings::DEFAULT)
    }

    fn constant(&self, patch: u32) -> Option<usize> {
        let function = RadianceFunction { patch, space: Function::CONSTANT, angle: Function::CONSTANT };
        self.basis.index_of(&function).map(|index| index as usize)
    }

    /// Radiance of one from everywhere.
    fn ones(&self) -> Vec<Vec3> {
        let mut ones = vec![Vec3::ZERO; self.operator.functions()];
        for (i, patch) in self.patches.iter().enumerate() {
            if let Some(index) = self.constant(i as u32) {
                ones[index] = Vec3::splat((PI * patch.area).sqrt());
            }
        }
        ones
    }

    /// Radiance of one on a patch from a part of the directions.
    fn light_from(&self, patch: u32, part: Node) -> Vec<Vec3> {
        let mut light = vec![Vec3::ZERO; self.operator.functions()];
        let norm = (PI * self.patches[patch as usize].area).sqrt() * part.side();
        transform(&mut vec![(part, norm)], |angle, value| {
            let function = RadianceFunction { patch, space: Function::CONSTANT, angle };
            if let Some(index) = self.basis.index_of(&function) {
                light[index as usize] = Vec3::splat(value);
            }
        });
        light
    }

    /// Mean radiance that arrives at each patch.
    fn means(&self, light: &[Vec3]) -> Vec<f32> {
        let mean = |(i, patch): (usize, &Patch)| {
            self.constant(i as u32).map_or(0.0, |index| light[index].x / (PI * patch.area).sqrt())
        };
        self.patches.iter().enumerate().map(mean).collect()
    }

    /// Form factor from one patch to another of reflectance one.
    fn form_factor(&self, from: u32, to: u32) -> f32 {
        let [receiver, sender] = [from, to].map(|patch| self.constant(patch).unwrap());
        let column = self.operator.column(sender);
        let value = column.iter().find(|(index, _)| *index as usize == receiver).unwrap().1.x;
        let [a, b] = [from, to].map(|patch| self.patches[patch as usize].area);
        value * (b / a).sqrt()
    }
}

/// A floor below a ceiling that faces it.
fn parallel(half: f32, other: f32, height: f32) -> Vec<[Vec3; 3]> {
    let down = floor(other, height).map(|[a, b, c]| [a, c, b]);
    [floor(half, 0.0), down].concat()
}

#[test]
fn parallel_squares_send_each_other_their_form_factor() {
    let near = Transported::new(&parallel(0.5, 0.5, 1.0), &[&diffuse(1.0)]);
    let found = near.form_factor(0, 1);
    assert!((found / 0.1998 - 1.0).abs() < 0.01, "{found}");
    let far = Transported::new(&parallel(0.5, 0.5, 1.1), &[&diffuse(1.0)]).form_factor(0, 1);
    assert!((far / 0.1998 - 1.0).abs() > 0.05, "negative control: farther, {far}");
}

#[test]
fn areas_times_form_factors_are_equal_both_ways() {
    let pair = Transported::new(&parallel(0.3, 0.8, 0.5), &[&diffuse(1.0)]);
    let [up, down] = [pair.form_factor(0, 1), pair.form_factor(1, 0)];
    let [a, b] = [0, 1].map(|patch| pair.patches[patch].area);
    assert!((a * up / (b * down) - 1.0).abs() < 0.01, "{up} {down}");
    assert!((up / down - 1.0).abs() > 0.5, "negative control: without areas");
}

/// A closed room with a box in it.
fn furnished() -> Mesh {
    scene_of(
        &[room(Vec3::ZERO, Vec3::new(1.0, 0.7, 1.2)), cuboid(Vec3::new(0.2, -0.2, 0.1), Vec3::splat(0.25))].concat(),
    )
    .mesh
}

#[test]
fn in_a_closed_room_one_bounce_of_light_from_everywhere_is_the_reflectance() {
    let (mesh, r) = (furnished(), 0.6);
    let largest_error = |rays: &Intersector| {
        let room = Transported::of(&mesh, rays, &[&diffuse(r)], &TransportSettings::DEFAULT);
        let once = room.means(&room.operator.apply(&room.ones()));
        once.iter().map(|mean| (mean / r - 1.0).abs()).fold(0.0, f32::max)
    };
    let found = largest_error(&Intersector::new(&mesh));
    assert!(found < 0.01, "{found}");
    let through = largest_error(&Intersector::new(&scene_of(&floor(0.1, -9.0)).mesh));
    assert!(through > 0.05, "negative control: no visibility, {through}");
}

#[test]
fn all_bounces_in_a_closed_room_are_a_geometric_series() {
    let mesh = furnished();
    let room = Transported::of(&mesh, &Intersector::new(&mesh), &[&diffuse(0.5)], &TransportSettings::DEFAULT);
    let all = GlobalTransport::of(&room.operator, 1e-5);
    let means = room.means(&all.operator.apply(&room.ones()));
    let error = means.iter().map(|mean| (mean / 2.0 - 1.0).abs()).fold(0.0, f32::max);
    assert!(error < 0.01, "{means:?}");
    assert!(all.coefficients.last() < all.coefficients.first(), "compression ends it: {:?}", all.coefficients);
    let back: Vec<Vec3> = {
        let light = all.operator.apply(&room.ones());
        light.iter().zip(room.operator.apply(&light)).map(|(light, reflected)| *light - reflected).collect()
    };
    let mean = room.means(&back).into_iter().map(|mean| (mean - 1.0).abs()).fold(0.0, f32::max);
    assert!(mean < 0.01, "(I - T) G = I: {mean}");
}

#[test]
fn a_glossy_floor_sends_light_on_where_its_lobe_goes() {
    // Light from a quarter of the directions on a floor, on its way to a diffuse wall beside it.
    let glossy = glossy();
    let found = Transported::new(&corner(), &[&glossy, &diffuse(0.5)]);
    let of_quarters: Vec<[f32; 2]> = Node::ROOT
        .children()
        .into_iter()
        .map(|quarter| {
            let arriving = found.means(&found.operator.apply(&found.light_from(0, quarter)))[1];
            [arriving, arriving_by_chance(&found.patches, &glossy, quarter)]
        })
        .collect();
    let most = of_quarters.iter().map(|[_, expected]| *expected).fold(0.0, f32::max);
    let error = of_quarters.iter().map(|[found, expected]| (found - expected).abs() / most).fold(0.0, f32::max);
    assert!(error < 0.03, "{of_quarters:?}");
    let least = of_quarters.iter().map(|[_, expected]| *expected).fold(f32::INFINITY, f32::min);
    assert!(least < 0.5 * most, "negative control: directions matter, {of_quarters:?}");
}

/// A floor and a wall beside it.
fn corner() -> Vec<[Vec3; 3]> {
    let p = |y: f32, z: f32| Vec3::new(0.5, y, z);
    [floor(0.5, 0.0), quad(p(0.0, -0.5), p(0.0, 0.5), p(1.0, 0.5), p(1.0, -0.5))].concat()
}

fn glossy() -> SurfaceBrdf {
    brdf(BrdfModel::Ggx, &[("roughness", 0.55), ("metalness", 1.0)], 0.9)
}

#[test]
fn light_arrives_at_a_glossy_wall_from_where_the_floor_is() {
    let found = Transported::new(&corner(), &[&diffuse(0.5), &glossy()]);
    let light = found.operator.apply(&found.light_from(0, Node::ROOT));
    let arriving =
        &PatchTexture::all(&found.reflecting, &vec![Vec::new(); found.reflecting.len()], &found.basis, &light)[1];
    let place = Vec2::new(0.4, 0.3);
    let (wall, cells) = (&found.reflecting[1], found.reflecting[1].cells);
    let radiance = arriving.at(place);
    let (mut shown, mut beside) = (0, 0);
    for (cell, value) in radiance.iter().enumerate() {
        let direction = wall.patch.frame * cells.direction_of(cell);
        let at = wall.patch.point(place);
        let on_floor = at - direction * (at.y / direction.y);
        let margin = 0.5 - on_floor.x.abs().max(on_floor.z.abs());
        // Cells across the edge of the floor, and nodes larger than the cells, blur it.
        if direction.y < -0.1 && margin > 0.2 {
            shown += 1;
            assert!((value.x / 0.5 - 1.0).abs() < 0.25, "{direction}: {value}");
        } else if direction.y > 0.1 {
            beside += 1;
            assert!(value.x.abs() < 0.02, "{direction}: {value}");
        }
    }
    assert!(shown > 2 && beside > 10, "negative control: {shown} cells of the floor, {beside} of nothing");
}

/// Mean over the second patch of radiance from the first, which light of one from a part of the directions meets: the mean of random
/// points.
fn arriving_by_chance(patches: &[Patch], brdf: &SurfaceBrdf, part: Node) -> f32 {
    let mut rng = fastrand::Rng::with_seed(3);
    let mut square = || Vec2::new(rng.f32(), rng.f32());
    let [from, to] = [&patches[0], &patches[1]];
    let samples = 200_000;
    let one = |_| {
        let (a, b) = (from.point(square()), to.point(square()));
        let direction = (b - a).normalize();
        let cosines = direction.dot(from.normal()) * -direction.dot(to.normal());
        let wo = from.frame.transpose() * direction;
        let wi = from.frame.transpose() * from.direction(part.point(square()));
        let reflected = PI * brdf.as_brdf().brdf_cos(wi, wo).x / wi.z.max(1e-4) * part.side() * part.side();
        reflected * cosines / (b - a).length_squared() * from.area / PI
    };
    (0..samples).map(one).map(f64::from).sum::<f64>() as f32 / samples as f32
}
