//! Transforms of NumPy arrays along one axis: columns by `column-fft`, contiguous rows by realfft and RustFFT.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Mul;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use column_fft::{ColumnFftPlanner, ComplexToRealColumns, FftDirection, FftError, Real, rows};
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

/// What transforms a row, with scratch of its own.
type Row<A, B> = Box<dyn FnMut(&[A], &mut [B])>;

/// What transforms `(n, columns)`, on one thread or on all of the pool.
type Columns<A, B> =
    Box<dyn Fn(ArrayView2<A>, ArrayViewMut2<B>, bool) -> Result<(), FftError> + Send + Sync>;

/// A transform along one axis, of columns or of contiguous rows.
struct Transform<A, B> {
    columns: Columns<A, B>,
    row: Box<dyn Fn() -> Row<A, B> + Send + Sync>,
    /// Whether columns are divided by their length.
    is_mean: bool,
}

type Kept<A, B> = HashMap<usize, Arc<Transform<A, B>>>;

/// From complex numbers to complex numbers.
type Both<T> = Transform<Complex<T>, Complex<T>>;

/// Transforms of one number type, by their lengths.
struct Plans<T: Real> {
    planner: ColumnFftPlanner<T>,
    forward: Kept<T, Complex<T>>,
    inverse: Kept<Complex<T>, T>,
    /// Of complex numbers, forward and inverse.
    both: [Kept<Complex<T>, Complex<T>>; 2],
}

/// Columns by a plan.
macro_rules! columns {
    ($plan:expr) => {{
        let plan = $plan;
        Box::new(move |input, output, in_parallel| match in_parallel {
            true => plan.process_in_parallel(input, output),
            false => plan.process(input, output),
        })
    }};
}

impl<T: Real> Plans<T> {
    fn new() -> Self {
        Plans {
            planner: ColumnFftPlanner::new(),
            forward: HashMap::new(),
            inverse: HashMap::new(),
            both: Default::default(),
        }
    }

    /// Lets go of all, where no more are kept.
    fn with_room(&mut self) -> &mut Self {
        let both: usize = self.both.iter().map(HashMap::len).sum();
        if self.forward.len() + self.inverse.len() + both >= KEPT {
            *self = Plans::new();
        }
        self
    }

    fn forward(&mut self, len: usize) -> Result<Arc<Transform<T, Complex<T>>>, FftError> {
        let plans = self.with_room();
        known(&mut plans.forward, len, || {
            let plan = rows::plan_fft_forward(len);
            Ok(Transform {
                columns: columns!(plans.planner.plan_fft_forward(len)?),
                row: Box::new(move || {
                    let plan = Arc::clone(&plan);
                    let (mut row, mut scratch) = (plan.make_input_vec(), plan.make_scratch_vec());
                    Box::new(move |input, output| {
                        row.copy_from_slice(input);
                        let done = plan.process_with_scratch(&mut row, output, &mut scratch);
                        debug_assert!(done.is_ok());
                    })
                }),
                is_mean: false,
            })
        })
    }

    fn inverse(&mut self, len: usize) -> Result<Arc<Transform<Complex<T>, T>>, FftError> {
        let plans = self.with_room();
        known(&mut plans.inverse, len, || {
            let forward = plans.planner.plan_fft_forward(len)?;
            let plan = rows::plan_fft_inverse(len);
            Ok(Transform {
                columns: columns!(ComplexToRealColumns::of(forward).normalized()),
                row: Box::new(move || {
                    let plan = Arc::clone(&plan);
                    let (mut bins, mut scratch) = (plan.make_input_vec(), plan.make_scratch_vec());
                    Box::new(move |input, output| {
                        bins.copy_from_slice(input);
                        // As everywhere, imaginary parts of 0 and of the Nyquist frequency do not count.
                        bins[0].im = T::default();
                        if len.is_multiple_of(2) {
                            bins[len / 2].im = T::default();
                        }
                        let done = plan.process_with_scratch(&mut bins, output, &mut scratch);
                        debug_assert!(done.is_ok());
                    })
                }),
                is_mean: true,
            })
        })
    }

    fn both(&mut self, len: usize, is_forward: bool) -> Result<Arc<Both<T>>, FftError> {
        let direction = match is_forward {
            true => FftDirection::Forward,
            false => FftDirection::Inverse,
        };
        let plans = self.with_room();
        known(&mut plans.both[usize::from(is_forward)], len, || {
            let plan = rows::plan_fft_complex(len, direction);
            Ok(Transform {
                columns: columns!(plans.planner.plan_fft_complex(len, direction)?),
                row: Box::new(move || {
                    let plan = Arc::clone(&plan);
                    let mut scratch = vec![Complex::default(); plan.get_inplace_scratch_len()];
                    Box::new(move |input, output| {
                        output.copy_from_slice(input);
                        plan.process_with_scratch(output, &mut scratch);
                    })
                }),
                is_mean: false,
            })
        })
    }
}

