"""Claims of the README and the docs that `./validate` does not verify, and why."""

CLAIMS = [
    (
        "On one thread with AVX-512 column FFTs take 0.33 to 0.55 of the time of the fastest of "
        "five others",
        "performance.md, Column transforms",
        "needs AVX-512, FFTW, MKL and ducc0, and times the library, not the program: "
        "`benches/peers/columns.py`",
    ),
    (
        "Errors of column transforms are below FFTW's",
        "accuracy.md, Spectra",
        "needs FFTW and the transforms themselves, of which the program writes squares: "
        "`benches/peers/columns.py --errors`",
    ),
    (
        "Chain velocities are checked against two codes in double the precision",
        "accuracy.md, Chains",
        "here against one of them, SciPy and closed forms; the other: `cargo test --test chain "
        "reference`",
    ),
    (
        "Budgets of 34 kinds of chains close",
        "accuracy.md, Budgets",
        "here random Hertz chains by NumPy, and eleven kinds by what the program states: `cargo "
        "test --test budget`",
    ),
    (
        "Spectra agree with xrft; bicoherence with pybispectra; multitaper spectra with nitime "
        "and `multitaper`; modes with PySPOD; increments with fluidsf; wavenumbers with DASCore",
        "accuracy.md; guide",
        "here the same equations in NumPy and SciPy; the packages: `cargo test --test analysis`, "
        "`python/check`",
    ),
    (
        "Gains between two sites against Burgers' exact transfer and the power flow of chains",
        "accuracy.md, Spectra",
        "needs the closed form of the library's test: `cargo test --test analysis transfer`",
    ),
    (
        "Triads of Burgers' equation and of alpha chains",
        "guide/triads.md",
        "`cargo test --test budget triads`",
    ),
    (
        "Averages in Python, over Dask arrays and stores",
        "accuracy.md, Spectra",
        "needs the Python package, a build of its own: `python/check`",
    ),
    (
        "With gains off by 1 %, 99.6 % of the overlaps lie within three stated errors",
        "accuracy.md, Measured chains",
        "`cargo test --test budget measured`",
    ),
    (
        "Ratios of localized waves of orders 9 to 19, and ratios of least leak",
        "accuracy.md, Localized waves",
        "the collocation here resolves orders to 8: `cargo test --test localized`",
    ),
    (
        "A collision with a wall and the force of the solitary wave in `attenuate`",
        "accuracy.md, Pulses",
        "`cargo test --test localized attenuation_pulse`",
    ),
    (
        "Files of HDF5, MATLAB, SEG-Y, UFF 58, TDMS, miniSEED and LAMMPS are read as other "
        "programs read them",
        "README.md",
        "needs files and packages of those programs: `cargo test -p wavecascade-formats`",
    ),
    (
        "A field of 12 GiB in 2 GiB of memory; resident memory stays within --memory",
        "performance.md, Fields larger than memory",
        "takes a disk and minutes: `benches/large_field.py`, `cargo test --test command_line limits`",
    ),
    (
        "Chains beside Boost.odeint, diffrax, numba and LAMMPS; sweeps; long chains",
        "performance.md, Chains",
        "needs those programs: `benches/peers/chain/run.py`, `sweeps.py`, `large.py`",
    ),
    (
        "Estimates beside nitime, pybispectra and PySPOD; files beside h5py and npTDMS",
        "performance.md",
        "needs those packages: `benches/peers/estimates.py`, `benches/peers/formats/run.py`",
    ),
    (
        "Any call to the file system may fail, any request for memory may be refused, the power "
        "may be cut",
        "robustness.md, What the tests do",
        "needs a preloaded library and recorded calls: `cargo test --test command_line`",
    ),
    (
        "No data races, no memory errors, 32-bit kernels, the oldest compiler",
        "robustness.md, What the tests do",
        "needs other toolchains: `./test --all`, `./test --platforms`",
    ),
    (
        "Fields that drift while they are read, symbolic links, networks",
        "robustness.md, Inputs",
        "`cargo test --test command_line`",
    ),
]
