//! Scalings that NI's drivers state beside raw samples.

use crate::Attributes;
use crate::rows::Scaling;

/// What stands for the samples themselves.
const RAW: i64 = 0xffff_ffff;
/// A polynomial of more coefficients is damage.
const MOST_COEFFICIENTS: i64 = 64;
const MOST_SCALES: i64 = 64;

/// The scaling that an object states, its samples as they are where it states none. `scaler` is that of samples of a
/// DAQmx device.
///
/// # Errors
/// The name of a scaling of another kind.
pub(super) fn scaling(
    properties: &Attributes,
    scaler: Option<u32>,
) -> std::result::Result<Option<Scaling>, String> {
    let integer = |name: &str| properties.get(name)?.integer();
    let count = integer("NI_Number_Of_Scales").or_else(|| Some(highest(properties)? + 1));
    let count = count.unwrap_or(0);
    if count <= 0 || properties.text("NI_Scaling_Status") == Some("scaled") {
        return Ok(None);
    }
    if count > MOST_SCALES {
        return Err("endless".into());
    }
    let mut steps = Vec::new();
    let mut scale = count - 1;
    // Each scale takes what another one gives, down to the samples.
    for _ in 0..=count {
        let of = |name: &str| format!("NI_Scale[{scale}]_{name}");
        let number = |name: &str| properties.number(&of(name)).ok_or("incomplete");
        let kind = properties.text(&of("Scale_Type"));
        let is_samples = match (kind, scaler) {
            _ if scale == RAW => scaler.is_none(),
            (None, Some(scaler)) => i64::from(scaler) == scale,
            _ => false,
        };
        if is_samples {
            steps.reverse();
            return Ok(Some(Scaling(steps)));
        }
        match kind.ok_or("incomplete")? {
            "Linear" => steps.push(vec![number("Linear_Y_Intercept")?, number("Linear_Slope")?]),
            "Polynomial" => {
                let size = integer(&of("Polynomial_Coefficients_Size")).unwrap_or(4);
                if !(0..=MOST_COEFFICIENTS).contains(&size) {
                    return Err("endless".into());
                }
                let coefficient = |i| number(&format!("Polynomial_Coefficients[{i}]"));
                let mut all = (0..size).map(coefficient).collect::<Result<Vec<_>, _>>()?;
                // Powers of coefficient 0 add nothing.
                while all.len() > 2 && all.last() == Some(&0.0) {
                    all.pop();
                }
                steps.push(all);
            }
            "AdvancedAPI" => {}
            other => return Err(other.to_owned()),
        }
        let source = of(&format!("{}_Input_Source", kind.unwrap_or_default()));
        scale = integer(&source).unwrap_or(RAW);
    }
    Err("circular".into())
}

/// The highest number of a scale.
fn highest(properties: &Attributes) -> Option<i64> {
    let number = |name: &String| {
        let rest = name.strip_prefix("NI_Scale[")?;
        rest.strip_suffix("]_Scale_Type")?.parse::<u32>().ok()
    };
    properties.0.keys().filter_map(number).max().map(i64::from)
}
