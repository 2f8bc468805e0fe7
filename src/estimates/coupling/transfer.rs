//! Linear and quadratic transfer between two sites.

use super::bicoherence::only_one_window;
use super::fit::{Fit, OutputFit, Resamplings};
use super::found::{Transfer, TransferShares};
use super::products::LEAST_POWER;
use super::spectra::{Spectra, last_bin};
use crate::error::{Error, Result};
use crate::estimates::SIGNIFICANCE;
use crate::estimates::realisations::{
    Averaging, Independence, Realisations, Records, SegmentScratch, Shots, a_site,
    check_significance, first_of, steadiness,
};
use crate::field::Field;
use crate::numeric::deviation;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::check_memory;
use crate::system::threads::in_pool;

/// All choices of [`transfer`].
#[derive(Debug, Clone, PartialEq, smart_default::SmartDefault)]
pub struct TransferRequest {
    /// Index of the site of the input.
    pub from: usize,
    /// Index of the site of the output.
    #[default(1)]
    pub to: usize,
    /// Samples by which the output is taken later: the time that waves need from one to the other.
    pub lag: usize,
    /// Frequency up to which the model has terms; `None`: all below the Nyquist frequency.
    pub highest: Option<f64>,
    /// One window; `segment: None` is a power of two that leaves four realisations for each unknown.
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// Probability by which an interval errs.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// How often realisations are drawn anew for the errors.
    #[default(200)]
    pub resamplings: usize,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// Linear and quadratic transfer from one site to another.
///
/// # Equation
/// With Fourier coefficients `X` of the input and `Y` of the output, at every frequency f,
///
/// ```text
/// Y(f) = L(f) X(f) + sum_{f1 + f2 = f} Q(f1, f2) X(f1) X(f2) + E(f),
/// ```
///
/// sums and differences of frequencies included. L and Q minimize `<|E|^2>`: the normal equations have the
/// moments of fourth order of the input, which is not taken for Gaussian. The power of the output is then, with
/// `q` the sum over Q,
///
/// ```text
/// <|Y|^2> = |L|^2 <|X|^2> + Re <q conj(2 L X + q)> + <|E|^2>,
/// ```
///
/// of which each pair has its part of the second term. What chance alone explains, `<|E|^2> / (K - unknowns)` a
/// term, is counted as residual.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes.
///
/// # Units
/// Powers as one-sided densities, in the square of the samples' unit over frequency.
///
/// # Errors
/// [`crate::Error::Request`] for fewer independent realisations than twice the unknowns, of which a frequency has one
/// and as many as there are pairs; for fields with different axes, sites that are none or one, segments that do
/// not fit, and several tapers; [`crate::Error::NonFinite`]; [`crate::Error::Memory`]; [`crate::Error::Cancelled`];
/// [`crate::Error::Failed`].
///
/// # Source
/// C. P. Ritz, E. J. Powers, Physica D 20, 320 (1986); K. I. Kim, E. J. Powers, IEEE Trans. Acoust. Speech
/// Signal Process. 36, 1758 (1988), for inputs of any distribution; J. S. Kim, R. J. Fonck, R. D. Durst, E. Fernandez,
/// P. W. Terry, S. F. Paul, M. C. Zarnstorff, Phys. Rev. Lett. 79, 841 (1997), for the transfer of energy.
pub fn transfer(
    fields: &[&Field],
    request: &TransferRequest,
    observer: &dyn Observer,
) -> Result<Transfer> {
    let first = first_of(fields)?;
    check(first, request)?;
    let record = first.n_times() - request.lag;
    // Of N samples, about `2 T / N` realisations for `N / 2` unknowns.
    let most = ((record * fields.len()) as f64 * 0.9).sqrt() as usize;
    let segment = (1 << most.max(8).ilog2()).min(record);
    let averaging = request.averaging.with_segment(segment);
    let all = Realisations::new(&averaging, record)?;
    let length = all.segments.length;
    let df = 1.0 / (length as f64 * first.time.step);
    let highest = request.highest.map(|f| (f / df * (1.0 + 1e-12)) as usize);
    let last = last_bin(length).min(highest.unwrap_or(usize::MAX));
    let expected = format!("at least two frequencies, multiples of {df}, below the highest");
    Error::require(last >= 2, "highest", expected, last)?;
    let (gaps, memory) = (request.gaps, request.memory);
    let shots = Shots::new(fields, gaps, memory, first.n_times(), observer)?;
    let needed = [(request.from, 0), (request.to, request.lag)];
    let realisations = shots.keeping(all, &needed)?;
    let pass = Pass {
        shots,
        request,
        realisations: &realisations,
        last,
    };
    in_pool(request.threads, || pass.run(first))
}

fn check(first: &Field, request: &TransferRequest) -> Result<()> {
    let (from, to, sites, times) = (request.from, request.to, first.n_sites(), first.n_times());
    for (option, site) in [("site", from), ("transfer", to)] {
        Error::require(site < sites, option, a_site(sites), site)?;
    }
    let other = "another site than that of the input";
    Error::require(from != to, "transfer", other, to)?;
    let lag = format!("a lag below the {times} samples of the record");
    Error::require(request.lag < times, "lag", lag, request.lag)?;
    let highest = request.highest.unwrap_or(1.0);
    let is_one = highest > 0.0 && highest.is_finite();
    Error::require(is_one, "highest", "a frequency above 0", highest)?;
    check_significance(request.alpha)?;
    let resamplings = request.resamplings;
    Error::require(resamplings >= 20, "resamplings", "at least 20", resamplings)?;
    only_one_window(&request.averaging)
}

struct Pass<'a> {
    shots: Shots<'a>,
    request: &'a TransferRequest,
    realisations: &'a Realisations,
    /// The highest bin of the model.
    last: usize,
}

