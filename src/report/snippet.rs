//! `plot.py`: a few lines of Python that draw a result's pictures from its archive or table.
//!
//! The arrays are used by the names of the reference, so that a reader sees which to take. Axes,
//! units and decades are those of the program's own figures.

use super::ArrayFormat;
use crate::analyze::axes::Side;
use crate::analyze::labels::Power;
use crate::analyze::{Analysis, Extent};
use crate::arrays::LargeArray;
use crate::budget::Budget;
use crate::sweep::{Request, SweptKey};

/// What scripts of arrays begin with. Logarithmic colours span as many decades as in the figures.
const PICTURE: &str = r#"
def picture(name, x, y, labels, limits, is_log, dashed=""):
    if name not in data:
        return
    values = data[name]
    fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
    if is_log:
        top = np.nanmax(values) or 1.0
        floor = top * 10.0**-8
        colors = dict(norm="log", vmin=floor, vmax=top)
        values = np.maximum(values, floor)
    else:
        sizes = np.abs(values[np.isfinite(values) & (values != 0)])
        limit = np.quantile(sizes, 0.995) if sizes.size else 1.0
        colors = dict(cmap="PuOr", vmin=-limit, vmax=limit)
    image = ax.pcolormesh(data[x], data[y], values, **colors)
    fig.colorbar(image, extend="neither" if is_log else "both").set_label(labels[2], fontsize=8)
    if dashed:
        ax.set_title(f"dashed: {dashed}", fontsize=9)
        for branch in data["dispersion_frequency"]:
            ax.plot(data["dispersion_wavenumber"], branch, color="w", linestyle="--", linewidth=1)
    ends = limits or [(data[axis][0], data[axis][-1]) for axis in (x, y)]
    ax.set(xlabel=labels[0], ylabel=labels[1], xlim=ends[0], ylim=ends[1])
    fig.savefig(here / f"plot-{name}.png", dpi=200)
"#;

/// The first lines of every script.
fn head(what: &str, of: &str, from: &str, needs: &str) -> String {
    format!(
        "# {what} of {}, from {from}. Needs Python with `pip install numpy matplotlib{needs}`.\n\
         # Edit a copy: a new run of cascade replaces this file and its pictures.\n\
         from pathlib import Path\n\nimport matplotlib.pyplot as plt\n",
        of.replace(['\n', '\r'], " ")
    )
}

/// A text, or several, as a literal of Python; JSON's are such.
fn quoted(text: impl Into<serde_json::Value>) -> String {
    text.into().to_string()
}

const HERE: &str = "\nhere = Path(__file__).resolve().parent\n";

/// An axis of a picture: its array, its label, and what of it the figures show, where that is not all.
type Shown<'a> = (&'static str, String, Option<&'a Extent>);

/// A script that draws pictures of the arrays of a result: of each array, its axes, and what its colours mean.
fn pictures<const N: usize>(
    [what, of, arrays]: [&str; 3],
    format: ArrayFormat,
    all: [(&str, [Shown; 2], String); N],
    more: impl Fn(&str) -> String,
) -> String {
    let file = format.file_name(arrays);
    let mut script = match format {
        ArrayFormat::Npz => format!(
            "{}import numpy as np\n{HERE}data = np.load(here / \"{file}\")\n",
            head(what, of, &file, "")
        ),
        ArrayFormat::NetCdf => format!(
            "{}import numpy as np\nimport xarray as xr\n{HERE}{arrays} = xr.open_dataset(here / \"{file}\")\n\
             data = {{name: array.values for name, array in {arrays}.variables.items()}}\n",
            head(what, of, &file, " xarray netCDF4")
        ),
    };
    script += "\n";
    script += PICTURE;
    script += "\n\n";
    for (name, [(x, x_label, x_shown), (y, y_label, y_shown)], label) in all {
        let limits = x_shown.zip(y_shown).map_or("None".into(), |(x, y)| {
            format!("[({}, {}), ({}, {})]", x.low, x.high, y.low, y.high)
        });
        let labels = quoted(vec![x_label, y_label, label]);
        let more = more(name);
        script += &format!(
            "picture(\"{name}\", \"{x}\", \"{y}\",\n        {labels},\n        {limits}, {more})\n"
        );
    }
    script
}

