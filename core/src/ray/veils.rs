//! Surfaces that let light through, kept apart from opaque ones: few rays meet them, and only those pay for them.

use super::{DirectionSet, Hit, Intersector, OPEN, triangle::TriangleFrom};
use crate::{
    mesh::Mesh,
    opacity::{Opacities, Opacity, chance},
    surfel::MeshPlace,
    texture::UvSet,
};
use glam::{Vec2, Vec3};
use obvhs::ray::Ray;
use std::collections::HashMap;

/// Thin surfaces: those whose materials let light through anywhere.
pub(super) struct Veils {
    pub surfaces: Intersector,
    /// The leaf of each triangle.
    leaf_of: HashMap<u32, u32>,
    /// Corners of each leaf triangle.
    corners: Vec<Corners>,
    /// Per material.
    opacities: Vec<Option<Opacity>>,
}

/// Attributes for the opacity lookup at points of a triangle.
struct Corners {
    /// Of both sets.
    uvs: [[Vec2; 3]; 2],
    material: u32,
}

impl Veils {
    /// The surfaces of a mesh whose materials have an opacity in `thin`.
    pub fn new(mesh: &Mesh, surfaces: Intersector, material: impl Fn(u32) -> u32, thin: &[Option<Opacity>]) -> Self {
        let of_leaf = |&t: &u32| {
            let uvs = |set| mesh.triangles[t as usize].map(|v| mesh.uv_set(set)[v as usize]);
            Corners { uvs: [uvs(UvSet::First), uvs(UvSet::Second)], material: material(t) }
        };
        let corners = surfaces.leaf_ids.iter().map(of_leaf).collect();
        let leaf_of = surfaces.leaf_ids.iter().copied().zip(0..).collect();
        Self { surfaces, leaf_of, corners, opacities: thin.to_vec() }
    }

    /// Takes other opacities, if the same materials stay thin. Returns whether it did.
    pub fn take(&mut self, thin: Vec<Option<Opacity>>) -> bool {
        let are_same = thin.iter().map(Option::is_some).eq(self.opacities.iter().map(Option::is_some));
        if are_same {
            self.opacities = thin;
        }
        are_same
    }

    /// Whether a ray ends at its hit on a leaf triangle: if the opacity is above `threshold`.
    pub fn stop(&self, leaf: usize, hit: &Hit, threshold: impl Fn(u32) -> f32) -> bool {
        let opacity = self.opacity(leaf, hit.barycentric);
        // A threshold may be rounded to 1.
        opacity >= 1.0 || opacity > threshold(self.surfaces.leaf_ids[leaf])
    }

    /// Share of the light that a leaf triangle stops at a point.
    fn opacity(&self, leaf: usize, barycentric: Vec2) -> f32 {
        let Corners { uvs, material } = self.corners[leaf];
        let at = uvs.map(|[a, b, c]| a + (b - a) * barycentric.x + (c - a) * barycentric.y);
        self.opacities[material as usize].as_ref().map_or(1.0, |opacity| opacity.at(at))
    }

    /// Share of the light that passes all thin surfaces along a ray before `distance`, in lengths of `direction`.
    fn transmittance(&self, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
        let mut passed = 1.0_f32;
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        self.surfaces.bvh.ray_traverse_miss(ray, |_, leaf| {
            let triangle = TriangleFrom::unless_missed(origin, self.surfaces.leaf_triangles[leaf], direction);
            if let Some(hit) =
                triangle.and_then(|triangle| triangle.hit(direction)).filter(|hit| hit.distance < distance)
            {
                passed *= 1.0 - self.opacity(leaf, hit.barycentric);
            }
            if passed > 0.0 { f32::INFINITY } else { 0.0 }
        });
        passed
    }
}

/// A random threshold of opacity for each ray and triangle: rays stop at thin surfaces as often as these stop light.
pub(super) fn any_threshold(origin: Vec3, direction: Vec3) -> impl Fn(u32) -> f32 {
    let [[x, y, z], [u, v, w]] = [origin, direction].map(|vector| vector.to_array().map(f32::to_bits));
    move |triangle| chance(&[x, y, z, u, v, w, triangle])
}

