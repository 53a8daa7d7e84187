"""Structure without a name: its surface is the sum of its products, a table says the same."""

from collections.abc import Mapping

import numpy as np
import pytest

from gsapp.discrepancy.results import FoundEffect
from gsapp.discrepancy.unexplained_structure import find_unexplained_structures, with_tables
from gsapp.dynamics.model import Model, format_model, load_model
from gsapp.identification.filter_error.motion_linearization import create_maneuver_record
from tests.discrepancy.core_kit import AIRCRAFT, maneuver

SIZES: Mapping[str, float] = {
    "unnamed.Cm.alpha2": -2.5,
    "unnamed.Cm.alpha_q": 40.0,
    "unnamed.CA.absbeta": 0.3,
    "unnamed.Cm.late_de": 0.1,
}


def _found(effect: str) -> FoundEffect:
    name = effect.removeprefix("unnamed.").replace(".", "_")
    return FoundEffect(
        effect=effect, title="", equation="", parameters={name: (SIZES[effect], 0.1)},
        confidence=0.0,
    )  # fmt: skip


def test_a_surface_is_the_sum_of_its_products_and_a_table_says_the_same(tmp_path):
    records = [create_maneuver_record(maneuver(seed, "both")) for seed in (1, 2)]
    kink, surface = sorted(
        find_unexplained_structures([_found(one) for one in SIZES], records, AIRCRAFT),
        key=lambda one: len(one.variables),
    )
    assert (kink.coefficient, kink.variables) == ("CA", ("beta",))
    np.testing.assert_allclose(kink.values, 0.3 * np.abs(kink.nodes[0]))
    assert 0.0 in kink.nodes[0]
    assert surface.variables == ("alpha", "q_hat")
    alpha, q_hat = np.meshgrid(*surface.nodes, indexing="ij")
    np.testing.assert_allclose(surface.values, -2.5 * alpha**2 + 40.0 * alpha * q_hat)
    assert surface.flown.sum() == pytest.approx(1.0)
    model = Model()
    for one, size in SIZES.items():
        model = model.with_effect(one, {one[8:].replace(".", "_"): size})
    kept = with_tables(model, (kink, surface))
    assert [one.id for one in kept.effects] == [
        "unnamed.Cm.late_de", "unnamed.CA.table_beta", "unnamed.Cm.table_alpha_q",
    ]  # fmt: skip
    file = tmp_path / "model.toml"
    file.write_text(format_model(kept), "utf-8")
    table = load_model(file).effects[2]
    flown = np.argwhere(surface.flown > 0.0)
    for row, column in flown:
        at = (float(surface.nodes[0][row]), float(surface.nodes[1][column]))
        value = table.term(AIRCRAFT).value(at, (), table.values(AIRCRAFT))
        assert value == pytest.approx(surface.values[row, column], abs=1e-12)
    # Beyond its ends a table does not grow.
    far = table.term(AIRCRAFT).value((9.0, 0.0), (), table.values(AIRCRAFT))
    end = float(surface.nodes[0][-1])
    assert far == table.term(AIRCRAFT).value((end, 0.0), (), table.values(AIRCRAFT))
