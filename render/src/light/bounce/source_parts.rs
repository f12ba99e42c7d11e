//! Points spread over the surface that each source represents. A shadow edge, a close lamp or a pattern may cross that surface, and
//! the source sends the mean.

use glam::Vec3;
use lapidary_core::{
    ray::Intersector,
    sources::Source,
    surfel::{Surfel, distance::distance},
};
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, PI};

/// Points per source.
pub(super) const PARTS: usize = 4;

/// [`PARTS`] surface points for each source. Rays start `offset` meters off the surface.
pub(super) fn source_parts(sources: &[Source], intersector: &Intersector, offset: f32) -> Vec<Surfel> {
    let parts = |(i, source): (usize, &Source)| {
        let place = move |part| place_of_part((i, source), part, intersector, offset);
        (0..PARTS).map(place).collect::<Vec<_>>()
    };
    sources.par_iter().enumerate().with_min_len(64).flat_map_iter(parts).collect()
}

/// The surface point beneath a position in the source's disc. It is the source's own point if the position is behind a wall, above
/// another surface, or above none.
fn place_of_part(
    (source_index, source): (usize, &Source),
    part: usize,
    intersector: &Intersector,
    offset: f32,
) -> Surfel {
    let Surfel { position, normal, .. } = source.surfel;
    let radius = (source.area * FRAC_1_PI).sqrt();
    let (u, v) = normal.any_orthonormal_pair();
    // A square with the variance of the disc, rotated per source so that neighbors do not align.
    let golden_angle = PI * (3.0 - 5.0_f32.sqrt());
    let (sin, cos) = (golden_angle * (source_index % 4096) as f32 + 0.5 * PI * part as f32).sin_cos();
    let lift = normal * (0.5 * radius + offset);
    let above = position + (u * cos + v * sin) * (radius * FRAC_1_SQRT_2) + lift;
    let is_open = !intersector.occluded_between(position + normal * offset, above);
    let found = is_open.then(|| intersector.surfel_above(above, -normal, radius + 2.0 * offset, |_| 0.0)).flatten();
    found.filter(|place| distance(place, &source.surfel) < 2.0 * radius).unwrap_or(source.surfel)
}

/// Means of [`PARTS`] values per source.
pub(super) fn means(parts: impl Iterator<Item = Vec3>) -> Vec<Vec3> {
    let values: Vec<Vec3> = parts.collect();
    values.chunks(PARTS).map(|parts| parts.iter().sum::<Vec3>() / PARTS as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::floor_and_wall;
    use lapidary_core::scene::Mesh;

    #[test]
    fn parts_lie_in_their_source_s_surface_around_it() {
        let dataset = floor_and_wall(4);
        let sources = &dataset.indirect.as_ref().unwrap().sources;
        let intersector = Intersector::new(&dataset.scene.mesh);
        let parts = source_parts(sources, &intersector, 1e-5);
        assert_eq!(parts.len(), PARTS * sources.len());
        for (source, parts) in sources.iter().zip(parts.chunks(PARTS)) {
            let at = source.surfel.position;
            let radius = (source.area * FRAC_1_PI).sqrt();
            let mean = parts.iter().map(|p| p.position - at).sum::<Vec3>() / PARTS as f32;
            assert!(mean.length() < 1e-3 * radius, "{mean}");
            for part in parts {
                let offset = part.position - at;
                assert!(offset.dot(source.surfel.normal).abs() < 1e-5 && part.normal.dot(source.surfel.normal) > 0.999);
                assert!((offset.length() / radius - FRAC_1_SQRT_2).abs() < 1e-2, "{offset}");
            }
        }
    }

    /// A floor from -1 to 1 with a wall over its middle line.
    fn parted_floor() -> Intersector {
        let quads = [
            [
                Vec3::new(-1.0, 0.0, -1.0),
                Vec3::new(-1.0, 0.0, 1.0),
                Vec3::new(1.0, 0.0, 1.0),
                Vec3::new(1.0, 0.0, -1.0),
            ],
            [Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 1.0, -1.0), Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, 0.0, 1.0)],
        ];
        let positions = quads.concat();
        Intersector::new(&Mesh {
            positions,
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Mesh::default()
        })
    }

    #[test]
    fn what_lies_behind_a_wall_or_beyond_a_rim_is_no_part() {
        let scene = parted_floor();
        let source = |x: f32, area: f32| Source {
            surfel: Surfel { position: Vec3::new(x, 0.0, 0.1), ..Default::default() },
            area,
            spacing: area.sqrt(),
        };
        let at_center = |x: f32, area: f32| {
            let source = source(x, area);
            let parts = source_parts(&[source], &scene, 1e-5);
            parts.iter().filter(|p| p.position.distance(source.surfel.position) < 1e-4).count()
        };
        assert!((1..PARTS).contains(&at_center(0.999, 0.01)), "beyond the rim");
        assert!((1..PARTS).contains(&at_center(0.001, 0.01)), "behind the wall");
        assert_eq!(at_center(0.5, 0.01), 0, "negative control: in the open");
        assert_eq!(at_center(0.5, 0.0), PARTS, "no area");
    }
}
