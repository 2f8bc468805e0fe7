//! Where the energy of a wave goes, from a velocity field $v(t, x)$ or from the chain that made it.
//!
//! A result is data. It says in words what it found ([`sheet`]), and the same description gives its numbers, arrays, figures
//! and page. Nothing is printed, and no function reads a command line.
//!
//! # A field
//!
//! [`Field::open`] reads a file, [`Field::from_array`] takes an array `(time, site)`. [`analyze()`] computes the spectra
//! `S(f, x)`, `S(k, t)` and `S(k, f)`, and says what moved:
//!
//! ```
//! use wavecascade::analyze::Request;
//! use wavecascade::arrays::LargeArray;
//! use wavecascade::reference::GrowingHarmonic;
//! use wavecascade::{Field, analyze};
//!
//! // A burst whose second harmonic grows along x, with noise: 1024 times, 96 sites.
//! let field: Field = GrowingHarmonic::EXAMPLE.field();
//! let (analysis, spectra) = analyze(&field, &Request::default())?;
//!
//! let answer = analysis.words().answer;
//! assert!(answer.starts_with("energy moves up in frequency along x: 36.8"), "{answer}");
//! // (frequency, site), in the square of the samples' unit over frequency.
//! assert_eq!(spectra[&LargeArray::TEMPORAL_SPECTRUM].dim(), (513, 96));
//! # Ok::<(), wavecascade::Error>(())
//! ```
//!
//! # A chain
//!
//! [`chain`] integrates bodies in contact to a stated tolerance, [`budget`] follows their energy. Each balance states by how
//! much it fails to close:
//!
//! ```
//! use wavecascade::budget::{BudgetRequest, Integration, Motion, budget};
//! use wavecascade::chain::{Chain, Simulation};
//! use wavecascade::observer::Silent;
//!
//! // Forty bodies, two stiffnesses in the ratio 2.398, struck with the speed 1; 65 samples up to the time 30.
//! let run = Simulation::impact(Chain::dimer(40, 2.398), 1.0, 30.0, 65).run(&Silent)?;
//! // Transfers are integrated over the steps of the run, not over its samples.
//! let request = BudgetRequest { integration: Integration::Stepping, ..BudgetRequest::default() };
//! let (found, _) = budget(&Motion::of(&run)?, &request)?;
//! assert!(found.closure.real_space.value() < Some(1e-10));
//! assert!(found.closure.wavenumber.value() < Some(1e-12));
//! # Ok::<(), wavecascade::Error>(())
//! ```
//!
//! # An estimate
//!
//! [`estimates`] average over segments, tapers or repeated records. What they find has an interval or a level of significance,
//! or says why it has none. [`Describe`](sheet::Describe) makes words and arrays of any result:
//!
//! ```
//! use wavecascade::estimates::{CoherenceRequest, coherence};
//! use wavecascade::observer::Silent;
//! use wavecascade::reference::{Grid, WhiteNoise};
//! use wavecascade::sheet::Describe;
//!
//! let grid = Grid { n_times: 8192, n_sites: 4, dt: 1e-3, dx: 0.5 };
//! let field = WhiteNoise { grid, deviation: 1.0, seed: 3 }.field();
//! let found = coherence(&[&field], &CoherenceRequest::default(), &Silent)?;
//!
//! // Noise: no more cells than one in twenty are above the level, but for chance.
//! assert!(found.above_level().is_some_and(|share| share < 0.08));
//! let sheet = found.describe();
//! assert!(sheet.variables.iter().any(|variable| variable.name == "coherence"));
//! # Ok::<(), wavecascade::Error>(())
//! ```
//!
//! # Where to go on
//!
//! | module | what it answers |
//! |---|---|
//! | [`field`], [`prepare`], [`transform`] | a field from files of laboratories, its gaps and trends, its transforms |
//! | [`mod@analyze`], [`moved`], [`ridges`], [`mod@flux`] | spectra and what moved; dispersion; flux of energy and its loss |
//! | [`estimates`] | spectra, coherence, bicoherence, modes, increments, slopes with intervals |
//! | [`chain`], [`mod@budget`], [`sweep`] | chains of bodies in contact, where their energy goes, many of them |
//! | [`fit`], [`design`], [`attenuation`], [`localized`] | from a measurement to a chain, and to the chain that is wanted |
//! | [`sheet`], [`report`] | results as data, and as files |
//!
//! The feature `figures` adds plots and pages, `cli` the program `cascade`, `hdf5` and `zarr` formats; the first three are on by
//! default.
#![warn(missing_debug_implementations)]

pub mod analyze;
pub mod arrays;
pub mod attenuation;
pub mod budget;
pub mod chain;
pub mod design;
mod diagnostics;
pub mod error;
pub mod estimates;
pub mod field;
pub mod fit;
pub mod flux;
mod formula;
pub mod localized;
pub mod measure;
pub mod moved;
mod numeric;
pub mod observer;
#[cfg(feature = "figures")]
pub mod plot;
pub mod prepare;
pub mod reference;
pub mod report;
pub mod ridges;
pub mod sheet;
pub mod sweep;
mod system;
pub mod transform;
mod unit;

pub use analyze::analyze;
pub use error::{Error, Result};
pub use field::Field;
pub use fit::plan;

/// The examples of the guide, compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/guide/scans.md")]
#[doc = include_str!("../docs/guide/chains.md")]
#[doc = include_str!("../docs/guide/budgets.md")]
#[doc = include_str!("../docs/guide/localized-waves.md")]
#[doc = include_str!("../docs/guide/attenuation.md")]
struct Guide;
