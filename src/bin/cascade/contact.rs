//! `cascade contact`: crossed cylinders.

use std::io::Write;

use serde::Serialize;
use wavecascade::Error;
use wavecascade::chain::contact::{
    Ellipse, HertzContact, Material, angle_of_stiffness_ratio, stiffness_ratio,
};

use crate::chain_args::{Body, Contact};
use crate::failure::Failure;
use crate::scene::{digits, name_of};
use crate::terminal::{self, HEADING, Lines, number, styled};

/// A contact by one form of its ellipse.
#[derive(Debug, Serialize)]
struct Form {
    ellipse: Ellipse,
    /// In degrees.
    angle: f64,
    /// Over that at 90 degrees.
    stiffness_ratio: f64,
    /// Minor over major semi-axis of the ellipse.
    aspect: f64,
    /// In N/m^1.5, where material and radius are known.
    coefficient: Option<f64>,
    coefficient_at_90: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Answer {
    schema: &'static str,
    forms: [Form; 2],
}

/// Runs the command.
pub fn run(typed: Contact) -> Result<(), Failure> {
    let body = match typed.body.material()? {
        Some(material) => typed.body.radius.map(|radius| (radius, material)),
        None => None,
    };
    let answer = Answer {
        schema: "cascade.contact/1",
        forms: [
            form(&typed, body, Ellipse::Approximate)?,
            form(&typed, body, Ellipse::Exact)?,
        ],
    };
    let mut out = terminal::stdout();
    if typed.json {
        let text = serde_json::to_string_pretty(&answer).map_err(std::io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    Ok(out.write_all(lines(&answer, terminal::width()).as_bytes())?)
}

fn form(typed: &Contact, body: Option<(f64, Material)>, ellipse: Ellipse) -> Result<Form, Error> {
    let angle = match (typed.angle, typed.stiffness_ratio) {
        (None, Some(ratio)) => angle_of_stiffness_ratio(ratio, ellipse)?,
        (angle, _) => angle.unwrap_or(90.0),
    };
    let ratio = stiffness_ratio(angle, ellipse)?;
    // The ellipse depends on the angle alone.
    let (radius, material) = body.unwrap_or((1.0, Material::QUARTZ));
    let crossed = |angle: f64| {
        let contact = HertzContact::crossed_cylinders(radius, material, angle, ellipse);
        contact.map_err(|error| typed_of(error, radius, angle))
    };
    let (right, contact) = (crossed(90.0)?, crossed(angle)?);
    Ok(Form {
        ellipse,
        angle,
        stiffness_ratio: ratio,
        aspect: contact.aspect,
        coefficient: body.map(|_| contact.coefficient),
        coefficient_at_90: body.map(|_| right.coefficient),
    })
}

/// Reports a fault of the curvatures as one of the typed radius and angle.
fn typed_of(error: Error, radius: f64, angle: f64) -> Error {
    match error {
        Error::Request {
            option: "curvature",
            expected,
            ..
        } if angle == 90.0 => Error::Request {
            option: "radius",
            expected,
            found: format!("a radius of {radius:e} m"),
        },
        Error::Request {
            option: "curvature",
            expected,
            ..
        } => Error::Request {
            option: "angle",
            expected,
            found: format!("{angle:e} degrees"),
        },
        error => error,
    }
}

impl Body {
    /// The material that was named or given by its constants.
    pub fn material(&self) -> Result<Option<Material>, Error> {
        if let (Some(young), Some(poisson)) = (self.young, self.poisson) {
            return Ok(Some(Material {
                young,
                poisson,
                // No contact depends on it.
                density: 1.0,
            }));
        }
        let Some(name) = &self.material else {
            return Ok(None);
        };
        let known = Material::named(name).ok_or_else(|| Error::Request {
            option: "material",
            expected: "quartz, steel or ptfe".into(),
            found: name.clone(),
        });
        known.map(Some)
    }
}

fn lines(answer: &Answer, width: usize) -> String {
    let mut lines = Lines::new(width);
    let [approximate, exact] = &answer.forms;
    let said = format!(
        "cylinders at {} degrees: a contact {} times as stiff as at 90 degrees ({} exactly)",
        number(approximate.angle),
        digits(approximate.stiffness_ratio),
        number(exact.stiffness_ratio)
    );
    let said = terminal::wrapped(&said, width - 2);
    let said = said.iter().map(|line| styled(HEADING, line));
    lines.text = said.collect::<Vec<_>>().join("\n  ") + "\n";
    for form in &answer.forms {
        let about = match form.ellipse {
            Ellipse::Approximate => "b/a = (A/B)^(2/3), the published form",
            Ellipse::Exact => "b/a from the transcendental equation",
        };
        lines.line("ellipse", &format!("{}: {about}", name_of(&form.ellipse)));
        lines.line("  angle", &format!("{} degrees", digits(form.angle)));
        lines.line(
            "  stiffness ratio",
            &format!("{} against 90 degrees", digits(form.stiffness_ratio)),
        );
        lines.line("  b/a", &digits(form.aspect));
        if let (Some(beta), Some(right)) = (form.coefficient, form.coefficient_at_90) {
            let text = format!("{beta:.6e} N/m^1.5, {right:.6e} at 90 degrees");
            lines.line("  beta", &text);
        }
    }
    lines.text
}
