//! Real transforms of NumPy arrays along one axis: columns by `column-fft`, contiguous rows by realfft.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use column_fft::{ColumnFftPlanner, FftError, Real, RealToComplex, RealToComplexColumns, rows};
use ndarray::{
    ArrayView1, ArrayView2, ArrayViewD, ArrayViewMut1, ArrayViewMut2, ArrayViewMutD, Axis,
};
use num_complex::Complex;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
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
        Ok(Arc::clone(match self.kept.entry(len) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => place.insert(Arc::new(Transform {
                columns: self.planner.plan_fft_forward(len)?,
                rows: rows::plan_fft_forward(len),
            })),
        }))
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
    /// Of `(n, columns)`, on one thread or on all of the pool.
    fn columns(
        &self,
        input: ArrayView2<T>,
        output: ArrayViewMut2<Complex<T>>,
        is_parallel: bool,
    ) -> Result<(), FftError> {
        match is_parallel {
            true => self.columns.process_in_parallel(input, output),
            false => self.columns.process(input, output),
        }
    }

    /// Of `(rows, n)`, each row contiguous.
    fn rows(&self, input: ArrayView2<T>, mut output: ArrayViewMut2<Complex<T>>, is_parallel: bool) {
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
    }

    /// Of `(rows, n)`, each row contiguous or not.
    fn of_either(
        &self,
        input: ArrayView2<T>,
        output: ArrayViewMut2<Complex<T>>,
        is_parallel: bool,
    ) -> Result<(), FftError> {
        let is_contiguous = |stride: isize, len: usize| stride == 1 || len <= 1;
        if is_contiguous(input.strides()[1], input.ncols())
            && is_contiguous(output.strides()[1], output.ncols())
        {
            self.rows(input, output, is_parallel);
            return Ok(());
        }
        self.columns(input.reversed_axes(), output.reversed_axes(), is_parallel)
    }

    /// Along the last axis, all but one of the others one by one.
    fn one_by_one(
        &self,
        input: ArrayViewD<T>,
        mut output: ArrayViewMutD<Complex<T>>,
        is_parallel: bool,
    ) -> Result<(), FftError> {
        let two = (
            input.view().into_dimensionality(),
            output.view_mut().into_dimensionality(),
        );
        if let (Ok(input), Ok(output)) = two {
            return self.of_either(input, output, is_parallel);
        }
        let mut pairs = input.outer_iter().zip(output.outer_iter_mut());
        pairs.try_for_each(|(from, to)| self.one_by_one(from, to, is_parallel))
    }

    /// Along `axis` of arrays of equal other axes.
    fn along(
        &self,
        axis: usize,
        input: ArrayViewD<T>,
        mut output: ArrayViewMutD<Complex<T>>,
        is_parallel: bool,
    ) -> Result<(), FftError> {
        let before: usize = input.shape()[..axis].iter().product();
        let after: usize = input.shape()[axis + 1..].iter().product();
        let (n, bins) = (input.shape()[axis], output.shape()[axis]);
        let from = input.view().into_shape_with_order((before, n, after));
        let to = output
            .view_mut()
            .into_shape_with_order((before, bins, after));
        match (from, to) {
            (Ok(from), Ok(to)) if after == 1 => {
                let rows = from.index_axis_move(Axis(2), 0);
                self.of_either(rows, to.index_axis_move(Axis(2), 0), is_parallel)
            }
            (Ok(from), Ok(mut to)) => {
                let mut pairs = from.outer_iter().zip(to.outer_iter_mut());
                pairs.try_for_each(|(from, to)| self.columns(from, to, is_parallel))
            }
            _ => {
                // The axis last, and one of length 1 before all, so that there are two.
                let others = (0..input.ndim()).filter(|&other| other != axis);
                let order: Vec<usize> = others.chain([axis]).collect();
                let input = input.permuted_axes(order.clone()).insert_axis(Axis(0));
                let output = output.permuted_axes(order).insert_axis(Axis(0));
                self.one_by_one(input, output, is_parallel)
            }
        }
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
    input: &Bound<'py, PyArrayDyn<T>>,
    axis: usize,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>>
where
    Complex<T>: Element,
{
    let py = input.py();
    let mut shape = input.shape().to_vec();
    let length = shape[axis];
    // The lock of all plans is let go of: work waits for none, and holds none.
    let transform = T::plans().transform(length).map_err(told)?;
    shape[axis] = length / 2 + 1;
    // SAFETY: every element is written below, or none exists.
    let output = unsafe { PyArrayDyn::<Complex<T>>::new(py, shape, false) };
    {
        // SAFETY: the new array has no other owner; the input is only read, as by any function that releases
        // the lock.
        let (from, to) = unsafe { (input.as_array(), output.as_array_mut()) };
        let work = |is_parallel| transform.along(axis, from, to, is_parallel);
        let done = py.detach(|| with_workers(workers, work));
        done.map_err(told)?.map_err(told)?;
    }
    Ok(output.into_any())
}

fn told(error: impl std::error::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Real numbers to their spectra along `axis`: `n / 2 + 1` bins. No axis has length 0.
#[pyfunction]
#[pyo3(signature = (a, axis, workers))]
pub fn rfft<'py>(
    a: &Bound<'py, PyUntypedArray>,
    axis: usize,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>> {
    if axis >= a.ndim() || a.shape().contains(&0) {
        let text = format!("axis: expected one of an array with samples, found {axis}");
        return Err(PyValueError::new_err(text));
    }
    match a.cast::<PyArrayDyn<f64>>() {
        Ok(a) => transformed(a, axis, workers),
        Err(_) => transformed::<f32>(a.cast()?, axis, workers),
    }
}
