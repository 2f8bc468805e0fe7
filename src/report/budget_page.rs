//! Pages of one budget, or of two to compare. They need no network and no scripts.

use base64::Engine;
use maud::{DOCTYPE, Markup, PreEscaped, html as markup};

use crate::Result;
use crate::budget::{Budget, Closure, Curves, Direction, Residual};
use crate::plot::{Figure, Format, SharedScales, budget_figures, encode_all, views};

const STYLE: &str = include_str!("../../assets/page.css");
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// The page of one budget.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn budget_html(name: &str, budget: &Budget, figures: &[Figure]) -> Result<String> {
    let pictures = pictures(figures)?;
    let body = markup! {
        (tables(&[(name, budget)]))
        @for (figure, picture) in figures.iter().zip(&pictures) {
            (shown(figure, picture))
        }
        (words())
    };
    Ok(page(
        name,
        "Where the energy of the chain goes, with the residual of each balance.",
        body,
    ))
}

/// The page of two budgets: the same figures on the same scales, and their differences.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn comparison_html(both: [(&str, &Budget); 2]) -> Result<String> {
    let budgets = both.map(|(_, budget)| budget);
    let shared = SharedScales(&budgets);
    let figures = both.map(|(name, budget)| budget_figures(budget, name, &shared));
    let drawn = [pictures(&figures[0])?, pictures(&figures[1])?];
    let together: Vec<Figure> = views(&both).into_iter().collect();
    let views = pictures(&together)?;
    let title = format!("{} and {}", both[0].0, both[1].0);
    let body = markup! {
        (tables(&both))
        @for (figure, picture) in together.iter().zip(&views) { (shown(figure, picture)) }
        @for (figure, picture) in figures[0].iter().zip(&drawn[0]) {
            @let other = figures[1].iter().zip(&drawn[1]).find(|(other, _)| other.name() == figure.name());
            @if figure.name() != "views" {
                div style="display: grid; grid-template-columns: 1fr 1fr; gap: 1rem" {
                    (shown(figure, picture))
                    @if let Some((figure, picture)) = other { (shown(figure, picture)) }
                }
            }
        }
        (words())
    };
    Ok(page(
        &title,
        "Two chains side by side; pictures of one kind share their colour scale.",
        body,
    ))
}

fn pictures(figures: &[Figure]) -> Result<Vec<String>> {
    let files = encode_all(figures, Format::Png)?;
    let encode = |bytes: Vec<u8>| base64::engine::general_purpose::STANDARD.encode(bytes);
    Ok(files.into_iter().map(encode).collect())
}

fn shown(figure: &Figure, picture: &str) -> Markup {
    let source = format!("data:image/png;base64,{picture}");
    markup! {
        figure style="margin: 1.5rem 0" {
            img src=(source) alt=(figure.title()) style="width: 100%; height: auto";
        }
    }
}

fn page(title: &str, sentence: &str, body: Markup) -> String {
    let page = markup! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="color-scheme" content="light dark";
                title { (title) " – cascade" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { h1 { (title) } p { (sentence) } }
                main { (body) }
            }
        }
    };
    page.into_string()
}

/// Energies and residuals, a column a budget, and the difference of two, or the standard errors of a
/// measured one.
fn tables(budgets: &[(&str, &Budget)]) -> Markup {
    let rows = rows(budgets);
    let measured = budgets.len() == 1 && budgets[0].1.errors.is_some();
    markup! {
        div class="tables" style="columns: 1" {
            table {
                caption { "Energies and balances" }
                thead {
                    tr {
                        th {}
                        @for (name, _) in budgets { th { (name) } }
                        @if budgets.len() == 2 { th { "second less first" } }
                        @if measured { th { "standard error" } }
                    }
                }
                tbody {
                    @for (name, values, error) in &rows {
                        tr {
                            th { (name) }
                            @for value in values { td { (number(*value)) } }
                            @if let [Some(a), Some(b)] = values[..] { td { (number(Some(b - a))) } }
                            @else if values.len() == 2 { td { "–" } }
                            @if measured { td { (number(*error)) } }
                        }
                    }
                }
            }
            @for (name, budget) in budgets {
                @if let Some(sentence) = direction(budget) { p { (name) ": " (sentence) } }
                @for (view, reason) in reasons(&budget.closure) {
                    p { (name) ": no balance over " (view) ", since " (reason) "." }
                }
            }
        }
    }
}

/// Which way energy has passed between low and high k, where that is known.
fn direction(budget: &Budget) -> Option<String> {
    let found = budget.wavenumber.as_ref()?;
    let edge = number(Some(found.edge));
    let share = found.passed_edge()? / budget.scale;
    let share = format!(
        "{} \u{b1} {:.1e}",
        number(Some(share)),
        found.passed_error.value() / budget.scale
    );
    Some(match found.direction()? {
        Direction::None => format!(
            "no energy has passed between the wavenumbers below and above {edge}, net (share {share}, \
             which is numerical error)."
        ),
        Direction::Unresolved => format!(
            "the net share of the energy that has passed k = {edge} is {share}: its direction is \
             not resolved."
        ),
        direction => format!(
            "energy has passed k = {edge} {}, net (share {share}).",
            direction.name()
        ),
    })
}

