//! Errors of plans and transforms.

use std::fmt;

use crate::InstructionSet;

/// Why a transform was not planned or not performed. Nothing was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FftError {
    /// A length, a number of rows or columns, or a hop is 0.
    Zero {
        /// What is 0.
        what: &'static str,
    },
    /// The slice ends before the last element of the array.
    Slice {
        /// Elements that the array spans.
        needed: usize,
        /// Elements of the slice.
        found: usize,
    },
    /// Two elements of an array to be written share a place.
    Overlap,
    /// The input has other rows and columns than the plan.
    Input {
        /// Rows and columns of the plan.
        expected: (usize, usize),
        /// Rows and columns of the array.
        found: (usize, usize),
    },
    /// The output has other rows and columns than the plan.
    Output {
        /// Rows and columns of the plan.
        expected: (usize, usize),
        /// Rows and columns of the array.
        found: (usize, usize),
    },
    /// The scratch is too short.
    Scratch {
        /// Elements that are needed.
        needed: usize,
        /// Elements of the slice.
        found: usize,
    },
    /// The processor lacks the instructions.
    InstructionSet(InstructionSet),
}

impl fmt::Display for FftError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FftError::Zero { what } => write!(f, "{what} is 0, expected at least 1"),
            FftError::Slice { needed, found } => {
                write!(
                    f,
                    "the array spans {needed} elements, the slice has {found}"
                )
            }
            FftError::Overlap => f.write_str("elements of the output overlap"),
            FftError::Input { expected, found } => {
                let ((rows, columns), (r, c)) = (expected, found);
                write!(f, "expected input of {rows} x {columns}, found {r} x {c}")
            }
            FftError::Output { expected, found } => {
                let ((rows, columns), (r, c)) = (expected, found);
                write!(f, "expected output of {rows} x {columns}, found {r} x {c}")
            }
            FftError::Scratch { needed, found } => {
                write!(f, "expected scratch of at least {needed}, found {found}")
            }
            FftError::InstructionSet(set) => write!(f, "the processor lacks {set:?}"),
        }
    }
}

impl std::error::Error for FftError {}
