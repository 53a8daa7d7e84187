"""Settings of a search for a missing effect: options of ``gsapp discrepancy``, form, report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import Names, OptionalNames, setting
from gsapp.foundation.translation import QT_TR_NOOP
from gsapp.quantities.constants import DEGREE


class SearchStoppedError(GroundStationError):
    """The user stopped the search; nothing was written."""


class DiscrepancySettings(ManeuverSettings):
    """What a user can choose of one search."""

    # fmt: off
    model: str = setting(
        "", QT_TR_NOOP("Current model"),
        QT_TR_NOOP("Model to test: a file, or the name of a shipped one; default: fitted linear "
                   "build-up. Its values are trusted."),
        option="--model", metavar="FILE")
    refused: Names = setting(
        (), QT_TR_NOOP("Refused"),
        QT_TR_NOOP("Never name this effect."),
        option="--refuse", metavar="ID", is_repeatable=True)
    forced: Names = setting(
        (), QT_TR_NOOP("Forced"),
        QT_TR_NOOP("Add this effect regardless of evidence. Several: in this order."),
        option="--force", metavar="ID", is_repeatable=True)
    held_out: OptionalNames = setting(
        None, QT_TR_NOOP("Held out"),
        QT_TR_NOOP("Hold out this maneuver; default: one of each kind, about a quarter. It takes "
                   "no part in naming and fitting."),
        option="--held-out", metavar="MANEUVER", is_repeatable=True)
    most_effects: int = setting(
        8, QT_TR_NOOP("Most effects"),
        QT_TR_NOOP("Maximum number of effects."),
        option="--most-effects", metavar="N", ge=0)
    tables: bool = setting(
        False, QT_TR_NOOP("As tables"),
        QT_TR_NOOP("Keep structure without a name in the model as tables over what was flown, not "
                   "as products."),
        option="--tables")
    check_instruments: bool = setting(
        False, QT_TR_NOOP("Check instruments"),
        QT_TR_NOOP("Compare instruments by kinematics, even where the model explains the flights: "
                   "seconds, ten of them with colored noise."))
    false_alarm: float = setting(
        0.001, QT_TR_NOOP("Chance of a false name"),
        QT_TR_NOOP("Chance of naming anything where nothing is missing, over all places and "
                   "candidates."))
    # fmt: on


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchProgress:
    """How far a search has come: share done (0 to 1) and what it is doing."""

    share: float
    activity: str


SearchProgressCallback = Callable[[SearchProgress], bool | None]
"""Called often; returning False stops the search with `SearchStoppedError`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DiscrepancyAlgorithmSettings:
    """Engineering choices, tuned and checked by `tests/bench/discrepancy.py`."""

    # Before the search.
    min_maneuvers: int = 4  # Maneuvers: three to learn from and one to judge by.
    max_checked_maneuvers: int = 6  # Instrument errors are common to all maneuvers.
    max_check_iterations: int = 8  # Gauss-Newton steps of the check.
    max_level_error: float = 0.5  # Of the normal force: share that a model may be off.
    response_ratio_range: tuple[float, float] = (0.55, 1.8)
    """Of computed to measured response, where the level is off by more: a vane may be mounted
    askew, or show far too much."""

    # Candidates.
    trial_backlashes: tuple[float, ...] = (0.06 * DEGREE, 0.3 * DEGREE, 1.0 * DEGREE, 3.0 * DEGREE)
    """Widths of play that are tried, rad: the least larger than noise of a potentiometer."""
    trial_limit_shares: tuple[float, ...] = (0.85, 0.65, 0.45)
    """Limits of deflection and rate that are tried, of the most that was recorded."""
    trial_share_range: tuple[float, float] = (0.3, 3.0)
    """Share of an effect tried at one size that the flights may show, to count for it."""
    trial_distance: float = 1e-3  # m by which a vane is moved; what it shows is linear in that.
    shape_parameter_cost: float = 2.0
    """Of the gain, for each parameter of its shape that an effect moves (H. Akaike, A new look at
    the statistical model identification, IEEE Trans. Autom. Control 19, 1974)."""
    mode_frequencies: tuple[float, float, float, float] = (3.0, 4.5, 6.7, 10.0)
    """Hz: structural modes at the accelerometers."""
    mode_damping: float = 0.15  # Damping ratio of these modes: reaches their neighbors too.

    # Search.
    max_passes: int = 5  # Of the fit of the current model: two before its noise is known.
    max_unexplained_share: float = 0.15  # Of its gain that a name may leave to the unnamed.
    min_equivalence_cosine: float = 0.95  # From it two effects explain the same.
    max_effects_per_target: int = 3  # So many names for one coefficient are none.
    max_rest_gain: float = 0.7  # Of the gain of a name: more is no rest of the same thing.
    reversal_tolerance: float = 0.15  # A scale this near to -1 is a reversed axis.
    max_unnamed_terms: int = 3  # Terms without a name that a coefficient takes.
    min_rest_share: float = 0.02
    """Of the largest gain of the effects found: structure without a name that gains less is how
    these differ from their form in the catalog."""
    min_name_share: float = 0.01  # The same of an effect that the catalog names.
    max_rests: int = 8  # Rests that are set aside; with more, the search ends.
    min_unnamed_sigmas: float = 3.0  # Size of a term without a name that a later name leaves.
    effect_passes: int = 4  # Passes of a fit with an effect more.
    unnamed_passes: int = 2  # The same where the effect is a term without a name.
    max_contenders: int = 3  # Candidates that are fitted fully before a name is said ...
    max_contender_gap: float = 16.0  # ... within this gain of the best.
    sign_check_misfit: float = 1.2  # Mean square of innovations for a check of signs first ...
    sign_check_ranks: int = 5  # ... where an instrument is among so many first candidates.
    min_gain_share: float = 0.25
    """Of the gain that its column promises: the full fit of an effect must show as much, unless
    chance does not reach it; far from neutral, columns promise too much."""
    max_passes_far_start: int = 12  # Of a fit that starts from reversed instruments.

    # Names.
    unnamed_effect_prior: float = 0.03  # Of each unnamed product over a catalog effect.
    min_catalog_probability: float = 0.8  # Of the catalog as a whole, to name any of it.
    min_effect_probability: float = 0.95  # Share of that, to name one effect, not a set.
    lag_delay_factor: float = 0.37
    """Weight of a difference in gain between a lag and a delay of one signal: the filter knows
    only in part how turbulence and a noisy control show through either. A gain of 16, four
    deviations, makes a name."""
    credible_set_mass: float = 0.95  # Probability that the set of alternatives holds together.
    max_confidence: float = 0.95  # The cause may be in no catalog and look like one that is.

    # Disagreements.
    window: float = 1.0  # Length of the stretch that is pointed out, s.
    min_samples: int = 10  # Samples that a disagreement takes.
    max_disagreements: int = 30  # Disagreements that are listed.

    # Maneuvers held out.
    cutoff: float = 3.0  # Of the smoothing, Hz: above the modes of the aircraft.
    noise_samples: int = 4000  # Random numbers that tell what smoothing leaves of noise.
    linearization_passes: int = 2  # Linearizations about the motion under a new model.
    still_air_intensity: float = 1e-12  # Turbulence with which the filter only simulates.
    min_gap_sigmas: float = 3.0  # Size of a gap of which a share can be told.
    floor_ratio: float = 3.0  # Times the noise floor within which a model explains a sample.

    # Experiment that decides.
    experiment_separation: float = 5.0
    """Standard deviations wanted. The log-likelihood ratio then is 12.5 +-5: in 95 % of flights
    above the 3 that make a name."""
    experiment_max_maneuvers: int = 6  # That count; more than a flight for it are not planned.
    experiment_min_gain: float = 0.5  # Separation (sigmas) that an experiment must add.
    experiment_refined_cards: int = 3  # Cards of which other shapes and sizes are tried.
    experiment_amplitudes: tuple[float, ...] = (0.4, 0.8)
    """Of the largest that limits of aircraft, sensors and linear model allow."""
    experiment_speeds: int = 3  # Over the envelope ...
    experiment_speed_reach: float = 1.15  # ... and no farther from speeds flown than this ratio.
    experiment_stall_margin: float = 1.1  # Slowest speed over that of level flight.
    experiment_flap_share: float = 0.5  # Of its travel.
    experiment_thrust_step: float = 0.1
    """Of the weight, by which a step of the throttle changes the thrust: after some seconds without
    hands the aircraft is a few m/s faster or slower, and climbs or sinks a little."""
    experiment_throttle_range: tuple[float, float] = (0.1, 0.95)
    experiment_hands_off: float = 4.0  # After the input, s.
    experiment_speed_step: float = 0.5  # m/s to which speeds of cards are rounded ...
    experiment_amplitude_step: float = 0.5 * DEGREE  # ... and rad, amplitudes.

    # Result.
    cg_tolerance: float = 2.0  # mm: no search would see a smaller shift.
    change_significance: float = 0.003  # Chance of reporting values that did not change.
    min_relative_change: float = 0.01  # Smaller changes are within any model's accuracy.
    min_pattern_share: float = 0.9  # Of all changes together that one mass property must explain.
    min_alias_cosine: float = 0.7  # Cosine from which an effect is listed as an alias.
    max_aliases: int = 4  # Aliases that are listed.
    visible_sigma: float = 5.0  # Deviations from which an effect of usual size is visible.
    strong_gain_ratio: float = 3.0  # Times the threshold: chance does not explain it.
    contradiction_sigmas: float = 2.5  # Below expectation on maneuvers held out.
    max_ranked: int = 12  # Candidates of a ranking that are told.
    min_observable_share: float = 0.1  # Of the catalog, to call a model adequate.
    min_gust_rms: float = 0.05  # Turbulence below this (m/s) is still air.


SEARCH: Final = DiscrepancyAlgorithmSettings()
