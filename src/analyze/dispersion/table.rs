//! Dispersion curves from a table of comma-separated values.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::super::Axes;
use crate::error::{Error, Result};
use crate::measure::{Frequency, Length, Time, size};

/// Curves as a file lists them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    path: PathBuf,
    k_unit: Option<String>,
    curves: Vec<Curve>,
}

#[derive(Debug, Clone, PartialEq)]
struct Curve {
    is_cycles: bool,
    unit: Option<String>,
    /// Rising k with their frequencies; NaN in gaps.
    points: Vec<(f64, f64)>,
}

/// Name and unit of a column: `k`, `k (rad/m)`, `omega_2 [rad/s]`. A number after the name tells branches apart.
fn header(cell: &str) -> (String, Option<String>) {
    let (name, unit) = match cell.split_once(['(', '[']) {
        Some((name, unit)) => (
            name,
            Some(unit.trim_end_matches([')', ']']).trim().to_owned()),
        ),
        None => (cell, None),
    };
    let is_number = |c: char| c.is_ascii_digit() || c == '_';
    (name.trim().trim_end_matches(is_number).to_lowercase(), unit)
}

impl Table {
    pub(super) fn read(path: &Path) -> Result<Table> {
        let text = std::fs::read_to_string(path).map_err(Error::read("read", path))?;
        Table::parse(path, &text)
    }

    fn parse(path: &Path, text: &str) -> Result<Table> {
        let fault = |expected: &str, found: String| Error::Unfit {
            path: path.to_owned(),
            expected: expected.into(),
            found,
        };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let broken = |error: csv::Error| fault("comma-separated values", error.to_string());
        let headers = reader.headers().map_err(broken)?.clone();
        let columns: Vec<(String, Option<String>)> = headers.iter().map(header).collect();
        let named = |names: &[&str]| -> Vec<usize> {
            let is_named = |n: &usize| names.contains(&&*columns[*n].0);
            (0..columns.len()).filter(is_named).collect()
        };
        let cycles = named(&["f", "frequency"]);
        let omega = named(&["omega", "\u{3c9}", "angular_frequency"]);
        let (ks, labels) = (named(&["k", "wavenumber"]), named(&["curve", "branch"]));
        let known = cycles.len() + omega.len() + labels.len() + 1;
        let ([k], true) = (
            &ks[..],
            known == columns.len() && known > labels.len() + 1 && labels.len() < 2,
        ) else {
            let expected = "columns k and omega or f by name, such as `k (rad/m),f (Hz)`, and at most \
                            one column `curve`";
            let found: Vec<&str> = headers.iter().collect();
            return Err(fault(expected, format!("`{}`", found.join(","))));
        };
        let mut points: BTreeMap<(String, usize), Vec<(f64, f64)>> = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |n: usize| match &record[n] {
                "" => Ok(f64::NAN),
                cell => cell
                    .parse()
                    .map_err(|_| fault("a number", format!("`{cell}` in line {line}"))),
            };
            let label = labels.first().map_or("", |&n| &record[n]);
            let at = number(*k)?;
            for &n in cycles.iter().chain(&omega) {
                let points = points.entry((label.to_owned(), n)).or_default();
                let rises = points.last().is_none_or(|last| last.0 < at);
                if !at.is_finite() || !rises {
                    let expected = "finite k that rises along a branch (a column `curve` tells \
                                    branches apart)";
                    return Err(fault(expected, format!("`{}` in line {line}", &record[*k])));
                }
                points.push((at, number(n)?));
            }
        }
        if points.is_empty() {
            return Err(fault("rows of numbers", "none".into()));
        }
        let curves = points.into_iter().map(|((_, n), points)| Curve {
            is_cycles: cycles.contains(&n),
            unit: columns[n].1.clone(),
            points,
        });
        Ok(Table {
            path: path.to_owned(),
            k_unit: columns[*k].1.clone(),
            curves: curves.collect(),
        })
    }

    /// Omega of every branch at the wavenumbers of a field, in its units.
    pub(super) fn branches(&self, axes: &Axes, wavenumber: &[f64]) -> Result<Vec<Vec<f64>>> {
        let k_factor = self.factor(&self.k_unit, axes.units().wavenumber, |unit| {
            let length = unit.strip_prefix("rad/").or(unit.strip_prefix("1/"))?;
            Some(1.0 / size::<Length>(length)?)
        })?;
        let one_sided = |curve: &Curve| curve.points.iter().all(|point| point.0 >= 0.0);
        let both = self.curves.iter().all(one_sided);
        let branch = |curve: &Curve| {
            let factor = match curve.is_cycles {
                true => TAU * self.factor(&curve.unit, axes.units().frequency, hertz)?,
                false => {
                    self.factor(&curve.unit, format!("rad/{}", axes.units().time), |unit| {
                        Some(1.0 / size::<Time>(unit.strip_prefix("rad/")?)?)
                    })?
                }
            };
            let at = |&k: &f64| {
                let k = if both { k.abs() } else { k };
                factor * interpolated(&curve.points, k / k_factor)
            };
            Ok(wavenumber.iter().map(at).collect())
        };
        self.curves.iter().map(branch).collect()
    }

    /// By what values in `unit` are multiplied; without a unit they are in that of the field, its `own`.
    fn factor(
        &self,
        unit: &Option<String>,
        own: String,
        size: impl Fn(&str) -> Option<f64>,
    ) -> Result<f64> {
        let Some(unit) = unit.as_ref().filter(|unit| **unit != own) else {
            return Ok(1.0);
        };
        let factor = size(unit).zip(size(&own)).map(|(unit, own)| unit / own);
        factor.ok_or_else(|| Error::Unfit {
            path: self.path.clone(),
            expected: format!("values in {own} or a unit that converts to it"),
            found: format!("values in {unit}"),
        })
    }
}