/// The numbers of two budgets, as a table of text: name, first, second, and second less first.
pub fn comparison_rows(both: [(&str, &Budget); 2]) -> Vec<[String; 4]> {
    let head = [both[0].0, both[1].0].map(str::to_owned);
    let [first, second] = head;
    let mut table = vec![[String::new(), first, second, "second less first".into()]];
    for (name, values, _) in rows(&both) {
        let difference = match values[..] {
            [Some(a), Some(b)] => Some(b - a),
            _ => None,
        };
        table.push([
            name,
            number(values[0]),
            number(values[1]),
            number(difference),
        ]);
    }
    table
}

/// Name, a value a budget, and the standard error of the first.
type Row = (String, Vec<Option<f64>>, Option<f64>);

fn rows(budgets: &[(&str, &Budget)]) -> Vec<Row> {
    let erring = |name: &str, value: &dyn Fn(&Budget) -> Option<f64>, error: Option<f64>| {
        let values = budgets.iter().map(|(_, budget)| value(budget));
        (name.to_owned(), values.collect::<Vec<_>>(), error)
    };
    let row = |name: &str, value: &dyn Fn(&Budget) -> Option<f64>| erring(name, value, None);
    let first = budgets[0].1;
    let error_of = |of: &dyn Fn(&Curves) -> Option<f64>| of(first.errors.as_deref()?);
    let share_error = || {
        first.errors.as_ref()?;
        Some(first.wavenumber.as_ref()?.passed_error.value() / first.scale)
    };
    let last = |values: &[f64]| values.last().copied();
    let energy = |what: &str| first.units.energy(what);
    let mut rows = vec![
        erring(
            &energy("energy at the start"),
            &|b| Some(b.kinetic[0] + b.contact[0]),
            error_of(&|e| e.energy.first().copied()),
        ),
        erring(
            &energy("of motion, at the end"),
            &|b| last(&b.kinetic),
            error_of(&|e| last(&e.kinetic)),
        ),
        erring(
            &energy("of contacts, at the end"),
            &|b| last(&b.contact),
            error_of(&|e| last(&e.contact)),
        ),
        erring(
            &energy("lost"),
            &|b| last(&b.lost),
            error_of(&|e| last(&e.lost)),
        ),
        row(&energy("put in"), &|b| last(&b.input)),
        erring(
            &energy("passed the middle"),
            &|b| b.passed.get(b.n_contacts / 2).copied(),
            error_of(&|e| e.passed.get(first.n_contacts / 2).copied()),
        ),
        erring(
            "share passed from low to high k (net)",
            &|b| {
                let found = b.wavenumber.as_ref()?;
                Some(found.passed_edge()? / b.scale)
            },
            share_error(),
        ),
    ];
    type Of = fn(&Closure) -> &Residual;
    let residuals: [(&str, Of); 4] = [
        ("residual in real space", |c| &c.real_space),
        ("residual over wavenumbers", |c| &c.wavenumber),
        ("residual over frequencies", |c| &c.frequency),
        ("residual over scales", |c| &c.scale),
    ];
    for (name, of) in residuals {
        rows.push(row(name, &|b| of(&b.closure).value()));
    }
    rows.push(row(
        "integrated flux at the largest k, over the energy",
        &|b| Some(b.closure.integrated_flux?.at_largest_wavenumber),
    ));
    rows.push(row("integrated flux made two ways, difference", &|b| {
        Some(b.closure.integrated_flux?.two_ways)
    }));
    rows
}

fn reasons(closure: &Closure) -> Vec<(&'static str, &str)> {
    let all = [
        ("sites", &closure.real_space),
        ("wavenumbers", &closure.wavenumber),
        ("frequencies", &closure.frequency),
        ("scales", &closure.scale),
    ];
    let named = all.into_iter();
    named
        .filter_map(|(view, residual)| Some((view, residual.reason()?)))
        .collect()
}

fn number(value: Option<f64>) -> String {
    match value.filter(|value| value.is_finite()) {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(value) if (1e-3..1e5).contains(&value.abs()) => format!("{value:.6}"),
        Some(value) => format!("{value:.3e}"),
    }
}

fn words() -> Markup {
    markup! {
        details {
            summary { h2 { "How to read this" } }
            p {
                "J(x, t) is the power through each contact, positive towards +x. E(k, t) is the energy "
                "of motion and of contacts at a wavenumber, both signs of k in one; Π(k, t) the power "
                "that passes from below k to above. An impact starts with E(k) flat, so early flux "
                "towards low k is real. P(f) is the power flow through a contact by frequency: it "
                "sums to the energy passed, may be negative in a bin, and is large at f = 0. Π_l(x, t) "
                "is the power that leaves the scales larger than l at a place; near the ends, where "
                "the filter does not fit into the chain, it is not defined (grey). The splits over k "
                "and over l are not the same, since the energy of contacts is not quadratic."
            }
            p {
                "A residual is the largest difference, over all samples, between what an energy "
                "changed by and the integral of its rate, relative to the largest energy of the chain. "
                "Colours about zero end where one cell in two hundred is beyond."
            }
        }
    }
}