impl Pass<'_> {
    fn run(&self, first: &Field) -> Result<Transfer> {
        let request = self.request;
        let mut records: Vec<[Spectra; 2]> = Vec::new();
        let mut steady = 0.0;
        let mut scratch = SegmentScratch::default();
        let (length, count) = (self.realisations.segments.length, self.realisations.count());
        let held = 2 * self.shots.count() as u64 * Spectra::bytes(length, count);
        let block = self.shots.block("the transforms of two sites", held)?;
        let kept = self.realisations.segments.record;
        self.shots.each(block, |shot| {
            let (input, output) = (shot.record(request.from), shot.record(request.to));
            let (input, output) = (&input[..kept], &output[request.lag..]);
            steady += steadiness(input).min(steadiness(output));
            let mut of = |record: &[f64]| {
                let record = Records::interleaved(record, 1);
                let spectra = Spectra::of(self.realisations, record, &mut scratch);
                spectra.into_iter().next().unwrap_or_default()
            };
            records.push([of(input), of(output)]);
            Ok(())
        })?;
        clear_rounding(&mut records);
        let (shots, steadiness) = (records.len(), steady / records.len() as f64);
        let independence = self.realisations.independence(shots, None, steadiness);
        let (unknowns, found) = (self.last, independence.independent);
        let Some(independent) = found.filter(|k| *k >= 2.0 * unknowns as f64) else {
            let expected = format!(
                "at least {} independent realisations, twice the {unknowns} unknowns of a frequency: shorter \
                 segments, fewer frequencies (highest), or more fields",
                2 * unknowns
            );
            let none = "one: a transient, or a single segment, is one realisation";
            let found = found.map_or(none.into(), |independent| format!("{independent:.1}"));
            return Err(Error::request("segment", expected, found));
        };
        let realisations = [shots, self.realisations.segment_count()];
        let is_transient = independence.is_transient();
        let draws = Resamplings::new(realisations, is_transient, request.resamplings);
        let (expected, blocks) = (
            "at least 10 blocks of realisations to draw from",
            draws.blocks(),
        );
        Error::require(blocks >= 10, "segment", expected, blocks)?;
        let threads = rayon::current_num_threads() as u64;
        // Pairs of all outputs together, at most.
        let pairs = (self.last * self.last) as u64;
        let needed = held + threads * draws.bytes(self.last) + 8 * pairs * 8;
        let what = "the moments of the transfer (see --highest)";
        check_memory(what, needed, request.memory)?;
        let observer = self.shots.observer;
        observer.stage("transfer functions", self.last as u64);
        let step = first.time.step;
        let fit = Fit {
            records: &records,
            draws: &draws,
            last: self.last,
            independent,
            density: 2.0 * step,
            kernel: self.realisations.quadratic_scale(),
            df: 1.0 / (self.realisations.segments.length as f64 * step),
        };
        let outputs = fit.all(observer)?;
        Ok(self.finish(first, independence, &fit, outputs))
    }

    fn finish(
        &self,
        field: &Field,
        independence: Independence,
        fit: &Fit<'_>,
        mut fits: Vec<OutputFit>,
    ) -> Transfer {
        let (segments, df) = (self.realisations.segments, fit.df);
        // Of every resampling, the sum of all gains, and that so far.
        let of_all = |r: usize| fits.iter().map(|fit| fit.gains[r] * df).sum::<f64>();
        let total: Vec<f64> = (0..fit.draws.count()).map(of_all).collect();
        let mut passed = vec![0.0; total.len()];
        let sum = |of: fn(&OutputFit) -> f64| fits.iter().map(of).sum::<f64>();
        let (all, mut flux) = (sum(|fit| fit.transfer.gain) * df, 0.0);
        for OutputFit {
            transfer, gains, ..
        } in &mut fits
        {
            flux -= transfer.gain * df;
            let sums = passed.iter_mut().zip(gains);
            sums.for_each(|(sum, gain)| *sum += *gain * df);
            let above = total.iter().zip(&passed).map(|(all, below)| all - below);
            (transfer.flux, transfer.flux_error) = (flux, deviation(&passed));
            transfer.above = all + flux;
            transfer.above_error = deviation(&above.collect::<Vec<f64>>());
        }
        let sum = |of: fn(&OutputFit) -> f64| fits.iter().map(of).sum::<f64>();
        let all = sum(|fit| fit.transfer.output);
        let of_rest = |of: fn(&OutputFit) -> [f64; 3]| {
            let shares = fits.iter().map(of).map(|[linear, every, power]| {
                let rest = power - linear;
                let share = ((every - linear) / rest).max(-1.0);
                if rest > 0.0 { share } else { 0.0 }
            });
            shares.sum::<f64>() / fits.len() as f64
        };
        let shares = TransferShares {
            linear: sum(|fit| fit.transfer.input + fit.transfer.linear) / all,
            quadratic: sum(|fit| fit.transfer.gain) / all,
            residual: sum(|fit| fit.transfer.residual) / all,
            held_out_linear: sum(|fit| fit.held_out[0]) / all,
            held_out_quadratic: sum(|fit| fit.held_out[1] - fit.held_out[0]) / all,
            held_out_of_rest: of_rest(|fit| fit.held_out),
            stronger_half_of_rest: (fit.independent >= 4.0 * self.last as f64)
                .then(|| of_rest(|fit| fit.stronger)),
        };
        let request = self.request;
        Transfer {
            time: field.time.clone(),
            space: field.space.clone(),
            unit: field.unit.clone(),
            from: request.from,
            to: request.to,
            lag: request.lag,
            segment: [segments.length, segments.length - segments.hop],
            independence,
            alpha: request.alpha,
            unknowns: self.last,
            blocks: fit.draws.blocks(),
            resamplings: fit.draws.count(),
            outputs: fits.iter().map(|fit| fit.transfer).collect(),
            pairs: fits.into_iter().flat_map(|fit| fit.pairs).collect(),
            shares,
        }
    }
}

/// Sets inputs that are rounding to 0, so that no term is made of them.
fn clear_rounding(records: &mut [[Spectra; 2]]) {
    let mut powers = vec![0.0; records[0][0].bins()];
    for [input, _] in records.iter() {
        input.add_power(&mut powers);
    }
    let largest = powers.iter().skip(1).fold(0.0, |m: f64, p| m.max(*p));
    for (bin, power) in powers.iter().enumerate() {
        if *power <= LEAST_POWER * largest {
            records.iter_mut().for_each(|[input, _]| input.clear(bin));
        }
    }
}
