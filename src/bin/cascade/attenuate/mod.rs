//! `cascade attenuate`: the pulse of a struck chain against its length.

mod measured;
mod summary;

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use wavecascade::Error;
use wavecascade::attenuation::{
    Attenuation, AttenuationRequest, ContactKind, Criterion, Named, Sense, TransmissionPoint,
    TransmissionRequest,
};
use wavecascade::chain::scene::{Scene, SceneSource, Setting};
use wavecascade::observer::Observer;
use wavecascade::report::{
    ATTENUATION_SCHEMA, attenuation_csv, attenuation_html, attenuation_snippet, versioned_json,
    write_beside,
};

use crate::analyze::use_threads;
use crate::chain_args::How;
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::parse;
use crate::progress::Progress;
use crate::saved::Saved;
use crate::scene_keys::SceneKeys;
use crate::terminal;
use measured::{Beside, MeasuredPulses};
pub use summary::{compared_line, failure_lines, without_arrival_line};

/// What `cascade attenuate` takes.
#[derive(Debug, Args)]
pub struct Attenuate {
    /// Files with the chains to compare; keys given as options hold for all of them.
    pub scenes: Vec<PathBuf>,

    /// Dimers of cylinders crossed at these angles, in degrees, and at 90; or at both angles of a
    /// pair, 8/45. The other keys describe the cylinders.
    #[arg(long, value_name = "A[/B],..", value_delimiter = ',', value_parser = angle_pair)]
    pub angles: Vec<[f64; 2]>,

    /// Dimers of these stiffness ratios.
    #[arg(long, value_name = "K,..", value_delimiter = ',', value_parser = parse::finite)]
    pub ratios: Vec<f64>,

    /// Bodies behind the striker up to which attenuation is followed.
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub bodies: u32,

    /// Where the pulse is followed: at the contacts of one long chain, or on the wall behind
    /// chains of every length.
    #[arg(long, value_enum, default_value_t = Where::Both)]
    pub sense: Where,

    /// Lengths in the sense of the wall [default: all up to 40, then in equal ratios].
    #[arg(long, value_name = "N,..", value_delimiter = ',')]
    pub lengths: Option<Vec<usize>>,

    /// Contacts that are fitted and compared with the target; soft and stiff ones carry different
    /// peaks.
    #[arg(long, value_enum, default_value_t = Kind::Soft)]
    pub contacts: Kind,

    /// By what the law of attenuation is chosen: exponential, power law, or plateau.
    #[arg(long, value_enum, default_value_t = Choice::Aicc)]
    pub fit: Choice,

    /// Find the length at which the force is down to this part of that in the homogeneous chain.
    #[arg(long, value_name = "PART", value_parser = parse::finite, allow_negative_numbers = true)]
    pub target: Option<f64>,

    /// Find the angle, or the stiffness ratio, that transmits least force to a wall behind N
    /// bodies.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub best_at: Option<u32>,

    /// The values among which `--best-at` looks, as for `cascade transmit`
    /// [default: angle=2:90:45 with a material, mass_ratio=0.1:1:45 where that is given, else
    /// stiffness_ratio=1:100:45log].
    #[arg(long, value_name = "KEY=VALUES", requires = "best_at")]
    pub best_over: Option<String>,

    /// A measured curve (.csv: bodies, relative force, standard error if known), or with
    /// `--measured-field` a field of velocities, to lay over the first chain.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<PathBuf>,

    /// The measured file is a field of velocities, whose site n is site n of the first chain and whose
    /// times count from the impact on: largest velocities and arrivals (half of these) are compared.
    #[arg(long, requires = "measured")]
    pub measured_field: bool,

    /// Upper edge of the low band, in cycles per unit of time [default: 90 % of the energy of the
    /// first contact's force in the homogeneous chain are below it].
    #[arg(long, value_name = "F", value_parser = parse::finite, allow_negative_numbers = true)]
    pub band_edge_frequency: Option<f64>,

    /// Directory for the results: attenuation.json, curves.csv, the figure attenuation,
    /// report.html, and the finished chains, so that an interrupted run resumes. Without it nothing is saved.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    #[command(flatten)]
    pub figures: FigureArgs,

    #[command(flatten)]
    pub how: How,

