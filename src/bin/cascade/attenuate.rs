//! `cascade attenuate`: the pulse of a struck chain against its length, or against a key of its scene.

use wavecascade::attenuation::{
    AttenuationRequest, ContactKind, Criterion, Curves, Followed, Measured, MeasuredPeak, Named,
    Sense, TransmissionRequest, measured_peaks, read_curve,
};
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::report::{attenuation_snippet, transmission_snippet};

use crate::analyze::print_notes;
use crate::prelude::*;
use crate::scene::source_of;
use crate::scene_keys::SceneKeys;

/// What `cascade attenuate` takes.
#[derive(Debug, Args)]
#[command(mut_arg("out", |arg| arg.help(OUT)), mut_arg("force", |arg| arg.hide(true)))]
#[command(mut_arg("open", |arg| arg.requires("out")), mut_arg("show", |arg| arg.requires("out")))]
pub struct Attenuate {
    /// Files with the chains to compare, one against a key; keys given as options hold for all of them.
    pub scenes: Vec<PathBuf>,

    /// Against what the pulse is followed: the number of bodies, or at the wall against a key of the scene with its
    /// values, as for `cascade sweep`: angle=2:90:45 (equal steps), stiffness_ratio=1:100:45log (equal ratios). These two
    /// and mass_ratio have usual values; angles are crossed with 90 degrees where the scene states none.
    #[arg(long, value_name = "bodies|KEY[=VALUES]", default_value = BODIES)]
    pub against: String,

    /// A measured curve (.csv: abscissa, relative force, standard error if known) to lay over the first one. Or a field
    /// of velocities whose times count from the impact on: of site n of the first chain, with `--measured-field`;
    /// against a key VALUE=FIELD, whose last site is that of the chain with this value.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<String>,

    #[command(flatten)]
    pub result: ResultArgs,

    #[command(flatten)]
    pub length: LengthArgs,

    #[command(flatten)]
    pub key: KeyArgs,

    #[command(flatten)]
    pub keys: SceneKeys,
}

const OUT: &str = "Directory for the results: summary.json, curves.csv, the figure, report.html, and the finished chains, so \
    that an interrupted run resumes. Without it nothing is saved";

/// The usual abscissa.
const BODIES: &str = "bodies";

/// Bodies up to which attenuation is followed where none are stated.
const LENGTH: u32 = 40;

/// Options of curves against length.
#[derive(Debug, Args)]
#[command(next_help_heading = "Against the number of bodies")]
pub struct LengthArgs {
    /// Dimers of cylinders crossed at these angles, in degrees, and at 90; or at both angles of a
    /// pair, 8/45. The other keys describe the cylinders.
    #[arg(long, value_name = "A[/B],..", value_delimiter = ',', value_parser = angle_pair)]
    pub angles: Vec<[f64; 2]>,

    /// Dimers of these stiffness ratios.
    #[arg(long, value_name = "K,..", value_delimiter = ',', value_parser = parse::finite)]
    pub ratios: Vec<f64>,

    /// Bodies behind the striker up to which attenuation is followed [default: 40].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub bodies: Option<u32>,

    /// Where the pulse is followed: at the contacts of one long chain, or on the wall behind
    /// chains of every length [default: both].
    #[arg(long, value_enum)]
    pub sense: Option<Where>,

    /// Lengths in the sense of the wall [default: all up to 40, then in equal ratios].
    #[arg(long, value_name = "N,..", value_delimiter = ',')]
    pub lengths: Option<Vec<usize>>,

    /// Contacts that are fitted and compared with the target; soft and stiff ones carry different
    /// peaks [default: soft].
    #[arg(long, value_enum)]
    pub contacts: Option<Kind>,

    /// By what the law of attenuation is chosen: exponential, power law, or plateau [default: aicc].
    #[arg(long, value_enum)]
    pub fit: Option<Choice>,

    /// Find the length at which the force is down to this part of that in the homogeneous chain.
    #[arg(long, value_name = "PART", value_parser = parse::finite)]
    pub target: Option<f64>,

    /// The measured file is a field of velocities.
    #[arg(long, requires = "measured")]
    pub measured_field: bool,

