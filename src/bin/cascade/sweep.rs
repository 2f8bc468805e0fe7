//! `cascade sweep`: a scene with varied keys, the runs, one table.

use std::time::Instant;

use wavecascade::plot::Style;
use wavecascade::report::{Provenance, sheet_html, sweep_snippet, write_beside};
use wavecascade::sweep::{Part, Sweep, Swept, read};

use crate::chain_args::SweepCommand;
use crate::prelude::*;
use crate::present::open_page;
use crate::scene::{named_like, source_of};
use crate::terminal::print_json;
use crate::words::as_text;

/// Runs the command.
pub fn run(typed: SweepCommand) -> Result<(), Failure> {
    let started = Instant::now();
    let progress = Progress::new(!typed.how.quiet);
    let named = || named_like(typed.scene.as_deref(), "chains", "-sweep");
    let out = typed.out.clone().unwrap_or_else(named);
    let standing = if typed.merge.is_empty() {
        let source = source_of(None, typed.scene.as_deref())?;
        let sweep = Sweep::new(source.with(typed.keys.settings.clone()), &typed.varied())?;
        progress.begin_writing();
        let part = typed.part.unwrap_or(Part::WHOLE);
        let standing = on_threads(typed.how.threads, || sweep.run(&out, part, &progress));
        progress.clear();
        standing?
    } else {
        if let Some(setting) = typed.keys.settings.first() {
            let expected = "no keys of a scene: the directories hold theirs";
            return Err(Error::request("merge", expected, &setting.source).into());
        }
        Sweep::merge(&typed.merge, &out)?
    };
    let (request, outcomes) = read(&out)?;
    let found = Swept { request, outcomes };
    let sheet = found.describe();
    let subject = match (&typed.scene, typed.merge.len()) {
        (Some(scene), _) => subject_of(std::slice::from_ref(scene)),
        (None, 0) => "sweep".into(),
        (None, parts) => format!("{parts} parts"),
    };
    if standing.table.is_some() {
        let input = typed.scene.as_ref().map(|path| path.display().to_string());
        let provenance = Provenance::new(as_text(), input, None);
        let page = sheet_html(&found, &sheet, &subject, &provenance, &Style::screen())?;
        write_beside(&out, "report.html", page.as_bytes())?;
        write_beside(&out, "summary.json", sheet.summary(&provenance)?.as_bytes())?;
        write_beside(&out, "plot.py", sweep_snippet(&found.request).as_bytes())?;
    }
    if typed.how.json {
        print_json(&standing)?;
    } else if !typed.how.quiet {
        let mut summary = Summary::of(&subject, &sheet);
        let (known, members, computed) = (standing.known, standing.members, standing.computed);
        let seconds = started.elapsed().as_secs_f64();
        let text = format!("{known} of {members} run, {computed} of them now in {seconds:.2} s");
        summary.line(false, "members", &text);
        summary.last(&match &standing.table {
            Some(table) => {
                let page = table.with_file_name("report.html");
                format!("wrote {}; open {}", table.display(), page.display())
            }
            None => format!(
                "run the other parts, and put them together with --merge; {} keeps what is known",
                out.display()
            ),
        });
        summary.print(typed.how.verbose)?;
    }
    if let Some(table) = standing.table.as_ref().filter(|_| typed.open) {
        open_page(&table.with_file_name("report.html"));
    }
    match standing.failed {
        0 => Ok(()),
        failed => Err(Failure::Partly(format!(
            "{failed} of the runs failed; the last column of the table says why"
        ))),
    }
}
