"""An answer with known numbers, and an engine that gives it, for the tests of the page Model gap.

The arrays are made up; nothing here searches. `ui.gap` draws what it is given, and the tests look
whether it draws that.
"""

import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from gsapp.discrepancy.results import (
    Alternative,
    ChangedValue,
    ChannelGap,
    DecidingExperiment,
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
    UnexplainedStructure,
)
from gsapp.dynamics.model import Model
from gsapp.flight.cards import TestCard
from ui.gap.search_jobs import EffectInfo, GapJob, GapReportJob, GapRequest, SearchResult
from ui.job_process.job_server import JobProgressCallback

COEFFICIENTS = ("CX", "CY", "CZ", "Cl", "Cm", "Cn")
CHANNELS = ("alpha", "q", "an", "beta", "p", "r", "ay")
THROTTLE, BACKLASH, ALPHA2 = "propulsion.Cm.throttle", "control.elevator.backlash", "aero.Cm.alpha2"
TITLES = {
    THROTTLE: "Throttle pitches the aircraft",
    BACKLASH: "Slop in the elevator linkage",
    ALPHA2: "Pitching moment varies nonlinearly with angle of attack",
    "aero.Cm.alphadot": "Downwash lag at the tail",
    "aero.Cm.speed": "Pitching moment changes with speed",
}
FLOOR = {"alpha": 0.002, "q": 0.004, "an": 0.15, "beta": 0.002, "p": 0.006, "r": 0.004, "ay": 0.12}
_KINDS = ("de 3-2-1-1", "de doublet", "da doublet", "dr doublet", "de doublet", "da+dr doublet",
          "dr doublet", "de 3-2-1-1")  # fmt: skip


def _candidate(effect: str, score: float, evidence: float, sigma: float) -> RankedCandidate:
    return RankedCandidate(
        effect=effect, title=TITLES[effect], score=score, evidence=evidence, held_out=0.4 * score,
        sigma=sigma,
    )  # fmt: skip


def _view(place: int, count: int, steps: int) -> ManeuverHistories:
    generator = np.random.default_rng(place)
    start = 60.0 + 25.0 * place
    times = start + 0.02 * np.arange(count)
    swing = np.exp(-(times - start) / 3.0) * np.sin(2.2 * (times - start))
    scale = np.array([0.05, 0.3, 4.0, 0.04, 0.4, 0.2, 2.0])
    truth = swing[:, None] * scale * (1.0 if place % 4 in (0, 1) else 0.4)
    noise = generator.normal(size=truth.shape) * np.array([FLOOR[name] for name in CHANNELS])
    off = np.sin(0.8 * (times - start))[:, None] * scale * 0.25
    left = (1.0, 0.25, 0.04)[:steps]
    missing = np.zeros((count, 6))
    missing[:, 4] = 0.012 * np.sin(0.8 * (times - start))
    missing[:, 2] = 0.004 * swing
    noise_c = generator.normal(size=missing.shape) * 0.0012
    measured = truth + noise
    measured[10:14, 1] = np.nan
    return ManeuverHistories(
        id=str(place + 1), flight="trial", kind=_KINDS[place % len(_KINDS)].split()[-1],
        held_out=place in (1, 5), times=times, channels=CHANNELS, measured=measured,
        computed=tuple(truth - share * off for share in left),
        coefficients=COEFFICIENTS, missing=tuple(share * missing + noise_c for share in left),
        noise_floor=FLOOR, coefficient_noise_floor=dict.fromkeys(COEFFICIENTS, 0.0024),
        conditions={
            "alpha": 0.06 + 0.05 * swing, "beta": 0.04 * np.roll(swing, 9),
            "V": 28.0 + 2.0 * np.cos(0.4 * (times - start)),
            "throttle": 0.5 + 0.4 * np.sin(0.8 * (times - start)),
            "de": 0.08 * np.sign(swing),
        },
    )  # fmt: skip


