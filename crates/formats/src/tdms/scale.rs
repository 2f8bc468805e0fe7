//! Scalings that NI's drivers state beside raw samples.

use super::property::{Properties, integer_of, number_of, text_of};
use crate::rows::Scaling;

/// What stands for the samples themselves.
const RAW: i64 = 0xffff_ffff;
/// A polynomial of more coefficients is damage.
const MOST_COEFFICIENTS: i64 = 64;
const MOST_SCALES: i64 = 64;

/// The scaling that the channel, else its group, else the file states. `scaler` is that of samples of a DAQmx
/// device.
///
/// # Errors
/// The name of a scaling of another kind.
pub(super) fn scaling(
    places: &[&Properties],
    scaler: Option<u32>,
) -> std::result::Result<Option<Scaling>, String> {
    for properties in places {
        if let Some(scaling) = stated(properties, scaler)? {
            return Ok(Some(scaling));
        }
    }
    Ok(None)
}

fn stated(
    properties: &Properties,
    scaler: Option<u32>,
) -> std::result::Result<Option<Scaling>, String> {
    let count = integer_of(properties, "NI_Number_Of_Scales")
        .or_else(|| highest(properties).map(|highest| highest + 1))
        .unwrap_or(0);
    if count <= 0 || text_of(properties, "NI_Scaling_Status") == Some("scaled") {
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
        let number = |name: &str| number_of(properties, &of(name)).ok_or("incomplete");
        let kind = text_of(properties, &of("Scale_Type"));
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
            "Linear" => {
                steps.push(vec![number("Linear_Y_Intercept")?, number("Linear_Slope")?]);
            }
            "Polynomial" => {
                let size = integer_of(properties, &of("Polynomial_Coefficients_Size"));
                let size = size.unwrap_or(4);
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
        scale = integer_of(properties, &source).unwrap_or(RAW);
    }
    Err("circular".into())
}

/// The highest number of a scale.
fn highest(properties: &Properties) -> Option<i64> {
    let number = |name: &String| {
        let rest = name.strip_prefix("NI_Scale[")?;
        rest.strip_suffix("]_Scale_Type")?.parse::<u32>().ok()
    };
    properties.keys().filter_map(number).max().map(i64::from)
}
