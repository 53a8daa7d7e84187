"""What the data cannot see or tell apart never gets a number."""

import numpy as np
import pytest

from gsapp.identification.statistics import (
    Identifiability,
    assess_identifiability,
    correlation_warning,
    information_matrix,
)
from gsapp.quantities import FloatArray

NAMES = ("Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
ONE = np.ones((1, 1))


def regressors(count: int = 500) -> FloatArray:
    random = np.random.default_rng(0)
    smooth = random.standard_normal((count + 50, 3))
    smooth = np.cumsum(smooth - np.vstack((np.zeros((50, 3)), smooth[:-50])), axis=0)[50:]
    return np.column_stack((np.ones(count), 0.01 * smooth))


def judged(columns: FloatArray, sigma: float) -> Identifiability:
    return assess_identifiability(information_matrix(columns[:, None, :], ONE / sigma**2), NAMES)


def test_what_is_well_excited_is_estimated() -> None:
    found = judged(regressors(), 0.01)
    assert [found[name].status for name in NAMES] == ["estimated"] * 4
    assert found.correlated == ()
    assert 1.0 <= found.condition < 100.0


def test_a_surface_that_did_not_move_is_unknown() -> None:
    random = np.random.default_rng(1)
    for still in (np.zeros(500), 1e-5 * random.standard_normal(500)):
        columns = regressors()
        columns[:, 3] = still
        found = judged(columns, 0.01)
        assert found["Cm_de"].status == "unknown"
        assert "excit" in found["Cm_de"].why
        assert [found[name].status for name in NAMES[:3]] == ["estimated"] * 3


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_twins_are_named(noise: float) -> None:
    columns = regressors()
    columns[:, 3] = 1.5 * columns[:, 1] + noise * np.random.default_rng(2).standard_normal(500)
    found = judged(columns, 0.01)
    assert found["Cm_alpha"].status == found["Cm_de"].status == "not-identifiable"
    assert found["Cm_alpha"].confounded_with == ("Cm_de",)
    assert found["Cm_de"].confounded_with == ("Cm_alpha",)
    assert "Cm_de" in found["Cm_alpha"].why
    assert (found["Cm_0"].status, found["Cm_q"].status) == ("estimated", "estimated")
    assert found.condition > 1e4


def test_three_that_depend_on_one_another() -> None:
    columns = regressors()
    columns[:, 3] = columns[:, 1] + columns[:, 2]
    found = judged(columns, 0.01)
    for name in NAMES[1:]:
        assert found[name].status == "not-identifiable"
        assert set(found[name].confounded_with) == set(NAMES[1:]) - {name}
    assert found["Cm_0"].status == "estimated"


def test_strong_correlation_is_a_warning_not_a_verdict() -> None:
    columns = regressors(2000)
    columns[:, 3] = columns[:, 1] + 0.02 * columns[:, 2]
    columns[:, 3] += 0.002 * np.random.default_rng(3).standard_normal(2000)
    found = judged(columns, 1e-4)
    assert found["Cm_de"].status == "estimated"
    assert ("Cm_alpha", "Cm_de") in [pair[:2] for pair in found.correlated]
    assert "Cm_alpha and Cm_de" in correlation_warning(found.correlated)


def test_a_parameter_of_unknown_size_is_judged_by_singularity() -> None:
    columns = regressors()
    names = ("a", "b", "c", "d")
    H = information_matrix(columns[:, None, :], ONE / 1e6**2)
    assert assess_identifiability(H, names)["b"].status == "estimated"
    assert assess_identifiability(H, names, plausible={"b": 1.0})["b"].status == "unknown"
    H[:, 2] = H[2, :] = 0.0
    assert assess_identifiability(H, names)["c"].status == "unknown"


def test_honest_bounds_judge_harder() -> None:
    H = information_matrix(regressors()[:, None, :], ONE / 0.01**2)
    covariance = 1e6 * np.linalg.inv(H)
    found = assess_identifiability(H, NAMES, covariance=covariance)
    assert found["Cm_alpha"].status == "unknown"
    assert assess_identifiability(H, NAMES)["Cm_alpha"].status == "estimated"


def test_one_sentence_names_the_correlated_pairs_of_a_fit() -> None:
    pairs = [(f"C{k}", f"D{k}", 0.99 - 0.001 * k) for k in range(9)]
    said = correlation_warning(pairs)
    assert "\n" not in said
    assert "C0 and D0 (+0.990)" in said
    assert said.endswith("3 more")
    assert "more" not in correlation_warning(pairs[:6])
