//! Noise that is subtracted from spectra along time.

use super::plan::Plan;
use crate::error::Result;
use crate::estimates::{
    NoiseFloor, SiteNoise, SpectrumRequest, SubtractedNoise, no_noise, spectrum,
};
use crate::field::Field;
use crate::numeric::lanes::{LaneBlock, WIDTH};
use crate::numeric::sum_of_squares;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::transform::fold;

/// The noise of the sites that are analyzed, in the units of the spectra before they are stored.
#[derive(Debug)]
pub(super) struct KnownNoise {
    pub floor: NoiseFloor,
    /// Of each site, in a bin that counts once.
    power: Vec<f64>,
    /// `sum (w v)^2` of it over all segments.
    pub energies: Vec<f64>,
    /// The first bin that has it: 1 where means are removed.
    first: usize,
    /// Samples of a transform.
    length: usize,
}

/// What was subtracted at a site.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Subtracted {
    /// From the sum over all bins.
    pub total: f64,
    pub clipped_bins: usize,
    /// What setting bins to 0 added to the sum.
    pub clipped: f64,
}

impl KnownNoise {
    /// Finds it in the spectra of the whole record, averaged over segments. `unit`: the amplitude that prepared
    /// samples count as 1.
    ///
    /// # Errors
    /// [`crate::Error::Request`] where no site has noise that is known; those of
    /// [`spectrum`](crate::estimates::spectrum()).
    pub fn find(field: &Field, plan: &Plan, unit: f64, observer: &dyn Observer) -> Result<Self> {
        let request = SpectrumRequest {
            // Samples that are missing are refused by the preparation, if they are.
            gaps: Gaps::LeaveOut,
            threads: Some(plan.threads),
            memory: plan.request.memory,
            ..SpectrumRequest::default()
        };
        let found = spectrum(&[field], &request, observer)?.noise;
        let sites = found.map(|noise| noise.sites).unwrap_or_default();
        let of_plan = plan.sites.clone().map(|site| {
            let is_left_out = plan.is_left_out(site - plan.sites.start);
            sites.get(site).copied().flatten().filter(|_| !is_left_out)
        });
        let floor = NoiseFloor {
            sites: of_plan.collect(),
            subtracted: None,
        };
        if floor.known() == 0 {
            return Err(no_noise());
        }
        let step = plan.axes.time.step;
        let variance = |noise: &Option<SiteNoise>| {
            noise.map_or(0.0, |noise| noise.density / (2.0 * step) / (unit * unit))
        };
        let window = sum_of_squares(&plan.window_time);
        let energies = floor.sites.iter().map(|noise| variance(noise) * window);
        let (factor, segments) = (plan.time_scale.factor, plan.segments.count() as f64);
        Ok(KnownNoise {
            power: energies.clone().map(|e| e * factor).collect(),
            energies: energies.map(|e| e * segments).collect(),
            floor,
            first: usize::from(plan.request.detrend_time != crate::prepare::Detrend::None),
            length: plan.conventions.padded_time,
        })
    }

    /// Whether that of a site in the range analyzed is known.
    pub fn is_known(&self, site: usize) -> bool {
        self.floor.sites[site].is_some()
    }

    /// Subtracts it from the spectra of `width` sites from `first` on, each a lane; never below 0.
    pub fn subtract(
        &self,
        first: usize,
        width: usize,
        power: &mut [LaneBlock],
    ) -> [Subtracted; WIDTH] {
        let mut done = [Subtracted::default(); WIDTH];
        for (m, row) in power.iter_mut().enumerate().skip(self.first) {
            let lanes = row.0.iter_mut().zip(&self.power[first..first + width]);
            for ((p, noise), done) in lanes.zip(&mut done) {
                let rest = *p - noise * fold(m, self.length);
                if rest < 0.0 {
                    done.clipped_bins += 1;
                    done.clipped -= rest;
                }
                let rest = rest.max(0.0);
                done.total += *p - rest;
                *p = rest;
            }
        }
        done
    }

    /// What is left of the bias: sums over bins are multiplied by `measure` to be energies.
    pub fn left(&self, done: &[Subtracted], measure: f64) -> NoiseFloor {
        let uncertain = |(noise, power): (&Option<SiteNoise>, &f64)| {
            let Some(noise) = noise else { return 0.0 };
            let relative = 0.5 * (noise.high - noise.low) / noise.density;
            relative * power * self.length as f64 * measure
        };
        let sites = self.floor.sites.iter().zip(&self.power);
        NoiseFloor {
            sites: self.floor.sites.clone(),
            subtracted: Some(SubtractedNoise {
                clipped_bins: done.iter().map(|one| one.clipped_bins).collect(),
                clipped_power: done.iter().map(|one| one.clipped * measure).collect(),
                uncertain_power: sites.map(uncertain).collect(),
            }),
        }
    }
}
