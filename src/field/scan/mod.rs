//! Point-by-point scans: one record a file, many files, one field.

mod correlate;
mod position;
mod records;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::align::{Alignment, Apart, Shift};
use super::assembly::Assembly;
use super::coordinates::{Coordinates, Listed};
use super::options::OpenOptions;
use super::resample::resampled;
use super::{Field, Note, Sample};
use crate::error::{Error, Fault, Result};
use crate::measure::digits;
use position::{Positions, factor, fault_of};
use records::Head;

pub(super) use position::NamedNumber;

/// Where the positions of a scan are found.
#[derive(Debug, Clone, PartialEq)]
pub enum PositionFrom {
    /// The number in the names of the files that differs among them, with or without a unit of length behind
    /// it (`x=12.5mm`): the only one, or the one behind these letters.
    Name(Option<String>),
    /// The single number of each file that is called as a position is and differs among the files: an
    /// attribute, an array of one number, the `x0` of a sidecar; or the one of this name.
    Header(Option<String>),
    /// A table with a header and two columns: `file` (a path as it is opened, or its last part), and
    /// `position` or `x`, with a unit as in `position_mm`.
    Table(PathBuf),
}

/// What becomes of several records at one position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EqualPositions {
    /// They are refused.
    #[default]
    Refuse,
    /// Their mean, once they are aligned.
    Average,
}

/// How files with one record each become one field, one site a file, in the order of the positions.
///
/// With the step `dt` and the start `o_i` of the record of site i, sample n is taken at the time
///
/// ```text
/// t = o_0 + (n + s_i) dt,    s_i = (o_i - o_0) / dt             by the times of the files,
///                            s_i = -(L_i + d_i)                 by a reference channel,
/// ```
///
/// and the field has the times that all records have in common. The delay `L_i`, in whole samples, is where
/// the cross-correlation with the reference `a` of the first site,
/// `c_i(L) = sum_n a[n] b_i[n + L]`, of records less their medians, is largest; `d_i` is the vertex of the
/// parabola through `c_i(L_i - 1)`, `c_i(L_i)` and `c_i(L_i + 1)`. The coefficient
/// `c_i(L_i) / sqrt(sum a^2 sum b_i^2)` is at most 1.
///
/// A shift within [`OpenOptions::jitter`] of a whole number is taken as whole, and samples stay what they
/// are. Another one is refused, unless [`OpenOptions::resample`] names a method along time; by a reference,
/// without a method, `d_i` is reported and left out.
///
/// # Examples
/// Records of 8 times, 2 samples late in the second file:
/// ```
/// use wavecascade::field::{OpenOptions, PositionFrom, Scan};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let place = tempfile::tempdir()?;
/// let paths = [0, 5].map(|x| place.path().join(format!("x={x}mm.csv")));
/// for (path, late) in paths.iter().zip([0, 2]) {
///     let row = |n: i32| format!("{n},{}\n", if n == 3 + late { 1.0 } else { 0.0 });
///     let rows: String = (0..8).map(row).collect();
///     std::fs::write(path, format!("time_ms,hammer\n{rows}"))?;
/// }
/// let mut scan = Scan::new(PositionFrom::Name(None));
/// scan.reference = Some("hammer".into());
/// let scanned = scan.open(&paths, &OpenOptions::default())?;
/// assert_eq!((scanned.field.n_times(), scanned.field.n_sites()), (6, 2));
/// assert_eq!((scanned.field.space.step, scanned.records[1].delay), (5.0, 2.0));
/// # Ok(())
/// # }
/// ```
///
/// # Source
/// J. S. Bendat and A. G. Piersol, Random Data (4th ed., Wiley 2010), section 5.1.4, for delays from
/// cross-correlations.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Where the positions are found.
    pub position: PositionFrom,
    /// The channel of each file that is the record, of files with several: an array or a column by its name,
    /// a column by its number from 0.
    pub channel: Option<String>,
    /// The channel by which records are aligned.
    pub reference: Option<String>,
    /// Least correlation coefficient of the references, 0.7 by default.
    pub least_correlation: f64,
    /// What becomes of several records at one position.
    pub equal_positions: EqualPositions,
}

