//! `cascade triads`: which wavenumbers feed which, where the law is quadratic.

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use wavecascade::budget::{
    BudgetUnits, Motion, Triads as Found, TriadsRequest, burgers_triads, chain_triads,
};
use wavecascade::field::is_run_file;
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    LabelledArrays, Provenance, RunFile, TriadsSummary, number, percent, triad_arrays,
    triad_sentences, triads_html,
};
use wavecascade::{Error, Field};

use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::further::input_options;
use crate::parse;
use crate::summary::Summary;
use crate::view_args::request_of;
use crate::words;

/// What `cascade triads` takes.
#[derive(Debug, Args)]
pub struct Triads {
    /// Run file of `cascade simulate`; with `--equation burgers`, a field that obeys it.
    #[arg(required = true, num_args = 1, value_name = "RUN")]
    pub run: Vec<PathBuf>,

    /// Equation of a field that is no run: burgers, `u_t + u u_x = nu u_xx`, on sites that are one period.
    #[arg(long, value_enum)]
    pub equation: Option<EquationArg>,
    /// Samples over which transfers are integrated, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub window_samples: Option<Range<usize>>,
    /// Working memory, such as 500MB [default: half of the free memory].
    #[arg(long, value_name = "BYTES", value_parser = parse::bytes)]
    pub memory: Option<u64>,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EquationArg {
    Burgers,
}

impl Triads {
    fn request(&self, units: BudgetUnits) -> TriadsRequest {
        TriadsRequest {
            window: self.window_samples.clone(),
            units,
            threads: self.estimate.threads(),
            memory: self.memory,
        }
    }

    /// Of a run and its scene.
    pub fn of_run(&self, file: &RunFile, observer: &dyn Observer) -> Result<Found, Error> {
        let motion = Motion::of(&file.run)?;
        let base = request_of(&file.setup);
        chain_triads(&motion, base.pitch, &self.request(base.units), observer)
    }

    /// Of a field that obeys the equation that is typed.
    pub fn of_field(&self, field: &Field, observer: &dyn Observer) -> Result<Found, Error> {
        let (times, sites) = (field.n_times(), field.n_sites());
        let needed = 8 * (times as u64) * (sites as u64);
        let allowed = self.memory.unwrap_or(u64::MAX);
        let memory = Error::Memory {
            what: "the samples of all times",
            needed,
            allowed,
        };
        if needed > allowed {
            return Err(memory);
        }
        let Ok(mut u) = wavecascade_system::memory::try_filled(times * sites, 0.0) else {
            return Err(memory);
        };
        field.read_time_major(0..times, 0..sites, &mut u);
        let length = field.space.step * sites as f64;
        let time = [field.time.origin, field.time.step];
        let units = BudgetUnits {
            time: field.time.unit.clone(),
            length: field.space.unit.clone(),
            energy: field.unit.as_deref().map(|unit| format!("({unit})²")),
        };
        let u = ndarray::ArrayView2::from_shape((times, sites), &u).map_err(|_| memory)?;
        burgers_triads(u, time, length, &self.request(units), observer)
    }
}

impl Typed for Triads {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        &self.run
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let path = &self.run[0];
        let is_run = path.is_file() && is_run_file(path)?;
        if path.is_file() {
            self.check(&path.display().to_string(), is_run, words::as_text())?;
        }
        Ok(
            move |fields: &[&Field], observer: &dyn Observer| match is_run {
                true => self.of_run(&RunFile::read(path)?, observer),
                false => self.of_field(fields[0], observer),
            },
        )
    }
}

impl Triads {
    /// That there is an equation of a field, and that a run has neither another one nor axes among the words.
    ///
    /// # Errors
    /// [`Error::Request`].
    pub fn check(&self, name: &str, is_run: bool, words: Vec<String>) -> Result<(), Error> {
        let refuse = |option, expected: &str, found: String| {
            Err(Error::Request {
                option,
                expected: expected.into(),
                found,
            })
        };
        let typed = input_options(words);
        match self.equation {
            Some(_) if is_run => {
                let found = format!("{name}, a run with a law of its own");
                refuse("equation", "a field that is no run", found)
            }
            None if !is_run => {
                let expected = "the equation of a field that is no run, such as burgers, or a run file of \
                                `cascade simulate`";
                let found = format!("none, and {name} is no run");
                refuse("equation", expected, found)
            }
            None if !typed.is_empty() => {
                let expected = "no options of fields with a run file, which has its own axes";
                refuse("run", expected, typed.trim().to_owned())
            }
            _ => Ok(()),
        }
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "triads";
    const EXTENSION: &'static str = "npz";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        TriadsSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        triad_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::triads(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        triads_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        let mut warnings = Vec::new();
        let largest = self.flux[self.locality.at].abs();
        if self.sampling_error > 0.1 * largest && largest > 0.0 {
            warnings.push([
                format!(
                    "the samples are too far apart: their sums are uncertain by {} of the largest flux",
                    percent(self.sampling_error / largest)
                ),
                "simulate with more samples".into(),
            ]);
        }
        warnings
    }

    fn answer(&self) -> String {
        let unit = match &self.units.length {
            Some(unit) => format!("rad/{unit}"),
            None => "rad per site".into(),
        };
        let at = self.locality.at;
        let flux = self.flux[at];
        let share = |energy: f64| percent(energy.abs() / self.energy);
        if !self.is_quadratic() {
            return "no triads can be stated: the law has no useful quadratic expansion at these amplitudes".into();
        }
        if !self.is_resolved() {
            return "no flux is resolved: the largest is not ten times its error".into();
        }
        let towards = if flux > 0.0 { "larger" } else { "smaller" };
        format!(
            "{} of the energy passes k = {} {unit} towards {towards} wavenumbers",
            share(flux),
            number(self.wavenumber[at])
        )
    }

    fn tell(&self, summary: &mut Summary) {
        for (name, text) in triad_sentences(self) {
            match name.as_str() {
                "expansion" => summary.detail(&name, &text),
                _ => summary.fact(&name, &text),
            }
        }
    }
}
