//! Transforms of 2, 3, 4, 5, 7 and 8 points in registers.

// Loops over places in registers are unrolled; iterators over several arrays are not, always.
#![allow(clippy::needless_range_loop)]
// Constants have more digits than numbers hold, so that the nearest number is sure.
#![allow(clippy::excessive_precision)]

use super::simd::Lanes;

/// A complex number in each lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Complex<L> {
    pub re: L,
    pub im: L,
}

// SAFETY of every block below: the processor has the instructions of L, by the caller's word.
impl<L: Lanes> Complex<L> {
    #[inline(always)]
    pub unsafe fn zero() -> Self {
        unsafe {
            Complex {
                re: L::of(0.0),
                im: L::of(0.0),
            }
        }
    }

    #[inline(always)]
    pub unsafe fn load(from: *const L::Scalar) -> Self {
        unsafe {
            Complex {
                re: L::load(from),
                im: L::load(from.add(L::WIDTH)),
            }
        }
    }

    #[inline(always)]
    pub unsafe fn store(self, to: *mut L::Scalar) {
        unsafe {
            self.re.store(to);
            self.im.store(to.add(L::WIDTH));
        }
    }

    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        unsafe {
            Complex {
                re: self.re.add(other.re),
                im: self.im.add(other.im),
            }
        }
    }

    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        unsafe {
            Complex {
                re: self.re.sub(other.re),
                im: self.im.sub(other.im),
            }
        }
    }

    /// `self - i other`.
    #[inline(always)]
    unsafe fn sub_i(self, other: Self) -> Self {
        unsafe {
            Complex {
                re: self.re.add(other.im),
                im: self.im.sub(other.re),
            }
        }
    }

    /// `self + i other`.
    #[inline(always)]
    unsafe fn add_i(self, other: Self) -> Self {
        unsafe {
            Complex {
                re: self.re.sub(other.im),
                im: self.im.add(other.re),
            }
        }
    }

    /// `self + factor other`, with a real factor.
    #[inline(always)]
    unsafe fn add_times(self, factor: L, other: Self) -> Self {
        unsafe {
            Complex {
                re: factor.mul_add(other.re, self.re),
                im: factor.mul_add(other.im, self.im),
            }
        }
    }

    /// `self - factor other`.
    #[inline(always)]
    unsafe fn sub_times(self, factor: L, other: Self) -> Self {
        unsafe {
            Complex {
                re: factor.neg_mul_add(other.re, self.re),
                im: factor.neg_mul_add(other.im, self.im),
            }
        }
    }

    /// Times one complex number in memory.
    #[inline(always)]
    pub unsafe fn times(self, twiddle: *const L::Scalar) -> Self {
        unsafe {
            let (cos, sin) = (L::splat(twiddle), L::splat(twiddle.add(1)));
            Complex {
                re: self.re.mul_sub(cos, self.im.mul(sin)),
                im: self.re.mul_add(sin, self.im.mul(cos)),
            }
        }
    }
}

/// `y_k = sum_i x_i exp(-2 pi i i k / R)`.
pub(super) trait Butterfly<const R: usize> {
    unsafe fn of<L: Lanes>(x: [Complex<L>; R]) -> [Complex<L>; R];
}

/// The discrete Fourier transform.
pub(super) struct Dft;

impl Butterfly<1> for Dft {
    #[inline(always)]
    unsafe fn of<L: Lanes>(x: [Complex<L>; 1]) -> [Complex<L>; 1] {
        x
    }
}

impl Butterfly<2> for Dft {
    #[inline(always)]
    unsafe fn of<L: Lanes>(x: [Complex<L>; 2]) -> [Complex<L>; 2] {
        unsafe { [x[0].add(x[1]), x[0].sub(x[1])] }
    }
}

impl Butterfly<4> for Dft {
    #[inline(always)]
    unsafe fn of<L: Lanes>(x: [Complex<L>; 4]) -> [Complex<L>; 4] {
        unsafe {
            let (a, b) = (x[0].add(x[2]), x[0].sub(x[2]));
            let (c, d) = (x[1].add(x[3]), x[1].sub(x[3]));
            [a.add(c), b.sub_i(d), a.sub(c), b.add_i(d)]
        }
    }
}

