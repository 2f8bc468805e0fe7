//! Energy at the top of an axis: folded down from beyond it, or a floor of noise.

use super::quality::{FLAT_PART, Findings, flat_part, total};
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::numeric::sum;
use crate::prepare::Window;
use crate::transform::RecordTransform;

const ALIASING_SHARE: f64 = 0.01;
/// Share of the top tenth of the axis, over that of a flat spectrum, for spectra as flat as white
/// noise. The effective bandwidth
/// of a periodogram of white noise is 0.66 of the axis, and less for few bins.
const FLAT_SHARE: std::ops::Range<f64> = 0.45..1.5;
/// Energy above the 90 % quantile of spectra with a white floor, as the top tenth foretells it: 0.1 up
/// to what differs by chance.
const FLOOR_SHARE: std::ops::Range<f64> = 0.08..0.125;
/// Bins that are too few to tell flat spectra by their bandwidth.
const FEW_BINS: usize = 6;
/// Samples of the frames in which noise is as flat as in the whole record, and a chirp is not; sites that are
/// looked at; the effective bandwidth over the axis, 0.61 of white noise under a Hann window, below 0.3 of
/// chirps.
const FRAME: usize = 64;
const LOOKED_AT: usize = 8;
const FLAT_FRAMES: f64 = 0.4;

/// Share of energy in the top tenth of an axis, and the lower edge of that tenth, if the share
/// suggests aliasing. Not decidable for spectra as flat as noise, and those with a floor of it.
/// `sweeps`: whether spectra that are flat are those of a tone that crosses the axis.
pub(super) fn aliased(
    rows: &[SpectrumMoments],
    bins: &Bins,
    sweeps: impl Fn() -> bool,
) -> Option<(f64, f64)> {
    let all = total(rows, |r| r.total);
    let share = total(rows, |r| r.top) / all;
    let last = bins.centres[bins.len() - 1];
    let from = bins.centres.partition_point(|&q| q <= 0.9 * last);
    let of_flat = 1.0 - (from as f64 - 0.5) * bins.step / bins.top();
    let is_wide = bins.len() < FEW_BINS || flat_part(rows, bins) > FLAT_PART;
    let is_flat = FLAT_SHARE.contains(&(share / of_flat)) && is_wide;
    let is_high = share > ALIASING_SHARE;
    let is_noise = is_flat || has_floor(rows, bins, of_flat);
    // Below a floor there is other motion, which is not flat in frames either.
    let is_folded = is_high && (!is_noise || (is_wide && sweeps()));
    is_folded.then_some((share, 0.9 * last))
}

/// Whether the energy in the top tenth is that of a white floor below other motion: spectra are as
/// dense from their 90 % quantile on as in the top tenth. A row with more than a hundredth of its
/// energy in a flat top tenth has its quantile in the floor, which then holds a tenth above it. A line
/// near the end of the axis may do so by chance: rows count whose quantile is below, or that are flat.
fn has_floor(rows: &[SpectrumMoments], bins: &Bins, of_flat: f64) -> bool {
    let high = rows.iter().filter(|r| r.top > ALIASING_SHARE * r.total);
    let (mut above, mut all) = (0.0, 0.0);
    for row in high {
        let is_flat = row.effective_bandwidth > FLAT_PART * bins.top();
        if is_flat || row.quantile_90 < 0.8 * bins.top() {
            above += row.top / of_flat * (1.0 - row.quantile_90 / bins.top());
        }
        all += row.total;
    }
    FLOOR_SHARE.contains(&(above / all))
}

impl Findings<'_> {
    /// Whether the loudest records, flat as a whole, are not so in short frames: a tone sweeps over the axis, and
    /// what it does at the end of it, it does beyond it, too.
    pub(super) fn sweeps(&self, rows: &[SpectrumMoments]) -> bool {
        if self.rows.ends.len() < 2 * FRAME {
            return false;
        }
        let mut loudest: Vec<usize> = (0..rows.len()).collect();
        loudest.sort_by(|&a, &b| rows[b].total.total_cmp(&rows[a].total).then(a.cmp(&b)));
        let transform = RecordTransform::<f64>::new(&Window::Hann.samples(FRAME), FRAME);
        let mut scratch = Default::default();
        let (mut wide, mut all) = (Vec::new(), Vec::new());
        for j in loudest.into_iter().take(LOOKED_AT) {
            let record = self.all.record(j);
            for frame in record.chunks_exact(FRAME) {
                let (spectrum, _) = transform.transform(std::iter::once(frame), &mut scratch);
                let inside = &spectrum[1..FRAME / 2];
                let energy: f64 = inside.iter().map(|x| x.norm_sqr()).sum();
                if energy > 0.0 {
                    let shares = inside.iter().map(|x| x.norm_sqr() / energy);
                    let entropy: f64 = shares.filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum();
                    wide.push(energy * entropy.exp() / inside.len() as f64);
                    all.push(energy);
                }
            }
        }
        sum(&wide) < FLAT_FRAMES * sum(&all)
    }
}