def make_discrepancy(
    effects: tuple[str, ...] = (THROTTLE, BACKLASH),
    *,
    maneuvers: int = 8,
    verdict: str = "effects-found",
    forced: tuple[str, ...] = (),
) -> DiscrepancyResult:
    """Return an answer with an effect for each step after the baseline, some of them forced."""
    views = tuple(_view(place, 260, len(effects) + 1) for place in range(maneuvers))
    ranked = (
        _candidate(THROTTLE, 412.6, 0.97, 31.0), _candidate("aero.Cm.speed", 388.1, 0.02, 28.4),
        _candidate("aero.Cm.alphadot", 120.4, 0.007, 15.2),
        _candidate(BACKLASH, 61.0, 0.002, 11.0), _candidate(ALPHA2, 12.2, 0.001, 5.3),
    )  # fmt: skip
    base = Model(name="b777", derivatives={"Cm_alpha": -0.34, "Cm_q": -20.0, "Cn_da": 0.02})
    models = [base]
    for effect in effects:
        models.append(models[-1].with_effect(effect, name=f"{models[-1].name}+"))
    steps = []
    for place, model in enumerate(models):
        ratio = np.full((maneuvers, 6), 1.0) + 0.1 * np.arange(6)
        left = (1.0, 0.25, 0.0)[min(place, 2)]
        ratio[:, 4] += left * (2.0 + np.arange(maneuvers) * 1.9)
        ratio[:, 2] += left * 1.2
        steps.append(
            ModelStep(
                model=model,
                added=effects[place - 1] if place else "",
                ranking=tuple(c for c in ranked if c.effect not in effects[:place]),
                coefficient_map=ratio,
                gap={name: 1.0 + left * (6.0 - index) for index, name in enumerate(CHANNELS)},
                misfit=1.0 + 4.2 * left,
            )
        )
    found = tuple(
        FoundEffect(
            effect=effect, title=TITLES.get(effect, effect),
            equation="ΔCm = Cm_throttle · throttle · (1 − V/V0)" if place == 0 else "δe = stop(δ)",
            parameters={"Cm_throttle": (-0.0412, 0.0013)} if place == 0
            else {"gap": (0.0105, 0.0006)},
            confidence=0.97 - 0.08 * place, runner_up="aero.Cm.speed" if place == 0 else "",
            margin=24.5, held_out=131.2, forced=effect in forced,
        )
        for place, effect in enumerate(effects)
    )  # fmt: skip
    disagreements = tuple(
        Disagreement(
            coefficient="Cm", channel="q", maneuver=view.id, t_start=float(view.times[60]),
            t_end=float(view.times[170]), rms=0.0024 * (3.0 + place), noise_floor=0.0024,
            p_value=1e-9,
            region=FlightRegion(variable="throttle", low=0.7, high=1.0,
            words="throttle above 70 %"),
        )
        for place, view in reversed(list(enumerate(views)))
    )  # fmt: skip
    gaps = {
        name: ChannelGap(
            before=FLOOR[name] * steps[0].gap[name], after=FLOOR[name] * steps[-1].gap[name],
            floor=FLOOR[name], before_pct=12.4, after_pct=2.2, theil_before=0.213,
            theil_after=0.041, within_before=1.0, within_after=0.997,
        )
        for name in CHANNELS
    }  # fmt: skip
    unnamed = [name for name in effects if name.startswith("unnamed.")]
    beta = np.linspace(-0.1, 0.1, 9)
    structures = tuple(
        UnexplainedStructure(
            coefficient="CA", effects=(name,), equation="CA += (0.21 +-0.01) |beta|",
            variables=("beta",), nodes=(beta,), values=0.21 * np.abs(beta), flown=np.full(9, 0.1),
        )
        for name in unnamed
    )  # fmt: skip
    return DiscrepancyResult(
        verdict=verdict,  # type: ignore[arg-type]
        why="The pitching moment grows with throttle, most at low speed; with that effect in the "
        "model the maneuvers kept out agree to the noise.",
        disagreements=disagreements if effects else (),
        observability=(
            Observability(effect=THROTTLE, effect_class="A", sigma=31.0, sigma_size=0.0013,
                          aliases=(("aero.Cm.speed", 0.93),),
                          fly="throttle steps at two speeds, sticks still"),
            Observability(effect=ALPHA2, effect_class="A", sigma=7.0, sigma_size=0.2),
            Observability(effect="aero.Cm.alphadot", effect_class="A", sigma=1.4, sigma_size=3.0,
                          fly="elevator doublets twice as fast"),
        ),
        steps=tuple(steps), effects=found,
        values={"Cm_q": ChangedValue(before=-20.0, after=-22.6, std=0.42)} if effects else {},
        alternatives=(
            Alternative(effects=("mass.cg.x",), title="Center of gravity farther aft",
                        why="It rescales Cm_alpha in the same way.",
                        fly="weigh nose and main wheels"),
        ),
        disturbance={"gust": 0.12, "gust_std": 0.03},
        gap=Gap(channels=gaps, closed=0.94 if effects else None,
                closed_std=0.03 if effects else None, on=("2", "6")),
        maneuvers=views, coefficients=COEFFICIENTS, channels=CHANNELS,
        instruments=(InstrumentRemark(channel="ay", words="a_y agrees.", consistent=True),),
        structures=structures,
    )  # fmt: skip


