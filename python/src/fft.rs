//! Real transforms of contiguous NumPy arrays along one axis: columns by `column-fft`, rows by realfft.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use column_fft::{ColumnFftPlanner, FftError, Real, RealToComplex, RealToComplexColumns, rows};
use ndarray::{ArrayView1, ArrayView3, ArrayViewMut1, ArrayViewMut3, Axis, Dimension};
use num_complex::Complex;
use numpy::{Element, PyArray3, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Transforms that are kept; with more, all are made anew.
const KEPT: usize = 128;

/// A transform of one length, of columns and of contiguous rows.
struct Transform<T: Real> {
    columns: Arc<RealToComplexColumns<T>>,
    rows: Arc<dyn RealToComplex<T>>,
}

/// Transforms of one number type, by their lengths.
struct Plans<T: Real> {
    planner: ColumnFftPlanner<T>,
    kept: HashMap<usize, Arc<Transform<T>>>,
}

impl<T: Real> Plans<T> {
    fn new() -> Self {
        Plans {
            planner: ColumnFftPlanner::new(),
            kept: HashMap::new(),
        }
    }

    fn transform(&mut self, len: usize) -> Result<Arc<Transform<T>>, FftError> {
        if self.kept.len() >= KEPT {
            *self = Plans::new();
        }
        if let Some(kept) = self.kept.get(&len) {
            return Ok(Arc::clone(kept));
        }
        let made = Arc::new(Transform {
            columns: self.planner.plan_fft_forward(len)?,
            rows: rows::plan_fft_forward(len),
        });
        self.kept.insert(len, Arc::clone(&made));
        Ok(made)
    }
}

/// Numbers with plans of their own.
trait Planned: Real + Element {
    fn plans() -> MutexGuard<'static, Plans<Self>>;
}

impl Planned for f32 {
    fn plans() -> MutexGuard<'static, Plans<f32>> {
        static PLANS: LazyLock<Mutex<Plans<f32>>> = LazyLock::new(|| Mutex::new(Plans::new()));
        PLANS.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Planned for f64 {
    fn plans() -> MutexGuard<'static, Plans<f64>> {
        static PLANS: LazyLock<Mutex<Plans<f64>>> = LazyLock::new(|| Mutex::new(Plans::new()));
        PLANS.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T: Planned> Transform<T> {
    /// Along the middle axis, on one thread or on all of the pool.
    fn along(
        &self,
        input: ArrayView3<T>,
        mut output: ArrayViewMut3<Complex<T>>,
        is_parallel: bool,
    ) -> Result<(), FftError> {
        if input.len_of(Axis(2)) > 1 {
            let mut pairs = input.outer_iter().zip(output.outer_iter_mut());
            return pairs.try_for_each(|(from, to)| match is_parallel {
                true => self.columns.process_in_parallel(from, to),
                false => self.columns.process(from, to),
            });
        }
        let (input, mut output) = (
            input.remove_axis(Axis(2)),
            output.index_axis_mut(Axis(2), 0),
        );
        let scratch = || (self.rows.make_input_vec(), self.rows.make_scratch_vec());
        let one =
            |(row, scratch): &mut (Vec<T>, Vec<Complex<T>>),
             (input, mut output): (ArrayView1<T>, ArrayViewMut1<Complex<T>>)| {
                if let (Some(input), Some(output)) = (input.as_slice(), output.as_slice_mut()) {
                    row.copy_from_slice(input);
                    let done = self.rows.process_with_scratch(row, output, scratch);
                    debug_assert!(done.is_ok());
                }
            };
        if is_parallel {
            let input = input.axis_iter(Axis(0)).into_par_iter();
            let pairs = input.zip(output.axis_iter_mut(Axis(0)).into_par_iter());
            pairs.for_each_init(scratch, one);
        } else {
            let mut scratch = scratch();
            let pairs = input.outer_iter().zip(output.outer_iter_mut());
            pairs.for_each(|pair| one(&mut scratch, pair));
        }
        Ok(())
    }
}

/// Runs `work` with as many threads; 0 stands for all.
fn with_workers<R: Send>(
    workers: usize,
    work: impl FnOnce(bool) -> R + Send,
) -> Result<R, rayon::ThreadPoolBuildError> {
    static POOLS: Mutex<Option<(usize, Arc<rayon::ThreadPool>)>> = Mutex::new(None);
    match workers {
        1 => return Ok(work(false)),
        0 => return Ok(rayon::scope(|_| work(true))),
        _ => {}
    }
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = pools.as_ref().filter(|(threads, _)| *threads == workers);
    let pool = match known {
        Some((_, pool)) => Arc::clone(pool),
        None => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(workers);
            let pool = Arc::new(pool.build()?);
            *pools = Some((workers, Arc::clone(&pool)));
            pool
        }
    };
    drop(pools);
    Ok(pool.install(|| work(true)))
}

fn transformed<'py, T: Planned>(
    input: &Bound<'py, PyArray3<T>>,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>>
where
    Complex<T>: Element,
{
    let (before, length, after) = input.dims().into_pattern();
    // The lock of all plans is let go of: work waits for none, and holds none.
    let transform = T::plans().transform(length).map_err(told)?;
    let shape = (before, length / 2 + 1, after);
    // SAFETY: every element is written below, or none exists.
    let output = unsafe { PyArray3::<Complex<T>>::new(input.py(), shape, false) };
    {
        // SAFETY: the new array has no other owner; the input is only read, as by any function that releases
        // the lock.
        let (from, to) = unsafe { (input.as_array(), output.as_array_mut()) };
        let work = |is_parallel| transform.along(from, to, is_parallel);
        let done = input.py().detach(|| with_workers(workers, work));
        done.map_err(told)?.map_err(told)?;
    }
    Ok(output.into_any())
}

fn told(error: impl std::error::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Real numbers `(before, n, after)`, contiguous, to their spectra: `n / 2 + 1` bins along the middle axis. None has
/// length 0.
#[pyfunction]
pub fn rfft<'py>(a: &Bound<'py, PyUntypedArray>, workers: usize) -> PyResult<Bound<'py, PyAny>> {
    if a.shape().contains(&0) {
        return Err(PyValueError::new_err("a: expected samples, found none"));
    }
    match a.cast::<PyArray3<f64>>() {
        Ok(a) => transformed(a, workers),
        Err(_) => transformed::<f32>(a.cast()?, workers),
    }
}
