//! Transforms of NumPy arrays along one axis: columns by `column-fft`, contiguous rows by realfft and RustFFT.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use column_fft::{
    ColumnFftPlanner, ComplexToRealColumns, FftDirection, FftError, Real, RealToComplexColumns,
    rows,
};
use ndarray::{ArrayView2, ArrayViewD, ArrayViewMut2, ArrayViewMutD, Axis};
use num_complex::Complex;
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Plans that are kept; with more, all are made anew.
const KEPT: usize = 128;

/// Plans of one number type.
struct Plans<T: Real> {
    planner: ColumnFftPlanner<T>,
    inverse: HashMap<usize, Arc<ComplexToRealColumns<T>>>,
    forward_rows: HashMap<usize, Arc<dyn column_fft::RealToComplex<T>>>,
    inverse_rows: HashMap<usize, Arc<dyn column_fft::ComplexToReal<T>>>,
    complex: HashMap<(usize, bool), Arc<column_fft::ComplexToComplexColumns<T>>>,
    complex_rows: HashMap<(usize, bool), Arc<dyn column_fft::Fft<T>>>,
    made: usize,
}

impl<T: Real> Plans<T> {
    fn new() -> Self {
        Plans {
            planner: ColumnFftPlanner::new(),
            inverse: HashMap::new(),
            forward_rows: HashMap::new(),
            inverse_rows: HashMap::new(),
            complex: HashMap::new(),
            complex_rows: HashMap::new(),
            made: 0,
        }
    }

    /// Counts a plan that is about to be made.
    fn room(&mut self) {
        if self.made >= KEPT {
            *self = Plans::new();
        }
        self.made += 1;
    }

    fn forward(&mut self, len: usize) -> Result<Arc<RealToComplexColumns<T>>, FftError> {
        if self.made >= KEPT {
            self.room();
        }
        self.planner.plan_fft_forward(len)
    }

    fn inverse(&mut self, len: usize) -> Result<Arc<ComplexToRealColumns<T>>, FftError> {
        if let Some(plan) = self.inverse.get(&len) {
            return Ok(Arc::clone(plan));
        }
        self.room();
        let plan = ComplexToRealColumns::of(self.planner.plan_fft_forward(len)?).normalized();
        let plan = Arc::new(plan);
        self.inverse.insert(len, Arc::clone(&plan));
        Ok(plan)
    }

    fn complex(
        &mut self,
        len: usize,
        is_forward: bool,
    ) -> Result<Arc<column_fft::ComplexToComplexColumns<T>>, FftError> {
        if let Some(plan) = self.complex.get(&(len, is_forward)) {
            return Ok(Arc::clone(plan));
        }
        self.room();
        let plan = self.planner.plan_fft_complex(len, direction(is_forward))?;
        self.complex.insert((len, is_forward), Arc::clone(&plan));
        Ok(plan)
    }

    fn forward_rows(&mut self, len: usize) -> Arc<dyn column_fft::RealToComplex<T>> {
        if !self.forward_rows.contains_key(&len) {
            self.room();
        }
        let plan = self.forward_rows.entry(len);
        Arc::clone(plan.or_insert_with(|| rows::plan_fft_forward(len)))
    }

    fn inverse_rows(&mut self, len: usize) -> Arc<dyn column_fft::ComplexToReal<T>> {
        if !self.inverse_rows.contains_key(&len) {
            self.room();
        }
        let plan = self.inverse_rows.entry(len);
        Arc::clone(plan.or_insert_with(|| rows::plan_fft_inverse(len)))
    }

    fn complex_rows(&mut self, len: usize, is_forward: bool) -> Arc<dyn column_fft::Fft<T>> {
        if !self.complex_rows.contains_key(&(len, is_forward)) {
            self.room();
        }
        let plan = self.complex_rows.entry((len, is_forward));
        Arc::clone(plan.or_insert_with(|| rows::plan_fft_complex(len, direction(is_forward))))
    }
}

fn direction(is_forward: bool) -> FftDirection {
    match is_forward {
        true => FftDirection::Forward,
        false => FftDirection::Inverse,
    }
}

