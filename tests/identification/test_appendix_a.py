"""Appendix A both ways: against the published matrices, and against exact linearization."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from gsapp.aircraft import Propulsion, load_aircraft
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.linearization import OperatingPoint, linearize
from gsapp.dynamics.model import load_model
from gsapp.dynamics.trim import trim
from gsapp.foundation import FileProblemsError, FlightError, UnknownNameError
from gsapp.identification.linear_models.derivative_conversion import (
    SteadyCondition,
    lateral_derivatives,
    lateral_model,
    longitudinal_derivatives,
    longitudinal_model,
    solve_steady_flight,
)
from gsapp.identification.linear_models.linear_model_files import (
    load_linear_model,
    published_errors,
    save_linear_model,
)
from gsapp.identification.linear_models.model_comparison import model_from_derivatives

B777 = load_aircraft("b777")
FOOT = 0.3048

# Notes, section 5: what the published ML model means per radian at sea level.
LONGITUDINAL = {
    "CL_alpha+CD1": 4.43, "CL_de": 0.379, "Cm_alpha": -0.339, "Cm_q": -23.0, "Cm_de": -1.104,
    "CL_q": -5.08, "CD_de": -0.649, "CD_alpha-CL1": 0.079,
}  # fmt: skip
LATERAL = {
    "Cl_beta": -0.324, "Cl_p": -1.056, "Cl_r": 0.474, "Cl_da": 0.395, "Cl_dr": 0.0127,
    "Cn_beta": 0.121, "Cn_p": -0.121, "Cn_r": -0.350, "Cn_da": 0.0073, "Cn_dr": -0.0661,
    "CY_beta": 0.832, "CY_p": -1.69, "CY_r": -2.16, "CY_da": 0.363, "CY_dr": -0.408,
}  # fmt: skip


def published(name: str) -> tuple[SteadyCondition, object]:
    file = load_linear_model(name)
    assert file.speed is not None
    condition = SteadyCondition(U1=file.speed, mass=B777.mass.mass, stability_axes=True)
    return condition, file.model()


def test_published_longitudinal_matrix_means_the_noted_derivatives() -> None:
    """(7.3.11) through appendix A gives the values of the notes within their rounding."""
    condition, model = published("seanor-ml-longitudinal")
    found = longitudinal_derivatives(B777, condition, model)
    for name, value in LONGITUDINAL.items():
        assert found[name] == pytest.approx(value, rel=6e-3, abs=6e-4), name


def test_published_lateral_matrix_means_the_noted_derivatives() -> None:
    """(7.3.13) through appendix A gives the values of the notes within their rounding."""
    condition, model = published("seanor-ml-lateral")
    found = lateral_derivatives(B777, condition, model)
    for name, value in LATERAL.items():
        assert found[name] == pytest.approx(value, rel=6e-3, abs=6e-4), name


def test_published_matrices_come_back_after_both_ways() -> None:
    """Matrices to derivatives to matrices: every entry that appendix A can give."""
    condition, model = published("seanor-ml-lateral")
    back = lateral_model(B777, condition, lateral_derivatives(B777, condition, model))
    assert np.allclose(back.A[:3, :3], model.A[:3, :3], rtol=1e-12)
    assert np.allclose(back.B, model.B, rtol=1e-12)
    # The published outputs are U1 times the state rows within their rounding.
    assert np.allclose(back.C[0], model.C[0], rtol=2e-3)
    assert np.allclose(back.D[0], model.D[0], rtol=2e-3)
    condition, model = published("seanor-ml-longitudinal")
    means = longitudinal_derivatives(B777, condition, model)
    renamed = {
        "CN_alpha": means["CL_alpha+CD1"], "CN_q": means["CL_q"], "CN_de": means["CL_de"],
        "CA_alpha": means["CD_alpha-CL1"], "CA_de": means["CD_de"], "CL1": 0.0,
        **{name: means[name] for name in ("Cm_alpha", "Cm_q", "Cm_de")},
    }  # fmt: skip
    back = longitudinal_model(B777, condition, renamed)
    assert np.allclose(back.A, model.A, rtol=2e-3, atol=1e-9)
    assert np.allclose(back.B, model.B, rtol=1e-12)
    assert np.allclose(back.C[0], model.C[0], rtol=2e-3, atol=0.02)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("seanor-ml-longitudinal", {"short period": -4.178 + 3.002j}),
        ("seanor-ml-lateral", {"roll": -12.36, "dutch roll": -0.462 + 5.399j, "spiral": -0.101}),
        ("seanor-bls-longitudinal", {"short period, slow": -1.049, "short period, fast": -9.116}),
        ("seanor-bls-lateral", {"roll": -7.016, "dutch roll": -3.833 + 3.098j}),
    ],
)
def test_modes_of_the_published_models(name: str, expected: dict[str, complex]) -> None:
    """The poles of the notes, section 5, to their last digit."""
    found = {mode.name: mode.pole for mode in load_linear_model(name).model().modes()}
    for mode, pole in expected.items():
        assert found[mode] == pytest.approx(pole, abs=2.5e-3), mode


@pytest.mark.parametrize("speed", [27.0, 32.0])
def test_appendix_a_agrees_with_exact_linearization(speed: float) -> None:
    """Body axes, gyro rates: our derivatives through appendix A give the exact A and B."""
    model = load_model("b777")
    flight_model = FlightModel(B777, model)
    level = trim(flight_model, V=speed)
    condition = SteadyCondition(
        U1=speed, mass=B777.mass.mass, alpha1=level.polar.alpha, de1=level.inputs[0]
    )
    condition, derivatives = solve_steady_flight(B777, condition, model.derivatives)
    lateral = lateral_model(B777, condition, derivatives)
    exact = linearize(
        flight_model, level, states=lateral.states, inputs=lateral.inputs,
        outputs=("ay", "beta", "p", "r", "phi"),
    )  # fmt: skip
    scale = np.abs(exact.A).max(axis=1, keepdims=True)
    # Thrust and drag times beta, which the appendix leaves out, are 0.1 of the CY_beta row.
    assert np.all(np.abs(lateral.A[1:] - exact.A[1:]) < 1e-9 * scale[1:])
    assert np.allclose(lateral.A[0, 1:], exact.A[0, 1:], rtol=2e-3, atol=1e-3)
    assert abs(lateral.A[0, 0] - exact.A[0, 0]) < 0.1 * abs(exact.A[0, 0])
    assert np.allclose(lateral.B, exact.B, rtol=1e-9)
    longitudinal = longitudinal_model(B777, condition, derivatives)
    exact = linearize(flight_model, level, states=longitudinal.states, inputs=("de",))
    # The appendix leaves out what pitch rate does to speed (X'_q = 0).
    exact.A[longitudinal.states.index("V"), longitudinal.states.index("q")] = 0.0
    assert np.allclose(longitudinal.A, exact.A, rtol=5e-3, atol=2e-4)
    assert np.allclose(longitudinal.B, exact.B, rtol=5e-3, atol=5e-2)


def test_a_glider_is_linear_about_its_glide() -> None:
    model, speed = load_model("b777"), 30.0
    flight_model = FlightModel(B777, model)

    def throttle(path: float) -> float:
        try:
            steady = trim(flight_model, V=speed, climb_angle=path)
        except FlightError:  # so steep that throttle closed is too much
            return -1.0
        return float(steady.inputs[MODEL_INPUTS.index("throttle")])

    glide = brentq(throttle, -0.2, -0.02, xtol=1e-12)
    assert isinstance(glide, float)
    steady = trim(flight_model, V=speed, climb_angle=glide)
    glider = B777.model_copy(update={"propulsion": Propulsion()})
    condition = SteadyCondition(
        U1=speed, mass=B777.mass.mass, alpha1=steady.polar.alpha, de1=steady.inputs[0]
    )
    for axis in ("lon", "lat"):
        found = model_from_derivatives(glider, condition, axis, model.derivatives)
        exact = linearize(flight_model, steady, states=found.states, inputs=found.inputs)
        for one, other in zip(found.modes(), exact.modes(), strict=True):
            # Drag times beta and X'_q, which the appendix leaves out.
            assert one.pole == pytest.approx(other.pole, rel=0.02), one.name


def test_without_drag_there_is_no_phugoid() -> None:
    """Nothing would damp it: it was told to grow, with a bound of half a percent."""
    known = dict(load_model("b777").derivatives)
    condition = SteadyCondition(U1=30.0, mass=B777.mass.mass, alpha1=0.05, de1=-0.01)
    found = model_from_derivatives(B777, condition, "lon", known)
    assert {mode.name: mode.pole.real < 0.0 for mode in found.modes()} == {
        "short period": True, "phugoid": True,
    }  # fmt: skip
    del known["CA_0"]
    found = model_from_derivatives(B777, condition, "lon", known)
    assert found.states == ("alpha", "q")
    assert [mode.name for mode in found.modes()] == ["short period"]


def test_derivatives_go_through_and_come_back() -> None:
    model = load_model("b777")
    given = {name: model.derivative(name) for name in model.derivatives}
    condition = SteadyCondition(U1=31.0, mass=21.0, alpha1=0.06)
    back = lateral_derivatives(B777, condition, lateral_model(B777, condition, given))
    for name, value in back.items():
        assert value == pytest.approx(given[name], abs=1e-12), name
    means = longitudinal_derivatives(B777, condition, longitudinal_model(B777, condition, given))
    for name in ("Cm_alpha", "Cm_q", "Cm_de"):
        assert means[name] == pytest.approx(given[name], rel=1e-12)


def test_linear_model_file_goes_to_disk_and_back(tmp_path: Path) -> None:
    steady = OperatingPoint(speed=31.5, density=1.1, mass=21.0)
    model = replace(load_linear_model("seanor-bls-lateral").model(), operating_point=steady)
    path = save_linear_model(model, tmp_path / "model.toml", name="mine")
    back = load_linear_model(path).model()
    assert back.states == model.states
    assert back.operating_point == steady
    for key in "ABCD":
        assert np.allclose(getattr(back, key), getattr(model, key), rtol=1e-12)
    path.write_text(path.read_text(encoding="utf-8").replace("de [", "dee [").replace(
        "[[3.0547", "[[3.0547, 7.0"), encoding="utf-8")  # fmt: skip
    with pytest.raises(FileProblemsError):
        load_linear_model(path)
    with pytest.raises(UnknownNameError, match="seanor-ml-lateral"):
        load_linear_model("seanor-ml-laterl")


def test_error_tables_of_the_source_are_complete() -> None:
    table = published_errors()
    assert set(table) == {"an", "alpha", "q", "ay", "beta", "p", "r"}
    assert table["r"].ml == 35.84
