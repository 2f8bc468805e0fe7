//! What is done with a result once it is written: its page in the browser, its main picture in the terminal.

use std::io::IsTerminal;

use crate::picture::{Picture, Protocol};
use crate::prelude::*;
use crate::terminal::Tone;

/// Options of commands whose result has a page.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct PresentArgs {
    /// Open the page of the result in the browser.
    #[arg(long)]
    pub open: bool,
    /// Draw the main picture of the result in the terminal; `--show=HOW` where it is not known what the terminal
    /// understands.
    #[arg(long, value_enum, value_name = "HOW", num_args = 0..=1, require_equals = true,
          default_missing_value = "auto")]
    pub show: Option<ShowArg>,
}

choice!(ShowArg => Protocol {
    /// As the terminal says what it is.
    Auto => Self::of_terminal(|name| std::env::var(name).unwrap_or_default()),
    Kitty,
    Iterm,
    Sixel,
    /// Characters that are half of a cell each, which all terminals have.
    Blocks,
});

/// Figures whose name is not that of the result and that answer its question, the first that is there.
const MAIN: [&str; 3] = ["temporal-spectrum.png", "views.png", "energies.png"];

impl PresentArgs {
    /// That there will be a page to open, and a picture and a terminal for it.
    pub fn check(self, draws: bool, has_png: bool) -> Result<(), Error> {
        let expected = "figures: without them there is no page";
        Error::require(draws || !self.open, "open", expected, "`--figures none`")?;
        if self.show.is_none() {
            return Ok(());
        }
        Error::require(has_png, "show", "`png` among `--figures`", "none")?;
        let is_terminal = std::io::stdout().is_terminal();
        let found = "standard output that is a file or a pipe";
        Error::require(is_terminal, "show", "a terminal to draw in", found)?;
        let is_dumb = std::env::var("TERM").is_ok_and(|name| name == "dumb");
        Error::require(!is_dumb, "show", "a terminal that can draw", "TERM=dumb")
    }

    /// Shows the main picture beside a page, and opens the page.
    pub fn run(self, page: &Path) -> Result<(), Failure> {
        if let (Some(show), Some(picture)) = (self.show, picture_of(page)) {
            let bytes = std::fs::read(&picture).map_err(|source| Error::Read {
                action: "read",
                path: picture,
                source,
            })?;
            let picture = Picture::read(&bytes).map_err(std::io::Error::other)?;
            let text = picture.drawn(show.into(), terminal::width());
            std::io::stdout().lock().write_all(text.as_bytes())?;
        }
        if self.open {
            open_page(page);
        }
        Ok(())
    }
}

/// Opens a page in the browser. That none can be started is no failure: the page is there.
pub fn open_page(page: &Path) {
    if let Err(why) = open::that_detached(page) {
        let text = format!("no browser could be started: {why}");
        terminal::message(Tone::Warning, &text);
        terminal::message(Tone::Help, &format!("open {} in one", page.display()));
    }
}

/// The main figure of the result that a page belongs to.
fn picture_of(page: &Path) -> Option<PathBuf> {
    let folder = page.parent()?;
    let within = |folder: PathBuf| {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let is_png = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "png");
        let mut found: Vec<PathBuf> = files.map(|file| file.path()).filter(is_png).collect();
        found.sort();
        let named = |name: &&str| found.iter().find(|path| path.ends_with(name));
        let main = MAIN.iter().find_map(named);
        main.or(found.first()).cloned()
    };
    within(folder.join("figures")).or_else(|| within(folder.to_owned()))
}