/// The transform that is kept, or a new one.
fn known<P>(
    kept: &mut HashMap<usize, Arc<P>>,
    len: usize,
    make: impl FnOnce() -> Result<P, FftError>,
) -> Result<Arc<P>, FftError> {
    Ok(Arc::clone(match kept.entry(len) {
        Entry::Occupied(found) => found.into_mut(),
        Entry::Vacant(place) => place.insert(Arc::new(make()?)),
    }))
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

/// By what columns and rows of a length are multiplied: 1, 1 / N or 1 / sqrt(N), which `norm` chooses; nothing for 1.
fn factors<T: Real>(norm: u8, len: usize, is_mean: bool) -> [Option<T>; 2] {
    let n = len as f64;
    let factors = match (norm, is_mean) {
        (0, true) => [n, 1.0],
        (1, true) => [1.0, 1.0 / n],
        (_, true) => [n.sqrt(), 1.0 / n.sqrt()],
        (0, false) => [1.0; 2],
        (1, false) => [1.0 / n; 2],
        (_, false) => [1.0 / n.sqrt(); 2],
    };
    factors.map(|factor| (factor != 1.0).then(|| T::rounded(factor)))
}

/// A transform with its factors.
struct Scaled<'a, T, A, B> {
    transform: &'a Transform<A, B>,
    of_columns: Option<T>,
    of_rows: Option<T>,
    is_parallel: bool,
}

