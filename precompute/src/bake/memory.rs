//! An estimate of the memory that a bake takes.

use lapidary_core::dataset::{BakeSettings, MeshlessSettings};

/// What a bake of this size will take beside the scene, in bytes: either while the hierarchy of boxes is built, and vertices are
/// placed if there is room for more, or for mesh, hierarchy, cuts and links of its parts, and buffers of each thread.
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

/// That of the parts of a bake.
fn parts(v: u64, settings: &BakeSettings, threads: usize) -> u64 {
    let (mode, lights, sources) = (settings.mode, settings.lights as u64, settings.indirect.sources as u64);
    let mut bytes = 0;
    if mode.environment() {
        bytes += cuts(v, environment_nodes(settings)) + buffers(lights, settings, threads);
    }
    if mode.sources() {
        bytes += cuts(v, source_nodes(settings)) + buffers(sources, settings, threads);
    }
    if mode.sources() && mode.environment() {
        bytes += cuts(sources, environment_nodes(settings));
    }
    if mode.meshless() { bytes + basis_and_links(&settings.meshless) } else { bytes }
}

/// The packed cuts.
fn cuts(points: u64, nodes: u64) -> u64 {
    points * nodes * 2
}

/// Pilot visibility, and a thread's visibility, sums and cut over lights or sources.
fn buffers(leaves: u64, settings: &BakeSettings, threads: usize) -> u64 {
    leaves * settings.pilot_clusters as u64 + threads as u64 * leaves * 20
}

/// Twice the mean of real scenes.
fn environment_nodes(settings: &BakeSettings) -> u64 {
    (settings.lights as u64).min(u64::from(settings.criterion.max_nodes)).min(400)
}

/// The mean of the scene with the longest cuts, of 32,768 sources at sigma 2. Other scenes have 500 and more. Finer
/// bounds give longer cuts.
fn source_nodes(settings: &BakeSettings) -> u64 {
    let finer = (2.0 / settings.indirect.criterion.sigma.max(1e-3)).max(1.0);
    ((1340.0 * finer) as u64).min(settings.indirect.sources as u64)
}

/// Each level has four times as many functions as the one before.
fn basis_and_links(settings: &MeshlessSettings) -> u64 {
    const BYTES_PER_FUNCTION: u64 = 150; // point, place in its tree, row of links
    const LINKS_PER_FUNCTION: u64 = 20; // 9 to 40 in real scenes, fewer with more levels
    const BYTES_PER_LINK: u64 = 24; // 16 in rows while baking, 8 packed
    let functions = settings.expected_functions();
    functions * (BYTES_PER_FUNCTION + LINKS_PER_FUNCTION * BYTES_PER_LINK)
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
        // 100,000 cuts of 1,340 nodes of two bytes, once.
        assert!(of(BakeParts::INDIRECT) > 268_000_000);
    }
}