/// The size of `kHz`, and of `cycles/min`, in hertz.
fn hertz(unit: &str) -> Option<f64> {
    let period = || Some(1.0 / size::<Time>(unit.strip_prefix("cycles/")?)?);
    size::<Frequency>(unit).or_else(period)
}

/// Linear between points; NaN outside them and beside a gap.
fn interpolated(points: &[(f64, f64)], k: f64) -> f64 {
    let after = points.partition_point(|point| point.0 < k);
    match (points.get(after.wrapping_sub(1)), points.get(after)) {
        (_, Some(&(at, value))) if at == k => value,
        (Some(&(a, low)), Some(&(b, high))) => low + (high - low) * (k - a) / (b - a),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Table> {
        Table::parse(Path::new("curve.csv"), text)
    }

    #[test]
    fn columns_and_labels_are_branches() {
        let table = parse("# measured\nk,f_1 (kHz),f_2 [Hz]\n0,0,5\n1,2,\n2,3,4\n").unwrap();
        let at = |curve: usize, k: f64| interpolated(&table.curves[curve].points, k);
        assert_eq!([at(0, 0.5), at(1, 2.0)], [1.0, 4.0]);
        assert!(at(1, 0.5).is_nan() && at(0, 2.1).is_nan());
        let table = parse("k,omega,curve\n0,0,low\n0,5,high\n1,2,low\n1,4,high\n").unwrap();
        assert!(table.curves.len() == 2 && !table.curves[0].is_cycles);
    }

    #[test]
    fn faults_name_line_and_column() {
        for (text, expected, found) in [
            ("k,speed\n0,1\n", "columns k and omega or f", "`k,speed`"),
            ("k\n0\n", "columns k and omega or f", "`k`"),
            ("omega,f\n0,1\n", "columns k", "`omega,f`"),
            ("k,f\n0,1\n1,two\n", "a number", "`two` in line 3"),
            ("k,f\n1,1\n0,2\n", "finite k that rises", "`0` in line 3"),
            ("k,f\n,2\n", "finite k", "`` in line 2"),
            ("k,f\n", "rows of numbers", "none"),
            ("k,f\n1\n", "comma-separated", "found record"),
            ("", "columns k", "``"),
        ] {
            match parse(text) {
                Err(Error::Unfit {
                    expected: e,
                    found: f,
                    ..
                }) => {
                    assert!(e.starts_with(expected), "{text}: {e}");
                    assert!(f.contains(found), "{text}: {f}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
    }
}
