//! What the targets share: files of random bytes, and short work on what was read from them.

pub mod opinion;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use tempfile::TempDir;
use wavecascade::Field;
use wavecascade::analyze::{Request, analyze};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Observer;

/// Most samples that are analyzed, and most samples times sites of a run.
const SMALL: usize = 1 << 13;

/// Files in memory, where the system has such.
static DIRECTORY: LazyLock<TempDir> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    match memory.is_dir() {
        true => tempfile::tempdir_in(memory),
        false => tempfile::tempdir(),
    }
    .expect("a directory for the input")
});

/// The directory of this process.
pub fn directory() -> &'static Path {
    DIRECTORY.path()
}

/// Writes a file of this name and returns its path.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory().join(name);
    std::fs::write(&path, bytes).expect("room for the input");
    path
}

/// Opens a field and analyses it if it is small. A result that is returned must be sound: it keeps
/// the energy, and no energy is negative.
pub fn open_and_analyze(path: &Path) {
    let Ok(field) = Field::open(path, &OpenOptions::default()) else {
        return;
    };
    if !is_small(field.n_times(), field.n_sites()) {
        return;
    }
    let Ok((analysis, _)) = analyze(&field, &Request::default()) else {
        return;
    };
    if let Some(residual) = analysis.accuracy.parseval {
        assert!(residual < 1e-9, "Parseval's residual is {residual}");
    }
}

/// Whether a run or field of this size takes little time.
pub fn is_small(times: usize, sites: usize) -> bool {
    times.saturating_mul(sites) <= SMALL
}

/// Stops work after half a second.
#[derive(Debug)]
pub struct Deadline(Instant);

impl Deadline {
    pub fn start() -> Deadline {
        Deadline(Instant::now() + Duration::from_millis(500))
    }
}

impl Observer for Deadline {
    fn cancelled(&self) -> bool {
        Instant::now() > self.0
    }
}