    #[command(flatten)]
    pub keys: SceneKeys,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Where {
    Chain,
    Wall,
    Both,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Kind {
    Soft,
    Stiff,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Choice {
    /// Akaike's criterion, corrected for few points.
    Aicc,
    /// The error of predicting a fifth of the points from the others.
    CrossValidation,
}

/// All that is printed and kept.
#[derive(Debug, Serialize)]
pub struct AttenuationReport {
    #[serde(flatten)]
    pub attenuation: Attenuation,
    best: Option<Best>,
    #[serde(flatten)]
    beside: Beside,
    #[serde(skip)]
    measured: MeasuredPulses,
}

impl AttenuationReport {
    /// `report.html`.
    pub fn page(&self) -> String {
        attenuation_html(&self.attenuation, self.measured.laid_over())
    }

    /// # Errors
    /// None for results of this program.
    pub fn to_json(&self) -> serde_json::Result<String> {
        versioned_json(ATTENUATION_SCHEMA, self)
    }
}

/// The value of the key that lets least through.
#[derive(Debug, Clone, Serialize)]
pub struct Best {
    bodies: usize,
    key: String,
    #[serde(flatten)]
    point: TransmissionPoint,
}

fn angle_pair(text: &str) -> Result<[f64; 2], String> {
    let (first, second) = text.split_once('/').unwrap_or((text, "90"));
    let angle = |text: &str| {
        let angle = text.trim().parse::<f64>().ok().filter(|a| a.is_finite());
        angle.ok_or("expected an angle in degrees, or two, A/B".to_owned())
    };
    Ok([angle(first)?, angle(second)?])
}

/// Runs the command.
pub fn run(typed: Attenuate) -> Result<(), Failure> {
    typed
        .figures
        .refuse_without(typed.out.is_some(), "`--out`")?;
    let drawing = typed.figures.drawing()?;
    use_threads(typed.how.threads.map(usize::from))?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    progress.begin_writing();
    let result = typed.find(&progress);
    progress.clear();
    let found = result?;
    let (attenuation, measured) = (&found.attenuation, &found.measured);
    let json = found.to_json().map_err(std::io::Error::from)?;
    let mut main = None;
    if let Some(out) = &typed.out {
        let csv = attenuation_csv(attenuation).map_err(std::io::Error::other)?;
        let page = found.page();
        let figure =
            wavecascade::plot::attenuation(attenuation, measured.laid_over(), &drawing.style);
        let saved = Saved {
            name: "attenuation",
            json: &json,
            csv: &csv,
            page: &page,
        };
        main = Some(out.join(saved.keep(out, &drawing, &figure)?));
        write_beside(out, "plot.py", attenuation_snippet().as_bytes())?;
    }
    if typed.how.json {
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.how.quiet {
        let subject = match typed.scenes.is_empty() {
            true => "struck chains".to_owned(),
            false => subject_of(&typed.scenes),
        };
        let mut told = summary::told(&subject, &found);
        if let Some(main) = main {
            told.last(&format!("open {}", main.display()));
        }
        told.print(typed.how.detail.verbose)?;
    }
    match attenuation.failed.len() {
        0 => Ok(()),
        failed => Err(Failure::Chains(failed)),
    }
}

impl Attenuate {
    /// Follows the pulses, and lays measured ones beside them.
    pub fn find(&self, observer: &dyn Observer) -> Result<AttenuationReport, Error> {
        let request = self.request()?;
        let measured = self.measured()?;
        let (attenuation, best) = self.compute(&request, observer)?;
        Ok(AttenuationReport {
            beside: measured.beside(&attenuation),
            attenuation,
            best,
            measured,
        })
    }

    fn compute(
        &self,
        request: &AttenuationRequest,
        progress: &dyn Observer,
    ) -> Result<(Attenuation, Option<Best>), Error> {
        let attenuation = request.run(self.out.as_deref(), progress)?;
        let Some(bodies) = self.best_at else {
            return Ok((attenuation, None));
        };
        let mut base = self.base()?;
        let typed = base.scene()?;
        if typed.angle.is_none() && typed.second_angle.is_none() && has_material(&typed) {
            base = base.with([setting("second_angle", "90", "best-at")]);
        }
        let over = match &self.best_over {
            Some(over) => over.clone(),
            None => default_over(&base)?,
        };
        let sites = setting("sites", &(bodies + 1).to_string(), "best-at");
        let transmission = TransmissionRequest::new(base.with([sites]), over);
        let directory = self.out.as_ref().map(|out| out.join("best"));
        let found = transmission.run(directory.as_deref(), progress);
        let found = found.map_err(|error| error.of_option("over", "best-over"))?;
        let point = found
            .curves
            .first()
            .and_then(|curve| curve.least())
            .copied();
        let best = point.map(|point| Best {
            bodies: bodies as usize,
            key: found.key.clone(),
            point,
        });
        Ok((attenuation, best))
    }

    /// The one scene that angles or ratios vary.
    fn base(&self) -> Result<SceneSource, Error> {
        let base = match self.scenes.as_slice() {
            [] => SceneSource::default(),
            [one] => SceneSource::read(one)?,
            many => {
                let option = match (self.angles.is_empty(), self.ratios.is_empty()) {
                    (false, _) => "angles",
                    (true, false) => "ratios",
                    (true, true) => "best-at",
                };
                return Err(Error::Request {
                    option,
                    expected: "one scene, whose keys are varied".into(),
                    found: format!("{} scenes", many.len()),
                });
            }
        };
        Ok(base.with(self.keys.settings.clone()))
    }

    fn chains(&self) -> Result<Vec<Named>, Error> {
        let mut chains = Vec::new();
        if self.angles.is_empty() && self.ratios.is_empty() {
            for path in &self.scenes {
                let scene = SceneSource::read(path)?.with(self.keys.settings.clone());
                chains.push(Named {
                    name: stem(path),
                    scene,
                });
            }
            if chains.is_empty() && !self.keys.settings.is_empty() {
                chains.push(Named {
                    name: "chain".into(),
                    scene: self.base()?,
                });
            }
            return Ok(chains);
        }
        let base = self.base()?;
        for [first, second] in &self.angles {
            let angles = [
                setting("angle", &format!("{first:?}"), "angles"),
                setting("second_angle", &format!("{second:?}"), "angles"),
            ];
            chains.push(Named {
                name: format!("angles {first}/{second}"),
                scene: base.with(angles),
            });
        }
        for ratio in &self.ratios {
            let ratios = [setting("stiffness_ratio", &format!("{ratio:?}"), "ratios")];
            chains.push(Named {
                name: format!("ratio {ratio}"),
                scene: base.with(ratios),
            });
        }
        Ok(chains)
    }

    fn request(&self) -> Result<AttenuationRequest, Error> {
        if let Some(sites) = self.keys.settings.iter().find(|s| s.key == "sites") {
            return Err(Error::Request {
                option: "sites",
                expected: "none beside `--bodies`, which says how long the chains are".into(),
                found: sites.text.clone(),
            });
        }
        if let (Some(lengths), Where::Chain) = (&self.lengths, self.sense) {
            return Err(Error::Request {
                option: "lengths",
                expected: "`--sense wall` or both: one long chain has all lengths".into(),
                found: format!("{} lengths and `--sense chain`", lengths.len()),
            });
        }
        let mut chains = self.chains()?;
        // The length is varied; a scene need not state one.
        for chain in &mut chains {
            let sites = setting("sites", &(self.bodies + 1).to_string(), "bodies");
            let typed = chain.scene.scene()?;
            if typed.sites.is_none() {
                chain.scene = chain.scene.with([sites]);
            }
        }
        if chains.is_empty() {
            return Err(Error::Request {
                option: "angles",
                expected: "chains to compare: scene files, --angles, or --ratios".into(),
                found: "none".into(),
            });
        }
        Ok(AttenuationRequest {
            chains,
            length: self.bodies as usize,
            senses: match self.sense {
                Where::Chain => vec![Sense::Chain],
                Where::Wall => vec![Sense::Wall],
                Where::Both => vec![Sense::Chain, Sense::Wall],
            },
            lengths: self.lengths.clone(),
            kind: match self.contacts {
                Kind::Soft => ContactKind::Soft,
                Kind::Stiff => ContactKind::Stiff,
            },
            criterion: match self.fit {
                Choice::Aicc => Criterion::Aicc,
                Choice::CrossValidation => Criterion::CrossValidation,
            },
            target: self.target,
            high_band: true,
            band_edge_frequency: self.band_edge_frequency,
        })
    }
}

/// The key that `--best-at` varies where none is given.
pub fn default_over(scene: &SceneSource) -> Result<String, Error> {
    let typed = scene.scene()?;
    Ok(if has_material(&typed) {
        "angle=2:90:45".into()
    } else if typed.mass_ratio.is_some() {
        "mass_ratio=0.1:1:45".into()
    } else {
        "stiffness_ratio=1:100:45log".into()
    })
}

fn has_material(scene: &Scene) -> bool {
    scene.material.is_some() || scene.young.is_some()
}

fn setting(key: &str, text: &str, option: &str) -> Setting {
    Setting::new(key, text, format!("--{option}"))
}

fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}
