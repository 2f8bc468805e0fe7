//! How much memory there is.

/// Bytes of memory that the system would give now; `None` where it does not say.
fn free() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes.saturating_mul(1024))
}

/// Bytes of memory that the system would give now, all that can be addressed where it does not say.
pub(crate) fn available_memory() -> u64 {
    free().unwrap_or(u64::MAX)
}

/// Half of the memory that is free now; 2 GiB where the system does not say.
pub(crate) fn half_of_free_memory() -> u64 {
    free().map_or(2 << 30, |free| free / 2)
}
