//! Memory of the machine and of this process.

/// Bytes that this process could allocate now, if the system reports them: the least of the machine's free memory, the
/// remainder of the process's control group, and of its own limit (`ulimit -v`).
pub fn available() -> Option<u64> {
    [kilobytes("/proc/meminfo", "MemAvailable:"), left_in_group(), left_of_address_space()].into_iter().flatten().min()
}

/// Resident memory of this process, 0 if the system does not report it.
pub fn resident() -> u64 {
    kilobytes("/proc/self/status", "VmRSS:").unwrap_or(0)
}

/// Peak resident memory of this process so far, 0 if the system does not report it.
pub fn peak() -> u64 {
    kilobytes("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// Needed memory, rounded up, and free memory, rounded down, in megabytes: a refusal never shows the same number twice.
pub fn in_megabytes(needed: u64, available: u64) -> [u64; 2] {
    [needed.div_ceil(1_000_000), available / 1_000_000]
}

/// Free memory in the control group of a container.
fn left_in_group() -> Option<u64> {
    let text = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok();
    let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
    Some(left_of(number("memory.max")?, number("memory.current")?, &text("memory.stat").unwrap_or_default()))
}

/// Free memory below a group's limit. Its used memory includes files that the system caches; the system frees these on demand.
fn left_of(limit: u64, used: u64, statistics: &str) -> u64 {
    const CACHED: [&str; 3] = ["inactive_file", "active_file", "slab_reclaimable"];
    let entries = statistics.lines().filter_map(|line| line.split_once(' '));
    let cached =
        entries.filter(|(key, _)| CACHED.contains(key)).filter_map(|(_, bytes)| bytes.trim().parse::<u64>().ok());
    limit.saturating_sub(used.saturating_sub(cached.sum::<u64>()))
}

fn left_of_address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit = line.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(limit.saturating_sub(kilobytes("/proc/self/status", "VmSize:")?))
}

fn kilobytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    #[test]
    fn the_system_tells_both() {
        assert!(available().is_some_and(|b| b > 1 << 20));
        assert!(resident() > 1 << 20 && peak() >= resident() / 2);
    }

    #[test]
    fn cached_files_of_a_group_count_as_free_and_never_more_than_its_limit() {
        let statistics = "anon 200\nfile 800\ninactive_file 500\nactive_file 250\nslab_reclaimable 20\nslab 90\n";
        assert_eq!(left_of(1000, 1000, statistics), 770);
        assert_eq!(left_of(1000, 300, statistics), 1000);
        assert_eq!(left_of(1000, 900, ""), 100, "negative control");
    }

    #[test]
    fn a_need_is_rounded_up_and_what_is_free_down() {
        assert_eq!(in_megabytes(3_999_999, 3_999_998), [4, 3]);
    }
}
