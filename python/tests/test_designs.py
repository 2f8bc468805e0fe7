"""Designs from Python are those of the program."""

import json

import numpy as np
import pytest

import wavecascade as wc

SCENE = {"sites": 8, "coefficients": [1.0] * 8, "end_time": 30.0, "samples": 256}


def test_a_design_is_found_and_is_a_scene():
    found = wc.design(
        SCENE, free={"coefficients[]": (0.2, 5)}, minimize="peak_force_last", tries=60, seed=1
    )
    values = [value["after"] for value in json.loads(found.attrs["values"])]
    assert len(values) == 8 and all(0.2 <= value <= 5 for value in values)
    assert found.attrs["judged_after"] < found.attrs["judged_before"]
    assert "less" in found.attrs["answer"]
    assert wc.simulate(found.attrs["scene"]).sizes["position"] == 8
    best = min(float(found["search"][-1]), float(found["random"][-1]))
    assert best == found.attrs["judged_after"]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="bounds of coefficients"):
        wc.design(SCENE, free="coefficients[0]", minimize="peak_force_last")


def test_a_chain_is_fitted_to_its_own_run():
    truth = wc.simulate(
        {"sites": 6, "law": "spring", "coefficient_cell": [1.7], "end_time": 20.0, "samples": 200}
    )
    scene = {"sites": 6, "law": "spring", "coefficient_cell": [1.5], "end_time": 20.0, "samples": 200}
    found = wc.fit(truth["velocity"], scene, free="coefficient_cell[0]", starts=1)
    assert abs(float(found["value"].sel(parameter="coefficient_cell[0]")) - 1.7) < 1e-4
    assert found.attrs["answer"]


def test_a_measurement_is_planned_and_a_field_compared():
    scene = {"sites": 6, "stiffness_ratio": 2.0, "tangent": 0.02, "end_time": 12.0, "samples": 200}
    with pytest.warns(wc.CascadeWarning, match="still fall"):
        planned = wc.plan_sensors(scene, free=["stiffness_ratio", "tangent"], sensors=2, noise="2%")
    assert len(json.loads(planned.attrs["bodies"])) == 2
    assert (planned["error_all"] <= planned["error"]).all()
    run = wc.simulate(scene)
    for other in (run, scene):
        found = wc.compare(run["velocity"], other)
        assert "agree to the error of runs" in found.attrs["answer"]
    with pytest.raises(ValueError, match="1 to 6"):
        wc.plan_sensors(scene, free="tangent", sensors=7)


def test_a_run_has_its_derivatives():
    chain = dict(sites=8, stiffness_ratio=2.0, end_time=8.0, samples=9, tolerance=1e-10)
    run = wc.simulate(chain, striker_velocity=1.0, gradient=["striker_velocity"])
    slower, faster = (wc.simulate(chain, striker_velocity=speed).velocity for speed in (0.999, 1.001))
    known = (faster - slower).values / 0.002
    found = run.gradient_velocity.sel(parameter="striker_velocity")
    assert found.dims == ("time", "position")
    off = np.abs(found.values - known).max() / np.abs(known).max()
    assert 1e-9 < off < 1e-5
    assert float(run.gradient_error[0]) < 1e-6
    with pytest.raises(ValueError, match="gradient"):
        wc.simulate(chain, gradient=["sites"])
