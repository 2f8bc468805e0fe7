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

/// What a column of the table is, from its header.
#[derive(Debug, Clone, PartialEq)]
enum Column {
    Wavenumber(Option<String>),
    Frequency {
        is_cycles: bool,
        unit: Option<String>,
    },
    Curve,
}

impl Column {
    /// `k`, `k (rad/m)`, `omega`, `omega_2 [rad/s]`, `f (Hz)`, `frequency`, `curve`.
    fn of(header: &str) -> Option<Column> {
        let header = header.trim();
        let (name, unit) = match header.find(['(', '[']) {
            Some(at) => {
                let unit = header[at + 1..].strip_suffix([')', ']'])?.trim();
                (header[..at].trim(), Some(unit.to_owned()))
            }
            None => (header, None),
        };
        // A number after the name tells branches apart.
        let name = name.trim_end_matches(|c: char| c.is_ascii_digit());
        match name.trim_end_matches('_').to_ascii_lowercase().as_str() {
            "k" | "wavenumber" => Some(Column::Wavenumber(unit)),
            "omega" | "\u{3c9}" | "angular_frequency" => Some(Column::Frequency {
                is_cycles: false,
                unit,
            }),
            "f" | "frequency" => Some(Column::Frequency {
                is_cycles: true,
                unit,
            }),
            "curve" | "branch" => Some(Column::Curve),
            _ => None,
        }
    }
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
        let header = "columns k and omega or f by name, such as `k (rad/m),f (Hz)`, and at most \
                      one column `curve`";
        let columns: Vec<Column> = headers
            .iter()
            .map(|cell| Column::of(cell).ok_or_else(|| fault(header, format!("`{cell}`"))))
            .collect::<Result<_>>()?;
        let places = |is: fn(&Column) -> bool| -> Vec<usize> {
            (0..columns.len()).filter(|&n| is(&columns[n])).collect()
        };
        let k = places(|c| matches!(c, Column::Wavenumber(_)));
        let frequencies = places(|c| matches!(c, Column::Frequency { .. }));
        let curve = places(|c| *c == Column::Curve);
        if k.len() != 1 || frequencies.is_empty() || curve.len() > 1 {
            let found: Vec<&str> = headers.iter().collect();
            return Err(fault(header, format!("`{}`", found.join(","))));
        }
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
            let label = curve.first().map_or("", |&n| &record[n]);
            let at = number(k[0])?;
            if !at.is_finite() {
                return Err(fault(
                    "a finite k",
                    format!("`{}` in line {line}", &record[k[0]]),
                ));
            }
            for &n in &frequencies {
                let points = points.entry((label.to_owned(), n)).or_default();
                if points.last().is_some_and(|last| last.0 >= at) {
                    let expected = "k that rises along a branch (a column `curve` tells branches \
                                    apart)";
                    return Err(fault(expected, format!("{at} in line {line}")));
                }
                points.push((at, number(n)?));
            }
        }
        if points.is_empty() {
            return Err(fault("rows of numbers", "none".into()));
        }
        let curves = points
            .into_iter()
            .filter_map(|((_, n), points)| match &columns[n] {
                Column::Frequency { is_cycles, unit } => Some(Curve {
                    is_cycles: *is_cycles,
                    unit: unit.clone(),
                    points,
                }),
                _ => None,
            });
        Ok(Table {
            path: path.to_owned(),
            k_unit: match &columns[k[0]] {
                Column::Wavenumber(unit) => unit.clone(),
                _ => None,
            },
            curves: curves.collect(),
        })
    }

    /// Omega of every branch at the wavenumbers of a field, in its units.
    pub(super) fn branches(&self, axes: &Axes, wavenumber: &[f64]) -> Result<Vec<Vec<f64>>> {
        let k_factor = self.factor(self.k_unit.as_deref(), &wavenumber_factor(axes))?;
        let one_sided = |curve: &Curve| curve.points.iter().all(|point| point.0 >= 0.0);
        let both = self.curves.iter().all(one_sided);
        let branch = |curve: &Curve| {
            let of_time = frequency_factor(axes, curve.is_cycles);
            let factor = self.factor(curve.unit.as_deref(), &of_time)?;
            let factor = if curve.is_cycles {
                TAU * factor
            } else {
                factor
            };
            let at = |&k: &f64| {
                let k = if both { k.abs() } else { k };
                factor * interpolated(&curve.points, k / k_factor)
            };
            Ok(wavenumber.iter().map(at).collect())
        };
        self.curves.iter().map(branch).collect()
    }

    /// By what values in `unit` are multiplied; without a unit they are in that of the field.
    fn factor(&self, unit: Option<&str>, known: &UnitFactor) -> Result<f64> {
        let Some(unit) = unit else { return Ok(1.0) };
        if unit == known.own {
            return Ok(1.0);
        }
        (known.of)(unit).ok_or_else(|| Error::Unfit {
            path: self.path.clone(),
            expected: format!("values in {} or a unit that converts to it", known.own),
            found: format!("values in {unit}"),
        })
    }
}

type SizeOf<'a> = Box<dyn Fn(&str) -> Option<f64> + 'a>;

/// The unit of an axis, and the size of others in it.
struct UnitFactor<'a> {
    own: String,
    of: SizeOf<'a>,
}

fn wavenumber_factor(axes: &Axes) -> UnitFactor<'_> {
    UnitFactor {
        own: axes.wavenumber_unit(),
        of: Box::new(|unit| {
            let length = unit.strip_prefix("rad/").or(unit.strip_prefix("1/"))?;
            Some(size::<Length>(axes.space_unit())? / size::<Length>(length)?)
        }),
    }
}

fn frequency_factor(axes: &Axes, is_cycles: bool) -> UnitFactor<'_> {
    let own = match is_cycles {
        true => axes.frequency_unit(),
        false => format!("rad/{}", axes.time_unit()),
    };
    let of = move |unit: &str| {
        let second = size::<Time>(axes.time_unit())?;
        match is_cycles {
            true => Some(second * size::<Frequency>(unit)?),
            false => Some(second / size::<Time>(unit.strip_prefix("rad/")?)?),
        }
    };
    UnitFactor {
        own,
        of: Box::new(of),
    }
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
        let table = parse("# measured\nk,f_1 (kHz),f_2 (kHz)\n0,0,5\n1,2,\n2,3,4\n").unwrap();
        assert_eq!(table.curves.len(), 2);
        assert_eq!(interpolated(&table.curves[0].points, 0.5), 1.0);
        assert!(interpolated(&table.curves[1].points, 0.5).is_nan());
        assert_eq!(interpolated(&table.curves[1].points, 2.0), 4.0);
        assert!(interpolated(&table.curves[0].points, 2.1).is_nan());

        let table = parse("k,omega,curve\n0,0,low\n0,5,high\n1,2,low\n1,4,high\n").unwrap();
        assert_eq!(table.curves.len(), 2);
        assert!(!table.curves[0].is_cycles);
    }

    #[test]
    fn faults_name_line_and_column() {
        for (text, expected, found) in [
            ("k,speed\n0,1\n", "columns k and omega or f", "`speed`"),
            ("k\n0\n", "columns k and omega or f", "`k`"),
            ("omega,f\n0,1\n", "columns k", "`omega,f`"),
            ("k,f\n0,1\n1,two\n", "a number", "`two` in line 3"),
            ("k,f\n1,1\n0,2\n", "k that rises", "0 in line 3"),
            ("k,f\n,2\n", "a finite k", "`` in line 2"),
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
