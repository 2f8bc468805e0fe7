//! `plot.py`: a few lines of Python that draw a result's pictures from its archive or table.
//!
//! The arrays are used by the names of the reference, so that a reader sees which to take. Axes,
//! units and decades are those of the program's own figures.

use super::ArrayFormat;
use crate::analyze::labels::{self, Power};
use crate::analyze::{Analysis, Extent};
use crate::budget::Budget;
use crate::sweep::{Request, SweptKey};

/// Decades below the largest value that logarithmic colours span, as in the figures.
const DECADES: u32 = 8;

const MAPS: &str = r#"from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

here = Path(__file__).resolve().parent
"#;

const LOG_PICTURE: &str = r#"

def picture(name, x, y, xlabel, ylabel, label, xlim, ylim):
    values = data[name]
    top = np.nanmax(values) or 1.0
    floor = top * 10.0**-DECADES
    fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
    image = ax.pcolormesh(data[x], data[y], np.maximum(values, floor), norm="log", vmin=floor, vmax=top)
    fig.colorbar(image).set_label(label, fontsize=8)
    ax.set(xlabel=xlabel, ylabel=ylabel, xlim=xlim, ylim=ylim)
    return fig, ax
"#;

const SIGNED_PICTURE: &str = r#"

def picture(name, x, y, xlabel, ylabel, label):
    values = data[name]
    sizes = np.abs(values[np.isfinite(values) & (values != 0)])
    limit = np.quantile(sizes, 0.995) if sizes.size else 1.0
    fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
    image = ax.pcolormesh(data[x], data[y], values, cmap="PuOr", vmin=-limit, vmax=limit)
    fig.colorbar(image, extend="both").set_label(label, fontsize=8)
    ax.set(xlabel=xlabel, ylabel=ylabel, xlim=(data[x][0], data[x][-1]), ylim=(data[y][0], data[y][-1]))
    fig.savefig(here / f"plot-{name}.png", dpi=200)
"#;

/// The first lines of every script.
fn head(what: &str, of: &str, from: &str) -> String {
    format!(
        "# {what} of {}, from {from}. Needs Python with `pip install numpy matplotlib`.\n\
         # Edit a copy: a new run of cascade replaces this file and its pictures.\n",
        of.replace(['\n', '\r'], " ")
    )
}

/// A text as a literal of Python; JSON's texts are such.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// The first lines of a script that draws `what` of the arrays of a result, which they open as `data`.
fn opened(what: &str, of: &str, arrays: &str, format: ArrayFormat) -> String {
    let file = format.file_name(arrays);
    let head = head(what, of, &file);
    match format {
        ArrayFormat::Npz => format!("{head}{MAPS}data = np.load(here / \"{file}\")\n"),
        ArrayFormat::NetCdf => {
            let head = head.replace("numpy matplotlib", "numpy matplotlib xarray netCDF4");
            let imports = MAPS.replace("numpy as np\n", "numpy as np\nimport xarray as xr\n");
            format!(
                "{head}{imports}{arrays} = xr.open_dataset(here / \"{file}\")\n\
                 data = {{name: array.values for name, array in {arrays}.variables.items()}}\n"
            )
        }
    }
}

