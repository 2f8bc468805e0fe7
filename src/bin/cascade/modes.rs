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

use crate::coherence::{AverageArgs, averages};
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed, one_realisation};
use crate::summary::Summary;
use crate::terminal::number;

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
        one_realisation(&self.independence, "record")
            .into_iter()
            .collect()
    }

    fn answer(&self) -> String {
        answer(self)
    }

    fn tell(&self, summary: &mut Summary) {
        tell(self, summary);
    }
}

/// How many modes there are, in words.
fn answer(found: &Found) -> String {
    let unit = wavecascade::measure::cycles_per(&found.units().0);
    let Some(shapes) = found.chosen.first() else {
        return "no power at any frequency".into();
    };
    let at = format!("{} {unit}", number(shapes.frequency));
    let share = percent(found.leading_share(shapes.bin));
    let Some(count) = found.above_noise(shapes.bin) else {
        let why = match found.independence.is_transient() {
            true => found.independence.why(),
            false => "there are too few realisations",
        };
        return format!(
            "the first mode at {at} holds {share}; how many there are cannot be told: {why}"
        );
    };
    match count {
        0 => format!(
            "no motion is coherent along x at {at}: the first mode holds {share}, as noise would"
        ),
        1 => format!("one mode at {at}, which holds {share} of the power"),
        _ => format!("{count} modes at {at}, of which the first holds {share} of the power"),
    }
}

fn tell(found: &Found, summary: &mut Summary) {
    let text = format!(
        "hold {} of the power of all frequencies",
        percent(found.leading_share_of_all())
    );
    summary.fact("first modes", &text);
    let interval = match found.interval(1) {
        Some([low, high]) => format!(
            "{} to {} of an eigenvalue, by chi-square, with probability {}",
            number(low),
            number(high),
            percent(1.0 - found.alpha)
        ),
        None => "none can be stated".into(),
    };
    summary.fact("interval", &interval);
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
        let name = format!("f = {}", number(shapes.frequency));
        summary.fact(
            &name,
            &format!("the first mode holds {share} of the power{wave}"),
        );
    }
    summary.detail("averages", &averages(&found.independence, found.segment[0]));
}
