"""Proves the algebra of `InformationMatrix` against plain least squares on the rows behind it."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.identification.filter_error.filter_error_fit import InformationMatrix
from gsapp.quantities import FloatArray

NAMES = ("a", "b", "c", "d", "e")


@dataclass(frozen=True)
class Rows:
    names: tuple[str, ...]
    columns: FloatArray
    residual: FloatArray

    def information(self) -> InformationMatrix:
        every = np.column_stack((self.columns, self.residual))
        return InformationMatrix(
            names=self.names, matrix=every.T @ every, samples=float(len(self.residual))
        )


def rows(seed: int, names: tuple[str, ...] = NAMES, n: int = 60) -> Rows:
    random = np.random.default_rng(seed)
    common = random.standard_normal((n, 1))
    sizes = 10.0 ** random.uniform(-3.0, 3.0, len(names))
    columns = (common + random.standard_normal((n, len(names)))) * sizes
    return Rows(names, columns, random.standard_normal(n) + 2.0 * common[:, 0])


def left_of(columns: FloatArray, target: FloatArray) -> FloatArray:
    return target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.permutations(NAMES), st.integers(1, 4))
def test_projection_is_least_squares(seed: int, order: list[str], count: int) -> None:
    one = rows(seed)
    nuisance = tuple(order[:count])
    found = one.information().projected(nuisance)
    out = one.columns[:, [NAMES.index(name) for name in nuisance]]
    kept = [name for name in NAMES if name not in nuisance]
    assert found.names == tuple(kept)
    assert found.samples == 60 - count
    every = np.column_stack((one.columns[:, [NAMES.index(name) for name in kept]], one.residual))
    left = left_of(out, every)
    sizes = np.sqrt(np.diag(every.T @ every))
    scaled = np.outer(sizes, sizes)
    assert found.matrix / scaled == pytest.approx(left.T @ left / scaled, abs=1e-8)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_projecting_twice_is_projecting_once(seed: int) -> None:
    whole = rows(seed).information()
    sizes = np.sqrt(np.diag(whole.projected(("a", "c")).matrix))
    once = whole.projected(("a", "c")).matrix / np.outer(sizes, sizes)
    for first, second in (("a", "c"), ("c", "a")):
        twice = whole.projected((first,)).projected((second,))
        assert twice.names == ("b", "d", "e")
        assert twice.matrix / np.outer(sizes, sizes) == pytest.approx(once, abs=1e-8)
        assert twice.samples == 58


def test_solution_is_least_squares_with_its_covariance() -> None:
    one = rows(3)
    for names in (NAMES, ("d", "b")):
        X = one.columns[:, [NAMES.index(name) for name in names]]
        values, covariance = one.information().solution(names)
        assert values == pytest.approx(np.linalg.lstsq(X, one.residual, rcond=None)[0], rel=1e-6)
        sizes = np.sqrt(np.diag(covariance))
        expected = np.linalg.inv(X.T @ X) / np.outer(sizes, sizes)
        assert covariance / np.outer(sizes, sizes) == pytest.approx(expected, abs=1e-6)


def test_misfit_is_the_sum_of_squares_with_given_values() -> None:
    one = rows(4)
    values = {"d": 0.3, "a": -2.0}
    X = one.columns[:, [3, 0]]
    left = one.residual - X @ np.array([0.3, -2.0])
    assert one.information().misfit(values) == pytest.approx(float(left @ left))
    assert one.information().misfit({}) == pytest.approx(float(one.residual @ one.residual))
    best, _ = one.information().solution(NAMES)
    assert one.information().misfit(dict(zip(NAMES, best, strict=True))) == pytest.approx(
        float(one.information().projected(NAMES).matrix[-1, -1])
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_maneuvers_add_up(seed: int) -> None:
    one, other = rows(seed, ("a", "b", "c")), rows(seed + 1, ("d", "b"), n=40)
    total = one.information() + other.information()
    assert total.names == ("a", "b", "c", "d")
    assert total.samples == 100
    stacked = np.zeros((100, 5))
    stacked[:60, [0, 1, 2]], stacked[60:, [3, 1]] = one.columns, other.columns
    stacked[:60, 4], stacked[60:, 4] = one.residual, other.residual
    assert total.matrix == pytest.approx(stacked.T @ stacked, rel=1e-9)


def test_the_order_of_maneuvers_changes_names_only() -> None:
    one, other = rows(7, ("a", "b", "c")).information(), rows(8, ("d", "b")).information()
    first, second = one + other, other + one
    assert set(first.names) == set(second.names)
    places = [*second.indices(first.names), -1]
    assert np.array_equal(first.matrix, second.matrix[np.ix_(places, places)])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(-5.0, 5.0), st.floats(0.01, 10.0))
def test_a_prior_is_one_more_row(seed: int, value: float, std: float) -> None:
    """Knowing b = value with a deviation is a measurement of it; unknown names do not count."""
    one = rows(seed)
    found = one.information().with_priors({"b": (value, std), "unknown": (1.0, 1.0)})
    extra = np.zeros((1, 6))
    extra[0, 1], extra[0, 5] = 1.0 / std, value / std
    every = np.vstack((np.column_stack((one.columns, one.residual)), extra))
    assert found.names == NAMES
    assert found.matrix == pytest.approx(every.T @ every, rel=1e-9)
    assert found.samples == 60


def test_gains_are_what_a_refit_with_one_more_column_takes_off() -> None:
    one = rows(11)
    own = one.columns[:, :2]
    left = one.information().projected(("a", "b"))
    gain, size, std = left.gains(one.information())
    without = float(np.sum(left_of(own, one.residual) ** 2))
    for place, column in enumerate((2, 3, 4)):
        X = np.column_stack((own, one.columns[:, column]))
        with_it = float(np.sum(left_of(X, one.residual) ** 2))
        assert gain[place] == pytest.approx(without - with_it, rel=1e-6, abs=1e-9)
        assert size[place] == pytest.approx(
            np.linalg.lstsq(X, one.residual, rcond=None)[0][-1], rel=1e-6
        )
        assert std[place] == pytest.approx(np.sqrt(np.linalg.inv(X.T @ X)[-1, -1]), rel=1e-6)


def test_what_the_others_hold_already_gains_nothing() -> None:
    """A column that the model's parameters make up: no gain, and no size that could be told.

    One that is zero altogether (an effect that cannot act here) likewise.
    """
    one = rows(12)
    double = one.columns[:, 0] * 3.0 - 0.01 * one.columns[:, 1]
    columns = np.column_stack((one.columns, double, np.zeros(60)))
    wide = Rows((*NAMES, "double", "still"), columns, one.residual).information()
    gain, size, std = wide.projected(("a", "b")).gains(wide)
    assert gain[3:].tolist() == [0.0, 0.0]
    assert size[3:].tolist() == [0.0, 0.0]
    assert np.isinf(std[3:]).all()
    assert np.isfinite(std[:3]).all()
    # And parameters that are one and the same do not break a solution.
    values, covariance = wide.solution(("a", "b", "double"))
    assert np.isfinite(values).all()
    assert np.isfinite(covariance).all()
    X = one.columns[:, :2]
    assert wide.misfit(dict(zip(("a", "b", "double"), values, strict=True))) == pytest.approx(
        float(np.sum(left_of(X, one.residual) ** 2)), rel=1e-6
    )


def test_cosines_tell_what_looks_alike() -> None:
    """Of what is left once the model took its part: 1 with itself, -1 with its opposite."""
    one = rows(13)
    mirrored = -4.0 * one.columns[:, 2] + 0.3 * one.columns[:, 0]
    wide = Rows((*NAMES, "m"), np.column_stack((one.columns, mirrored)), one.residual)
    left = wide.information().projected(("a", "b"))
    cosines = dict(zip(left.names, left.cosines("c"), strict=True))
    assert cosines["c"] == pytest.approx(1.0)
    assert cosines["m"] == pytest.approx(-1.0, abs=1e-7)
    c, d = (left_of(one.columns[:, :2], one.columns[:, k]) for k in (2, 3))
    assert cosines["d"] == pytest.approx(float(c @ d / np.sqrt((c @ c) * (d @ d))), rel=1e-6)


def test_what_nothing_is_known_of_stays_where_it_is() -> None:
    one = rows(4)
    blind = Rows(NAMES, one.columns * (np.array(NAMES) != "c"), one.residual)
    moves, covariance = blind.information().solution(NAMES)
    others = [name for name in NAMES if name != "c"]
    expected, bounds = blind.information().solution(others)
    kept = [NAMES.index(name) for name in others]
    assert moves[NAMES.index("c")] == 0.0
    assert moves[kept] == pytest.approx(expected, rel=1e-6)
    assert covariance[np.ix_(kept, kept)] == pytest.approx(bounds, rel=1e-6)
    assert covariance[NAMES.index("c"), NAMES.index("c")] > 1e6
