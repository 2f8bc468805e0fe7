#!/bin/sh
# Installs the Python peers, pinned, into target/peers. Run from the repository's root.
set -eu
python3 -m venv target/peers
target/peers/bin/pip install --quiet numpy==2.4.6 scipy==1.17.1 \
    ducc0==0.42.0 pyfftw==0.15.1 mkl_fft==2.3.2
target/peers/bin/python -c 'import numpy, scipy; print("numpy", numpy.__version__, "scipy", scipy.__version__)'
