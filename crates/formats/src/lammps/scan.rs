//! The frames of a dump: what their headers say, and where their rows are.

use std::fmt::Display;
use std::ops::Range;
use std::str::FromStr;
use std::sync::Arc;

use memchr::memmem;

use super::text::{float, is_blank, lines, values};
use crate::cursor::{Budget, beginning};
use crate::{Error, Options, Result};

const ITEM: &[u8] = b"ITEM: ";
pub(super) const OTHER_ATOMS: &str = "dump a group whose atoms do not change, or the frames apart";

/// The edges of a box, each along x, y and z.
pub(super) type Cell = [[f64; 3]; 3];

/// The atoms at one time step.
#[derive(Debug)]
pub(super) struct Frame {
    pub step: i64,
    /// Zero if the dump has no times.
    pub time: f64,
    /// The bytes of its rows, one an atom.
    pub rows: Range<usize>,
    /// Its box, if it states one.
    pub cell: Option<Arc<Cell>>,
}

impl Frame {
    pub fn damaged(&self, expected: impl Display, found: impl Display) -> Error {
        let place = format!("the frame of time step {}", self.step);
        Error::damaged(place, expected, found)
    }
}

/// What the headers of a dump say.
#[derive(Debug)]
pub(super) struct Headers {
    pub frames: Vec<Frame>,
    /// Atoms of every frame.
    pub atoms: usize,
    /// Names of the columns of every frame.
    pub columns: Vec<String>,
    /// The style of units.
    pub style: Option<String>,
    pub has_times: bool,
    /// What is written beside `BOX BOUNDS` in the first frame, such as `pp pp pp`.
    pub boundary: String,
    /// The bounds of the box of the first frame, a row a direction.
    pub bounds: Vec<Vec<f64>>,
    budget: Budget,
    /// The header that is being read.
    open: Option<Open>,
}

/// A header before its rows.
#[derive(Debug, Default)]
struct Open {
    step: Option<i64>,
    time: Option<f64>,
    atoms: Option<usize>,
    cell: Option<Cell>,
}

/// The headers of all frames.
pub(super) fn headers(bytes: &[u8], options: &Options) -> Result<Headers> {
    if !bytes.starts_with(ITEM) {
        return Err(Error::damaged("byte 0", "ITEM: ", beginning(bytes)));
    }
    let mut headers = Headers {
        frames: Vec::new(),
        atoms: 0,
        columns: Vec::new(),
        style: None,
        has_times: false,
        boundary: String::new(),
        bounds: Vec::new(),
        budget: Budget::new("the list of frames", options),
        open: None,
    };
    let items = memmem::find_iter(bytes, ITEM).filter(|&at| at == 0 || bytes[at - 1] == b'\n');
    let mut start = 0;
    for at in items.skip(1).chain([bytes.len()]) {
        headers.item(bytes, start..at)?;
        start = at;
    }
    if headers.open.is_some() {
        let place = match headers.frames.last() {
            Some(last) => format!("behind the frame of time step {}", last.step),
            None => "the file".into(),
        };
        return Err(Error::damaged(place, "ITEM: ATOMS", "the end of the file"));
    }
    Ok(headers)
}

