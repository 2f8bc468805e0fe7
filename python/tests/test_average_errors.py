"""Errors of the tasks of lazy averages: samples are named as in the whole field."""

import numpy as np
import pytest

import wavecascade as wc

pytest.importorskip("xarray")
da = pytest.importorskip("dask.array")

FINITE = r"expected finite samples, found {} that are not \(NaN or infinite\), the first at time row {}"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "field: " + FINITE.format(2, 700) + ", site 17; 2 of 5 sites of this task are affected"),
        ({"estimate": "coherence"}, "field: .* row 700, site 17; 2 of 6 sites of this task are affected"),
    ],
)
def test_errors_of_tasks_name_samples_of_the_whole_field(record, options, message):
    gaps = record.copy()
    # In the same chunk.
    gaps[700, 17], gaps[701, 18] = np.nan, np.inf
    lazy = wc.distributed.averaged(da.from_array(gaps, chunks=(600, 5)), segment=64, **options)
    with pytest.raises(ValueError, match=message):
        lazy.compute(scheduler="synchronous")


def test_errors_of_tasks_name_gaps_and_references(record):
    averaged = wc.distributed.averaged
    gap = record.copy()
    gap[1216, 17] = np.nan
    for options in ({}, {"estimate": "coherence", "reference": 17}):
        lazy = averaged(
            da.from_array(gap, chunks=(600, 5)), segment=64, overlap=0, gaps="interpolate", **options
        )
        with pytest.raises(ValueError, match="gaps: .*, found none at time row 1216, site 17 of field"):
            lazy.compute(scheduler="synchronous")
    # A reference counts once where it is in a task as a site as well.
    gap[1217, 18] = np.inf
    lazy = averaged(da.from_array(gap, chunks=(600, 5)), "coherence", reference=17, segment=64)
    for sites, found in ((slice(15, 20), "2 of 5"), (slice(0, 5), "1 of 6")):
        with pytest.raises(ValueError, match=f"row 1216, site 17; {found} sites of this task"):
            lazy.coherence[:, sites].compute(scheduler="synchronous")
    # A reference that is no site. Segments share nothing here, so that one task sees the gap.
    lazy = da.from_array(record, chunks=(600, 5))
    found = averaged(lazy, "coherence", reference=gap[:, 17], segment=64, overlap=0)
    with pytest.raises(ValueError, match="^reference: " + FINITE.format(1, 1216) + "$"):
        found.compute(scheduler="synchronous")
    found = averaged(lazy, "coherence", reference=gap[:, 17], segment=64, overlap=0, gaps="interpolate")
    with pytest.raises(ValueError, match="found none at time row 1216, the reference of field"):
        found.compute(scheduler="synchronous")
    # The sites of a chunk are counted from the first one behind the reference.
    gap[1300, 21] = np.inf
    found = averaged(da.from_array(gap, chunks=(600, 5)), "coherence", reference=gap[:, 3], segment=64)
    with pytest.raises(ValueError, match="row 1300, site 21; 1 of 3 sites of this task are affected"):
        found.coherence[:, 20:].compute(scheduler="synchronous")