    /// Upper edge of the low band, in cycles per unit of time [default: 90 % of the energy of the
    /// first contact's force in the homogeneous chain are below it].
    #[arg(long, value_name = "F", value_parser = parse::finite)]
    pub band_edge_frequency: Option<f64>,
}

impl LengthArgs {
    /// Refuses what says something of lengths, or of other chains, beside a key.
    fn refuse_beside(&self, key: &str) -> Result<(), Error> {
        let is_inside = matches!(self.sense, Some(Where::Chain | Where::Both));
        let typed = [
            ("angles", !self.angles.is_empty()),
            ("ratios", !self.ratios.is_empty()),
            ("bodies", self.bodies.is_some()),
            ("lengths", self.lengths.is_some()),
            ("sense", is_inside),
            ("target", self.target.is_some()),
            ("contacts", self.contacts.is_some()),
            ("fit", self.fit.is_some()),
            ("band-edge-frequency", self.band_edge_frequency.is_some()),
        ];
        let Some((option, _)) = typed.into_iter().find(|(_, is_typed)| *is_typed) else {
            return Ok(());
        };
        let expected = match option {
            "angles" | "ratios" => "values of the key: angle=A,B,.. or stiffness_ratio=A,B,..",
            "bodies" | "lengths" => "`--sites N`, or `--vary sites=A,B,..`",
            "sense" => "`--sense wall`: against a key the pulse is followed there",
            _ => "`--against bodies`, with a scene file, `--angles` or `--ratios` for each chain",
        };
        let found = format!("`--{option}` beside `--against {key}`");
        Err(Error::request(option, expected, found))
    }
}

/// Options of curves against a key.
#[derive(Debug, Args)]
#[command(next_help_heading = "Against a key of the scene")]
pub struct KeyArgs {
    /// Another key and its values, a curve for each: striker_velocity=0.5,1,2 or sites=21,41,81 or
    /// tangent=0,1e-6. Repeat it for all combinations.
    #[arg(long, value_name = "KEY=VALUES", requires = "against")]
    pub vary: Vec<String>,

    /// Leave out the search for the extremes between the values.
    #[arg(long, requires = "against")]
    pub no_extremes: bool,
}

choice!(Where => Vec<Sense> {
    Chain => vec![Sense::Chain],
    Wall => vec![Sense::Wall],
    Both => vec![Sense::Chain, Sense::Wall],
});

choice!(Kind => ContactKind { Soft, Stiff });

choice!(Choice => Criterion {
    /// Akaike's criterion, corrected for few points.
    Aicc,
    /// The error of predicting a fifth of the points from the others.
    CrossValidation,
});

fn angle_pair(text: &str) -> Result<[f64; 2], String> {
    let (first, second) = text.split_once('/').unwrap_or((text, "90"));
    let angle = |text: &str| {
        let angle = text.trim().parse::<f64>().ok().filter(|a| a.is_finite());
        angle.ok_or("expected an angle in degrees, or two, A/B".to_owned())
    };
    Ok([angle(first)?, angle(second)?])
}

impl Describing for Attenuate {
    fn about(&self) -> About<'_> {
        About {
            subject: "struck chains".into(),
            is_journal: true,
            ..About::of("attenuate", &self.result.how, &self.scenes, "toml")
        }
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let found = self.followed(given.scene, observer)?;
        let (script, failed) = (script(&found.curves), found.failed().len());
        Ok(Found {
            failed: (failed > 0).then(|| {
                format!(
                    "{failed} of the chains could not be followed, for reasons given under `failed`; the \
                     others stand"
                )
            }),
            ..Found::of(found).with_text("plot.py", script)
        })
    }
}

/// Draws `curves.csv`.
fn script(curves: &Curves) -> String {
    match curves {
        Curves::Length(_) => attenuation_snippet(),
        Curves::Key(found) => {
            let first = found.curves.first();
            let others = first.map_or(&[][..], |curve| &curve.settings);
            let others: Vec<&str> = others.iter().map(|(key, _)| &**key).collect();
            transmission_snippet(&found.key, &others)
        }
    }
}

