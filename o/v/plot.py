# Spectra of white, from spectra.npz. Needs Python with `pip install numpy matplotlib`.
# Edit a copy: a new run of cascade replaces this file and its pictures.
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

here = Path(__file__).resolve().parent
data = np.load(here / "spectra.npz")


def picture(name, x, y, xlabel, ylabel, label, xlim, ylim):
    values = data[name]
    top = np.nanmax(values) or 1.0
    floor = top * 10.0**-8
    fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
    image = ax.pcolormesh(data[x], data[y], np.maximum(values, floor), norm="log", vmin=floor, vmax=top)
    fig.colorbar(image).set_label(label, fontsize=8)
    ax.set(xlabel=xlabel, ylabel=ylabel, xlim=xlim, ylim=ylim)
    return fig, ax


fig, ax = picture("spacetime_spectrum", "wavenumber_signed", "frequency",
    "wavenumber (rad/m)", "frequency (Hz)",
    "energy spectral density [(m/s)² s m/(Hz · rad/m)]",
    xlim=(-314.15926535897927, 298.45130209103047), ylim=(0, 500))
fig.savefig(here / "plot-spacetime_spectrum.png", dpi=200)


fig, ax = picture("temporal_spectrum", "position", "frequency",
    "position (m)", "frequency (Hz)",
    "energy spectral density [(m/s)² s/Hz]",
    xlim=(0, 0.39), ylim=(0, 500))
fig.savefig(here / "plot-temporal_spectrum.png", dpi=200)


fig, ax = picture("spatial_spectrum", "wavenumber", "time",
    "wavenumber (rad/m)", "time (s)",
    "energy spectral density [(m/s)² m/(rad/m)]",
    xlim=(0, 314.1592653589793), ylim=(0, 4.095))
fig.savefig(here / "plot-spatial_spectrum.png", dpi=200)