/// A field from the files of a scan.
#[derive(Debug)]
pub struct Scanned {
    /// The field.
    pub field: Field,
    /// What was taken of each file, in the order of the sites.
    pub records: Vec<ScanRecord>,
}

/// What was taken of one file.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanRecord {
    /// The file.
    pub path: PathBuf,
    /// Its position, in the unit of the field's space.
    pub position: f64,
    /// How many samples its record has.
    pub n_times: usize,
    /// By how many samples an event comes later in the record than in that of the first site: `-s_i`.
    pub delay: f64,
    /// The share of a sample of it that is left in the field, since nothing is resampled.
    pub left: f64,
    /// The correlation coefficient of its reference.
    pub correlation: Option<f64>,
}

impl Scan {
    /// A scan without a reference.
    pub fn new(position: PositionFrom) -> Scan {
        Scan {
            position,
            channel: None,
            reference: None,
            least_correlation: 0.7,
            equal_positions: EqualPositions::default(),
        }
    }

    /// The field of the files at `paths`, in any order, each opened with `options`; `dx`, `x0` and
    /// `space_unit` are those of the whole.
    ///
    /// The field is held in memory, within [`OpenOptions::memory`] or half of what is free, else in a scratch
    /// file. Its hash is that of the hashes of the files in the order of the sites.
    ///
    /// # Errors
    /// As [`Field::open`] for each file; [`Error::Scan`] for a file that does not go with the others;
    /// [`Error::Request`] for fewer than two files; positions that are not even, as for any coordinates;
    /// [`Error::Changed`] for a file that is written to meanwhile.
    pub fn open<P: AsRef<Path>>(&self, paths: &[P], options: &OpenOptions) -> Result<Scanned> {
        self.check(paths.len())?;
        options.check()?;
        let paths: Vec<PathBuf> = paths.iter().map(|path| path.as_ref().to_owned()).collect();
        let of_each = OpenOptions {
            dx: None,
            x0: None,
            space_unit: None,
            ..options.clone()
        };
        let positions = position::of(&self.position, &paths, &of_each)?;
        let positions = in_unit(positions, options.space_unit.as_deref());
        let (order, sites) = self.sites(&positions, &paths)?;
        let paths: Vec<&PathBuf> = order.iter().map(|&i| &paths[i]).collect();

        let heads = records::heads(self, &paths, &of_each)?;
        records::check_alike(&heads, options.jitter)?;
        let alignment = alignment(self, &heads, options)?;
        let n_sites = sites.last().map_or(0, |last| last + 1);
        let shape = [n_sites, alignment.n_times];
        let (assembly, hash) = self.assemble(&heads, &sites, &alignment, &of_each, shape)?;

        let at: Vec<f64> = order.iter().map(|&i| positions.values[i]).collect();
        let records = taken(&heads, &at, &alignment);
        let listed = space(&at, &positions, &heads, &sites, options)?;
        let mut notes = vec![self.note(&records, n_sites, positions.unit.as_deref())];
        let weakest = records.iter().filter_map(|record| record.correlation);
        let weakest = weakest.fold(1.0, f64::min);
        notes.extend(alignment.note(self.reference.as_deref().map(|name| (name, weakest))));
        notes.extend(listed.note);
        notes.extend(records::notes(&heads));
        let mut storage = assembly.finish(false)?;
        if let Some(space) = &listed.resampling {
            storage = resampled(&storage, alignment.n_times, space, options, false)?;
        }
        let even = Coordinates {
            unit: positions.unit,
            ..listed.even
        };
        let Head { path, field, .. } = &heads[0];
        let space = even.axis([options.x0, options.dx], options.space_unit.clone());
        let space = space.map_err(Error::input(path))?;
        let mut time = field.time.clone();
        time.origin += alignment.start as f64 * time.step;
        let field = Field {
            name: name(path),
            time,
            space,
            quantity: field.quantity,
            unit: field.unit.clone(),
            dispersion: field.dispersion.clone(),
            content_hash: Some(hash),
            notes,
            ..Field::of_storage(storage, (alignment.n_times, n_sites))
        };
        Ok(Scanned { field, records })
    }