impl Attenuate {
    /// Follows the pulses, and lays measured ones beside them. `text` is that of a scene without a file.
    fn followed(&self, text: Option<String>, observer: &dyn Observer) -> Result<Followed, Error> {
        let directory = self.result.out.as_deref();
        let is_length = self.against == BODIES;
        let (curves, measured) = if is_length {
            if let Some(vary) = self.key.vary.first() {
                let expected = "a key behind `--against`; lengths are compared of scene files, `--angles` or `--ratios`";
                let found = format!("`{vary}` beside `--against {BODIES}`");
                return Err(Error::request("vary", expected, found));
            }
            let request = self.request(text)?;
            let measured = self.measured_along()?;
            (Curves::Length(request.run(directory, observer)?), measured)
        } else {
            self.length.refuse_beside(&self.against)?;
            let base = self.base(text, "against")?;
            let (scene, over) = against(base, &self.against)?;
            let (measured, also) = self.measured_at()?;
            let request = TransmissionRequest {
                also,
                vary: self.key.vary.clone(),
                locate: !self.key.no_extremes,
                ..TransmissionRequest::new(scene, over)
            };
            (Curves::Key(request.run(directory, observer)?), measured)
        };
        Ok(Followed::new(curves, measured))
    }

    /// What was measured along the first chain.
    fn measured_along(&self) -> Result<Measured, Error> {
        let Some(path) = &self.measured else {
            return Ok(Measured::default());
        };
        if !self.length.measured_field {
            return Ok(Measured::of_forces(read_curve(Path::new(path))?));
        }
        let is_inside = self.length.sense != Some(Where::Wall);
        let expected = "`--sense chain` or both: sites of a field are those of one chain";
        Error::require(is_inside, "measured-field", expected, "wall")?;
        let (field, peaks) = self.peaks_of(Path::new(path))?;
        let points = peaks.iter().map(|peak| peak.points(peak.site as f64));
        let (velocities, arrivals): (_, Vec<_>) = points.unzip();
        // The struck body moves fastest when it is struck, which is no peak.
        let has_none = |site: &usize| peaks.binary_search_by_key(site, |peak| peak.site).is_err();
        let without_peak = (1..field.n_sites()).filter(has_none);
        Ok(Measured {
            velocities,
            arrivals: arrivals.into_iter().flatten().collect(),
            without_peak: without_peak.map(|site| site as f64).collect(),
            ..Measured::default()
        })
    }

    /// What was measured at values of the key, and these values.
    fn measured_at(&self) -> Result<(Measured, Vec<f64>), Error> {
        let Some(typed) = &self.measured else {
            return Ok(Default::default());
        };
        let with_value = typed.split_once('=');
        let with_value = with_value.and_then(|(v, path)| Some((v.parse::<f64>().ok()?, path)));
        let Some((at, path)) = with_value else {
            let forces = read_curve(Path::new(typed))?;
            let values = forces.iter().map(|point| point.at).collect();
            return Ok((Measured::of_forces(forces), values));
        };
        let (field, peaks) = self.peaks_of(Path::new(path))?;
        let last = peaks.last();
        let Some(peak) = last.filter(|peak| peak.site + 1 == field.n_sites()) else {
            let expected = "a field with a pulse at its last site";
            return Err(unfit(Path::new(path), expected, "none there"));
        };
        let (velocity, arrival) = peak.points(at);
        let measured = Measured {
            velocities: vec![velocity],
            arrivals: arrival.into_iter().collect(),
            ..Measured::default()
        };
        Ok((measured, vec![at]))
    }

    /// A measured field with its peaks.
    fn peaks_of(&self, path: &Path) -> Result<(Field, Vec<MeasuredPeak>), Error> {
        let field = Field::open(path, &wavecascade::field::OpenOptions::default())?;
        print_notes(&field, self.result.how.quiet);
        let peaks = measured_peaks(&field);
        field.check_unchanged()?;
        Ok((field, peaks))
    }

