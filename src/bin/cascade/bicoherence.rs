//! `cascade bicoherence`: coupling of three frequencies, and on request the transfer between two sites.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use wavecascade::estimates::{Bicoherence, BicoherenceRequest, Transfer, bicoherence, transfer};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{
    BicoherenceSummary, LabelledArrays, Provenance, bicoherence_arrays, bicoherence_html,
    transfer_arrays,
};
use wavecascade::{Error, Field};

use crate::coherence::averages;
use crate::estimate::{Computation, Estimate, EstimateArgs, Typed, one_realisation};
use crate::parse;
use crate::summary::Summary;
use crate::terminal::number;
use crate::transfer::{self, TransferArgs};
use crate::triple_args::TripleArgs;

/// What `cascade bicoherence` takes.
#[derive(Debug, Args)]
pub struct BicoherenceArgs {
    /// File with the field; several, or patterns such as `'shot*.npy'`, are repeated records (shots) of the
    /// same sites, which are averaged.
    #[arg(required = true, value_name = "FIELD")]
    pub fields: Vec<PathBuf>,

    /// Index of the site of the two frequencies that are added.
    #[arg(long, short, value_name = "SITE", default_value_t = 0)]
    pub site: usize,

    /// Index of the site of their sum and difference [default: the same, where differences repeat sums].
    #[arg(long, value_name = "SITE")]
    pub output: Option<usize>,

    /// Sites whose own bicoherence is followed along x, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub along: Option<Range<usize>>,

    /// Of these every N-th; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub every: usize,

    #[command(flatten)]
    pub averages: TripleArgs,
    #[command(flatten)]
    pub transfer: TransferArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

/// What was found.
pub struct Found {
    bicoherence: Bicoherence,
    transfer: Option<Transfer>,
}

impl Typed for BicoherenceArgs {
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
        Ok(|fields: &[&Field], observer: &dyn Observer| {
            let first = fields.first();
            let n_sites = first.map_or(0, |field| field.n_sites());
            let unit = first.and_then(|field| field.time.unit.as_deref());
            let of_transfer = self.transfer.request(self, unit)?;
            Ok(Found {
                bicoherence: bicoherence(fields, &self.request(n_sites), observer)?,
                transfer: match of_transfer {
                    Some(request) => Some(transfer(fields, &request, observer)?),
                    None => None,
                },
            })
        })
    }
}

impl BicoherenceArgs {
    fn request(&self, n_sites: usize) -> BicoherenceRequest {
        let along = self.along.clone().unwrap_or(0..n_sites);
        BicoherenceRequest {
            site: self.site,
            output: self.output,
            along: match self.every {
                0 => Vec::new(),
                every => along.step_by(every).collect(),
            },
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.averages.memory,
        }
    }
}

impl Estimate for Found {
    const COMMAND: &'static str = "bicoherence";

    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        BicoherenceSummary::new(&self.bicoherence, self.transfer.as_ref(), provenance).to_json()
    }

    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error> {
        bicoherence_arrays(&self.bicoherence, to)?;
        let transfer = self.transfer.iter();
        transfer.map(|found| transfer_arrays(found, to)).collect()
    }

    fn figures(&self, name: &str, style: &Style) -> Vec<Figure> {
        let transfer = self.transfer.iter();
        let transfer = transfer.map(|found| plot::transfer(found, name, style));
        std::iter::once(plot::bicoherence(&self.bicoherence, name, style))
            .chain(transfer)
            .collect()
    }

    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String> {
        let found = (&self.bicoherence, self.transfer.as_ref());
        bicoherence_html(found, name, provenance, warnings, style)
    }

    fn warnings(&self) -> Vec<[String; 2]> {
        let mut all = warnings(&self.bicoherence);
        all.extend(self.transfer.iter().flat_map(transfer::warnings));
        all
    }

    fn answer(&self) -> String {
        answer(&self.bicoherence)
    }

    fn tell(&self, summary: &mut Summary) {
        tell(&self.bicoherence, summary);
        if let Some(found) = &self.transfer {
            transfer::tell(found, summary);
        }
    }
}

/// Triples that are printed at most.
const PRINTED: usize = 5;

/// Which frequencies are coupled, in words.
fn answer(found: &Bicoherence) -> String {
    let independence = &found.independence;
    let (Some(_), Some(map)) = (found.cell_level(), found.map_level()) else {
        let why = match independence.is_transient() {
            true => independence.why(),
            false => "there are too few independent realisations",
        };
        return format!("coupling cannot be told: {why}");
    };
    if independence.is_transient() {
        return "coupling cannot be told: pulses of one shape in every record are coupled at all frequencies".into();
    }
    if found.cells() == 0 {
        return "coupling cannot be told: no triple of frequencies has power at all three".into();
    }
    let unit = wavecascade::measure::cycles_per(&found.units().0);
    match (found.above(map), found.strongest(1).first()) {
        (0, _) | (_, None) => format!(
            "no frequencies are coupled with their sum above chance (b\u{b2} below {})",
            number(map)
        ),
        (count, Some(triple)) => {
            let [first, second, third] = triple.frequencies.map(number);
            let others = match count - 1 {
                0 => String::new(),
                1 => ", and one more triple".into(),
                others => format!(", and {others} more triples"),
            };
            format!(
                "{first} and {second} are coupled with {third} {unit} (b\u{b2} {}){others}",
                number(triple.bicoherence)
            )
        }
    }
}

fn tell(found: &Bicoherence, summary: &mut Summary) {
    if found.cell_level().is_some() {
        summary.detail("coupling", &found.coupling());
    }
    let unit = wavecascade::measure::cycles_per(&found.units().0);
    let level = found.map_level().unwrap_or(f64::NAN);
    let strongest = found.strongest(PRINTED);
    for (n, triple) in strongest.iter().enumerate() {
        let [first, second, third] = triple.frequencies.map(number);
        let degrees = |angle: f64| format!("{:.0}", angle.to_degrees());
        let half = match triple.biphase_interval.is_finite() {
            true => format!(" \u{b1} {}", degrees(triple.biphase_interval)),
            false => String::new(),
        };
        let text = format!(
            "{first} and {second} with {third} {unit}: b\u{b2} {}, biphase {}{half} degrees",
            number(triple.bicoherence),
            degrees(triple.biphase)
        );
        let name = if n == 0 { "strongest" } else { "" };
        match triple.bicoherence > level {
            true => summary.fact(name, &text),
            false => summary.detail(name, &text),
        }
    }
    summary.detail("averages", &averages(&found.independence, found.segment[0]));
}

/// What the user should know, each with what to do.
fn warnings(found: &Bicoherence) -> Vec<[String; 2]> {
    let independence = &found.independence;
    let mut warnings = Vec::new();
    if let Some(warning) = one_realisation(independence, "record") {
        warnings.push(warning);
    } else if independence.is_transient() {
        warnings.push([
            "the records are transients: alike in every shot, they have a bicoherence of 1".into(),
            "compare sites along x, or use a budget if the chain is known".into(),
        ]);
    }
    if let Some(level) = found.map_level().filter(|level| *level > 0.5) {
        warnings.push([
            format!(
                "coupling below b\u{b2} {} is not seen with {} effective realisations",
                number(level),
                number(independence.effective)
            ),
            "use shorter segments (--segment), a longer record, or several shots".into(),
        ]);
    }
    warnings
}
