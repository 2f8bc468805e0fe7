//! Options that select budgets, of `cascade budget` and `cascade compare`.

use std::ops::Range;

use clap::ValueEnum;
use wavecascade::budget::{Budget, BudgetRequest, BudgetUnits, Filter, Integration, Views};
use wavecascade::chain::scene::{Setup, Units};
use wavecascade::measure::{Frequency, Length, Measure, Wavenumber};

use crate::prelude::*;

/// Options of the budgets.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "The budgets")]
pub struct ViewArgs {
    /// Compute these beside the balance in real space alone.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VIEW")]
    pub only: Vec<ViewArg>,
    /// Energy by normal mode of the chain, linearized about its static state, its spectral entropy, and the time to
    /// equipartition.
    #[arg(long)]
    pub modes: bool,
    /// Integrate rates over the samples alone: faster, and balances close to the trapezoid rule's
    /// error. By default the chain is stepped anew, and rates are integrated between the times at
    /// which contacts open.
    #[arg(long)]
    pub from_samples: bool,
    /// Filter of the coarse graining.
    #[arg(long, value_enum, default_value_t = FilterArg::Gaussian)]
    pub filter: FilterArg,
    /// Scales l, in units of length, or with their own (20mm) [default: from two cells on, by the square root of two].
    #[arg(long, value_delimiter = ',', value_name = "LENGTH", value_parser = parse::origin::<Length>)]
    pub scales: Vec<Measure<Length>>,
    /// Scale whose flux is kept contact by contact [default: the one in the middle].
    #[arg(long, value_name = "LENGTH", value_parser = parse::origin::<Length>)]
    pub map_scale: Option<Measure<Length>>,
    /// Upper edge of the low band, in cycles per unit of time, or with its unit (2kHz) [default: bounds 90 % of the
    /// energy of the first contact's force].
    #[arg(long, value_name = "FREQUENCY", value_parser = parse::origin::<Frequency>)]
    pub band_edge_frequency: Option<Measure<Frequency>>,
    /// Upper edge of the low band, in rad per unit of length, or with its unit (50rad/m) [default: bounds 90 % of the
    /// energy at the first sample with energy].
    #[arg(long, value_name = "WAVENUMBER", value_parser = parse::origin::<Wavenumber>)]
    pub band_edge_wavenumber: Option<Measure<Wavenumber>>,
    /// Pairs of contacts between which each band's gain and the energy left behind are reported,
    /// besides the first, the middle and the last.
    #[arg(long, value_delimiter = ',', value_name = "A:B", value_parser = parse::pair)]
    pub between: Vec<[usize; 2]>,
    /// Samples over which the real-space balance is judged, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub window_samples: Option<Range<usize>>,
    /// Sites over which it is judged, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub window_sites: Option<Range<usize>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ViewArg {
    /// E(k, t), transfer, flux.
    Wavenumber,
    /// Power flow by frequency.
    Frequency,
    /// Coarse-grained flux.
    Scale,
}

choice!(FilterArg => Filter {
    /// sigma = l / sqrt(12).
    Gaussian,
    /// Equal weights over l.
    Box,
    /// Cut off at k = 2 pi / l; periodic chains only.
    Sharp,
});

impl ViewArgs {
    pub fn request(&self, setup: &Setup) -> Result<BudgetRequest, Error> {
        let simulation = &setup.simulation;
        let sites = simulation.chain.n_sites();
        self.choices(simulation.samples, sites, request_of(setup))
    }

    /// Sets band edges and mapped scale that were not typed to those of a first budget, so that
    /// both are compared alike.
    pub fn take_over(&mut self, found: &Budget) {
        let edge = |edge: f64| edge.is_finite().then_some(edge);
        let over_f = found.frequency.as_ref().and_then(|flow| edge(flow.edge));
        self.band_edge_frequency = self.band_edge_frequency.or(over_f.map(Measure::new));
        let over_k = found.wavenumber.as_ref().and_then(|found| edge(found.edge));
        self.band_edge_wavenumber = self.band_edge_wavenumber.or(over_k.map(Measure::new));
        let mapped = found.scales.as_ref().map(|found| found.map_scale);
        self.map_scale = self.map_scale.or(mapped.map(Measure::new));
    }

    /// The choices typed over `base`.
    ///
    /// # Errors
    /// [`Error::Request`] for a unit where the run has none.
    pub fn choices(
        &self,
        samples: usize,
        sites: usize,
        base: BudgetRequest,
    ) -> Result<BudgetRequest, Error> {
        let units = AxisUnits {
            time: base.units.time.as_deref(),
            length: base.units.length.as_deref(),
            samples: None,
        };
        let edge = self.band_edge_wavenumber;
        let band_edge_wavenumber = units.stated("band-edge-wavenumber", edge)?;
        let scales = self.scales.iter();
        let scales = scales.map(|scale| units.number("scales", *scale));
        let only = |view| self.only.is_empty() || self.only.contains(&view);
        let is_window = self.window_samples.is_some() || self.window_sites.is_some();
        let window = is_window.then(|| {
            let samples = self.window_samples.clone().unwrap_or(0..samples);
            [samples, self.window_sites.clone().unwrap_or(0..sites)]
        });
        Ok(BudgetRequest {
            views: Views {
                wavenumber: only(ViewArg::Wavenumber),
                frequency: only(ViewArg::Frequency),
                scale: only(ViewArg::Scale),
            },
            normal_modes: self.modes,
            filter: self.filter.into(),
            scales: scales.collect::<Result<_, _>>()?,
            map_scale: units.stated("map-scale", self.map_scale)?,
            band_edge_frequency: units.stated("band-edge-frequency", self.band_edge_frequency)?,
            band_edge_wavenumber,
            window,
            between: self.between.clone(),
            integration: match self.from_samples {
                true => Integration::Samples,
                false => Integration::Stepping,
            },
            ..base
        })
    }
}

/// All views of a run, in its units.
pub fn request_of(setup: &Setup) -> BudgetRequest {
    BudgetRequest {
        pitch: setup.pitch.unwrap_or(1.0),
        units: match (setup.units, setup.pitch) {
            (Units::None, _) => BudgetUnits::default(),
            (Units::Si, Some(_)) => BudgetUnits::si(),
            // Without a stated distance, positions are site indices.
            (Units::Si, None) => BudgetUnits {
                length: None,
                ..BudgetUnits::si()
            },
        },
        ..BudgetRequest::default()
    }
}
