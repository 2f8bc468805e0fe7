//! Workloads whose instructions are counted by an external tool (valgrind).

use std::fmt;
use std::str::FromStr;

use crate::Precision;
use crate::machine::set_name;
use crate::{ArrayShape, Arrays, Implementation, PlannedTransform};
use crate::{Error, Result};
use column_fft::{InstructionSet, Real};

/// The implementation that transforms the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// [`column_fft::RealToComplexColumns`] by an instruction set.
    Cascade(InstructionSet),
    /// [`Implementation::Rustfft`].
    Rustfft,
}

/// A counted workload: the array and the implementation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CountedCase {
    pub shape: ArrayShape,
    pub precision: Precision,
    pub by: Counted,
}

impl CountedCase {
    /// Small arrays of every kind of length: `2^10`, that of short-time segments (with columns left
    /// over after whole tiles), `3^3 5 7`, and a prime.
    pub const SHORT: [ArrayShape; 4] = [
        ArrayShape {
            rows: 1024,
            columns: 16,
        },
        ArrayShape {
            rows: 256,
            columns: 37,
        },
        ArrayShape {
            rows: 945,
            columns: 16,
        },
        ArrayShape {
            rows: 1009,
            columns: 16,
        },
    ];

    /// The case, and bytes of its array and spectrum.
    pub fn memory(&self) -> (CountedCase, u64) {
        (*self, self.shape.bytes(self.precision) as u64)
    }

    /// Transforms the columns `times` times on the calling thread.
    ///
    /// # Errors
    /// [`Error::InstructionSet`] where the processor lacks the instructions, [`Error::Memory`] without memory.
    pub fn repeat(&self, times: usize) -> Result<()> {
        match self.precision {
            Precision::F64 => self.repeat_of::<f64>(times),
            Precision::F32 => self.repeat_of::<f32>(times),
        }
    }

    fn repeat_of<T: Real>(&self, times: usize) -> Result<()> {
        let (arrays, way) = match self.by {
            Counted::Rustfft => (Some(Arrays::<T>::new(self.shape)?), Implementation::Rustfft),
            Counted::Cascade(set) => (Arrays::with(self.shape, set)?, Implementation::Cascade),
        };
        let mut arrays = arrays.ok_or_else(|| Error::InstructionSet(self.by.to_string()))?;
        for _ in 0..times {
            arrays.run(way, false);
        }
        Ok(())
    }
}

impl Counted {
    /// The implementations that can be counted on this machine; valgrind does not support AVX-512.
    pub fn all() -> Vec<Counted> {
        let sets = InstructionSet::available().into_iter();
        let sets = sets.filter(|set| *set != InstructionSet::Avx512);
        sets.map(Counted::Cascade)
            .chain([Counted::Rustfft])
            .collect()
    }
}

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Counted::Cascade(set) => f.write_str(&set_name(*set)),
            Counted::Rustfft => f.write_str("rustfft"),
        }
    }
}

impl FromStr for Counted {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Counted, String> {
        let mut all = Counted::all().into_iter();
        let found = all.find(|counted| counted.to_string() == text);
        found.ok_or_else(|| "expected rustfft or an instruction set that this processor has".into())
    }
}

impl fmt::Display for CountedCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let precision = crate::case::name(self.precision);
        write!(f, "{} {precision} {}", self.shape, self.by)
    }
}
