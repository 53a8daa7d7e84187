"""Answers of a search made by hand: what printing, drawing and writing are tested with."""

from dataclasses import replace

import numpy as np

from gsapp.discrepancy.results import (
    Alternative,
    ChangedValue,
    ChannelGap,
    Disagreement,
    DiscrepancyResult,
    FlightRegion,
    FoundEffect,
    Gap,
    InstrumentRemark,
    ManeuverHistories,
    ModelStep,
    Observability,
    RankedCandidate,
)
from gsapp.dynamics.model import Model, load_model

COEFFICIENTS = ("CX", "CZ", "Cm", "CY", "Cl", "Cn")
CHANNELS = ("alpha", "q", "an", "ax", "V", "theta", "beta", "p", "r", "ay", "phi")
_FLOOR = {
    "alpha": 0.002, "q": 0.01, "an": 0.05, "ax": 0.05, "V": 0.3, "theta": 0.002,
    "beta": 0.002, "p": 0.01, "r": 0.01, "ay": 0.05, "phi": 0.002,
}  # fmt: skip
_EFFECT = "propulsion.Cm.throttle"


def answer(*, maneuvers: int = 6, samples: int = 600) -> DiscrepancyResult:
    """Return an answer that found throttle to pitching moment, then a second, forced effect."""
    baseline = load_model("b777")
    first = baseline.with_effect(_EFFECT, {"arm": 0.05}, name="b777+1")
    second = first.with_effect("aero.Cm.alpha2", {"Cm_alpha2": -1.9}, name="b777+2")
    views = tuple(_view(number, maneuvers, samples) for number in range(maneuvers))
    steps = (
        _step(baseline, "", maneuvers, 8.0),
        _step(first, _EFFECT, maneuvers, 2.0),
        _step(second, "aero.Cm.alpha2", maneuvers, 1.05),
    )
    channels = {
        name: ChannelGap(
            before=floor * (6.0 if name in ("q", "alpha") else 1.3), after=floor * 1.05,
            floor=floor, before_pct=9.5, after_pct=1.7, theil_before=0.12, theil_after=0.02,
            within_before=0.55, within_after=0.98,
        )
        for name, floor in _FLOOR.items()
    }  # fmt: skip
    return DiscrepancyResult(
        verdict="effects-found",
        why="Pitching moment follows throttle, most at low speed.",
        disagreements=(
            Disagreement(
                coefficient="Cm", channel="q", maneuver="1", t_start=102.0, t_end=108.0, rms=0.02,
                noise_floor=0.0025, p_value=3e-9,
                region=FlightRegion(
                    variable="throttle", low=0.7, high=1.0, words="throttle above 70 %"
                ),
            ),
            Disagreement(
                coefficient="", channel="ay", maneuver="2", t_start=110.0, t_end=116.0, rms=0.2,
                noise_floor=0.05, p_value=0.001,
            ),
        ),
        observability=(
            Observability(
                effect=_EFFECT, effect_class="A", sigma=22.0, sigma_size=0.0022,
                aliases=(("aero.Cm.speed", 0.71),),
            ),
            Observability(
                effect="aero.Cm.flap", effect_class="A", sigma=0.0, sigma_size=float("inf"),
                aliases=(), fly="an elevator doublet with the flap at 20 deg",
            ),
        ),
        steps=steps,
        effects=(
            FoundEffect(
                effect=_EFFECT, title="throttle lifts the nose", equation="M += arm thrust",
                parameters={"arm": (0.0493, 0.0021)}, confidence=0.97, runner_up="aero.Cm.speed",
                margin=41.0, held_out=33.0,
            ),
            FoundEffect(
                effect="aero.Cm.alpha2", title=(
                    "pitching moment varies nonlinearly with angle of attack"
                ),
                equation="Cm += Cm_alpha2 alpha^2", parameters={"Cm_alpha2": (-1.9, 0.4)},
                confidence=0.8, forced=True,
            ),
        ),
        values={"Cm_q": ChangedValue(before=-23.0, after=-19.4, std=0.6)},
        alternatives=(
            Alternative(
                effects=("mass.cg.x", "aero.CN.alpha"), title="CG forward, and more lift",
                why="both shift Cm_alpha", fly="weigh the aircraft on two scales",
            ),
        ),
        disturbance={"gust": 0.31, "gust_std": 0.04},
        gap=Gap(channels=channels, closed=0.94, closed_std=0.03, on=("3", "6")),
        maneuvers=views,
        coefficients=COEFFICIENTS,
        channels=CHANNELS,
        instruments=(
            InstrumentRemark(channel="ay", words="a_y reads 0.02 g high", consistent=False),
            InstrumentRemark(channel="q", words="q agrees", consistent=True),
        ),
        warnings=("maneuver 4: q was clipped in 0.3 s",),
    )  # fmt: skip


