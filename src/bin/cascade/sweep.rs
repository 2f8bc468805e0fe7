//! `cascade sweep`: a scene with varied keys, the runs, one table.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use wavecascade::Error;
use wavecascade::chain::scene::SceneSource;
use wavecascade::report::{sweep_html, sweep_snippet, write_beside};
use wavecascade::sweep::{Part, Standing, Sweep, read};

use crate::analyze::use_threads;
use crate::chain_args::SweepCommand;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::terminal;

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
    if standing.table.is_some() {
        let (request, outcomes) = read(&out)?;
        write_beside(
            &out,
            "report.html",
            sweep_html(&request, &outcomes).as_bytes(),
        )?;
        write_beside(&out, "plot.py", sweep_snippet(&request).as_bytes())?;
    }
    tell(&typed, &standing, &out, started)?;
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
    out: &Path,
    started: Instant,
) -> Result<(), Failure> {
    let mut stdout = terminal::stdout();
    if typed.how.json {
        let text = serde_json::to_string_pretty(standing).map_err(std::io::Error::from)?;
        writeln!(stdout, "{text}")?;
    } else if !typed.how.quiet {
        let Standing {
            members,
            known,
            computed,
            table,
            ..
        } = standing;
        let seconds = started.elapsed().as_secs_f64();
        let known_now = format!(
            "{known} of {members} members known, {computed} of them computed now in {seconds:.2} s"
        );
        let next = match table {
            Some(table) => {
                let page = table.with_file_name("report.html");
                format!("wrote {}; open {}", table.display(), page.display())
            }
            None => format!(
                "no table yet, {} members are missing: run the other parts, and put them together \
                 with --merge; {} keeps what is known",
                members - known,
                out.display()
            ),
        };
        let text = terminal::paragraphs(&[known_now, next], terminal::width());
        stdout.write_all(text.as_bytes())?;
    }
    Ok(())
}