impl Intersector {
    /// Takes other opacities of the same materials, unless that changes which surfaces are thin. Returns whether it did.
    pub fn take_opacities(&mut self, opacities: &Opacities) -> bool {
        let thin = opacities.thin();
        match &mut self.veils {
            Some(veils) => veils.take(thin),
            None => thin.iter().all(Option::is_none),
        }
    }

    /// Whether any surface lets light through.
    pub fn has_veils(&self) -> bool {
        self.veils.is_some()
    }

    /// Share of the light that passes along a ray, 0 to 1.
    pub fn transmittance(&self, origin: Vec3, direction: Vec3) -> f32 {
        if self.occluded(origin, direction) { 0.0 } else { self.past_veils(origin, direction, f32::INFINITY) }
    }

    /// Share of the light that passes along a ray before `distance` meters, 0 to 1.
    pub fn transmittance_before(&self, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
        if self.occluded_before(origin, direction, distance) {
            0.0
        } else {
            self.past_veils(origin, direction, distance)
        }
    }

    /// Share of the light that passes strictly between two points, 0 to 1. Both lie off any surface.
    pub fn transmittance_between(&self, from: Vec3, to: Vec3) -> f32 {
        if self.occluded_between(from, to) { 0.0 } else { self.past_veils_between(from, to) }
    }

    /// Share of the light that passes the thin surfaces alone between two points.
    pub fn past_veils_between(&self, from: Vec3, to: Vec3) -> f32 {
        self.past_veils(from, to - from, 1.0)
    }

    /// Whether light passes between two points; by chance where thin surfaces pass a share.
    pub fn lets_through_by_chance(&self, from: Vec3, to: Vec3) -> bool {
        self.transmittance_between(from, to) > any_threshold(from, to - from)(0)
    }

    /// Share of the light that a point of the mesh stops.
    pub fn opacity_at(&self, place: MeshPlace) -> f32 {
        self.veils.as_ref().map_or(1.0, |veils| {
            veils.leaf_of.get(&place.triangle).map_or(1.0, |&leaf| veils.opacity(leaf as usize, place.barycentric))
        })
    }

    /// Share of the light that passes the thin surfaces before `distance`, in lengths of `direction`.
    pub fn past_veils(&self, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
        self.veils.as_ref().map_or(1.0, |veils| veils.transmittance(origin, direction, distance))
    }

