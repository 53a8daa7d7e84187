"""How names are listed, and how a slip is answered."""

import pytest

from gsapp.foundation.name_suggestions import did_you_mean, format_names


@pytest.mark.parametrize(
    ("names", "text"),
    [((), ""), (("p",), "p"), (("p", "q"), "p, q"), (("p", "q", "r", "V"), "p, q and 2 more")],
)
def test_of_many_names_only_the_first_are_named(names: tuple[str, ...], text: str) -> None:
    assert format_names(names, 2) == text


def test_a_slip_is_answered_by_what_is_near() -> None:
    known = ("alpha", "beta", "theta")
    assert did_you_mean("thetta", known) == "did you mean 'theta' or 'beta'?"
    assert did_you_mean("thetta", known, most=1) == "did you mean 'theta'?"
    assert did_you_mean("rpm", known, "known are three") == "known are three"
