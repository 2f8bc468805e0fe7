"""Designs from Python are those of the program."""

import pytest

import wavecascade as wc

SCENE = {"sites": 8, "coefficients": [1.0] * 8, "end_time": 30.0, "samples": 256}


def test_a_design_is_found_and_is_a_scene():
    found = wc.design(
        SCENE, free={"coefficients[]": (0.2, 5)}, minimize="peak_force_last", tries=60, seed=1
    )
    values = [value["after"] for value in found.attrs["values"]]
    assert len(values) == 8 and all(0.2 <= value <= 5 for value in values)
    assert found.attrs["judged_after"] < found.attrs["judged_before"]
    assert "less" in found.attrs["answer"]
    assert "coefficients" in found.attrs["scene"]
    assert float(found["search"][-1]) == found.attrs["judged_after"]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="bounds of coefficients"):
        wc.design(SCENE, free="coefficients[0]", minimize="peak_force_last")
