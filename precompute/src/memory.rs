//! Memory: an estimate before the start, and what was used in the end.

/// Bytes that a bake of this size needs at its peak: mesh and hierarchy, cuts, and buffers of each thread.
pub fn estimate(vertices: usize, triangles: usize, lights: usize, clusters: usize, threads: usize) -> u64 {
    const BYTES_PER_VERTEX: u64 = 160; // positions to tangents, twice while tessellating, and bake points
    const BYTES_PER_TRIANGLE: u64 = 260; // indices, corners, and two hierarchy nodes of 48 bytes
    const NODES_PER_CUT: u64 = 400; // twice the mean of real scenes
    let (v, t, n) = (vertices as u64, triangles as u64, lights as u64);
    let mesh = v * BYTES_PER_VERTEX + t * BYTES_PER_TRIANGLE;
    let cuts = 2 * v * NODES_PER_CUT * 2; // chunks and their concatenation
    mesh + cuts + n * clusters as u64 + threads as u64 * n * 20
}

/// Bytes that could be allocated now, where the system tells.
pub fn available() -> Option<u64> {
    kilobytes("/proc/meminfo", "MemAvailable:")
}

/// Greatest resident memory of this process so far, 0 where the system does not tell.
pub fn peak() -> u64 {
    kilobytes("/proc/self/status", "VmHWM:").unwrap_or(0)
}

fn kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimate_of_the_armadillo_scene_is_near_what_it_takes() {
        let bytes = estimate(57_884, 115_282, 32_768, 1024, 2);
        assert!((100_000_000..1_000_000_000).contains(&bytes), "{bytes}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_system_tells_both() {
        assert!(available().is_some_and(|b| b > 1 << 20));
        assert!(peak() > 1 << 20);
    }
}
