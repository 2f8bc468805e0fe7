//! What moves in wavenumber in time in a run, whose total energy is known.

use std::ops::Range;

use super::contacts::Contacts;
use super::modes::Basis;
use super::motion::Motion as Recorded;
use super::wavenumber::Transfers;
use crate::analyze::Analysis;
use crate::chain::{Ends, Run};
use crate::error::Result;
use crate::moved::{Motion, Place, Profiles, Source, TOLERANCE, Verdict, in_time};

/// Puts what a run knows into the answer of an analysis of all its sites and times: whether the chain loses energy, and, where
/// displacements were recorded, what moved in wavenumber, of the energy `E(k) = |q^|^2 / 2 + |phi^|^2`, in sines between fixed
/// ends, in place of that of `v^2`, which oscillates. The analysis of a run, of its file or of its field in memory, is then the same.
///
/// # Errors
/// [`Error::Request`](crate::Error::Request) for a motion that does not fit its chain.
pub fn answer_of_run(run: &Run, analysis: &mut Analysis) -> Result<()> {
    let axes = &analysis.axes;
    let is_whole = axes.n_times == run.time.len() && axes.n_sites == run.chain.n_sites();
    let Some(answer) = analysis.answer.as_mut().filter(|_| is_whole) else {
        return Ok(());
    };
    answer.is_lossy = run.chain.is_lossy();
    // Of a struck ring the front counts.
    answer.is_periodic = run.chain.ends == Ends::Periodic && !answer.is_struck;
    let movement = &mut answer.frequency;
    // Without losses, what is missing in the windows follows behind; and linear waves keep their frequencies: they lag behind, are
    // reflected, or decay.
    let follows = run.chain.is_linear() || (movement.transfer == Some(false) && !answer.is_lossy);
    if movement.moves() && follows {
        movement.transfer = answer.is_lossy.then_some(false);
        movement.lags = !answer.is_lossy;
    }
    if run.displacement.is_none() {
        return Ok(());
    }
    let motion = &Recorded::of(run)?;
    motion.check()?;
    let contacts = Contacts::of(motion);
    if contacts.check_roots(motion).is_err() {
        // The analysis keeps what it knows of the velocities alone.
        return Ok(());
    }
    let transfers = Transfers::new(&contacts, None);
    let basis = transfers.modes.basis();
    let wavenumbers = transfers.modes.wavenumbers(axes.space.step.abs());
    let profiles = OfRun {
        motion: *motion,
        transfers,
    };
    let among = answer.since.clone().unwrap_or(0..axes.n_times);
    let time = &axes.time;
    let source = Source {
        profiles: &profiles,
        among: among.start..among.end.min(axes.n_times),
        step: wavenumbers.get(1).copied().unwrap_or(f64::NAN),
        // Between fixed ends and around a ring the first mode is a wave; elsewhere one bin is the mean, the next the whole chain.
        first: match basis == Basis::Standing || answer.is_periodic {
            true => 1,
            false => 2,
        },
        period: answer.period / time.step,
        motion: match answer.is_periodic {
            true => Motion::Box,
            false => Motion::Run,
        },
        is_inside: false,
        is_short: false,
        uneven: 0.0,
        tolerance: TOLERANCE,
        stays_along_x: true,
        place: &|rows: Range<usize>| Place {
            rows: [rows.start, rows.end - 1],
            at: 0.5 * (time.at(rows.start) + time.at(rows.end - 1)),
        },
    };
    answer.tell(in_time(&source));
    // A chain whose wavenumbers keep their energies transfers none: what the front is short of follows behind.
    let movement = &mut answer.frequency;
    let keeps = answer.wavenumber.verdict == Verdict::Unchanged && !answer.is_lossy;
    if movement.verdict == Verdict::Down && keeps {
        (movement.transfer, movement.lags) = (None, true);
    }
    Ok(())
}

struct OfRun<'a> {
    motion: Recorded<'a>,
    transfers: Transfers<'a>,
}

impl Profiles for OfRun<'_> {
    fn energy(&self, time: usize) -> f64 {
        self.powers(time).iter().sum()
    }

    fn at_ends(&self, _: usize) -> f64 {
        0.0
    }

    fn powers(&self, time: usize) -> Vec<f64> {
        self.transfers.energies(self.motion.at(time))
    }
}
