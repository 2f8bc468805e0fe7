//! A field in a file, streamed through bounded memory to an archive, with progress.

use std::sync::atomic::{AtomicU64, Ordering};

use wavecascade::Field;
use wavecascade::analyze::{Request, plan, run};
use wavecascade::arrays::Precision;
use wavecascade::field::OpenOptions;
use wavecascade::observer::Observer;
use wavecascade::report::{Archive, ArrayFile};
use wavecascade::sheet::Describe;

/// Counts what is done; a program would draw it.
#[derive(Default)]
struct Counter(AtomicU64);

impl Observer for Counter {
    fn stage(&self, name: &'static str, units: u64) {
        println!("{name}: {units} units of work");
    }

    fn advance(&self, units: u64) {
        self.0.fetch_add(units, Ordering::Relaxed);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let place = tempfile::tempdir()?;
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/data/lattice_impact.npy"
    );
    let field = Field::open(path, &OpenOptions::default())?;
    let request = Request {
        memory: Some(12 << 20),
        threads: Some(1),
        ..Request::default()
    };

    let plan = plan(&field, &request)?;
    println!(
        "blocks of {} sites; {} bytes of {} allowed",
        plan.blocks().sites,
        plan.memory_needed,
        plan.memory_allowed
    );
    let archive = Archive::create(&place.path().join("spectra.npz"), Precision::F64)?;
    let counter = Counter::default();
    let analysis = run(&field, &plan, &archive, &counter)?;
    analysis.describe().write_to(&archive)?;
    archive.finish()?;

    let written = std::fs::metadata(place.path().join("spectra.npz"))?.len();
    println!(
        "{} units done, {written} bytes written",
        counter.0.into_inner()
    );
    Ok(())
}