/// Numbers with plans of their own.
trait Planned: Real + Element {
    fn plans() -> MutexGuard<'static, Plans<Self>>;
}

macro_rules! planned {
    ($real:ty) => {
        impl Planned for $real {
            fn plans() -> MutexGuard<'static, Plans<$real>> {
                static PLANS: LazyLock<Mutex<Plans<$real>>> =
                    LazyLock::new(|| Mutex::new(Plans::new()));
                PLANS.lock().unwrap_or_else(PoisonError::into_inner)
            }
        }
    };
}
planned!(f32);
planned!(f64);

/// By what a result is multiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    One,
    /// 1 / N.
    Mean,
    /// 1 / sqrt(N).
    Root,
}

impl Scale {
    fn of(norm: u8) -> Scale {
        match norm {
            0 => Scale::One,
            1 => Scale::Mean,
            _ => Scale::Root,
        }
    }

    fn factor(self, len: usize) -> f64 {
        match self {
            Scale::One => 1.0,
            Scale::Mean => 1.0 / len as f64,
            Scale::Root => 1.0 / (len as f64).sqrt(),
        }
    }
}

/// A transform along the first axis of `(n, columns)`, or of rows where both arrays have them contiguous.
trait Transform<A, B>: Sync {
    fn columns(&self, input: ArrayView2<A>, output: ArrayViewMut2<B>, is_parallel: bool);
    /// `(rows, n)`, each row contiguous.
    fn rows(&self, input: ArrayView2<A>, output: ArrayViewMut2<B>, is_parallel: bool);
}

/// Runs `transform` along `axis` of arrays of equal other axes.
fn along<A, B>(
    transform: &dyn Transform<A, B>,
    input: ArrayViewD<A>,
    mut output: ArrayViewMutD<B>,
    axis: usize,
    is_parallel: bool,
) {
    let before: usize = input.shape()[..axis].iter().product();
    let after: usize = input.shape()[axis + 1..].iter().product();
    let (n, m) = (input.shape()[axis], output.shape()[axis]);
    if before * after == 0 {
        return;
    }
    let cubes = input
        .view()
        .into_shape_with_order((before, n, after))
        .ok()
        .zip(
            output
                .view_mut()
                .into_shape_with_order((before, m, after))
                .ok(),
        );
    match cubes {
        Some((input, output)) if after == 1 => {
            let (input, output) = (
                input.index_axis_move(Axis(2), 0),
                output.index_axis_move(Axis(2), 0),
            );
            match is_contiguous(&input) {
                true => transform.rows(input, output, is_parallel),
                false => {
                    transform.columns(input.reversed_axes(), output.reversed_axes(), is_parallel)
                }
            }
        }
        Some((input, mut output)) => {
            for (input, output) in input.outer_iter().zip(output.outer_iter_mut()) {
                transform.columns(input, output, is_parallel);
            }
        }
        None => {
            // The axis first, then all but one of the others one by one.
            let ndim = input.ndim();
            let order: Vec<usize> = std::iter::once(axis)
                .chain((0..ndim).filter(|&other| other != axis))
                .collect();
            let input = input.permuted_axes(order.clone());
            let output = output.permuted_axes(order);
            one_by_one(transform, input, output, is_parallel);
        }
    }
}

fn is_contiguous<A>(rows: &ArrayView2<A>) -> bool {
    rows.strides()[1] == 1 || rows.ncols() <= 1
}

fn one_by_one<A, B>(
    transform: &dyn Transform<A, B>,
    input: ArrayViewD<A>,
    output: ArrayViewMutD<B>,
    is_parallel: bool,
) {
    if input.ndim() > 2 {
        let slices = input.axis_iter(Axis(1));
        let mut output = output;
        for (input, output) in slices.zip(output.axis_iter_mut(Axis(1))) {
            one_by_one(transform, input, output, is_parallel);
        }
        return;
    }
    let (input, output) = match input.ndim() {
        1 => (input.insert_axis(Axis(1)), output.insert_axis(Axis(1))),
        _ => (input, output),
    };
    let two = (
        input.into_dimensionality::<ndarray::Ix2>(),
        output.into_dimensionality::<ndarray::Ix2>(),
    );
    if let (Ok(input), Ok(output)) = two {
        let turned = (input.t(), output);
        let (rows, mut out) = (turned.0, turned.1);
        if is_contiguous(&rows) && is_contiguous(&out.view_mut().reversed_axes().view()) {
            transform.rows(rows, out.reversed_axes(), is_parallel);
        } else {
            transform.columns(input, out, is_parallel);
        }
    }
}