def adequate(*, maneuvers: int = 6, samples: int = 600) -> DiscrepancyResult:
    found = answer(maneuvers=maneuvers, samples=samples)
    gap = Gap(channels=found.gap.channels, closed=None, closed_std=None, on=found.gap.on)
    return replace(
        found, verdict="model-adequate", why="Nothing is left beyond the noise.",
        disagreements=(), steps=(replace(found.steps[0], ranking=()),), effects=(), values={},
        alternatives=(), disturbance={}, gap=gap, instruments=(), warnings=(),
        maneuvers=tuple(
            replace(one, computed=one.computed[:1], missing=one.missing[:1])
            for one in found.maneuvers
        ),
    )  # fmt: skip


def _step(model: Model, added: str, maneuvers: int, misfit: float) -> ModelStep:
    ranking = (
        RankedCandidate(effect=_EFFECT, title="throttle lifts the nose", score=120.0 * misfit,
                  evidence=0.97, held_out=33.0, sigma=23.0),
        RankedCandidate(effect="aero.Cm.speed", title="pitching moment changes with speed",
                  score=79.0 * misfit, evidence=0.03, held_out=20.0, sigma=18.0),
        RankedCandidate(effect="unnamed.Cm.alpha_de2", title="structure without a name", score=4.0,
                  evidence=1e-9, held_out=-1.0, sigma=3.0),
    )  # fmt: skip
    sizes = np.ones((maneuvers, len(COEFFICIENTS)))
    sizes[:, 2] += misfit * np.linspace(0.5, 1.5, maneuvers)
    gap = {name: 1.0 + (misfit - 1.0) * (name in ("q", "alpha")) for name in CHANNELS}
    return ModelStep(
        model=model, added=added, ranking=ranking, coefficient_map=sizes, gap=gap, misfit=misfit
    )


def _view(number: int, count: int, samples: int) -> ManeuverHistories:
    random = np.random.default_rng(number)
    times = 100.0 + 20.0 * number + 0.01 * np.arange(samples)
    throttle = np.where(times - times[0] > 2.0, 0.8, 0.3)
    conditions = {
        "alpha": 0.06 + 0.03 * np.sin(times), "beta": 0.01 * np.sin(2.0 * times),
        "V": 28.0 + 2.0 * np.sin(0.5 * times), "throttle": throttle,
        "de": 0.05 * np.sin(3.0 * times), "da": np.zeros(samples), "dr": np.zeros(samples),
    }  # fmt: skip
    measured = np.column_stack(
        [np.sin(times) * 20.0 * floor + random.normal(0.0, floor, samples)
         for floor in _FLOOR.values()]
    )  # fmt: skip
    measured[:20, 1] = np.nan
    smooth = np.column_stack([np.sin(times) * 20.0 * floor for floor in _FLOOR.values()])
    off = np.zeros_like(smooth)
    off[:, 1] = (throttle - 0.5) * 0.2
    noise = 0.002 * np.column_stack(
        [np.convolve(random.normal(0.0, 1.0, samples), np.ones(40) / 40.0, "same")
         for _ in COEFFICIENTS]
    )  # fmt: skip
    missing = [noise.copy() for _ in range(3)]
    missing[0][:, 2] += 0.03 * (throttle - 0.4)
    missing[1][:, 2] += 0.006 * np.sin(times)
    return ManeuverHistories(
        id=str(number + 1), flight="a flight", kind="doublet" if number % 2 else "3-2-1-1",
        held_out=number % 3 == 2, times=times, channels=CHANNELS, measured=measured,
        computed=(smooth + off, smooth + 0.3 * off, smooth), coefficients=COEFFICIENTS,
        missing=tuple(missing), noise_floor=dict(_FLOOR),
        coefficient_noise_floor=dict.fromkeys(COEFFICIENTS, 0.0008), conditions=conditions,
    )  # fmt: skip
