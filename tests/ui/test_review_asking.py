"""From the panel of the estimate to what is asked for, and back; nothing of it needs a window."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.foundation.settings import SettingError
from gsapp.identification.axes import AXIS_RESPONSES, axis_derivatives
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.review.estimate_request import (
    FIELD_HELP,
    build_run_request,
    field_help_text,
    find_form_error,
    find_unrestored_settings,
    form_from_request,
    format_maneuver_count,
)
from ui.settings import Settings

NAMES = axis_derivatives("both")
EFFECT = "aero.Cm.alpha2.Cm_alpha2"
NUMBERS = st.floats(-1e3, 1e3, allow_nan=False).map(repr)
POSITIVE = st.floats(1e-6, 1e3).map(repr)
CHANNELS = st.lists(st.sampled_from(AXIS_RESPONSES["both"]), unique=True, min_size=1).map(tuple)


@st.composite
def derivative_entries(draw: st.DrawFn) -> DerivativeEntry:
    treated = draw(st.sampled_from(["tables", "free", "held"]))
    if treated == "held":
        return DerivativeEntry(treated="held", value=draw(NUMBERS))
    known = draw(st.booleans())
    return DerivativeEntry(
        treated=treated,
        start=draw(st.one_of(st.just(""), NUMBERS)),
        prior=draw(NUMBERS) if known else "",
        deviation=draw(POSITIVE) if known else "",
    )


@st.composite
def forms(draw: st.DrawFn) -> EstimateForm:
    """Return a panel for all six degrees of freedom, where everything can be chosen."""
    model = draw(st.sampled_from(["", "b777"]))
    # Parameters of effects are asked for where there is a model that has them.
    known = (*NAMES, EFFECT) if model else NAMES
    names = draw(st.lists(st.sampled_from(known), unique=True, max_size=6))
    return EstimateForm(
        six_degrees=True,
        joint=draw(st.booleans()),
        derivatives={name: draw(derivative_entries()) for name in names},
        noise=draw(st.sampled_from(["diagonal", "full"])),
        integration=draw(st.sampled_from(["rk4", "euler"])),
        bound_factor=draw(st.one_of(st.just(""), POSITIVE)),
        responses=draw(st.one_of(st.none(), CHANNELS)),
        biases=draw(st.one_of(st.none(), CHANNELS)),
        scale_factors=draw(CHANNELS),
        stand_ins=draw(st.sampled_from(["", "V=30", "V=30, alpha=0.05"])),
        weights=draw(st.sampled_from(["", "table-6.2.7"])),
        model=model,
    )


@settings(max_examples=25, deadline=None)
@given(forms())
def test_the_settings_of_a_run_fill_the_panel_so_that_it_asks_the_same(panel: EstimateForm) -> None:
    request = build_run_request(panel, (Path("a"),), ())
    again = form_from_request(request)
    assert build_run_request(again, (Path("a"),), ()) == request
    kept = Settings(review_estimate=again)
    assert Settings.model_validate(kept.model_dump()).review_estimate == again


@pytest.mark.parametrize(
    ("panel", "field", "words"),
    [
        ({"Cm_q": {"treated": "held"}}, "derivatives", "Cm_q is held: enter its value"),
        ({"Cm_q": {"treated": "held", "value": "x"}}, "derivatives", "'x' is not a number"),
        ({"Cm_q": {"prior": "-20"}}, "derivatives", "needs a deviation"),
        ({"Cm_q": {"prior": "-20", "deviation": "0"}}, "derivatives", "above zero"),
        ({"Cm_q": {"start": "nan"}}, "derivatives", "'nan' is not a number"),
    ],
)
def test_what_cannot_be_asked_of_a_derivative_is_said(
    panel: dict[str, dict[str, str]], field: str, words: str
) -> None:
    wished = EstimateForm.model_validate({"derivatives": panel})
    problem = find_form_error(wished)
    assert problem.field == field
    assert words in str(problem)


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"bound_factor": "0"}, "bound_factor", "greater than 0"),
        ({"stand_ins": "V30"}, "stand_ins", "write NAME=VALUE"),
        ({"weights": "/nowhere.toml"}, "weights", "nowhere"),
        ({"model": "no such"}, "model", "no such"),
        ({"axis": "lon", "responses": ("thrust",)}, "channels", "'thrust' is not one of"),
        (
            {"axis": "lon", "derivatives": dict.fromkeys(
                axis_derivatives("lon"), DerivativeEntry(treated="held", value="1"))},
            "derivatives", "free at least one",
        ),
    ],
)  # fmt: skip
def test_each_field_says_what_is_wrong_with_it(
    changes: dict[str, object], field: str, words: str
) -> None:
    problem = find_form_error(EstimateForm().with_changes(**changes))
    assert (problem.field, words in str(problem)) == (field, True), str(problem)


def test_what_a_method_does_not_heed_is_neither_asked_for_nor_judged() -> None:
    panel = EstimateForm(
        weights="/nowhere.toml", bound_factor="x", stand_ins="?",
        derivatives={"Cm_q": DerivativeEntry(treated="held", value="-20")},
    )  # fmt: skip
    assert find_form_error(panel) is not None
    assert find_form_error(panel.with_changes(method="ftr")) is None
    asked = build_run_request(panel.with_changes(method="ftr"), (Path("a"),), ())
    assert (asked.weights, dict(asked.held)) == ("", {})
    with pytest.raises(SettingError):
        build_run_request(panel.with_changes(method="ee"), (Path("a"),), ())


def test_settings_that_the_panel_cannot_hold_are_named() -> None:
    request = build_run_request(EstimateForm(), (Path("a"),), ())
    assert find_unrestored_settings(request, form_from_request(request)) == ()
    other = request.with_changes(max_iterations=5)
    assert find_unrestored_settings(other, form_from_request(other)) == ("maximum iterations",)


def test_every_choice_says_what_it_does_and_maneuvers_are_counted() -> None:
    for field in FIELD_HELP:
        assert field_help_text(field).endswith(".")
        assert len(field_help_text(field)) < 350
    assert "3 maneuvers of 2 flights" in format_maneuver_count([("de",), ("de",), ("da", "dr")], 2)
    assert format_maneuver_count([("de",)], 1) == "1 maneuver: 1 de"