impl Headers {
    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// Reads the item at `range` of the file.
    fn item(&mut self, bytes: &[u8], range: Range<usize>) -> Result<()> {
        let text = &bytes[range.clone()];
        let title_end = text.iter().position(|&byte| byte == b'\n');
        let title = &text[ITEM.len()..title_end.unwrap_or(text.len())];
        let body = title_end.map_or(text.len(), |end| end + 1);
        let title = String::from_utf8_lossy(title).trim_ascii().to_owned();
        let body = range.start + body..range.end;
        let first = lines(&bytes[body.clone()]).next().unwrap_or_default();
        let first = String::from_utf8_lossy(first).trim_ascii().to_owned();
        let place = || format!("ITEM: {title} at byte {}", range.start);
        let header = self.open.get_or_insert_default();
        match title.as_str() {
            "UNITS" => {
                self.style.get_or_insert(first);
            }
            "TIME" => header.time = Some(number(&first, "a time", place)?),
            // The frame before has lost the title of its rows.
            "TIMESTEP" if header.step.is_some() => {
                return Err(Error::damaged(place(), "ITEM: ATOMS", "the next frame"));
            }
            "TIMESTEP" => header.step = Some(number(&first, "a time step", place)?),
            "NUMBER OF ATOMS" => header.atoms = Some(number(&first, "a number of atoms", place)?),
            title => {
                if let Some(columns) = title.strip_prefix("ATOMS") {
                    return self.rows(columns, bytes, body);
                }
                if let Some(boundary) = title.strip_prefix("BOX BOUNDS") {
                    let bounds = bounds(&bytes[body]);
                    header.cell = cell(&bounds);
                    if self.frames.is_empty() {
                        self.boundary = boundary.trim_ascii().to_owned();
                        self.bounds = bounds;
                    }
                } else if title.contains("ENTRIES") || title.contains("GRID") {
                    return Err(Error::unsupported(
                        format!("a LAMMPS dump of other values than those of atoms ({title})"),
                        "write atoms with `dump custom`",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Ends a header: its rows follow.
    fn rows(&mut self, columns: &str, bytes: &[u8], rows: Range<usize>) -> Result<()> {
        let columns = columns.split_ascii_whitespace();
        let header = self.open.take().unwrap_or_default();
        let before = format!("byte {}", rows.start);
        let missing = |what: &str| Error::damaged(&before, what, "ITEM: ATOMS");
        let step = header.step.ok_or_else(|| missing("ITEM: TIMESTEP"))?;
        let atoms = header.atoms;
        let atoms = atoms.ok_or_else(|| missing("ITEM: NUMBER OF ATOMS"))?;
        let place = || format!("the frame of time step {step}");
        if self.frames.is_empty() {
            self.columns = columns.map(str::to_owned).collect();
            self.has_times = header.time.is_some();
            self.atoms = atoms;
        } else if !columns.eq(self.columns.iter().map(String::as_str)) {
            let what = format!("{} with other columns than the first", place());
            let way_out = "write one file for each selection of columns";
            return Err(Error::unsupported(what, way_out));
        } else if atoms != self.atoms {
            let (place, first) = (place(), self.atoms);
            let what = format!("{place} with {atoms} atoms, the first with {first}");
            return Err(Error::unsupported(what, OTHER_ATOMS));
        }
        if self.has_times && header.time.is_none() {
            return Err(Error::damaged(place(), "ITEM: TIME", "none"));
        }
        // A value and a blank or line end for each column of each atom, so that no claim exceeds the file.
        let least = self.columns.len().max(1).checked_mul(2);
        let least = least.and_then(|row| row.checked_mul(atoms));
        let ends_whole = rows.is_empty() || bytes[rows.end - 1] == b'\n';
        if least.is_none_or(|least| least > rows.len()) || !ends_whole {
            let expected = format!("{atoms} whole rows of {} values", self.columns.len());
            let found = format!("{} bytes", rows.len());
            return Err(Error::damaged(place(), expected, found));
        }
        let before = self.frames.last().and_then(|frame| frame.cell.clone());
        let cell = match before.filter(|before| Some(**before) == header.cell) {
            None if header.cell.is_some() => {
                self.budget.take(size_of::<Cell>() as u64)?;
                header.cell.map(Arc::new)
            }
            same => same,
        };
        self.frames.push(Frame {
            step,
            time: header.time.unwrap_or_default(),
            rows,
            cell,
        });
        self.budget.take(size_of::<Frame>() as u64)
    }
}

fn number<T: FromStr>(found: &str, expected: &str, place: impl Fn() -> String) -> Result<T> {
    let number = found.parse();
    number.map_err(|_| Error::damaged(place(), expected, found))
}

/// The bounds of a box; none if there are not three rows of numbers.
fn bounds(body: &[u8]) -> Vec<Vec<f64>> {
    let row = |row: &[u8]| -> Option<Vec<f64>> { values(row).map(float).collect() };
    let rows = lines(body).filter(|line| !is_blank(line)).take(3);
    let rows: Option<Vec<Vec<f64>>> = rows.map(row).collect();
    rows.filter(|rows| rows.len() == 3).unwrap_or_default()
}

/// The edges of the box with these bounds: of a tilted one, whose tilts xy, xz and yz stand behind the
/// bounds of all of it, or of one of any edges, whose origin stands behind them.
fn cell(bounds: &[Vec<f64>]) -> Option<Cell> {
    let [x, y, z] = bounds else { return None };
    match [&x[..], &y[..], &z[..]] {
        [&[x, x1], &[y, y1], &[z, z1]] => {
            Some([[x1 - x, 0.0, 0.0], [0.0, y1 - y, 0.0], [0.0, 0.0, z1 - z]])
        }
        [&[x, x1, xy], &[y, y1, xz], &[z, z1, yz]] => {
            let reach = |tilts: &[f64]| -> f64 {
                let largest = tilts.iter().copied().fold(0.0, f64::max);
                largest - tilts.iter().copied().fold(0.0, f64::min)
            };
            let x = x1 - x - reach(&[xy, xz, xy + xz]);
            let y = y1 - y - reach(&[yz]);
            Some([[x, 0.0, 0.0], [xy, y, 0.0], [xz, yz, z1 - z]])
        }
        [&[ax, ay, az, _], &[bx, by, bz, _], &[cx, cy, cz, _]] => {
            Some([[ax, ay, az], [bx, by, bz], [cx, cy, cz]])
        }
        _ => None,
    }
}