/// Each row with scratch of its thread.
fn each_row<A: Sync, B: Send + Sync, S>(
    input: ArrayView2<A>,
    mut output: ArrayViewMut2<B>,
    is_parallel: bool,
    scratch: impl Fn() -> S + Sync + Send,
    row: impl Fn(&mut S, &[A], &mut [B]) + Sync + Send,
) {
    let one =
        |scratch: &mut S,
         (input, mut output): (ndarray::ArrayView1<A>, ndarray::ArrayViewMut1<B>)| {
            if let (Some(input), Some(output)) = (input.as_slice(), output.as_slice_mut()) {
                row(scratch, input, output);
            }
        };
    match is_parallel {
        true => input
            .axis_iter(Axis(0))
            .into_par_iter()
            .zip(output.axis_iter_mut(Axis(0)).into_par_iter())
            .for_each_init(scratch, one),
        false => {
            let mut scratch = scratch();
            for pair in input.outer_iter().zip(output.outer_iter_mut()) {
                one(&mut scratch, pair);
            }
        }
    }
}

struct Forward<T: Real> {
    len: usize,
    plan: Arc<RealToComplexColumns<T>>,
    rows: Arc<dyn column_fft::RealToComplex<T>>,
    factor: Option<T>,
}

impl<T: Planned> Transform<T, Complex<T>> for Forward<T> {
    fn columns(
        &self,
        input: ArrayView2<T>,
        mut output: ArrayViewMut2<Complex<T>>,
        is_parallel: bool,
    ) {
        let done = match is_parallel {
            true => self.plan.process_in_parallel(input, output.view_mut()),
            false => self.plan.process(input, output.view_mut()),
        };
        debug_assert!(done.is_ok());
        if let Some(factor) = self.factor {
            output.mapv_inplace(|z| z * factor);
        }
    }

    fn rows(&self, input: ArrayView2<T>, output: ArrayViewMut2<Complex<T>>, is_parallel: bool) {
        let scratch = || (vec![T::default(); self.len], self.rows.make_scratch_vec());
        each_row(
            input,
            output,
            is_parallel,
            scratch,
            |(row, scratch), input, output| {
                row.copy_from_slice(input);
                let done = self.rows.process_with_scratch(row, output, scratch);
                debug_assert!(done.is_ok());
                if let Some(factor) = self.factor {
                    output.iter_mut().for_each(|z| *z = *z * factor);
                }
            },
        );
    }
}

struct Inverse<T: Real> {
    len: usize,
    plan: Arc<ComplexToRealColumns<T>>,
    rows: Arc<dyn column_fft::ComplexToReal<T>>,
    scale: Scale,
}

impl<T: Planned> Transform<Complex<T>, T> for Inverse<T> {
    fn columns(
        &self,
        input: ArrayView2<Complex<T>>,
        mut output: ArrayViewMut2<T>,
        is_parallel: bool,
    ) {
        let done = match is_parallel {
            true => self.plan.process_in_parallel(input, output.view_mut()),
            false => self.plan.process(input, output.view_mut()),
        };
        debug_assert!(done.is_ok());
        // The plan divides by N.
        let len = self.len as f64;
        let factor = match self.scale {
            Scale::Mean => return,
            Scale::One => T::rounded(len),
            Scale::Root => T::rounded(len.sqrt()),
        };
        output.mapv_inplace(|x| x * factor);
    }

