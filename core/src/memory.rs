//! Memory of the machine and of this process.

/// Bytes that this process could allocate now, where the system tells: what is free on the machine, in the group of
/// processes that it is confined to, and below its own limit (`ulimit -v`).
pub fn available() -> Option<u64> {
    [kilobytes("/proc/meminfo", "MemAvailable:"), left_in_group(), left_of_address_space()].into_iter().flatten().min()
}

/// Greatest resident memory of this process so far, 0 where the system does not tell.
pub fn peak() -> u64 {
    kilobytes("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// What the control group of a container leaves.
fn left_in_group() -> Option<u64> {
    let number =
        |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    Some(number("memory.max")?.saturating_sub(number("memory.current")?))
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
        assert!(peak() > 1 << 20);
    }
}
