"""Settings of recognizing inputs in flight and of the verdicts on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class DoubletSettings:
    """Engineering choices, tuned and checked by `tests/bench/verdicts.py`."""

    # Recognizing an input.
    history_retention: float = 40.0  # s: an input may take ten, its response six.
    airborne_at_start: float = 1.5  # s: flying so soon means no take-off in the record.
    landing_height: float = 8.0  # m above the ground: lower, the sticks are landing.
    ground_altitude_frames: int = 8  # Frames on the ground whose median is its altitude.
    continuation_after_target: float = 1.0  # s that sticks may move after the expected input.
    recovery_time: float = 4.0  # s after a verdict: only unmistakable inputs count.
    max_start_bank: float = 32.0 * DEGREE  # rad: beyond it, sticks only roll out of a turn.
    step_gap: float = 0.05  # Seconds without a quick move between two steps.
    min_relative_size: float = 0.5  # Of the motion before: less is a part of a larger input.
    release_time: float = 0.15  # s without a quick move: an input is over.
    release_time_expected: float = 0.6  # The same until an expected surface moved.
    continuation_time: float = 0.7  # A quick move so soon after an input, s, goes on with it.
    max_duration: float = 10.0  # An input that goes on for longer, s, is steering.
    hands_off_other: float = 1.05  # s without sticks after an input of unusual shape.
    returned_share: float = 0.4  # Of the excursion: nearer to trim, the surface is back.
    displaced_share: float = 0.25
    """Of the amplitude: farther, the surface was not brought back, and the input looks like
    another shape about the line between its trims."""
    second_side_share: float = 0.35  # Of the larger side, to be a half of a doublet.
    rest_interval: tuple[float, float] = (0.4, 0.1)  # s before the end of an input: rest after it.
    rest_movement: float = 0.3 * DEGREE  # What a surface at rest moves at most, rad ...
    stick_movement: float = 0.6 * DEGREE  # ... and what it moves by when a hand is put on, rad.
    last_step_time: float = 0.8  # s after which an input that ends off trim is over.
    max_unrest_other: float = 0.15
    """Motion before an input of another shape than expected, as a share of its amplitude, for it
    to be taken as the expected one ..."""
    max_unrest_expected: float = 0.25  # ... and before one of the expected shape.
    certain_step_ratio_one_side: float = 2.0  # Its quickest move over the threshold, one side ...
    certain_step_ratio: float = 1.3  # ... and to both.

    # Measuring an input.
    edge_search: float = 0.3  # Seconds before and after an input in which its edges are looked for.
    pre_input_time: float = 2.5  # s before an input that are examined, trim included.
    bank_history: float = 12.0  # s of bank followed where no attitude is measured.
    initial_state_time: float = 0.15  # Seconds that tell in which state the input began.
    default_gusts: float = 0.3  # Gusts assumed where none were measured, m/s.

    # Parting an answer into what the sticks and what gusts did.
    gust_step: float = 0.05  # s: averaging of samples, and one step of the gust.
    gust_iterations: int = 6  # Of answer and strengths, each from the other.
    initial_gust: float = 0.1 * DEGREE  # Of a step, rad: gusts of half a meter a second.
    min_gust: float = 0.001 * DEGREE  # rad; below it the air is still.
    min_noise_share: float = 0.02  # Of the response: no model follows it more closely.
    gain_std: float = 0.4  # Of the gains about one: how far control derivatives are off.
    max_trim_offset: float = 1.0 * DEGREE
    """rad, of a surface from trim as an input begins: a stick that is held makes a steady roll,
    which is no gust."""
    effect_state_std: float = 1.0  # Of an effect's own state, in its unit: unknown.
    speed_step: float = 1.0  # Small motions are found once for each so many m/s ...
    density_step: float = 0.02  # ... and kg/m^3: 2 % change no response visibly.
    min_response_samples: int = 50  # Of an answer; fewer tell nothing about it.

    # The verdict.
    min_symmetry: float = 0.6  # Of a doublet's halves by area; reported, yet it counts.
    reduction: float = 0.75  # Advised after a response that was too large without a band.
    min_change: float = 1.1
    """Least factor by which a wrong size is to change: *the same* is no advice, even where the
    best size lies at the end of the band."""


DOUBLETS: Final = DoubletSettings()
