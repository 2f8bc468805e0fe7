//! Scalings that NI's drivers state beside raw samples.

use super::property::Properties;

/// What stands for the samples themselves.
const RAW: i64 = 0xffff_ffff;
/// A polynomial of more coefficients is damage.
const MOST_COEFFICIENTS: i64 = 64;
const MOST_SCALES: i64 = 64;

/// From stored to scaled numbers, one polynomial after another.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Scaling {
    /// Coefficients, that of power 0 first.
    steps: Vec<Vec<f64>>,
}

/// A scaling of another kind, by its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Foreign(pub String);

impl Scaling {
    /// The scaling that the channel, else its group, else the file states. `scaler` is that of samples of a
    /// DAQmx device.
    pub(super) fn of(
        places: &[&Properties],
        scaler: Option<u32>,
    ) -> std::result::Result<Option<Scaling>, Foreign> {
        for properties in places {
            if let Some(scaling) = Scaling::stated(properties, scaler)? {
                return Ok(Some(scaling));
            }
        }
        Ok(None)
    }

    fn stated(
        properties: &Properties,
        scaler: Option<u32>,
    ) -> std::result::Result<Option<Scaling>, Foreign> {
        let count = properties
            .integer("NI_Number_Of_Scales")
            .or_else(|| highest(properties).map(|highest| highest + 1))
            .unwrap_or(0);
        if count <= 0 || properties.text("NI_Scaling_Status") == Some("scaled") {
            return Ok(None);
        }
        let unknown = |what: &str| Foreign(what.to_owned());
        if count > MOST_SCALES {
            return Err(unknown("endless"));
        }
        let mut steps = Vec::new();
        let mut scale = count - 1;
        // Each scale takes what another one gives, down to the samples.
        for _ in 0..=count {
            if scale == RAW && scaler.is_none() {
                steps.reverse();
                return Ok(Some(Scaling { steps }));
            }
            let of = |name: &str| format!("NI_Scale[{scale}]_{name}");
            let source = |kind: &str| {
                let name = of(&format!("{kind}_Input_Source"));
                properties.integer(&name).unwrap_or(RAW)
            };
            let number = |name: &str| {
                let missing = || Foreign("incomplete".to_owned());
                properties.number(&of(name)).ok_or_else(missing)
            };
            match properties.text(&of("Scale_Type")) {
                None if scaler.is_some_and(|scaler| i64::from(scaler) == scale) => {
                    steps.reverse();
                    return Ok(Some(Scaling { steps }));
                }
                None => return Err(unknown("incomplete")),
                Some("Linear") => {
                    steps.push(vec![number("Linear_Y_Intercept")?, number("Linear_Slope")?]);
                    scale = source("Linear");
                }
                Some("Polynomial") => {
                    let size = properties.integer(&of("Polynomial_Coefficients_Size"));
                    let size = size.unwrap_or(4);
                    if !(0..=MOST_COEFFICIENTS).contains(&size) {
                        return Err(unknown("endless"));
                    }
                    let coefficient = |i| number(&format!("Polynomial_Coefficients[{i}]"));
                    let mut all = (0..size).map(coefficient).collect::<Result<Vec<_>, _>>()?;
                    // Powers of coefficient 0 add nothing.
                    while all.len() > 2 && all.last() == Some(&0.0) {
                        all.pop();
                    }
                    steps.push(all);
                    scale = source("Polynomial");
                }
                Some("AdvancedAPI") => scale = source("AdvancedAPI"),
                Some(other) => return Err(unknown(other)),
            }
        }
        Err(unknown("circular"))
    }

    /// Slope and intercept, if it has no more.
    pub(super) fn linear(&self) -> Option<[f64; 2]> {
        match &self.steps[..] {
            [] => Some([1.0, 0.0]),
            [step] => match step[..] {
                [intercept, slope] => Some([slope, intercept]),
                _ => None,
            },
            _ => None,
        }
    }

    pub(super) fn apply(&self, sample: f64) -> f64 {
        let polynomial = |x: f64, coefficients: &Vec<f64>| {
            let mut coefficients = coefficients.iter().rev();
            let highest = coefficients.next().copied().unwrap_or(0.0);
            coefficients.fold(highest, |sum, coefficient| sum * x + coefficient)
        };
        self.steps.iter().fold(sample, polynomial)
    }
}

/// The highest number of a scale.
fn highest(properties: &Properties) -> Option<i64> {
    let number = |name: &str| {
        let rest = name.strip_prefix("NI_Scale[")?;
        rest.strip_suffix("]_Scale_Type")?.parse::<u32>().ok()
    };
    let numbers = properties.list.iter().filter_map(|(name, _)| number(name));
    numbers.max().map(i64::from)
}
