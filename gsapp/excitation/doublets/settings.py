"""Settings of recognizing inputs in flight and of the verdicts on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class DoubletSettings:
    """Engineering choices, tuned and checked by `tests/bench/verdicts.py`."""

    # Recognizing an input.
    history_retention: float = 40.0
    """Seconds that are surely kept: an input may take ten, its answer six."""
    airborne_at_start: float = 1.5
    """A stretch that flies so soon after its beginning, s, did not take off in it."""
    landing_height: float = 8.0
    """Height above where it stood, m, below which the sticks are busy with the landing."""
    ground_altitude_frames: int = 8
    """Frames on the ground whose median altitude is that of the field."""
    continuation_after_target: float = 1.0
    """Seconds for which the sticks may go on moving after an input that was expected and whole."""
    recovery_time: float = 4.0
    """Seconds after a verdict in which the pilot recovers, and only unmistakable inputs are any."""
    max_start_bank: float = 32.0 * DEGREE
    """Bank in which nobody begins an input: what moves the sticks there rolls out of a turn."""
    step_gap: float = 0.05  # Seconds without a quick move between two steps.
    min_relative_size: float = 0.5
    """Of what went before it that an input reaches at least: a part of a larger one is none."""
    release_time: float = 0.15
    """Seconds without a quick move after which an input is over, if the surfaces are back."""
    release_time_expected: float = 0.6
    """The same while a surface that is expected has not moved yet."""
    continuation_time: float = 0.7  # A quick move so soon after an input, s, goes on with it.
    max_duration: float = 10.0  # An input that goes on for longer, s, is steering.
    hands_off_other: float = 1.05
    """Seconds without a stick after which an input of an unusual shape is believed."""
    returned_share: float = 0.4
    """Share of its excursion that a surface may be away from trim and be back."""
    displaced_share: float = 0.25
    """Share of its amplitude from which a surface was not brought back, and looks like another
    shape about the line between its trims."""
    second_side_share: float = 0.35
    """Share of the larger excursion from which the smaller one is the other half of a doublet."""
    rest_interval: tuple[float, float] = (0.4, 0.1)
    """Seconds before the end of an input between which a surface is at rest that is no more part of
    it."""
    rest_movement: float = 0.3 * DEGREE  # What a surface at rest moves at most, rad ...
    stick_movement: float = 0.6 * DEGREE  # ... and what it moves by when a hand is put on, rad.
    last_step_time: float = 0.8
    """Seconds after which an input that ends away from trim is over, once both sides were seen."""
    max_unrest_other: float = 0.15
    """Unrest before an input of another shape than expected, as a share of its amplitude, so that
    it is taken for the one expected ..."""
    max_unrest_expected: float = 0.25
    """The same of the shape that was expected, which is then an input whatever follows."""
    certain_step_ratio_one_side: float = 2.0
    """... and its quickest move over the threshold for that, to one side alone ..."""
    certain_step_ratio: float = 1.3  # ... and to both.

    # Measuring an input.
    edge_search: float = 0.3  # Seconds before and after an input in which its edges are looked for.
    pre_input_time: float = 2.5
    """Seconds before an input that are looked at; the second of trim is the last of them."""
    bank_history: float = 12.0
    """Seconds before an input from which bank is followed where no attitude tells it."""
    min_secondary_movement: float = 0.5 * DEGREE
    """Motion of another surface that has an answer of its own."""
    initial_state_time: float = 0.15  # Seconds that tell in which state the input began.
    default_gusts: float = 0.3  # Gusts assumed where none were measured, m/s.
    rest_after_input: tuple[float, float] = (0.1, 0.6)
    """Seconds after an input between which its surface shows where it was left."""

    # Parting an answer into what the sticks and what gusts did.
    gust_step: float = 0.05
    """Seconds over which samples are averaged, and in which the air shifts by one push."""
    gust_iterations: int = 6  # Of answer and strengths, each from the other.
    initial_gust: float = 0.1 * DEGREE
    """What a push is taken for at first, rad: gusts of half a meter a second."""
    min_gust: float = 0.001 * DEGREE  # rad; below it the air is still.
    min_noise_share: float = 0.02
    """Share of a channel's answer that its noise is at least: no model follows it more closely."""
    gain_std: float = 0.4  # Of the gains about one: how far control derivatives are off.
    max_trim_offset: float = 1.0 * DEGREE
    """What a surface may stand away from the trim of level flight as an input begins, rad: a stick
    that is held makes a steady roll, which is no gust."""
    effect_state_std: float = 1.0
    """Of a state that an effect of the model has of its own, in its unit: nothing is known of
    it."""
    speed_step: float = 1.0  # Small motions are found once for each so many m/s ...
    density_step: float = 0.02
    """... and of air so dense, kg/m^3: 2 % change no answer that one sees."""
    min_response_samples: int = 50  # Of an answer; fewer tell nothing about it.

    # The verdict.
    min_symmetry: float = 0.6
    """Smaller over larger half of a doublet, by area, below which it is told; it counts, though."""
    trim_tolerance_factor: float = 2.0
    """Times the tolerances of GO within which a start still counts."""
    max_cross_input: float = 0.35
    """Share of the main input, both as shares of travel, from which another stick spoils it."""
    max_residual_deflection: float = 0.4
    """Share of its amplitude that a surface may stay away from its trim."""
    min_hands_off_share: float = 0.5
    """Share of the wanted hands-off interval that is enough: one period of the oscillation."""
    max_gust_fraction: float = 0.5  # Share of the answer that gusts may make.
    min_time_out_of_range: float = 0.1  # Seconds out of the linear range that count.
    min_sample_share: float = 0.8  # Share of the samples that must be there.
    min_cross_input: float = 0.5 * DEGREE
    """rad; another surface that moves less spoils nothing, however small the main input was."""
    min_clipped_time: float = 0.03  # Seconds at the end of a sensor's range that count.
    max_gust_ratio: float = 3.0
    """What the model takes for gusts counts up to so many times the unrest before the input: a
    model that is wrong finds as many in calm air. Gusts are slow, and within two seconds most of
    them are hidden in a straight line."""
    max_unrest: float = 0.6
    """Unrest before the input over its answer that counts for gusts where no model tells more; the
    grader calls it a large defect."""
    reduction: float = 0.75
    """Advice after an answer that was too large, where no band tells better."""
    min_change: float = 1.1
    """A size that was wrong is to change by this factor at least: *the same* is no advice, even
    where the best size lies at the very end of the band that was left."""


DOUBLETS: Final = DoubletSettings()
