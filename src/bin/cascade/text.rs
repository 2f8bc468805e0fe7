//! Text on a terminal: its width, wrapped lines, colours.

use std::io::{StderrLock, StdoutLock, Write};

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};

/// Columns where there is no terminal.
const USUAL: usize = 80;
/// Narrower and wider terminals are treated as these.
const BOUNDS: (usize, usize) = (40, 120);

/// Columns of the terminal that standard output is, of `COLUMNS` where it is none, else 80.
pub fn width() -> usize {
    if let Some((width, _)) = terminal_size::terminal_size_of(std::io::stdout()) {
        return usize::from(width.0).clamp(BOUNDS.0, BOUNDS.1);
    }
    let stated = std::env::var("COLUMNS").ok();
    let stated = stated.and_then(|columns| columns.trim().parse::<usize>().ok());
    stated.map_or(USUAL, |columns| columns.max(BOUNDS.0))
}

/// Standard output, without colours where it is no terminal or the user wants none (`NO_COLOR`,
/// `CLICOLOR`, `TERM=dumb`; `CLICOLOR_FORCE` keeps them).
pub fn stdout() -> AutoStream<StdoutLock<'static>> {
    anstream::stdout().lock()
}

/// Standard error, likewise.
pub fn stderr() -> AutoStream<StderrLock<'static>> {
    anstream::stderr().lock()
}

/// What a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    Error,
    Warning,
    Note,
    Help,
}

impl Tone {
    pub fn label(self) -> &'static str {
        match self {
            Tone::Error => "error",
            Tone::Warning => "warning",
            Tone::Note => "note",
            Tone::Help => "help",
        }
    }

    pub fn style(self) -> Style {
        match self {
            Tone::Error => AnsiColor::Red.on_default().bold(),
            Tone::Warning => AnsiColor::Yellow.on_default().bold(),
            Tone::Note => AnsiColor::Cyan.on_default().bold(),
            Tone::Help => AnsiColor::Green.on_default().bold(),
        }
    }
}

/// `text` in a style.
pub fn styled(style: Style, text: &str) -> String {
    match text.trim().is_empty() {
        true => text.to_owned(),
        false => format!("{style}{text}{style:#}"),
    }
}

/// A name or a heading.
pub const HEADING: Style = Style::new().bold();

/// Prints a message to standard error. It is wrapped where that is a terminal; in a file it remains one
/// line, so that it can be searched for.
pub fn message(tone: Tone, text: &str) {
    let terminal = terminal_size::terminal_size_of(std::io::stderr());
    let columns = terminal.map(|(width, _)| usize::from(width.0).clamp(BOUNDS.0, BOUNDS.1));
    let text = labelled(tone, text, columns);
    // Nothing can be done where even this cannot be written.
    let _ = writeln!(stderr(), "{text}");
}

/// `label: text`, wrapped below the text at so many columns.
pub fn labelled(tone: Tone, text: &str, columns: Option<usize>) -> String {
    let (label, style) = (tone.label(), tone.style());
    let indent = label.len() + 2;
    let lines: Vec<String> = match columns {
        None => vec![text.to_owned()],
        // Lines that the text has, such as those of a nested reason, stay apart.
        Some(columns) => text
            .lines()
            .flat_map(|line| wrapped(line, columns - indent))
            .collect(),
    };
    let head = styled(style, &format!("{label}:"));
    format!("{head} {}", lines.join(&format!("\n{:indent$}", "")))
}

/// `text` in lines of at most `width` columns; a longer word has a line of its own.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut column = 0;
    for word in words(text) {
        let length = word.chars().count();
        match lines.last_mut() {
            Some(line) if column + 1 + length <= width => {
                line.push(' ');
                line.push_str(word);
                column += 1 + length;
            }
            _ => {
                lines.push(word.to_owned());
                column = length;
            }
        }
    }
    lines
}

/// Each sentence in lines of at most `width` columns, indented from its second line on.
pub fn paragraphs(sentences: &[String], width: usize) -> String {
    let lines = sentences.iter().map(|sentence| {
        let indent = sentence.len() - sentence.trim_start().len() + 2;
        wrapped(sentence, width - 2).join(&format!("\n{:indent$}", "")) + "\n"
    });
    lines.collect()
}

/// The words of `text`; a percent sign stays with its number, code between backticks in one piece.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let mut breaks = rest.match_indices(' ').map(|(at, _)| at);
        let is_in_code = |at: usize| rest[..at].matches('`').count() % 2 == 1;
        let end = breaks.find(|&at| !rest[at + 1..].starts_with('%') && !is_in_code(at));
        let word = &rest[..end.unwrap_or(rest.len())];
        rest = end.map_or("", |at| &rest[at + 1..]);
        Some(word)
    })
}

/// Lines of names and values, wrapped.
pub struct Lines {
    /// With colours, which a stream without them removes.
    pub text: String,
    width: usize,
}

impl Lines {
    /// Where what a name is begins.
    const INDENT: usize = 19;

    pub fn new(width: usize) -> Self {
        Lines {
            text: String::new(),
            width,
        }
    }

    pub fn line(&mut self, name: &str, value: &str) {
        // Details of the line before are not set off.
        let style = match name.starts_with(' ') {
            true => Style::new(),
            false => HEADING,
        };
        self.styled_line(style, name, value);
    }

    /// A finding and what to do about it.
    pub fn warning(&mut self, message: &str, advice: &str) {
        self.styled_line(Tone::Warning.style(), "warning", message);
        if !advice.is_empty() {
            self.line("", &format!("-> {advice}"));
        }
    }

    fn styled_line(&mut self, style: Style, name: &str, value: &str) {
        let indent = Self::INDENT;
        let lines = wrapped(value, self.width - indent);
        let gap = indent.saturating_sub(name.chars().count()).max(1);
        self.text += &styled(style, name);
        self.text += &" ".repeat(gap);
        self.text += &lines.join(&format!("\n{:indent$}", ""));
        self.text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> String {
        anstream::adapter::strip_str(text).to_string()
    }

    #[test]
    fn long_lines_wrap_below_where_they_began() {
        let mut lines = Lines::new(40);
        lines.line("warning", "one two three four 12 % of it");
        let expected = "warning            one two three four\n                   12 % of it\n";
        assert_eq!(plain(&lines.text), expected);
        lines.line("", "a-word-that-is-longer-than-the-line");
        let last = "                   a-word-that-is-longer-than-the-line\n";
        assert!(lines.text.ends_with(last));
    }

    #[test]
    fn messages_wrap_below_their_text_and_keep_code_whole() {
        let said = |columns| {
            let text = "convert it with `numpy.save(\"field.npy\", array)` and so on";
            plain(&labelled(Tone::Help, text, columns))
        };
        assert_eq!(
            said(Some(40)),
            "help: convert it with\n      `numpy.save(\"field.npy\", array)`\n      and so on"
        );
        assert_eq!(said(None).lines().count(), 1);
    }
}