    fn rows(&self, input: ArrayView2<Complex<T>>, output: ArrayViewMut2<T>, is_parallel: bool) {
        let scratch = || {
            let bins = vec![Complex::default(); self.len / 2 + 1];
            (bins, self.rows.make_scratch_vec())
        };
        let factor = T::rounded(self.scale.factor(self.len));
        each_row(
            input,
            output,
            is_parallel,
            scratch,
            |(bins, scratch), input, output| {
                bins.copy_from_slice(input);
                // As everywhere, imaginary parts of 0 and of the Nyquist frequency do not count.
                bins[0].im = T::default();
                if self.len.is_multiple_of(2) {
                    bins[self.len / 2].im = T::default();
                }
                let done = self.rows.process_with_scratch(bins, output, scratch);
                debug_assert!(done.is_ok());
                if self.scale != Scale::One {
                    output.iter_mut().for_each(|x| *x = *x * factor);
                }
            },
        );
    }
}

struct Both<T: Real> {
    plan: Arc<column_fft::ComplexToComplexColumns<T>>,
    rows: Arc<dyn column_fft::Fft<T>>,
    factor: Option<T>,
}

impl<T: Planned> Transform<Complex<T>, Complex<T>> for Both<T> {
    fn columns(
        &self,
        input: ArrayView2<Complex<T>>,
        mut output: ArrayViewMut2<Complex<T>>,
        is_parallel: bool,
    ) {
        let done = match is_parallel {
            true => self.plan.process_in_parallel(input, output.view_mut()),
            false => self.plan.process(input, output.view_mut()),
        };
        debug_assert!(done.is_ok());
        if let Some(factor) = self.factor {
            output.mapv_inplace(|z| z * factor);
        }
    }

    fn rows(
        &self,
        input: ArrayView2<Complex<T>>,
        output: ArrayViewMut2<Complex<T>>,
        is_parallel: bool,
    ) {
        let scratch = || vec![Complex::default(); self.rows.get_inplace_scratch_len()];
        each_row(
            input,
            output,
            is_parallel,
            scratch,
            |scratch, input, output| {
                output.copy_from_slice(input);
                self.rows.process_with_scratch(output, scratch);
                if let Some(factor) = self.factor {
                    output.iter_mut().for_each(|z| *z = *z * factor);
                }
            },
        );
    }
}

/// Runs `work` with as many threads; 0 stands for all.
fn with_workers(workers: usize, work: impl FnOnce(bool) + Send) -> Result<(), String> {
    static POOLS: Mutex<Option<(usize, Arc<rayon::ThreadPool>)>> = Mutex::new(None);
    match workers {
        1 => work(false),
        0 => rayon::scope(|_| work(true)),
        workers => {
            let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
            let known = pools.as_ref().filter(|(threads, _)| *threads == workers);
            let pool = match known {
                Some((_, pool)) => Arc::clone(pool),
                None => {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(workers).build();
                    let pool = Arc::new(pool.map_err(|error| error.to_string())?);
                    *pools = Some((workers, Arc::clone(&pool)));
                    pool
                }
            };
            drop(pools);
            pool.install(|| work(true));
        }
    }
    Ok(())
}

/// The result of a transform of `input` to `len` rows along `axis`.
fn transformed<'py, A: Element + Sync, B: Element>(
    py: Python<'py>,
    input: &Bound<'py, PyArrayDyn<A>>,
    axis: usize,
    len: usize,
    workers: usize,
    transform: &(dyn Transform<A, B> + Send),
) -> PyResult<Bound<'py, PyAny>> {
    let mut shape = input.shape().to_vec();
    shape[axis] = len;
    // SAFETY: every element is written below, or none exists.
    let output = unsafe { PyArrayDyn::<B>::new(py, shape, false) };
    {
        // SAFETY: the new array has no other owner; the input is only read, as by any function that releases
        // the lock.
        let (from, to) = unsafe { (input.as_array(), output.as_array_mut()) };
        py.detach(|| {
            with_workers(workers, |is_parallel| {
                along(transform, from, to, axis, is_parallel)
            })
        })
        .map_err(PyValueError::new_err)?;
    }
    Ok(output.into_any())
}

fn failed(error: FftError) -> PyErr {
    PyValueError::new_err(format!("n: {error}"))
}

fn length_of(array: &Bound<'_, PyUntypedArray>, axis: usize) -> PyResult<usize> {
    let shape = array.shape();
    shape.get(axis).copied().ok_or_else(|| {
        PyValueError::new_err(format!(
            "axis: expected one below {}, found {axis}",
            shape.len()
        ))
    })
}

