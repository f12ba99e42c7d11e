//! Bounds of objects and of parts.

use lapidary_core::{bounds::Bounds, parts::Part, scene::Mesh};

/// Bounds of a part, as [`object_bounds`].
pub fn part_bounds(mesh: &Mesh, part: Part) -> Option<Bounds> {
    bounds_of(mesh, part.object, |triangle| mesh.triangle_material[triangle] == part.material)
}

/// Bounds of an object's triangles; `None` if it has none. The endless ground has the bounds of the rest of the scene. Takes a pass
/// over the whole mesh: keep the result.
pub fn object_bounds(mesh: &Mesh, object: u32) -> Option<Bounds> {
    bounds_of(mesh, object, |_| true)
}

fn bounds_of(mesh: &Mesh, object: u32, counts: impl Fn(usize) -> bool) -> Option<Bounds> {
    if mesh.ground_object() == Some(object) {
        return Some(mesh.bounds());
    }
    let owners = mesh.triangle_object.iter().enumerate();
    let counted = owners.filter(|&(triangle, &owner)| owner == object && counts(triangle));
    let bounds = Bounds::around(counted.flat_map(|(triangle, _)| mesh.corners(triangle)));
    (bounds.min.x <= bounds.max.x).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::two_squares;
    use glam::Vec3;

    #[test]
    fn bounds_are_those_of_the_object_alone() {
        let mesh = two_squares();
        let bounds = object_bounds(&mesh, 1).unwrap();
        assert_eq!((bounds.min, bounds.max), (Vec3::new(0.5, -0.5, 0.0), Vec3::new(1.5, 0.5, 0.0)));
        let left = object_bounds(&mesh, 0).unwrap();
        assert_eq!((left.min, left.max), (Vec3::new(-1.5, -0.5, 0.0), Vec3::new(-0.5, 0.5, 0.0)));
        assert_eq!(object_bounds(&mesh, 2), None);
    }
}