    fn check(&self, n_files: usize) -> Result<()> {
        let found = format!("{n_files} of them");
        Error::require(n_files > 1, "position-from", "two files or more", found)?;
        let (least, expected) = (self.least_correlation, "a number from 0 to 1");
        let is_one = (0.0..=1.0).contains(&least);
        Error::require(is_one, "least-correlation", expected, least)
    }

    /// The files in the order of their positions, and the site of each.
    fn sites(&self, positions: &Positions, paths: &[PathBuf]) -> Result<(Vec<usize>, Vec<usize>)> {
        let values = &positions.values;
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| {
            let by_place = values[a].total_cmp(&values[b]);
            by_place.then(paths[a].cmp(&paths[b]))
        });
        let span = values[order[order.len() - 1]] - values[order[0]];
        let mut sites = vec![0];
        for pair in order.windows(2) {
            let is_equal = values[pair[1]] - values[pair[0]] <= 1e-9 * span;
            if is_equal && self.equal_positions == EqualPositions::Refuse {
                let found = format!("{} as in {}", values[pair[1]], paths[pair[0]].display());
                let advice = "leave one out, or take their mean: `--equal-positions average`";
                let fault = Fault::expected("positions that differ", found, advice);
                return Err(fault_of(&paths[pair[1]], fault));
            }
            sites.push(sites[sites.len() - 1] + usize::from(!is_equal));
        }
        Ok((order, sites))
    }

    /// The aligned records, one row a site, and the hash of all files.
    fn assemble(
        &self,
        heads: &[Head],
        sites: &[usize],
        alignment: &Alignment,
        options: &OpenOptions,
        [n_sites, n_times]: [usize; 2],
    ) -> Result<(Assembly, String)> {
        let (what, shape) = ("the field of all files", [n_sites, n_times]);
        let mut assembly = Assembly::new(what, Sample::F64, shape, options)?;
        let at_once = rayon::current_num_threads().max(1);
        let mut hasher = blake3::Hasher::new();
        let (mut sum, mut count) = (Vec::new(), 0.0);
        for from in (0..heads.len()).step_by(at_once) {
            let part = from..heads.len().min(from + at_once);
            let read = part.clone().into_par_iter();
            let read = read.map(|n| records::aligned(self, &heads[n], alignment, n, options));
            for (n, read) in part.zip(read.collect::<Vec<_>>()) {
                let (record, hash) = read?;
                hasher.update(hash.as_bytes());
                if n > 0 && sites[n] == sites[n - 1] {
                    let sums = sum.iter_mut().zip(&record);
                    sums.for_each(|(sum, value)| *sum += value);
                    count += 1.0;
                } else {
                    (sum, count) = (record, 1.0);
                }
                if sites.get(n + 1) != Some(&sites[n]) {
                    sum.iter_mut().for_each(|sum| *sum /= count);
                    assembly.write(sites[n], &sum)?;
                }
            }
        }
        Ok((assembly, hasher.finalize().to_hex().to_string()))
    }

    fn note(&self, records: &[ScanRecord], n_sites: usize, unit: Option<&str>) -> Note {
        let positions_from = match &self.position {
            PositionFrom::Name(_) => "the names of the files".into(),
            PositionFrom::Header(_) => "the headers of the files".into(),
            PositionFrom::Table(table) => table.display().to_string(),
        };
        let files = records.len();
        let sites = match files == n_sites {
            true => "one site a file".into(),
            false => format!("{n_sites} sites, equal positions averaged"),
        };
        let [first, last] = [&records[0], &records[files - 1]].map(|of| digits(of.position));
        let unit = unit.unwrap_or_default();
        let text = format!(
            "{files} files are one field, {sites}; positions from {positions_from}, {first} to {last} {unit}"
        );
        Note::told("scan", text.trim_end())
    }
}

