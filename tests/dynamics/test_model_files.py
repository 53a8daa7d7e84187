"""Model files: read strictly, written back, revised with their parents named."""

from pathlib import Path

import pytest

from gsapp.aircraft import Aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Effect, Model, load_model, save_model, shipped_models
from gsapp.dynamics.terms import POSITIONED_INSTRUMENTS, create_term, effect_ids
from gsapp.foundation import FileProblemsError, UnknownNameError

GOOD = """
name = "revised"
parent = "b777"
[derivatives]
Cm_alpha = -0.34
[[effects]]
id = "aero.Cm.alpha2"
[effects.parameters]
Cm_alpha2 = -1.5
[[effects]]
id = "control.elevator.backlash"
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "model.toml"
    path.write_text(text)
    return path


def test_a_file_as_in_the_design(tmp_path: Path, aircraft: Aircraft) -> None:
    model = load_model(write(tmp_path, GOOD))
    assert (model.name, model.parent) == ("revised", "b777")
    assert model.derivative("Cm_alpha") == -0.34
    assert model.derivative("Cm_q") == 0.0
    assert model.effects[0].values(aircraft) == (-1.5,)
    assert model.effects[1].values(aircraft) == (0.02,)
    built = FlightModel(aircraft, model)
    assert built.defaults[built.parameter_names.index("aero.Cm.alpha2.Cm_alpha2")] == -1.5
    assert [term.id for term, _ in built.control_terms["elevator"]] == ["control.elevator.backlash"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('nam = "x"', "did you mean 'name'"),
        ("[derivatives]\nCm_alfa = 1.0", "did you mean 'Cm_alpha'"),
        ("[derivatives]\nCm_alpha = nan", "not a finite number"),
        ('[derivatives]\nCm_alpha = "steep"', "derivatives.Cm_alpha"),
        ('[[effects]]\nid = "aero.Cm.alfa2"', "did you mean 'aero.Cm.alpha2'"),
        (
            '[[effects]]\nid = "aero.Cm.alpha2"\n[effects.parameters]\nCm_alfa2 = 1',
            "effects[0].parameters.Cm_alfa2",
        ),
        (
            '[[effects]]\nid = "aero.Cm.alpha2"\n[effects.parameters]\nCm_alpha2 = inf',
            "not a finite number",
        ),
        ('[[effects]]\nid = "aero.Cm.alpha2"\n' * 2, "appears twice"),
        ("[derivatives", "not valid TOML"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(FileProblemsError) as caught:
        load_model(write(tmp_path, text))
    assert says in str(caught.value)


def test_an_unknown_model_names_those_shipped() -> None:
    with pytest.raises(UnknownNameError, match="b777"):
        load_model("b77")


def test_written_and_read_again(tmp_path: Path) -> None:
    model = load_model(write(tmp_path, GOOD))
    again = load_model(save_model(model, tmp_path / "again.toml"))
    assert again == model


def test_revising_names_the_parent(model: Model) -> None:
    revised = model.with_effect("aero.Cm.beta2", {"Cm_beta2": -0.4}, name="b777-r1")
    assert (revised.name, revised.parent) == ("b777-r1", "b777")
    assert revised.derivatives == model.derivatives
    changed = revised.with_derivatives({"Cm_alpha": -0.4})
    assert changed.derivative("Cm_alpha") == -0.4
    assert model.derivative("Cm_alpha") == -0.339
    twice = changed.with_effect("aero.Cm.beta2", {"Cm_beta2": -0.2})
    assert [effect.parameters for effect in twice.effects] == [{"Cm_beta2": -0.2}]
    assert twice.without_effect("aero.Cm.beta2").effects == ()


def test_the_shipped_model_is_that_of_the_notes(model: Model) -> None:
    assert "b777" in shipped_models()
    expected = {
        "CN_de": 0.379, "Cm_alpha": -0.339, "Cm_q": -23.0, "Cm_de": -1.104, "Cl_beta": -0.324,
        "Cl_p": -1.056, "Cl_r": 0.474, "Cl_da": 0.395, "Cl_dr": 0.0127, "Cn_beta": 0.121,
        "Cn_p": -0.121, "Cn_r": -0.350, "Cn_da": 0.0073, "Cn_dr": -0.0661,
        "CY_beta": -0.6, "CY_r": 0.3, "CY_dr": 0.15, "CN_q": 5.0,
    }  # fmt: skip
    assert {name: model.derivative(name) for name in expected} == expected


def test_a_model_with_every_effect_comes_back_from_its_file(
    tmp_path: Path, aircraft: Aircraft
) -> None:
    effects = tuple(
        Effect(id=name, parameters=create_term(name, aircraft).defaults) for name in effect_ids()
    )
    model = Model(name="all", effects=effects)
    path = save_model(model, tmp_path / "all.toml")
    back = load_model(path)
    assert back == model
    built, again = FlightModel(aircraft, model), FlightModel(aircraft, back)
    assert built.defaults == again.defaults
    assert built.swapped_channels == again.swapped_channels
    assert set(built.displaced_instruments) == set(POSITIONED_INSTRUMENTS)
    # Every signal term stands on one path, that of a box on those of all its channels.
    paths = {
        term.id
        for group in (*built.control_terms.values(), *built.sensor_terms.values())
        for term, _ in group
    }
    inside = {term.id for term, _ in built.terms}
    swapped = {name for name in effect_ids() if name.endswith(".swapped")}
    assert paths | inside | swapped >= set(effect_ids())
