//! Available memory, memory in huge pages, and sizes as text.

use std::io::Result;

use memmap2::MmapMut;

/// Bytes of memory available now; `None` where the system does not report it.
fn free() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes.saturating_mul(1024))
}

/// Bytes of memory available now; `u64::MAX` where the system does not report it.
pub fn available_memory() -> u64 {
    free().unwrap_or(u64::MAX)
}

/// Half of the memory available now; 2 GiB where the system does not report it.
pub fn half_of_free_memory() -> u64 {
    free().map_or(2 << 30, |free| free / 2)
}

/// Zeroed memory in huge pages, where the system has them.
///
/// # Errors
/// The system's, where it gives no memory.
pub fn huge_pages(bytes: usize) -> Result<MmapMut> {
    let pages = MmapMut::map_anon(bytes)?;
    // Small pages do as well where the system refuses.
    #[cfg(target_os = "linux")]
    let _refused = pages.advise(memmap2::Advice::HugePage);
    Ok(pages)
}

/// Bytes in a binary unit, rounded up, so that the printed limit suffices.
pub fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let power = (bytes.max(1).ilog2() / 10).min(4);
    let value = bytes as f64 / 1024f64.powi(power as i32);
    match UNITS.get(power as usize) {
        Some(unit) if power > 0 => format!("{:.2} {unit}", (value * 100.0).ceil() / 100.0),
        _ => format!("{bytes} bytes"),
    }
}