    /// The one scene whose keys an option varies.
    fn base(&self, text: Option<String>, option: &'static str) -> Result<SceneSource, Error> {
        let is_one = text.is_some() || self.scenes.len() < 2;
        let found = format!("{} scenes", self.scenes.len());
        Error::require(is_one, option, "one scene, whose keys are varied", found)?;
        let base = source_of(text, self.scenes.first().map(PathBuf::as_path))?;
        Ok(base.with(self.keys.settings.clone()))
    }

    fn chains(&self, text: Option<String>) -> Result<Vec<Named>, Error> {
        let LengthArgs { angles, ratios, .. } = &self.length;
        let settings = &self.keys.settings;
        if angles.is_empty() && ratios.is_empty() {
            if self.scenes.is_empty() && (text.is_some() || !settings.is_empty()) {
                let scene = self.base(text, "against")?;
                let name = "chain".into();
                return Ok(vec![Named { name, scene }]);
            }
            let read = |path: &PathBuf| {
                let scene = SceneSource::read(path)?.with(settings.clone());
                let name = stem_of(path);
                Ok(Named { name, scene })
            };
            return self.scenes.iter().map(read).collect();
        }
        let option = match angles.is_empty() {
            true => "ratios",
            false => "angles",
        };
        let base = self.base(text, option)?;
        let crossed = angles.iter().map(|[first, second]| Named {
            name: format!("angles {first}/{second}"),
            scene: base.with([
                setting("angle", &format!("{first:?}"), "angles"),
                setting("second_angle", &format!("{second:?}"), "angles"),
            ]),
        });
        let of_ratios = ratios.iter().map(|ratio| Named {
            name: format!("ratio {ratio}"),
            scene: base.with([setting("stiffness_ratio", &format!("{ratio:?}"), "ratios")]),
        });
        Ok(crossed.chain(of_ratios).collect())
    }

    fn request(&self, text: Option<String>) -> Result<AttenuationRequest, Error> {
        let typed = &self.length;
        let bodies = typed.bodies.unwrap_or(LENGTH);
        if let Some(sites) = self.keys.settings.iter().find(|s| s.key == "sites") {
            let expected = "none beside `--bodies`, which says how long the chains are";
            return Err(Error::request("sites", expected, &sites.text));
        }
        let mut chains = self.chains(text)?;
        // The length is varied; a scene need not state one.
        for chain in &mut chains {
            let sites = setting("sites", &(bodies + 1).to_string(), "bodies");
            if chain.scene.scene()?.sites.is_none() {
                chain.scene = chain.scene.with([sites]);
            }
        }
        let expected = "chains to compare: scene files, --angles, or --ratios";
        Error::require(!chains.is_empty(), "angles", expected, "none")?;
        Ok(AttenuationRequest {
            chains,
            length: bodies as usize,
            senses: typed.sense.unwrap_or(Where::Both).into(),
            lengths: typed.lengths.clone(),
            kind: typed.contacts.map_or(ContactKind::Soft, Into::into),
            criterion: typed.fit.map_or(Criterion::Aicc, Into::into),
            target: typed.target,
            high_band: true,
            band_edge_frequency: typed.band_edge_frequency,
        })
    }
}

/// The scene, and the key with its values.
fn against(scene: SceneSource, typed: &str) -> Result<(SceneSource, String), Error> {
    let key = typed.split('=').next().unwrap_or(typed);
    let usual = match key {
        _ if typed.contains('=') => typed.to_owned(),
        "angle" => "angle=2:90:45".into(),
        "mass_ratio" => "mass_ratio=0.1:1:45".into(),
        "stiffness_ratio" => "stiffness_ratio=1:100:45log".into(),
        _ => {
            let expected =
                "`bodies`, or a key of the scene with its values, KEY=A:B:N or KEY=A,B,..";
            return Err(Error::request("against", expected, typed));
        }
    };
    let typed = scene.scene()?;
    let mut crossed = Vec::new();
    if key == "angle" && typed.second_angle.is_none() {
        crossed.push(setting("second_angle", "90", "against"));
        if typed.angle.is_none() {
            crossed.push(setting("angle", "90", "against"));
        }
    }
    Ok((scene.with(crossed), usual))
}

fn setting(key: &str, text: &str, option: &str) -> Setting {
    Setting::new(key, text, format!("--{option}"))
}