/// Draws `S(k, f)` with its dispersion curves, `S(f, x)` and `S(k, t)` from the file of spectra, those
/// of them that were computed.
pub fn analysis_snippet(analysis: &Analysis, format: ArrayFormat) -> String {
    let power = Power::of(analysis);
    let all = [
        LargeArray::SPACETIME_SPECTRUM,
        LargeArray::TEMPORAL_SPECTRUM,
        LargeArray::SPATIAL_SPECTRUM,
    ];
    let all = all.map(|array| {
        let mut axes = Side::of(array).map(|side| {
            let (label, part) = (side.label(&analysis.axes), analysis.display.part(side));
            (side.name(), label, Some(part))
        });
        axes.reverse();
        (array.name(), axes, power.of_array(array))
    });
    let names: Vec<&str> = analysis.dispersion.iter().map(|c| &c.name[..]).collect();
    let dashed = quoted(names.join("; "));
    pictures(
        ["Spectra", &analysis.name, "spectra"],
        format,
        all,
        |name| match name {
            "spacetime_spectrum" => format!("is_log=True, dashed={dashed}"),
            _ => "is_log=True".into(),
        },
    )
}

/// Draws the energy flux, the spectral flux and the power flow from the file of a budget, those of them
/// that were computed.
pub fn budget_snippet(budget: &Budget, name: &str, format: ArrayFormat) -> String {
    let units = &budget.units;
    let (position, time) = (units.position(), units.time());
    let over_time = ("time", time, None);
    let contacts = ("contact_position", position, None);
    let wavenumber = ("wavenumber", units.wavenumber(), None);
    let frequency = ("frequency", units.frequency(), None);
    let flux = units.power("energy flux J");
    let spectral = units.power("spectral flux \u{3a0}, towards high k");
    let flow = units.energy("power flow P(f) per unit of frequency");
    let all = [
        ("energy_flux", [contacts.clone(), over_time.clone()], flux),
        ("spectral_flux", [wavenumber, over_time], spectral),
        ("power_flow", [contacts, frequency], flow),
    ];
    pictures(["Fluxes", name, "budget"], format, all, |_| {
        "is_log=False".into()
    })
}

/// A script that draws the curves of a table: its columns with their labels, the columns whose values name a curve, and a
/// Python condition on a row.
fn curves(
    what: &str,
    table: &str,
    [x, x_label]: [&str; 2],
    [y, y_label]: [&str; 2],
    apart: &[&str],
    only: &str,
) -> String {
    let [file, x, y, x_label, y_label] = [table, x, y, x_label, y_label].map(quoted);
    let mut script = head(what, "chains", table, "");
    script += "import csv\n";
    script += HERE;
    script += &format!(
        r#"x, y, apart = {x}, {y}, {apart}
curves = {{}}


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


with open(here / {file}, newline="", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        if row[x] and row[y] and {only}:
            name = ", ".join(row[key] for key in apart)
            curves.setdefault(name, []).append((number(row[x]), float(row[y])))

fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
for name, points in curves.items():
    ax.plot(*zip(*sorted(points)), ".-", label=name)
ax.set(xlabel={x_label}, ylabel={y_label})
if len(curves) > 1:
    ax.legend(fontsize=8)
fig.savefig(here / "plot-curves.png", dpi=200)
"#,
        apart = quoted(apart),
    );
    script
}

/// Draws the relative force against length from `curves.csv` of `attenuate`.
pub fn attenuation_snippet() -> String {
    let y = "peak force / that of the homogeneous chain";
    curves(
        "Force against length",
        "curves.csv",
        ["bodies", "bodies before the contact"],
        ["relative_force", y],
        &["chain", "sense", "contact_kind"],
        "True",
    )
}

/// Draws the relative force at the wall against the key from `curves.csv` of `transmit`.
pub fn transmission_snippet(key: &str, others: &[&str]) -> String {
    let y = "peak force at the wall / that of the homogeneous chain";
    curves(
        "Transmitted force",
        "curves.csv",
        [key, &key.replace('_', " ")],
        ["relative_force", y],
        others,
        "row[\"row\"] == \"value\"",
    )
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
    let y = match request.is_si() {
        true => "largest force at the last contact (N)",
        false => "largest force at the last contact",
    };
    let x = [key, &key.replace('_', " ")];
    curves(
        "A sweep",
        "table.csv",
        x,
        ["peak_force_last", y],
        &others,
        "True",
    )
}

/// Draws the ratios against their order from `table.csv` of `localize`.
pub fn localized_snippet() -> String {
    let y = ["ratio", "ratio that carries a localized wave"];
    let what = "Ratios of localized waves";
    curves(what, "table.csv", ["order", "order"], y, &[], "True")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_literals_of_python() {
        assert_eq!(quoted("a \"b\" \\ c\n"), r#""a \"b\" \\ c\n""#);
        let script = transmission_snippet("stiffness_ratio", &["sites"]);
        assert!(script.contains(r#"x, y, apart = "stiffness_ratio", "relative_force", ["sites"]"#));
        let head = head("Spectra", "a\nimport os", "b", "");
        assert!(head.lines().all(|line| line != "import os"), "{head}");
    }
}
