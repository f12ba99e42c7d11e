//! An estimate of a bake's memory.

use super::parts;
use lapidary_core::dataset::BakeSettings;

/// Estimated peak memory of a bake beside the scene, in bytes. The peak is either while the box hierarchy is built and further
/// vertices are placed, or later, with mesh, hierarchy, the parts' cuts and links, and each thread's buffers.
pub fn estimate(
    vertices: usize,
    triangles: usize,
    places_vertices: bool,
    settings: &BakeSettings,
    threads: usize,
) -> u64 {
    const BUILDING: [u64; 2] = [80, 470]; // bake points; leaves, nodes and candidates, and what is made of them
    const PLACING: u64 = 600; // a triangle's edges, their errors, and what their ends see
    const BUILDERS: u64 = 64 << 20; // what their heaps keep
    const RESIDENT: [u64; 2] = [160, 220];
    let (v, t) = (vertices as u64, triangles as u64);
    let placing = if places_vertices { t * PLACING } else { 0 };
    let building = v * BUILDING[0] + t * BUILDING[1] + placing;
    BUILDERS + building.max(v * RESIDENT[0] + t * RESIDENT[1] + parts(v, settings, threads))
}

/// Memory of the parts of a bake.
fn parts(vertices: u64, settings: &BakeSettings, threads: usize) -> u64 {
    parts::of(settings.mode).map(|part| part.memory(vertices, settings, threads)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::BakeParts;

    #[test]
    fn placing_vertices_takes_more_than_cuts_do() {
        let bytes = |placing| estimate(100_000, 200_000, placing, &BakeSettings::default(), 2);
        let parts = 100_000 * 400 * 2 + 32_768 * (1024 + 2 * 20);
        let builders = 64 << 20;
        assert_eq!(bytes(false), builders + 100_000 * 160 + 200_000 * 220 + parts);
        assert_eq!(bytes(true), builders + 100_000 * 80 + 200_000 * 1070);
    }

    #[test]
    fn each_part_of_a_mode_counts() {
        let of = |mode| parts(100_000, &BakeSettings { mode, ..Default::default() }, 2);
        assert!(of(BakeParts::CUTS) > of(BakeParts::ENVIRONMENT) + of(BakeParts::INDIRECT));
        assert!(of(BakeParts::INDIRECT) > of(BakeParts::ENVIRONMENT), "their cuts are longer");
        assert!(of(BakeParts::ALL) > of(BakeParts::CUTS));
        // 100,000 cuts of 1,340 two-byte nodes, once.
        assert!(of(BakeParts::INDIRECT) > 268_000_000);
    }
}