impl<T, A, B> Scaled<'_, T, A, B>
where
    T: Copy + Send + Sync,
    A: Sync,
    B: Copy + Mul<T, Output = B> + Send + Sync,
{
    fn columns(&self, input: ArrayView2<A>, mut output: ArrayViewMut2<B>) {
        let done = (self.transform.columns)(input, output.view_mut(), self.is_parallel);
        debug_assert!(done.is_ok());
        if let Some(factor) = self.of_columns {
            output.mapv_inplace(|x| x * factor);
        }
    }

    /// `(rows, n)`, each row contiguous.
    fn rows(&self, input: ArrayView2<A>, mut output: ArrayViewMut2<B>) {
        let one = |row: &mut Row<A, B>, (input, mut output): (ArrayView1<A>, ArrayViewMut1<B>)| {
            if let (Some(input), Some(output)) = (input.as_slice(), output.as_slice_mut()) {
                row(input, output);
                if let Some(factor) = self.of_rows {
                    output.iter_mut().for_each(|x| *x = *x * factor);
                }
            }
        };
        if self.is_parallel {
            let input = input.axis_iter(Axis(0)).into_par_iter();
            let pairs = input.zip(output.axis_iter_mut(Axis(0)).into_par_iter());
            pairs.for_each_init(|| (self.transform.row)(), one);
        } else {
            let mut row = (self.transform.row)();
            let pairs = input.outer_iter().zip(output.outer_iter_mut());
            pairs.for_each(|pair| one(&mut row, pair));
        }
    }

    /// Along `axis` of arrays of equal other axes.
    fn along(&self, axis: usize, input: ArrayViewD<A>, mut output: ArrayViewMutD<B>) {
        let before: usize = input.shape()[..axis].iter().product();
        let after: usize = input.shape()[axis + 1..].iter().product();
        let (n, m) = (input.shape()[axis], output.shape()[axis]);
        if before * after == 0 {
            return;
        }
        let from = input.view().into_shape_with_order((before, n, after));
        let to = output.view_mut().into_shape_with_order((before, m, after));
        match (from, to) {
            (Ok(from), Ok(to)) if after == 1 => {
                let (from, to) = (
                    from.index_axis_move(Axis(2), 0),
                    to.index_axis_move(Axis(2), 0),
                );
                self.of_either(from, to);
            }
            (Ok(from), Ok(mut to)) => {
                for (from, to) in from.outer_iter().zip(to.outer_iter_mut()) {
                    self.columns(from, to);
                }
            }
            _ => {
                // The axis last, then all but one of the others one by one.
                let others = (0..input.ndim()).filter(|&other| other != axis);
                let order: Vec<usize> = others.chain([axis]).collect();
                let input = input.permuted_axes(order.clone());
                self.one_by_one(input, output.permuted_axes(order));
            }
        }
    }

    /// Of `(rows, n)`, each row contiguous or not.
    fn of_either(&self, input: ArrayView2<A>, output: ArrayViewMut2<B>) {
        let is_contiguous = |stride: isize, len: usize| stride == 1 || len <= 1;
        let rows = is_contiguous(input.strides()[1], input.ncols())
            && is_contiguous(output.strides()[1], output.ncols());
        match rows {
            true => self.rows(input, output),
            false => self.columns(input.reversed_axes(), output.reversed_axes()),
        }
    }

    fn one_by_one(&self, input: ArrayViewD<A>, mut output: ArrayViewMutD<B>) {
        if input.ndim() > 2 {
            for (from, to) in input.outer_iter().zip(output.outer_iter_mut()) {
                self.one_by_one(from, to);
            }
            return;
        }
        let (input, output) = match input.ndim() {
            1 => (input.insert_axis(Axis(0)), output.insert_axis(Axis(0))),
            _ => (input, output),
        };
        let two = (input.into_dimensionality(), output.into_dimensionality());
        if let (Ok(input), Ok(output)) = two {
            self.of_either(input, output);
        }
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

/// How a transform is called.
struct Call<'py> {
    py: Python<'py>,
    axis: usize,
    norm: u8,
    workers: usize,
}

impl<'py> Call<'py> {
    /// The result of a transform of length `len`, of `bins` along the axis.
    fn made<T, A, B>(
        &self,
        input: &Bound<'py, PyArrayDyn<A>>,
        [len, bins]: [usize; 2],
        find: impl FnOnce(&mut Plans<T>) -> Result<Arc<Transform<A, B>>, FftError>,
    ) -> PyResult<Bound<'py, PyAny>>
    where
        T: Planned,
        A: Element + Sync,
        B: Element + Copy + Mul<T, Output = B> + Sync,
    {
        // Work holds the lock of no plan, and waits for none.
        let transform = find(&mut T::plans());
        let transform = transform.map_err(|error| PyValueError::new_err(format!("n: {error}")))?;
        let [of_columns, of_rows] = factors(self.norm, len, transform.is_mean);
        let mut shape = input.shape().to_vec();
        shape[self.axis] = bins;
        // SAFETY: every element is written below, or none exists.
        let output = unsafe { PyArrayDyn::<B>::new(self.py, shape, false) };
        {
            // SAFETY: the new array has no other owner; the input is only read, as by any function that releases
            // the lock.
            let (from, to) = unsafe { (input.as_array(), output.as_array_mut()) };
            let (axis, workers) = (self.axis, self.workers);
            let work = |is_parallel| {
                let scaled = Scaled {
                    transform: &*transform,
                    of_columns,
                    of_rows,
                    is_parallel,
                };
                scaled.along(axis, from, to);
            };
            let done = self.py.detach(|| with_workers(workers, work));
            done.map_err(PyValueError::new_err)?;
        }
        Ok(output.into_any())
    }
}

fn call<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyUntypedArray>,
    axis: usize,
    norm: u8,
    workers: usize,
) -> PyResult<(Call<'py>, usize)> {
    let shape = a.shape();
    let Some(&length) = shape.get(axis) else {
        let text = format!("axis: expected one below {}, found {axis}", shape.len());
        return Err(PyValueError::new_err(text));
    };
    let call = Call {
        py,
        axis,
        norm,
        workers,
    };
    Ok((call, length))
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
    let (call, n) = call(py, a, axis, norm, workers)?;
    let lengths = [n, n / 2 + 1];
    match a.cast::<PyArrayDyn<f64>>() {
        Ok(a) => call.made(a, lengths, |plans: &mut Plans<f64>| plans.forward(n)),
        Err(_) => call.made(a.cast()?, lengths, |plans: &mut Plans<f32>| {
            plans.forward(n)
        }),
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
    let (call, bins) = call(py, a, axis, norm, workers)?;
    if n == 0 || bins != n / 2 + 1 {
        let text = format!("n: expected {} bins, found {bins}", n / 2 + 1);
        return Err(PyValueError::new_err(text));
    }
    match a.cast::<PyArrayDyn<Complex<f64>>>() {
        Ok(a) => call.made(a, [n, n], |plans: &mut Plans<f64>| plans.inverse(n)),
        Err(_) => call.made(a.cast()?, [n, n], |plans: &mut Plans<f32>| plans.inverse(n)),
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
    let (call, n) = call(py, a, axis, norm, workers)?;
    match a.cast::<PyArrayDyn<Complex<f64>>>() {
        Ok(a) => call.made(a, [n, n], |all: &mut Plans<f64>| all.both(n, is_forward)),
        Err(_) => call.made(a.cast()?, [n, n], |all: &mut Plans<f32>| {
            all.both(n, is_forward)
        }),
    }
}