def make_open(found: DiscrepancyResult) -> DiscrepancyResult:
    """Return an answer that leaves open which of two effects it is, with what decides."""
    card = TestCard(
        id="X1", speed="30 m/s", surfaces=("de",), amplitude="3 deg", width="0.4 s",
    )  # fmt: skip
    experiment = DecidingExperiment(
        purpose="separate", effects=(THROTTLE, "aero.Cm.speed"),
        titles=(TITLES[THROTTLE], TITLES["aero.Cm.speed"]), cards=(card,), separation=6.2,
        target=5.0,
    )  # fmt: skip
    return replace(found, verdict="ambiguous", experiment=experiment)


NOTES = {
    name: EffectInfo(
        effect=name, title=title, equation="ΔCm = …",
        mistaken_for=("aero.Cm.speed",) if name != "aero.Cm.speed" else (THROTTLE,),
        distinguished_by="throttle steps at constant speed", units={"gap": "rad"},
    )
    for name, title in TITLES.items()
}  # fmt: skip


class FakeEngine:
    """Gives the made-up answer: refused effects are left out, forced ones come first.

    While `hold` is cleared, a job goes on until it is stopped; `fails` is raised in its place.
    """

    def __init__(self, effects: tuple[str, ...] = (THROTTLE, BACKLASH)) -> None:
        self.effects = effects
        self.jobs: list[GapJob] = []
        self.hold = threading.Event()
        self.hold.set()
        self.fails: Exception | None = None
        self.closed = False

    def do(self, job: GapJob, tell: JobProgressCallback) -> SearchResult | Path:
        self.jobs.append(job)
        tell(0.25, "looking at maneuver 3")
        while not self.hold.is_set():
            tell(0.5, "weighing the candidates")
            time.sleep(0.01)
        if self.fails is not None:
            raise self.fails
        if isinstance(job, GapReportJob):
            job.path.write_text("report", encoding="utf-8")
            return job.path
        return make_answer(job, self.effects)

    def close(self) -> None:
        self.closed = True


def make_answer(
    request: GapRequest | None = None,
    effects: tuple[str, ...] = (THROTTLE, BACKLASH),
) -> SearchResult:
    request = request or GapRequest(flights=(Path("trial"),), model="b777")
    proven = tuple(e for e in effects if e not in (*request.refused, *request.forced))
    return SearchResult(
        request=request,
        discrepancy=make_discrepancy(
            (*request.forced, *proven),
            forced=request.forced,
            verdict="effects-found" if proven or request.forced else "model-adequate",
        ),
        effect_infos=NOTES,
        kinds={str(index + 1): kind for index, kind in enumerate(_KINDS)},
        remarks=("maneuver 9 is left out: too little excitation",),
    )
