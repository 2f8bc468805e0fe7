//! Which stored numbers are samples and which are gaps, as the CF conventions say it.

use wavecascade_formats::{Format, Sample, Value};

use super::super::Note;
use super::super::meaning::Meaning::{
    self, Fill, Offset, Scale, Unit, ValidMax, ValidMin, ValidRange,
};
use super::super::meaning::is_added;
use super::super::statements::{Statement, Statements, contradiction, unused};
use super::super::storage::{Factor, Packing};
use crate::error::InputFault;

impl Statements {
    /// Single scale and offset of an array that is no field.
    pub(super) fn linear(&self) -> (f64, f64) {
        let one = |meaning: Meaning, otherwise: f64| {
            let is_it = |one: &Statement| meaning == Scale || is_added(&one.name);
            let found = self.lists(meaning).find(|(one, _)| is_it(one));
            found.map_or(otherwise, |(_, numbers)| numbers[0])
        };
        (one(Scale, 1.0), one(Offset, 0.0))
    }

    /// The unit that is stated first.
    pub(super) fn own_unit(&self) -> Option<String> {
        let units = self.texts(Unit);
        units.first().map(|(_, unit)| (*unit).to_owned())
    }

    /// Scale, offset, and which numbers are gaps: those of the attributes of the samples, in stored numbers.
    ///
    /// # Errors
    /// Limits that contradict each other.
    pub(super) fn packing(
        &self,
        sample: Option<Sample>,
        format: Format,
        [scale, offset]: [Factor; 2],
        notes: &mut Vec<Note>,
    ) -> Result<Packing, InputFault> {
        /// What NetCDF fills floats with that were never written.
        const UNWRITTEN: f64 = 9.969_209_968_386_869e36;
        /// Of a stored integer, what a limit is off by rounding.
        const SLACK: f64 = 1e-2;
        // A number stated with more digits than the samples have is one of them, rounded.
        let rounded = |number: f64| match sample {
            Some(Sample::F32) => f64::from(number as f32),
            _ => number,
        };
        let is_float = sample.is_some_and(Sample::is_float);
        let gaps = self.lists(Fill).flat_map(|(_, numbers)| numbers);
        let mut gaps: Vec<f64> = gaps.filter(|gap| !gap.is_nan()).map(rounded).collect();
        // A stated fill value takes the place of the usual one, which NumPy has not.
        let has_usual = !matches!(format, Format::Npy | Format::Npz);
        if is_float && has_usual && self.all.iter().all(|one| one.name != "_FillValue") {
            gaps.push(UNWRITTEN);
        }
        let mut limits: [Option<(f64, String)>; 2] = [None, None];
        for (meaning, ends) in [(ValidRange, 0..2), (ValidMin, 0..1), (ValidMax, 1..2)] {
            for (one, numbers) in self.lists(meaning) {
                // Floats beside packed integers are limits of what those stand for.
                let is_unpacked = !is_float && matches!(one.value, Value::Numbers(_));
                let factors = match is_unpacked {
                    true => scale.only().zip(offset.only()),
                    false => Some((1.0, 0.0)),
                };
                let Some((scale, offset)) = factors.filter(|_| numbers.len() == ends.len()) else {
                    notes.push(unused(&one.shown()));
                    continue;
                };
                for (end, number) in ends.clone().zip(numbers.into_iter().map(rounded)) {
                    let shown = format!("`{}` = {number}", one.name);
                    // The limits of what a negative scale turns round change places. Integers have no fractions.
                    let end = if scale < 0.0 { 1 - end } else { end };
                    let slack = if is_unpacked { SLACK } else { 0.0 };
                    let slack = [-slack, slack][end];
                    let number = (number - offset) / scale + slack;
                    match &limits[end] {
                        Some((other, first)) if *other != number => {
                            let what = "limit of valid samples";
                            return Err(contradiction(what, first.clone(), shown));
                        }
                        _ => limits[end] = Some((number, shown)),
                    }
                }
            }
        }
        let [least, most] = limits.map(|limit| limit.map(|(number, _)| number));
        let valid = match (least, most) {
            (None, None) => None,
            (least, most) => {
                let [none, all] = [f64::NEG_INFINITY, f64::INFINITY];
                Some([least.unwrap_or(none), most.unwrap_or(all)])
            }
        };
        Ok(Packing {
            scale,
            offset,
            gaps,
            valid,
        })
    }
}
