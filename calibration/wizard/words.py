"""The wizard's sentences: what to do, what happened; and the few words that are spoken."""

from __future__ import annotations

from calibration.plan import InstrumentPlan
from calibration.wizard.hand import Hint, Look
from calibration.wizard.schedule import Slot
from calibration.wizard.state import Taken


def sign_prompt(instrument: InstrumentPlan, hint: Hint) -> str:
    """Return how to prove the sign."""
    if hint == "against":
        return (
            f"The volts went against the certificate in force: is it {instrument.positive} now? "
            "Confirm, or move it the right way."
        )
    if hint == "little":
        return f"{instrument.positive_words}, farther, and hold it there."
    return f"{instrument.positive_words} and hold it there."


def sign_spoken(instrument: InstrumentPlan, hint: Hint) -> str:
    """Return the same in few words."""
    if hint == "against":
        return f"Against the certificate. Is it {instrument.positive}?"
    return f"{instrument.title}, {instrument.positive}"


def point_prompt(instrument: InstrumentPlan, slot: Slot, look: Look) -> str:
    """Return how to come to a setting, and what was wrong with where it rests."""
    goal = instrument.setting_words(slot.value)
    there, back = _ways(instrument, slot)
    if look.hint == "wrong_side":
        if slot.turns:
            return f"Past it: now come {back} to {goal} and hold."
        return f"Overshot: go back {there} past it, then {back} to {goal} and hold."
    if look.hint == "elsewhere" and look.value is not None:
        about = instrument.setting_words(round(look.value, 1))
        return f"It rests at about {about}: go on to {goal} and hold."
    if slot.direction == "single":
        return f"Set it to {goal} and hold."
    if slot.turns:
        return f"Go {there} past {goal}, come {back} to it and hold."
    return f"Go {back} to {goal} and hold."


def point_spoken(instrument: InstrumentPlan, slot: Slot, look: Look) -> str:
    """Return the setting as it is called out."""
    there, back = _ways(instrument, slot)
    side = ""
    if slot.value:
        side = f" {_last(instrument.positive if slot.value > 0.0 else instrument.negative)}"
    goal = f"{abs(slot.value):g}{side}" if slot.value else "Zero"
    if look.hint == "wrong_side":
        return f"Now {back} to {goal}" if slot.turns else f"Overshot. {there.title()}, then {back}"
    if look.hint == "elsewhere":
        return f"Not yet {goal}"
    if slot.turns and slot.direction != "single":
        return f"{there.title()} past {goal}, then back"
    return goal


def taken_words(instrument: InstrumentPlan, taken: Taken, slot: Slot, hint: Hint) -> str:
    """Return what was taken, and what is odd about it."""
    text = f"taken: {taken.volts:.3f} V at {instrument.setting_words(taken.value)}"
    if hint == "noisy":
        return f"{text}, noisy ({1e3 * taken.std:.0f} mV)"
    if hint == "unmoved":
        return f"{text}, though it did not move since the last step"
    if slot.direction not in ("single", taken.direction):
        return f"{text}, reached from the other side"
    return text


def _ways(instrument: InstrumentPlan, slot: Slot) -> tuple[str, str]:
    """Return the words for moving past a setting and for coming to it: ``up``, ``down``."""
    up, down = _last(instrument.negative), _last(instrument.positive)
    return (up, down) if slot.direction == "up" else (down, up)


def _last(words: str) -> str:
    return words.rpartition(" ")[2]
