//! An estimate of the memory that a bake takes.

use lapidary_core::dataset::{BakeSettings, MeshlessSettings};

/// Peak memory of a bake of this size, in bytes: mesh and hierarchy, the cuts and links of its parts, and buffers of
/// each thread.
pub fn estimate(vertices: usize, triangles: usize, settings: &BakeSettings, threads: usize) -> u64 {
    const BYTES_PER_VERTEX: u64 = 160; // positions to tangents, twice while tessellating, and bake points
    const BYTES_PER_TRIANGLE: u64 = 260; // indices, corners, and two hierarchy nodes of 48 bytes
    let (v, t, mode) = (vertices as u64, triangles as u64, settings.mode);
    let (lights, sources) = (settings.lights as u64, settings.indirect.sources as u64);
    let mut bytes = v * BYTES_PER_VERTEX + t * BYTES_PER_TRIANGLE;
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

/// Chunks, their concatenation, and the packed cuts.
fn cuts(points: u64, nodes: u64) -> u64 {
    3 * points * nodes * 2
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
    let functions = MeshlessSettings::COARSEST_FUNCTIONS as u64 * ((1 << (2 * settings.levels)) - 1) / 3;
    functions * (BYTES_PER_FUNCTION + LINKS_PER_FUNCTION * BYTES_PER_LINK)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::BakeParts;

    #[test]
    fn estimate_of_the_armadillo_scene_is_near_what_it_takes() {
        let bytes = estimate(57_884, 115_282, &BakeSettings::default(), 2);
        let mesh = 57_884 * 160 + 115_282 * 260;
        let cuts = 3 * 57_884 * 400 * 2;
        let buffers = 32_768 * (1024 + 2 * 20);
        assert_eq!(bytes, mesh + cuts + buffers);
        assert_eq!(bytes / 1_000_000, 213);
    }

    #[test]
    fn each_part_of_a_mode_counts() {
        let of = |mode| estimate(100_000, 200_000, &BakeSettings { mode, ..Default::default() }, 2);
        let mesh = estimate(100_000, 200_000, &BakeSettings { mode: BakeParts::MESHLESS, ..levels(1) }, 2);
        assert!(of(BakeParts::CUTS) > of(BakeParts::ENVIRONMENT) + of(BakeParts::INDIRECT) - mesh);
        assert!(of(BakeParts::INDIRECT) > of(BakeParts::ENVIRONMENT), "their cuts are longer");
        assert!(of(BakeParts::ALL) > of(BakeParts::CUTS) + of(BakeParts::MESHLESS) - mesh);
        // 100,000 cuts of 1,340 nodes of two bytes, once.
        assert!(of(BakeParts::INDIRECT) > 268_000_000);
    }

    fn levels(levels: usize) -> BakeSettings {
        let normal = BakeSettings::default();
        BakeSettings { meshless: MeshlessSettings { levels, ..normal.meshless }, ..normal }
    }
}