/// Real numbers to their spectra along `axis`: `n / 2 + 1` bins.
#[pyfunction]
#[pyo3(signature = (a, axis, norm, workers))]
pub fn r2c<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyUntypedArray>,
    axis: usize,
    norm: u8,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>> {
    fn typed<'py, T: Planned>(
        py: Python<'py>,
        a: &Bound<'py, PyArrayDyn<T>>,
        (len, axis, norm, workers): (usize, usize, u8, usize),
    ) -> PyResult<Bound<'py, PyAny>>
    where
        Complex<T>: Element,
    {
        let scale = Scale::of(norm);
        let mut plans = T::plans();
        let transform = Forward {
            len,
            plan: plans.forward(len).map_err(failed)?,
            rows: plans.forward_rows(len),
            factor: (scale != Scale::One).then(|| T::rounded(scale.factor(len))),
        };
        drop(plans);
        transformed(py, a, axis, len / 2 + 1, workers, &transform)
    }
    let with = (length_of(a, axis)?, axis, norm, workers);
    match a.cast::<PyArrayDyn<f64>>() {
        Ok(a) => typed(py, a, with),
        Err(_) => typed(py, a.cast::<PyArrayDyn<f32>>()?, with),
    }
}

/// Spectra of `n / 2 + 1` bins along `axis` to `n` real numbers.
#[pyfunction]
#[pyo3(signature = (a, n, axis, norm, workers))]
pub fn c2r<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyUntypedArray>,
    n: usize,
    axis: usize,
    norm: u8,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>> {
    fn typed<'py, T: Planned>(
        py: Python<'py>,
        a: &Bound<'py, PyArrayDyn<Complex<T>>>,
        (len, axis, norm, workers): (usize, usize, u8, usize),
    ) -> PyResult<Bound<'py, PyAny>>
    where
        Complex<T>: Element,
    {
        let mut plans = T::plans();
        let transform = Inverse {
            len,
            plan: plans.inverse(len).map_err(failed)?,
            rows: plans.inverse_rows(len),
            scale: Scale::of(norm),
        };
        drop(plans);
        transformed(py, a, axis, len, workers, &transform)
    }
    let bins = length_of(a, axis)?;
    if n == 0 || bins != n / 2 + 1 {
        let text = format!("n: expected {} bins, found {bins}", n / 2 + 1);
        return Err(PyValueError::new_err(text));
    }
    let with = (n, axis, norm, workers);
    match a.cast::<PyArrayDyn<Complex<f64>>>() {
        Ok(a) => typed(py, a, with),
        Err(_) => typed(py, a.cast::<PyArrayDyn<Complex<f32>>>()?, with),
    }
}

/// Complex numbers to their spectra along `axis`, or back.
#[pyfunction]
#[pyo3(signature = (a, is_forward, axis, norm, workers))]
pub fn c2c<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyUntypedArray>,
    is_forward: bool,
    axis: usize,
    norm: u8,
    workers: usize,
) -> PyResult<Bound<'py, PyAny>> {
    fn typed<'py, T: Planned>(
        py: Python<'py>,
        a: &Bound<'py, PyArrayDyn<Complex<T>>>,
        is_forward: bool,
        (len, axis, norm, workers): (usize, usize, u8, usize),
    ) -> PyResult<Bound<'py, PyAny>>
    where
        Complex<T>: Element,
    {
        let scale = Scale::of(norm);
        let mut plans = T::plans();
        let transform = Both {
            plan: plans.complex(len, is_forward).map_err(failed)?,
            rows: plans.complex_rows(len, is_forward),
            factor: (scale != Scale::One).then(|| T::rounded(scale.factor(len))),
        };
        drop(plans);
        transformed(py, a, axis, len, workers, &transform)
    }
    let with = (length_of(a, axis)?, axis, norm, workers);
    match a.cast::<PyArrayDyn<Complex<f64>>>() {
        Ok(a) => typed(py, a, is_forward, with),
        Err(_) => typed(py, a.cast::<PyArrayDyn<Complex<f32>>>()?, is_forward, with),
    }
}