/// Draws `S(k, f)` with its dispersion curves, `S(f, x)` and `S(k, t)` from the file of spectra, those
/// of them that were computed.
pub fn analysis_snippet(analysis: &Analysis, format: ArrayFormat) -> String {
    let axes = &analysis.axes;
    let power = Power::of(analysis);
    let [k, f, x, t] = [
        labels::wavenumber(axes),
        labels::frequency(axes),
        labels::position(axes),
        labels::time(axes),
    ];
    let display = &analysis.display;
    let mut script = opened("Spectra", &analysis.name, "spectra", format);
    script += &LOG_PICTURE.replace("DECADES", &DECADES.to_string());
    let overlay = overlay(analysis);
    let mut draw = |name: &str, [x, y]: [Shown; 2], label: String, more: &str| {
        let [x_label, y_label, label] = [&x.label, &y.label, &label].map(|l| quoted(l));
        let limits = |axis: &Shown| format!("({}, {})", axis.extent.low, axis.extent.high);
        script += &format!(
            "\n\nfig, ax = picture(\"{name}\", \"{}\", \"{}\",\n    {x_label}, {y_label},\n    \
             {label},\n    xlim={}, ylim={})\n{more}fig.savefig(here / \
             \"plot-{name}.png\", dpi=200)\n",
            x.array,
            y.array,
            limits(&x),
            limits(&y)
        );
    };
    if analysis.direction.is_some() {
        let x = Shown::of("wavenumber_signed", k.clone(), &display.wavenumber_signed);
        let y = Shown::of("frequency", f.clone(), &display.frequency);
        draw("spacetime_spectrum", [x, y], power.over_both(), &overlay);
    }
    if analysis.along_space.is_some() {
        let x = Shown::of("position", x, &display.space);
        let y = Shown::of("frequency", f, &display.frequency);
        draw("temporal_spectrum", [x, y], power.over_frequency(), "");
    }
    if analysis.along_time.is_some() {
        let x = Shown::of("wavenumber", k, &display.wavenumber);
        let y = Shown::of("time", t, &display.time);
        draw("spatial_spectrum", [x, y], power.over_wavenumber(), "");
    }
    script
}

/// An axis of a picture: its array, its label, and what of it the figures show.
struct Shown<'a> {
    array: &'static str,
    label: String,
    extent: &'a Extent,
}

impl<'a> Shown<'a> {
    fn of(array: &'static str, label: String, extent: &'a Extent) -> Shown<'a> {
        Shown {
            array,
            label,
            extent,
        }
    }
}

/// Lines that draw dispersion curves.
fn overlay(analysis: &Analysis) -> String {
    if analysis.dispersion.is_empty() {
        return String::new();
    }
    let names: Vec<&str> = analysis.dispersion.iter().map(|c| &c.name[..]).collect();
    format!(
        "for branch in data[\"dispersion_frequency\"]:\n    \
         ax.plot(data[\"dispersion_wavenumber\"], branch, color=\"w\", linestyle=\"--\", \
         linewidth=1)\nax.set_title({}, fontsize=9)\n",
        quoted(&format!("dashed: {}", names.join("; ")))
    )
}

/// Draws the energy flux, the spectral flux and the power flow from the file of a budget, those of them
/// that were computed.
pub fn budget_snippet(budget: &Budget, name: &str, format: ArrayFormat) -> String {
    let units = &budget.units;
    let mut script = opened("Fluxes", name, "budget", format);
    script += SIGNED_PICTURE;
    let mut draw = |name: &str, [x, y]: [&str; 2], labels: [String; 3]| {
        let [x_label, y_label, label] = labels.map(|label| quoted(&label));
        script += &format!(
            "\n\nif \"{name}\" in data:\n    picture(\"{name}\", \"{x}\", \"{y}\",\n            \
             {x_label}, {y_label}, {label})\n"
        );
    };
    draw(
        "energy_flux",
        ["contact_position", "time"],
        [units.position(), units.time(), units.power("energy flux J")],
    );
    draw(
        "spectral_flux",
        ["wavenumber", "time"],
        [
            units.wavenumber(),
            units.time(),
            units.power("spectral flux \u{3a0}, towards high k"),
        ],
    );
    draw(
        "power_flow",
        ["contact_position", "frequency"],
        [
            units.position(),
            units.frequency(),
            units.energy("power flow P(f) per unit of frequency"),
        ],
    );
    script
}

/// What a table's curves are: the columns, their labels, and the columns that tell curves apart.
struct Curves<'a> {
    what: &'a str,
    table: &'a str,
    x: &'a str,
    x_label: &'a str,
    y: &'a str,
    y_label: &'a str,
    /// Columns whose values name a curve.
    apart: &'a [&'a str],
    /// A Python condition on a row.
    only: &'a str,
    /// Whether x is a number rather than a name.
    is_number: bool,
}