impl Butterfly<8> for Dft {
    #[inline(always)]
    unsafe fn of<L: Lanes>(x: [Complex<L>; 8]) -> [Complex<L>; 8] {
        unsafe {
            let e = <Dft as Butterfly<4>>::of([x[0], x[2], x[4], x[6]]);
            let o = <Dft as Butterfly<4>>::of([x[1], x[3], x[5], x[7]]);
            let half = L::of(std::f64::consts::FRAC_1_SQRT_2);
            // exp(-i pi / 4) o and exp(-3 i pi / 4) o, but for the factor.
            let a = Complex {
                re: o[1].re.add(o[1].im),
                im: o[1].im.sub(o[1].re),
            };
            let b = Complex {
                re: o[3].im.sub(o[3].re),
                im: o[3].re.add(o[3].im),
            };
            [
                e[0].add(o[0]),
                e[1].add_times(half, a),
                e[2].sub_i(o[2]),
                Complex {
                    re: half.mul_add(b.re, e[3].re),
                    im: half.neg_mul_add(b.im, e[3].im),
                },
                e[0].sub(o[0]),
                e[1].sub_times(half, a),
                e[2].add_i(o[2]),
                Complex {
                    re: half.neg_mul_add(b.re, e[3].re),
                    im: half.mul_add(b.im, e[3].im),
                },
            ]
        }
    }
}

/// `cos(2 pi j / R)` and `sin(2 pi j / R)`, `j = 1 ..= (R - 1) / 2`.
trait Roots<const R: usize> {
    const COS: &'static [f64];
    const SIN: &'static [f64];
}

impl Roots<3> for Dft {
    const COS: &'static [f64] = &[-0.5];
    const SIN: &'static [f64] = &[0.866_025_403_784_438_646_76];
}

impl Roots<5> for Dft {
    const COS: &'static [f64] = &[0.309_016_994_374_947_424_10, -0.809_016_994_374_947_424_10];
    const SIN: &'static [f64] = &[0.951_056_516_295_153_572_12, 0.587_785_252_292_473_129_17];
}

impl Roots<7> for Dft {
    const COS: &'static [f64] = &[
        0.623_489_801_858_733_530_53,
        -0.222_520_933_956_314_404_29,
        -0.900_968_867_902_419_126_24,
    ];
    const SIN: &'static [f64] = &[
        0.781_831_482_468_029_808_71,
        0.974_927_912_181_823_607_02,
        0.433_883_739_117_558_120_48,
    ];
}

/// Of an odd number of points, by the sums and differences of those that mirror each other.
macro_rules! odd {
    ($radix:literal) => {
        impl Butterfly<$radix> for Dft {
            #[inline(always)]
            unsafe fn of<L: Lanes>(x: [Complex<L>; $radix]) -> [Complex<L>; $radix] {
                const HALF: usize = $radix / 2;
                let cos = <Dft as Roots<$radix>>::COS;
                let sin = <Dft as Roots<$radix>>::SIN;
                unsafe {
                    let mut sums = [x[0]; HALF];
                    let mut differences = [x[0]; HALF];
                    let mut y = x;
                    for j in 0..HALF {
                        sums[j] = x[j + 1].add(x[$radix - 1 - j]);
                        differences[j] = x[j + 1].sub(x[$radix - 1 - j]);
                        y[0] = y[0].add(sums[j]);
                    }
                    for k in 1..=HALF {
                        let mut a = x[0];
                        let mut b = Complex::zero();
                        for j in 0..HALF {
                            let phase = (j + 1) * k % $radix;
                            let (at, back) = if phase > HALF {
                                ($radix - phase - 1, true)
                            } else {
                                (phase - 1, false)
                            };
                            a = a.add_times(L::of(cos[at]), sums[j]);
                            let sine = L::of(if back { -sin[at] } else { sin[at] });
                            b = if j == 0 {
                                Complex {
                                    re: sine.mul(differences[j].re),
                                    im: sine.mul(differences[j].im),
                                }
                            } else {
                                b.add_times(sine, differences[j])
                            };
                        }
                        y[k] = a.sub_i(b);
                        y[$radix - k] = a.add_i(b);
                    }
                    y
                }
            }
        }
    };
}
odd!(3);
odd!(5);
odd!(7);
