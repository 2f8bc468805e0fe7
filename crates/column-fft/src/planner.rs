//! Plans that share their tables.

use std::collections::HashMap;
use std::sync::Arc;

use rustfft::{Fft, FftDirection};

use crate::{
    ComplexToComplexColumns, ComplexToReal2d, ComplexToRealColumns, FftError, InstructionSet, Real,
    RealToComplex2d, RealToComplexColumns, ShortTimeColumns, rows,
};

/// Makes plans and keeps them: another plan of the same length is the same one, and plans there and back share their
/// tables.
pub struct ColumnFftPlanner<T: Real> {
    set: InstructionSet,
    forward: HashMap<usize, Arc<RealToComplexColumns<T>>>,
    inverse: HashMap<usize, Arc<ComplexToRealColumns<T>>>,
    /// By length, forward or not.
    rows: HashMap<(usize, bool), Arc<dyn Fft<T>>>,
}

impl<T: Real> ColumnFftPlanner<T> {
    /// For this processor.
    pub fn new() -> Self {
        ColumnFftPlanner {
            set: InstructionSet::best(),
            forward: HashMap::new(),
            inverse: HashMap::new(),
            rows: HashMap::new(),
        }
    }

    /// For chosen instructions along columns.
    ///
    /// # Errors
    /// [`FftError::InstructionSet`] where the processor lacks them.
    pub fn with_instruction_set(set: InstructionSet) -> Result<Self, FftError> {
        match set.is_available() {
            true => Ok(ColumnFftPlanner { set, ..Self::new() }),
            false => Err(FftError::InstructionSet(set)),
        }
    }

    /// Real columns of `len` samples to their spectra.
    ///
    /// # Errors
    /// [`FftError::Zero`] for length 0.
    pub fn plan_fft_forward(
        &mut self,
        len: usize,
    ) -> Result<Arc<RealToComplexColumns<T>>, FftError> {
        if let Some(plan) = self.forward.get(&len) {
            return Ok(Arc::clone(plan));
        }
        let plan = Arc::new(RealToComplexColumns::with_instruction_set(len, self.set)?);
        self.forward.insert(len, Arc::clone(&plan));
        Ok(plan)
    }

    /// Spectra to real columns of `len` samples, unnormalised.
    ///
    /// # Errors
    /// As [`ColumnFftPlanner::plan_fft_forward`].
    pub fn plan_fft_inverse(
        &mut self,
        len: usize,
    ) -> Result<Arc<ComplexToRealColumns<T>>, FftError> {
        if let Some(plan) = self.inverse.get(&len) {
            return Ok(Arc::clone(plan));
        }
        let plan = Arc::new(ComplexToRealColumns::of(self.plan_fft_forward(len)?));
        self.inverse.insert(len, Arc::clone(&plan));
        Ok(plan)
    }

    /// Complex columns of `len` samples to their spectra, or back, unnormalised.
    ///
    /// # Errors
    /// As [`ColumnFftPlanner::plan_fft_forward`].
    pub fn plan_fft_complex(
        &mut self,
        len: usize,
        direction: FftDirection,
    ) -> Result<Arc<ComplexToComplexColumns<T>>, FftError> {
        let plan = self.plan_fft_forward(len)?;
        Ok(Arc::new(ComplexToComplexColumns::of(plan, direction)))
    }

    /// Both axes of real arrays of `(rows, columns)`, with kernels `exp(-i ..)` along both.
    ///
    /// # Errors
    /// [`FftError::Zero`] without rows or columns.
    pub fn plan_fft_2d_forward(
        &mut self,
        shape: (usize, usize),
    ) -> Result<Arc<RealToComplex2d<T>>, FftError> {
        let columns = self.plan_fft_forward(shape.0)?;
        let rows = self.plan_rows(shape.1, FftDirection::Forward)?;
        Ok(Arc::new(RealToComplex2d::of(columns, rows)))
    }

    /// Spectra to real arrays of `(rows, columns)`, with kernels `exp(+i ..)` along both axes, unnormalised.
    ///
    /// # Errors
    /// As [`ColumnFftPlanner::plan_fft_2d_forward`].
    pub fn plan_fft_2d_inverse(
        &mut self,
        shape: (usize, usize),
    ) -> Result<Arc<ComplexToReal2d<T>>, FftError> {
        let columns = ComplexToRealColumns::of(self.plan_fft_forward(shape.0)?);
        let rows = self.plan_rows(shape.1, FftDirection::Inverse)?;
        Ok(Arc::new(ComplexToReal2d::of(columns, rows)))
    }

    /// Segments of `window.len()` samples, `hop` samples apart, of real columns.
    ///
    /// # Errors
    /// [`FftError::Zero`] for a window without samples or hop 0.
    pub fn plan_short_time(
        &mut self,
        window: &[f64],
        hop: usize,
    ) -> Result<Arc<ShortTimeColumns<T>>, FftError> {
        let plan = self.plan_fft_forward(window.len())?;
        Ok(Arc::new(ShortTimeColumns::of(plan, window, hop)?))
    }

    fn plan_rows(
        &mut self,
        columns: usize,
        along: FftDirection,
    ) -> Result<Arc<dyn Fft<T>>, FftError> {
        if columns == 0 {
            return Err(FftError::Zero {
                what: "the number of columns",
            });
        }
        let plan = self.rows.entry((columns, along == FftDirection::Forward));
        let plan = plan.or_insert_with(|| rows::plan_fft_complex(columns, along));
        Ok(Arc::clone(plan))
    }
}

impl<T: Real> Default for ColumnFftPlanner<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> std::fmt::Debug for ColumnFftPlanner<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ColumnFftPlanner")
            .field("instruction_set", &self.set)
            .field("lengths", &self.forward.keys())
            .finish_non_exhaustive()
    }
}