    /// Multiplies `visible`, the result of [`Self::trace_batch`] or a boundary tracer for the directions of `wanted`,
    /// by the share of light that passes the thin surfaces.
    pub fn attenuate(
        &self,
        origin: Vec3,
        directions: &DirectionSet,
        wanted: impl Fn(Vec3) -> bool,
        visible: &mut [u8],
    ) {
        let Some(veils) = &self.veils else { return };
        let mut clear = vec![0; visible.len()];
        veils.surfaces.trace_batch(origin, directions, |_, d| wanted(d), &mut clear);
        directions.each(|i, direction| {
            if visible[i] != 0 && clear[i] == 0 && wanted(direction) {
                let passed = veils.transmittance(origin, direction, f32::INFINITY);
                visible[i] = (passed * f32::from(OPEN)).round() as u8;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{material::Material, sphere::fibonacci_directions, texture::TextureSlot};

    /// A triangle that faces up, around the y axis.
    fn triangle(y: f32, side: f32) -> [Vec3; 3] {
        [Vec3::new(-side, y, side), Vec3::new(side, y, side), Vec3::new(0.0, y, -2.0 * side)]
    }

    /// Stacked triangles, each with a material of some opacity; the last one has a hole where u > 0.5.
    fn stack(opacities: &[f32]) -> (Mesh, Opacities) {
        let triangles = (1..=opacities.len() as u32).map(|i| triangle(i as f32, 2.0));
        let positions: Vec<Vec3> = triangles.flatten().collect();
        let count = opacities.len() as u32;
        let mesh = Mesh {
            uvs: positions.iter().map(|p| Vec2::new(0.25 * p.x + 0.5, 0.25)).collect(),
            triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            triangle_material: (0..count).collect(),
            triangle_object: vec![0; opacities.len()],
            positions,
            ..Mesh::default()
        };
        let material = |&opacity: &f32| {
            let mut material = Material::default();
            material.parameters.set("geometry_opacity", opacity);
            material
        };
        let mut materials: Vec<Material> = opacities.iter().map(material).collect();
        let checker = crate::texture::Procedural::default();
        let slot = TextureSlot { procedural: Some(checker), ..Default::default() };
        if let Some(last) = materials.last_mut() {
            last.maps.set("geometry_opacity", Some(slot));
        }
        (mesh, Opacities::of(&materials, &[]))
    }

    #[test]
    fn holes_lie_where_their_set_of_texture_coordinates_has_them() {
        let (mut mesh, _) = stack(&[1.0]);
        // The second set has the holes where the first has none.
        mesh.second_uvs = mesh.uvs.iter().map(|uv| Vec2::new(1.0 - uv.x, uv.y)).collect();
        let passes = |uv_set| {
            let slot = TextureSlot { procedural: Some(Default::default()), uv_set, ..Default::default() };
            let mut material = Material::default();
            material.maps.set("geometry_opacity", Some(slot));
            let scene = Intersector::with_opacities(&mesh, &Opacities::of(&[material], &[]));
            AT.map(|at| scene.transmittance(at, Vec3::Y))
        };
        let [[a, b], [c, d]] = [UvSet::First, UvSet::Second].map(passes);
        assert!(a != b && (a - d).abs() < 1e-5 && (b - c).abs() < 1e-5, "{a} {b} {c} {d}");
    }

    const AT: [Vec3; 2] = [Vec3::new(-0.3, 0.0, 0.1), Vec3::new(0.3, 0.0, 0.1)];

    #[test]
    fn light_passes_in_proportion_through_all_that_lies_between() {
        let (mesh, opacities) = stack(&[0.25, 0.5, 0.8]);
        let scene = Intersector::with_opacities(&mesh, &opacities);
        let last = AT.map(|at| scene.transmittance(at + 2.5 * Vec3::Y, Vec3::Y));
        assert!(
            [1.0, 0.2].map(|share| last.iter().any(|t: &f32| (t - share).abs() < 1e-5)) == [true; 2],
            "a hole and a pane: {last:?}"
        );
        for (at, last) in AT.into_iter().zip(last) {
            let expected = [(0.5, 1.0), (1.5, 0.75), (2.5, 0.375), (3.5, 0.375 * last)];
            for (height, expected) in expected {
                let [before, between] = [
                    scene.transmittance_before(at, Vec3::Y, height),
                    scene.transmittance_between(at, at + height * Vec3::Y),
                ];
                assert!((before - expected).abs() < 1e-5 && (between - expected).abs() < 1e-5, "{before} {between}");
            }
            assert!(!scene.occluded(at, Vec3::Y), "nothing stops all of it");
        }
        assert!(Intersector::new(&mesh).occluded(AT[0], Vec3::Y), "negative control: without opacities");
    }

    #[test]
    fn what_stops_all_light_hides_what_lets_some_through() {
        let (mesh, opacities) = stack(&[0.5, 1.0, 0.5]);
        let scene = Intersector::with_opacities(&mesh, &opacities);
        assert!(scene.has_veils() && scene.occluded(AT[0], Vec3::Y));
        assert_eq!(scene.transmittance(AT[0], Vec3::Y), 0.0);
        assert_eq!(scene.transmittance_before(AT[0], Vec3::Y, 1.5), 0.5);
        let met = |threshold: f32| scene.closest_above(AT[0], Vec3::Y, |_| threshold).unwrap().triangle;
        assert_eq!([0.0, 0.49, 0.5, 0.9].map(met), [0, 0, 1, 1]);
    }

    #[test]
    fn whole_sets_and_eights_of_rays_agree_with_single_ones() {
        let (mesh, opacities) = stack(&[0.25, 0.5, 0.8]);
        let scene = Intersector::with_opacities(&mesh, &opacities);
        let (origin, directions) = (Vec3::new(0.1, 0.2, 0.0), fibonacci_directions(2048));
        let set = DirectionSet::new(&directions);
        let upward = |d: Vec3| d.y > 0.1;
        let mut visible = vec![0; directions.len()];
        scene.trace_batch(origin, &set, |_, d| upward(d), &mut visible);
        assert!(directions.iter().zip(&visible).all(|(&d, &v)| v == if upward(d) { OPEN } else { 0 }));
        scene.attenuate(origin, &set, upward, &mut visible);
        let single = |&d: &Vec3| if upward(d) { (scene.transmittance(origin, d) * 255.0).round() as u8 } else { 0 };
        assert_eq!(visible, directions.iter().map(single).collect::<Vec<u8>>());
        assert!(visible.iter().filter(|&&v| v != 0 && v != OPEN).count() > 200);

        let eights = crate::ray::in_eights(directions.iter().copied());
        let hits = scene.closest_hits(origin, &eights);
        let surfels = scene.surfels_before(origin, &eights, 2.5);
        for (i, &direction) in directions.iter().enumerate() {
            let hit = scene.closest_hit(origin, direction);
            assert_eq!(hits[i / 8][i % 8], hit);
            assert_eq!(surfels[i / 8][i % 8], scene.surfel_before(origin, direction, 2.5));
        }
    }

    #[test]
    fn rays_stop_as_often_as_light_is_stopped() {
        let (mesh, opacities) = stack(&[0.25, 0.5, 1.0]);
        let scene = Intersector::with_opacities(&mesh, &opacities);
        let directions: Vec<Vec3> = fibonacci_directions(400_000).into_iter().filter(|d| d.y > 0.98).collect();
        let mut met = [0.0; 3];
        for &direction in &directions {
            if let Some(hit) = scene.closest_hit(Vec3::new(-0.4, 0.0, 0.0), direction) {
                met[hit.triangle as usize] += 1.0 / directions.len() as f32;
            }
        }
        assert!((met[0] - 0.25).abs() < 0.02 && (met[1] - 0.375).abs() < 0.02, "{met:?}");
    }

    #[test]
    fn cones_and_rays_through_thin_surfaces_are_neither_open_nor_closed() {
        use crate::ray::{EightCones, EightRays, SeenThrough};
        for (opacities, closed) in [(&[0.5][..], 0), (&[1.0, 0.5], 0xf)] {
            let (mesh, opacities) = stack(opacities);
            let scene = Intersector::with_opacities(&mesh, &opacities);
            // Four below the triangles, four beside them.
            let origins = [0.0, 0.1, 0.2, 0.3, 10.0, 11.0, 12.0, 13.0].map(|x| Vec3::new(x, 0.0, 0.0));
            let cones = EightCones { origins, axis: Vec3::Y, sine: 0.01, active: 0xff };
            let rays = EightRays::new(origins, [Vec3::Y; 8], 0xff);
            let expected = SeenThrough { open: 0xf0, closed };
            assert_eq!((scene.seen_through(&cones), scene.has_veils()), (expected, true));
            assert_eq!(scene.seen_before(&rays, [f32::INFINITY; 8]), expected);
            let all_open = SeenThrough { open: 0xff, closed: 0 };
            assert_eq!(scene.seen_before(&rays, [0.5; 8]), all_open, "negative control: before the triangles");
            let passed = scene.passed_before(&EightRays::new(origins, [Vec3::Y; 8], 0x7f), [f32::INFINITY; 8]);
            let mut alone = origins.map(|origin| scene.transmittance(origin, Vec3::Y));
            assert!(closed != 0 || (0.0..1.0).contains(&alone[1]) && alone[4] == 1.0, "{alone:?}");
            alone[7] = 0.0;
            assert_eq!(passed, alone, "as one by one; the last is inactive");
            assert_eq!(scene.passed_before(&rays, [0.5; 8]), [1.0; 8], "negative control: before the triangles");
        }
    }
}
