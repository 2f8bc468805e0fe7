//! What a command found, on a dozen lines: the answer first.

use std::io::Write;

use wavecascade::sheet::{Sheet, Table, Warning};

use crate::table;
use crate::text::{HEADING, Lines, Tone, labelled, paragraphs, stdout, styled, width, wrapped};

/// Lines that a summary has at most, where not all details are asked for.
const MOST_LINES: usize = 12;

/// Lines of a table that is cut, at least: names of columns, a row, and how many are left.
const LEAST_OF_TABLE: usize = 4;

/// Blocks of a profile.
const PROFILE: usize = 16;

/// What a command found: an answer in words, facts, details, warnings, and where to go on.
#[derive(Default)]
pub struct Summary {
    answer: String,
    /// Each with whether it is a detail, which is printed with `--verbose` alone; others are where there is room.
    parts: Vec<(bool, Part)>,
    warnings: Vec<Warning>,
    last: String,
}

enum Part {
    Line(String, String),
    /// Set by themselves, to any width.
    Rows(Table),
}

impl Summary {
    /// `subject: answer`.
    pub fn new(subject: &str, answer: &str) -> Self {
        Summary {
            answer: format!("{subject}: {answer}"),
            ..Summary::default()
        }
    }

    /// What a described result says.
    pub fn of(subject: &str, sheet: &Sheet) -> Self {
        let mut summary = Summary::new(subject, &sheet.answer);
        for table in sheet.tables.iter().filter(|table| table.is_fact) {
            summary.table(table);
        }
        for fact in &sheet.facts {
            let profile = match has_blocks() {
                true => blocks(&fact.profile, PROFILE),
                false => String::new(),
            };
            let text = format!("{profile} {}", fact.text);
            summary.line(fact.is_detail, &fact.name, text.trim_start());
        }
        for table in sheet.tables.iter().filter(|table| !table.is_fact) {
            summary.table(table);
        }
        summary.warnings.clone_from(&sheet.warnings);
        summary
    }

    /// A table of a result: its rows, of which those that there is room for are printed, or names with their values.
    pub fn table(&mut self, table: &Table) {
        if !table.head.is_empty() {
            self.parts.push((!table.is_fact, Part::Rows(table.clone())));
            return;
        }
        for row in &table.rows {
            if let [name, value] = row.as_slice() {
                self.line(!table.is_fact, name, value);
            }
        }
    }

    pub fn line(&mut self, is_detail: bool, name: &str, value: &str) {
        let line = Part::Line(name.to_owned(), value.to_owned());
        self.parts.push((is_detail, line));
    }

    /// A finding about the data and what to do about it.
    pub fn warning(&mut self, message: &str, advice: &str) {
        self.warnings.push(Warning::new(message, advice));
    }

    /// The line that follows all others: what to open, what was written.
    pub fn last(&mut self, text: &str) {
        self.last = text.to_owned();
    }

    /// Prints it.
    pub fn print(&self, is_verbose: bool) -> std::io::Result<()> {
        let width = width();
        let said = match is_verbose {
            true => self.whole(width),
            false => self.cut(width),
        };
        stdout().write_all(said.as_bytes())
    }

    fn whole(&self, width: usize) -> String {
        let parts = self.parts.iter().map(|(_, part)| part.text(width));
        let texts = [self.head(width)].into_iter().chain(parts);
        let warnings = set(&self.all_warnings(), width);
        texts.chain([warnings, self.closing(width)]).collect()
    }

    fn all_warnings(&self) -> Vec<(Tone, String)> {
        let all = self.warnings.iter();
        let warnings = all.flat_map(|of| {
            let (message, advice) = (of.message.clone(), of.advice.clone());
            [(Tone::Warning, message), (Tone::Help, advice)]
        });
        warnings.filter(|(_, text)| !text.is_empty()).collect()
    }

    /// The same without details, in a dozen lines.
    fn cut(&self, width: usize) -> String {
        let (mut text, closing) = (self.head(width), self.closing(width));
        let mut room = MOST_LINES.saturating_sub(text.lines().count() + closing.lines().count());
        let lines = |of: &Warning| lines_of(Tone::Warning, &of.message, width);
        let messages = self.warnings.iter().map(lines);
        let reserved = messages.sum::<usize>().min(room / 2);
        let facts = self.parts.iter().filter(|(is_detail, _)| !is_detail);
        for (_, part) in facts {
            let part = part.in_lines(width, room - reserved);
            room -= part.lines().count();
            text += &part;
        }
        text + &set(&self.cut_warnings(width, room), width) + &closing
    }

    /// Warnings in so many lines: their messages, and what to do about them where all messages have room.
    fn cut_warnings(&self, width: usize, mut room: usize) -> Vec<(Tone, String)> {
        let lines = |tone: Tone, text: &str| lines_of(tone, text, width);
        let message_lines = |of: &Warning| lines(Tone::Warning, &of.message);
        let mut said = Vec::new();
        for (n, warning) in self.warnings.iter().enumerate() {
            let (own, later) = (message_lines(warning), &self.warnings[n + 1..]);
            if n > 0 && own + usize::from(!later.is_empty()) > room {
                let plural = if later.is_empty() { "" } else { "s" };
                let text = format!("{} more warning{plural}: --verbose", later.len() + 1);
                said.push((Tone::Note, text));
                break;
            }
            room = room.saturating_sub(own);
            let (message, advice) = (&warning.message, &warning.advice);
            let joined = format!("{message} -> {advice}");
            let reserved: usize = later.iter().map(message_lines).sum();
            let needed = lines(Tone::Help, advice) + reserved;
            if !advice.is_empty() && lines(Tone::Warning, &joined) == own {
                said.push((Tone::Warning, joined));
                continue;
            }
            said.push((Tone::Warning, message.clone()));
            if !advice.is_empty() && needed <= room {
                room -= needed - reserved;
                said.push((Tone::Help, advice.clone()));
            }
        }
        said
    }