impl Curves<'_> {
    fn script(&self) -> String {
        let [table, x, y, x_label, y_label] =
            [self.table, self.x, self.y, self.x_label, self.y_label].map(quoted);
        let value = if self.is_number {
            "float(row[x])"
        } else {
            "row[x]"
        };
        let apart: Vec<String> = self.apart.iter().map(|key| quoted(key)).collect();
        let only = match self.only {
            "" => String::new(),
            only => format!(" and {only}"),
        };
        let mut script = head(self.what, "chains", self.table);
        script += "import csv\nfrom pathlib import Path\n\nimport matplotlib.pyplot as plt\n\n\
                   here = Path(__file__).resolve().parent\n";
        script += &format!(
            r#"x, y, apart = {x}, {y}, [{}]
curves = {{}}
with open(here / {table}, newline="", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        if row[x] and row[y]{only}:
            name = ", ".join(row[key] for key in apart)
            curves.setdefault(name, []).append(({value}, float(row[y])))

fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
for name, points in curves.items():
    ax.plot(*zip(*sorted(points)), ".-", label=name)
ax.set(xlabel={x_label}, ylabel={y_label})
if len(curves) > 1:
    ax.legend(fontsize=8)
fig.savefig(here / "plot-curves.png", dpi=200)
"#,
            apart.join(", ")
        );
        script
    }
}

/// Draws the relative force against length from `curves.csv` of `attenuate`.
pub fn attenuation_snippet() -> String {
    Curves {
        what: "Force against length",
        table: "curves.csv",
        x: "bodies",
        x_label: "bodies before the contact",
        y: "relative_force",
        y_label: "peak force / that of the homogeneous chain",
        apart: &["chain", "sense", "contact_kind"],
        only: "",
        is_number: true,
    }
    .script()
}

/// Draws the relative force at the wall against the key from `curves.csv` of `transmit`.
pub fn transmission_snippet(key: &str, others: &[&str]) -> String {
    Curves {
        what: "Transmitted force",
        table: "curves.csv",
        x: key,
        x_label: &key.replace('_', " "),
        y: "relative_force",
        y_label: "peak force at the wall / that of the homogeneous chain",
        apart: others,
        only: "row[\"row\"] == \"value\"",
        is_number: true,
    }
    .script()
}

/// Draws the force at the last contact against a key from `table.csv` of `sweep`: the first key
/// whose values are numbers, else the first one.
pub fn sweep_snippet(request: &Request) -> String {
    let is_number = |axis: &&SweptKey| axis.values.iter().all(|text| text.parse::<f64>().is_ok());
    let numbers = request.vary.iter().find(is_number);
    let chosen = numbers.or(request.vary.first());
    let key = chosen.map_or("", |axis| &axis.key);
    let keys = request.vary.iter().map(|axis| &*axis.key);
    let others: Vec<&str> = keys.filter(|other| *other != key).collect();
    let label = match request.is_si() {
        true => "largest force at the last contact (N)",
        false => "largest force at the last contact",
    };
    Curves {
        what: "A sweep",
        table: "table.csv",
        x: key,
        x_label: &key.replace('_', " "),
        y: "peak_force_last",
        y_label: label,
        apart: &others,
        only: "",
        is_number: numbers.is_some(),
    }
    .script()
}

/// Draws the ratios against their order from `table.csv` of `localize`.
pub fn localized_snippet() -> String {
    Curves {
        what: "Ratios of localized waves",
        table: "table.csv",
        x: "order",
        x_label: "order",
        y: "ratio",
        y_label: "ratio that carries a localized wave",
        apart: &[],
        only: "",
        is_number: true,
    }
    .script()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_literals_of_python() {
        assert_eq!(quoted("a \"b\" \\ c\n"), r#""a \"b\" \\ c\n""#);
        let script = transmission_snippet("stiffness_ratio", &["sites"]);
        assert!(script.contains(r#"x, y, apart = "stiffness_ratio", "relative_force", ["sites"]"#));
        assert!(head("Spectra", "a\nimport os", "b").lines().count() == 2);
    }
}
