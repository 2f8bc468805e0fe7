//! `cascade sweep`: a scene with varied keys, the runs, one table.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use wavecascade::Error;
use wavecascade::chain::scene::SceneSource;
use wavecascade::report::{sweep_html, sweep_snippet, write_beside};
use wavecascade::sweep::{
    Measures, Needs, Outcome, Outcomes, Part, Request, Standing, Sweep, read,
};

use crate::analyze::use_threads;
use crate::chain_args::SweepCommand;
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, number};

/// Runs the command.
pub fn run(typed: SweepCommand) -> Result<(), Failure> {
    let started = Instant::now();
    use_threads(typed.how.threads.map(usize::from))?;
    let out = typed
        .out
        .clone()
        .unwrap_or_else(|| default_out(typed.scene.as_deref()));
    let standing = if typed.merge.is_empty() {
        let source = match &typed.scene {
            Some(path) => SceneSource::read(path)?,
            None => SceneSource::default(),
        };
        let sweep = Sweep::new(source.with(typed.keys.settings.clone()), &typed.vary)?;
        let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
        progress.begin_writing();
        let standing = sweep.run(&out, typed.part.unwrap_or(Part::WHOLE), &progress);
        progress.clear();
        standing?
    } else {
        if let Some(setting) = typed.keys.settings.first() {
            return Err(Failure::Library(Error::Request {
                option: "merge",
                expected: "no keys of a scene: the directories hold theirs".into(),
                found: setting.source.clone(),
            }));
        }
        Sweep::merge(&typed.merge, &out)?
    };
    let (request, outcomes) = read(&out)?;
    if standing.table.is_some() {
        write_beside(
            &out,
            "report.html",
            sweep_html(&request, &outcomes).as_bytes(),
        )?;
        write_beside(&out, "plot.py", sweep_snippet(&request).as_bytes())?;
    }
    tell(&typed, &standing, (&request, &outcomes), &out, started)?;
    match standing.failed {
        0 => Ok(()),
        failed => Err(Failure::Members(failed)),
    }
}

fn default_out(scene: Option<&Path>) -> PathBuf {
    let stem = scene.and_then(Path::file_stem);
    let mut name = stem.unwrap_or("chains".as_ref()).to_owned();
    name.push("-sweep");
    name.into()
}

fn tell(
    typed: &SweepCommand,
    standing: &Standing,
    (request, outcomes): (&Request, &Outcomes),
    out: &Path,
    started: Instant,
) -> Result<(), Failure> {
    if typed.how.json {
        let text = serde_json::to_string_pretty(standing).map_err(std::io::Error::from)?;
        writeln!(terminal::stdout(), "{text}")?;
    } else if !typed.how.quiet {
        let subject = match (&typed.scene, typed.merge.len()) {
            (Some(scene), _) => subject_of(std::slice::from_ref(scene)),
            (None, 0) => "sweep".into(),
            (None, parts) => format!("{parts} parts"),
        };
        let known: Vec<(usize, Measures)> = outcomes
            .iter()
            .filter_map(|(member, outcome)| {
                Some((
                    *member,
                    match outcome {
                        Outcome::Done(measures) => Some(measures.clone()),
                        Outcome::Failed(_) => None,
                    }?,
                ))
            })
            .collect();
        let mut summary = Summary::new(&subject, &answer(standing, request, &known));
        let Standing {
            members,
            computed,
            known,
            ..
        } = standing;
        let seconds = started.elapsed().as_secs_f64();
        let text = format!(
            "{known} of {members} known, {computed} of them computed now in {seconds:.2} s"
        );
        summary.fact("members", &text);
        match &standing.table {
            Some(table) => {
                let page = table.with_file_name("report.html");
                summary.last(&format!(
                    "wrote {}; open {}",
                    table.display(),
                    page.display()
                ));
            }
            None => {
                let text = format!(
                    "run the other parts, and put them together with --merge; {} keeps what is known",
                    out.display()
                );
                summary.last(&text);
            }
        }
        summary.print(typed.how.detail.verbose)?;
    }
    Ok(())
}

/// Least and largest force that comes through, of how many members, and what the others need.
fn answer(standing: &Standing, request: &Request, known: &[(usize, Measures)]) -> String {
    let values = |member: usize| {
        let keys = request.vary.iter().zip(request.values(member));
        let pairs = keys.map(|(key, value)| format!("{} {value}", key.key.replace('_', " ")));
        pairs.collect::<Vec<_>>().join(", ")
    };
    let unit = if request.is_si() { " N" } else { "" };
    let mut forces: Vec<(usize, f64)> = known
        .iter()
        .filter_map(|(member, measures)| Some((*member, measures.peak_force_last?)))
        .collect();
    forces.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let members = standing.members;
    let of = match members - forces.len() {
        0 => String::new(),
        _ if standing.known < members => format!(" of {} of {members} members", forces.len()),
        _ => format!(
            " of the {} of {members} members where it is known",
            forces.len()
        ),
    };
    let missing = missing(standing, known);
    match forces.as_slice() {
        [] if standing.known == 0 => format!("none of {members} members has a value yet"),
        [] => format!(
            "the largest force at the last contact is known in none of {members} members{missing}"
        ),
        [one] => format!(
            "force at the last contact{of} {}{unit} at {}{missing}",
            number(one.1),
            values(one.0)
        ),
        [least, .., most] => format!(
            "force at the last contact{of} from {}{unit} at {} to {}{unit} at {}{missing}",
            number(least.1),
            values(least.0),
            number(most.1),
            values(most.0)
        ),
    }
}

/// Why members have no force, and what to state.
fn missing(standing: &Standing, known: &[(usize, Measures)]) -> String {
    let needing = |needs: Needs| {
        let all = known.iter();
        all.filter(|(_, measures)| measures.peak_force_last_needs == Some(needs))
            .count()
    };
    let mut text = String::new();
    let mut add = |count: usize, why: &str| match count {
        0 => {}
        _ => text += &format!("; {why} in {count}"),
    };
    add(
        needing(Needs::EndTime),
        "when the run ends it still rises, which a later `--end-time` mends,",
    );
    add(
        needing(Needs::Samples),
        "samples are too far apart, which more `--samples` mend,",
    );
    if standing.known < standing.members {
        text += &format!(
            "; {} are not computed yet",
            standing.members - standing.known
        );
    }
    text
}