    fn head(&self, width: usize) -> String {
        let lines = wrapped(&self.answer, width - 2);
        let lines = lines.iter().map(|line| styled(HEADING, line));
        lines.collect::<Vec<_>>().join("\n  ") + "\n"
    }

    fn closing(&self, width: usize) -> String {
        match self.last.is_empty() {
            true => String::new(),
            false => paragraphs(std::slice::from_ref(&self.last), width),
        }
    }
}

/// Whether the terminal has block characters.
fn has_blocks() -> bool {
    let stated = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .filter_map(std::env::var_os);
    let first = stated
        .map(|value| value.to_string_lossy().to_lowercase())
        .find(|value| !value.is_empty());
    first.is_some_and(|locale| locale.contains("utf-8") || locale.contains("utf8"))
}

/// A profile in block characters, each from 0 to the largest; `width` of them at most.
fn blocks(profile: &[f64], width: usize) -> String {
    const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let largest = profile.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return String::new();
    }
    let count = width.min(profile.len());
    let block = |i: usize| {
        let part = &profile[i * profile.len() / count..(i + 1) * profile.len() / count];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        BLOCKS[((mean / largest * 8.0) as usize).min(7)]
    };
    (0..count).map(block).collect()
}

/// Lines that a message takes.
fn lines_of(tone: Tone, text: &str, width: usize) -> usize {
    let indent = tone.label().len() + 2;
    wrapped(text, width - indent).len()
}

/// Messages in lines.
fn set(messages: &[(Tone, String)], width: usize) -> String {
    let lines = messages.iter();
    let lines = lines.map(|(tone, text)| labelled(*tone, text, Some(width)) + "\n");
    lines.collect()
}

impl Part {
    fn text(&self, width: usize) -> String {
        match self {
            Part::Line(name, value) => {
                let mut lines = Lines::new(width);
                lines.line(name, value);
                lines.text
            }
            Part::Rows(rows) if rows.is_fact || rows.title.is_empty() => table::text(rows, width),
            Part::Rows(rows) => {
                let title = paragraphs(std::slice::from_ref(&rows.title), width);
                title + &table::text(rows, width)
            }
        }
    }

    /// In so many lines; empty where it does not fit, a table without its last rows.
    fn in_lines(&self, width: usize, room: usize) -> String {
        let text = self.text(width);
        let count = text.lines().count();
        if count <= room {
            return text;
        }
        match self {
            // Columns that follow below belong to all rows.
            Part::Rows(_) if !text.contains("\n\n") => {
                if room < LEAST_OF_TABLE {
                    return String::new();
                }
                let kept: Vec<&str> = text.lines().take(room - 1).collect();
                let left = count - kept.len();
                kept.join("\n") + &format!("\n... {left} more lines: --verbose\n")
            }
            _ => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> String {
        anstream::adapter::strip_str(text).to_string()
    }

    fn long() -> Summary {
        let mut summary = Summary::new("run.npz", "it is so");
        for n in 0..20 {
            summary.line(false, &format!("fact {n}"), "a value");
            summary.line(true, "detail", "a value");
        }
        for n in 0..9 {
            summary.warning(&format!("finding {n}"), "what to do");
        }
        summary.last("open page");
        summary
    }

    #[test]
    fn val_blocks_are_means_over_the_largest() {
        assert_eq!(blocks(&[0.0, 1.0, 2.0, 4.0], 4), "▁▃▅█");
        assert_eq!(blocks(&[0.0, 2.0, 4.0, 4.0], 2), "▃█");
        assert_eq!(blocks(&[0.0; 3], 8), "");
    }

    #[test]
    fn a_dozen_lines_hold_the_answer_and_the_first_of_each_kind() {
        let said = plain(&long().cut(80));
        assert!(said.starts_with("run.npz: it is so\nfact 0"), "{said}");
        let is_cut = said.ends_with("\nopen page\n") && !said.contains("detail");
        assert!(is_cut, "{said}");
        assert_eq!(said.lines().count(), MOST_LINES);
        for line in [
            "warning: finding 0 -> what to do",
            "note: 5 more warnings: --verbose",
        ] {
            assert!(said.contains(&format!("\n{line}\n")), "{said}");
        }
        let all = plain(&long().whole(80));
        assert_eq!(all.lines().count(), 42 + 18, "{all}");
    }

    #[test]
    fn one_warning_says_what_to_do_where_there_is_room() {
        let mut summary = Summary::new("a.npy", "nothing");
        summary.warning(&"word ".repeat(13), &"advice ".repeat(9));
        let said = plain(&summary.cut(80));
        assert_eq!(said.lines().count(), 3, "{said}");
        assert!(said.contains("\nhelp: advice"), "{said}");
    }

    #[test]
    fn a_long_table_is_cut() {
        let rows = (0..30).map(|n| vec![n.to_string(), "1".into()]);
        let table = Table {
            is_fact: true,
            ..Table::of("", &["n", "value"], rows)
        };
        let mut summary = Summary::new("a", "b");
        summary.table(&table);
        let said = plain(&summary.cut(80));
        assert_eq!(said.lines().count(), MOST_LINES);
        assert!(said.ends_with("... 21 more lines: --verbose\n"), "{said}");
    }
}