/// The shifts of the records: by the delays of the references, else by the times of the files.
fn alignment(scan: &Scan, heads: &[Head], options: &OpenOptions) -> Result<Alignment> {
    let (jitter, method) = (options.jitter, options.resample.time);
    let first = &heads[0].field.time;
    let shift = |head: &Head| -> Result<Shift> {
        if let (Some(_), Some(delay)) = (&scan.reference, head.delay) {
            let left = Shift {
                whole: -delay.samples,
                fraction: 0.0,
                left: -delay.fraction,
            };
            let exact = left.total();
            let resampled = method.and_then(|_| Shift::of(exact, jitter, method));
            return Ok(resampled.unwrap_or(left));
        }
        let shift = (head.field.time.origin - first.origin) / first.step;
        let parts = Shift::of(shift, jitter, method);
        parts.ok_or_else(|| {
            let expected = "a start at a whole number of steps from that of the first file";
            let advice =
                "interpolate the records, `--resample cubic`, or allow more, `--jitter 5%`";
            let fault = Fault::expected(expected, format!("{shift} steps"), advice);
            fault_of(&head.path, fault)
        })
    };
    let shifts = heads.iter().map(shift).collect::<Result<Vec<_>>>()?;
    let lengths = heads.iter().map(|head| head.field.n_times).collect();
    Alignment::new(shifts, lengths, method).map_err(|Apart { early, late }| {
        let found = format!("an end before {} begins", heads[late].path.display());
        let advice = "leave one of the two files out, or check the times of both";
        let fault = Fault::expected("at least two times in common", found, advice);
        fault_of(&heads[early].path, fault)
    })
}

/// What was taken of each file, at positions `at`.
fn taken(heads: &[Head], at: &[f64], alignment: &Alignment) -> Vec<ScanRecord> {
    let parts = heads.iter().zip(at).zip(&alignment.shifts);
    let one = |((head, &position), shift): ((&Head, &f64), &Shift)| ScanRecord {
        path: head.path.clone(),
        position,
        n_times: head.field.n_times,
        // No negative zeros.
        delay: 0.0 - shift.total(),
        left: 0.0 - shift.left,
        correlation: head.delay.map(|delay| delay.coefficient),
    };
    parts.map(one).collect()
}

/// The positions in the unit of the axis, where both are known.
fn in_unit(mut positions: Positions, unit: Option<&str>) -> Positions {
    let own = positions.unit.as_deref().filter(|_| unit.is_some());
    if let Some(factor) = own.and_then(|own| factor(Some(own), unit)) {
        let all = positions.values.iter_mut();
        all.for_each(|value| *value *= factor);
        positions.rounding *= factor;
        positions.unit = unit.map(str::to_owned);
    }
    positions
}

/// The axis of the sites, of files at positions `at`.
fn space(
    at: &[f64],
    positions: &Positions,
    heads: &[Head],
    sites: &[usize],
    options: &OpenOptions,
) -> Result<Listed> {
    let first_of = |site: usize| sites.iter().position(|&one| one == site).unwrap_or(0);
    let n_sites = sites.last().map_or(0, |last| last + 1);
    let at: Vec<f64> = (0..n_sites).map(|site| at[first_of(site)]).collect();
    let rules = options.dx.is_none().then(|| options.evenness("space"));
    let listed = Coordinates::listed("space", &at, (positions.rounding, None), rules);
    listed.map_err(|uneven| {
        let path = &heads[first_of(uneven.index)].path;
        Error::input(path)(uneven.fault("space"))
    })
}

/// The name of the folder of a file.
fn name(path: &Path) -> String {
    let folder = path.parent().and_then(Path::file_name);
    folder.map_or("scan".into(), |name| name.to_string_lossy().into_owned())
}
