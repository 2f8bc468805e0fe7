//! `cascade modes`: motions that are coherent along x, by frequency.

use std::path::PathBuf;

use clap::Args;
use wavecascade::estimates::{Modes as Found, ModesRequest, modes};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    LabelledArrays, ModesSummary, Provenance, modes_arrays, modes_html, percent,
};
use wavecascade::{Error, Field};

use crate::coherence::AverageArgs;
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed};
use crate::terminal::{self, Lines, number};

/// What `cascade modes` takes.
#[derive(Debug, Args)]
pub struct Modes {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Frequencies whose modes are written, in cycles per unit of time, such as 0.1,0.25 [default: that of the
    /// largest eigenvalue].
    #[arg(long, value_name = "F,...", value_delimiter = ',')]
    pub frequencies: Vec<f64>,

    /// Modes that are written of each of these frequencies.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub modes: usize,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Typed for Modes {
    type Found = Found;

    fn fields(&self) -> &[PathBuf] {
        &self.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let request = ModesRequest {
            frequencies: self.frequencies.clone(),
            modes: self.modes,
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        };
        Ok(move |fields: &[&Field], observer: &dyn Observer| modes(fields, &request, observer))
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "modes";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        ModesSummary::new(self, provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        modes_arrays(self, to)
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        vec![plot::modes(self, name, style)]
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        modes_html(self, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        let independence = &self.independence;
        if !(independence.is_transient() && independence.records < 2) {
            return Vec::new();
        }
        let message = format!(
            "the record is a transient: its energy lies in a few of its parts (steadiness {}), and segments of \
             one transient are not independent; no interval is stated",
            number(independence.steadiness)
        );
        let advice = "name several records of the same sites, one a shot";
        vec![[message, advice.into()]]
    }

    fn lines(&self) -> String {
        lines(self)
    }
}

/// What was found, in words.
fn lines(found: &Found) -> String {
    let mut lines = Lines::new(terminal::width());
    let independence = &found.independence;
    lines.line(
        "averages",
        &format!(
            "records {}, segments {} of {} samples, tapers {}: {} effective realisations",
            independence.records,
            independence.segments,
            found.segment[0],
            independence.tapers,
            number(independence.effective)
        ),
    );
    lines.line(
        "first modes",
        &format!(
            "hold {} of the power",
            percent(found.leading_share_of_all())
        ),
    );
    let interval = match found.interval(1) {
        Some([low, high]) => format!(
            "{} to {} of an eigenvalue, by chi-square, with probability {}",
            number(low),
            number(high),
            percent(1.0 - found.alpha)
        ),
        None => "none can be stated".into(),
    };
    lines.line("interval", &interval);
    let (time_unit, space_unit) = found.units();
    for shapes in &found.chosen {
        let share = percent(found.leading_share(shapes.bin));
        let wave = match shapes.waves.first().copied().flatten() {
            Some(wave) if wave.is_wave => format!(
                "; a wave, k = {} rad/{space_unit}, {} {space_unit}/{time_unit}",
                number(wave.wavenumber),
                number(wave.velocity)
            ),
            _ => String::new(),
        };
        lines.line(
            &format!("f = {}", number(shapes.frequency)),
            &format!("the first mode holds {share} of the power{wave}"),
        );
    }
    lines.text
}
