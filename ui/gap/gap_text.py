"""What the page says: verdicts, confidence, coefficients, effects and numbers in words. No Qt."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

from gsapp.discrepancy.results import (
    DiscrepancyResult,
    FlightRegion,
    FoundEffect,
    ManeuverHistories,
)
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.foundation import UnknownNameError
from gsapp.quantities import (
    SURFACE_NAMES,
    ChannelSpec,
    channel,
    convert_text_units,
    convert_value_and_std,
)
from ui.gap.search_jobs import SearchResult
from ui.icons import IndicatorState
from ui.number_format import (
    DASH,
    MINUS,
    clock_text,
    count_text,
    number_text,
    percent_text,
    symbol_text,
    unit_text,
    value_with_std_text,
)
from ui.translation import QT_TR_NOOP, tr

_VERDICT_STATES: Mapping[str, IndicatorState] = {
    "effects-found": "caution",
    "values-wrong": "caution",
    "model-adequate": "good",
    "ambiguous": "unknown",
    "unexplained": "warning",
    "not-observable": "unknown",
}
_CONFIDENCE = (
    (0.90, QT_TR_NOOP("very likely")),
    (0.80, QT_TR_NOOP("likely")),
    (0.50, QT_TR_NOOP("more likely than not")),
    (0.0, QT_TR_NOOP("a guess")),
)
_OBSERVABILITY_TEXTS = (
    (10.0, QT_TR_NOOP("clearly")),
    (5.0, QT_TR_NOOP("well enough")),
    (3.0, QT_TR_NOOP("barely")),
    (-math.inf, QT_TR_NOOP("too little")),
)


def coefficient_text(name: str) -> str:
    """Return ``Cm, pitching moment``."""
    text = COEFFICIENT_TITLES.get(name)
    return f"{name}, {text}" if text else name


def verdict_state(found: DiscrepancyResult) -> IndicatorState:
    """Return the state that a verdict is shown as."""
    return _VERDICT_STATES.get(found.verdict, "plain")


def verdict_text(result: SearchResult) -> str:
    """Return the verdict as a headline."""
    found = result.discrepancy
    titles = [effect.title for effect in found.effects if effect.named]
    if found.verdict == "effects-found" and len(titles) == 1:
        return tr("One effect is missing: {title}").format(title=titles[0])
    headlines = {
        "effects-found": tr("{count} effects are missing").format(count=_count_text(len(titles))),
        "values-wrong": tr("No effect is missing; {values} must change").format(
            values=count_text(len(found.values), "value")
        ),
        "model-adequate": tr("No effect is missing: model and flight agree within the noise"),
        "ambiguous": tr("An effect is missing; these flights cannot tell which"),
        "unexplained": tr("An effect is missing that is not in the catalog"),
        "not-observable": tr("These flights cannot show the missing effect"),
    }
    return headlines.get(found.verdict, found.verdict)


def _count_text(count: int) -> str:
    words = (tr("No"), tr("One"), tr("Two"), tr("Three"), tr("Four"), tr("Five"), tr("Six"))
    return words[count] if count < len(words) else str(count)


def confidence_text(probability: float) -> str:
    """Return ``very likely: right in 97 of 100 cases``."""
    if not math.isfinite(probability):
        return tr("confidence unknown")
    text = tr(next(word for bound, word in _CONFIDENCE if probability >= bound))
    # Never a certainty: no number of flights earns it.
    share = min(max(round(100 * probability), 1), 99)
    return tr("{words}: right in {share} of 100 such cases").format(words=text, share=share)


def effect_confidence_text(result: SearchResult, effect: FoundEffect) -> str:
    """Return how sure an effect is, or what it cannot be told from."""
    others = [f"“{result.title(name)}”" for name in effect.one_of if name != effect.effect]
    if others:
        return tr("these flights cannot tell it from {others}").format(others=", ".join(others))
    if not effect.named:
        return tr("found, not understood: the catalog has no effect like it")
    return confidence_text(effect.confidence)


def observability_text(sigma: float) -> str:
    """Return how well an effect of plausible size would show: ``12 σ, clearly``."""
    if not math.isfinite(sigma):
        return DASH
    text = tr(next(word for bound, word in _OBSERVABILITY_TEXTS if sigma >= bound))
    return f"{sigma_text(sigma)}, {text}"


def sigma_text(sigma: float) -> str:
    """Return ``0.4 σ``, ``12 σ``."""
    if not math.isfinite(sigma):
        return DASH
    return f"{number_text(sigma, 1 if abs(sigma) < 9.95 else 0)} σ"


def noise_ratio_text(ratio: float) -> str:
    """Return a ratio to the noise floor: ``1.0``, ``3.4``, ``12``, ``140``."""
    if not math.isfinite(ratio):
        return DASH
    return number_text(ratio, 1 if ratio < 9.95 else 0)


def signed_number_text(value: float, decimals: int) -> str:
    """Return a number with its sign."""
    if math.isfinite(value) and abs(value) >= 99.95:
        # Who has hundreds does not look at tenths.
        text = f"{abs(value):,.0f}"
        return f"+{text}" if value > 0 else f"{MINUS}{text}"
    text = number_text(value, decimals)
    return f"+{text}" if value > 0 and set(text) - set("0.") else text


def parameter_text(value: float, std: float, unit: str, system: str) -> str:
    """Return a parameter with its standard deviation in the units of the screen."""
    value, std, unit = convert_value_and_std(value, std, unit, system)
    return f"{value_with_std_text(value, std)} {unit_text(unit)}".rstrip()


def find_channel_spec(name: str) -> ChannelSpec | None:
    """Return what is known of a channel; None for a name of no channel."""
    try:
        return channel(name)
    except UnknownNameError:
        return None


def channel_text(name: str) -> str:
    """Return a channel as the axis says it: ``α, angle of attack``."""
    spec = find_channel_spec(name)
    if spec is None:
        return name
    symbol = symbol_text(spec.symbol)
    title = spec.title[:1].lower() + spec.title[1:]
    return title if symbol.lower() == title else f"{symbol}, {title}"


def channel_symbol(name: str) -> str:
    """Return the symbol of a channel."""
    spec = find_channel_spec(name)
    return symbol_text(spec.symbol) if spec is not None else name


def axis_unit(name: str, system: str) -> str:
    """Return the unit in which a channel is shown."""
    spec = find_channel_spec(name)
    return unit_text(spec.display_unit(system)) if spec is not None else ""


def maneuver_kind_text(kind: str) -> str:
    """Return the kind of a maneuver in words: ``elevator doublet`` stays, ``de`` is spelled."""
    text = re.split(r"(\W+)", kind.strip())
    return "".join(SURFACE_NAMES.get(word, word) for word in text) or tr("maneuver")


def maneuver_text(result: SearchResult, view: ManeuverHistories, *, clock: bool = True) -> str:
    """Return one maneuver in a list: ``3 · elevator doublet · 02:18.4 · kept out``."""
    parts = [view.id, maneuver_kind_text(result.kinds.get(view.id, view.kind))]
    if clock and view.times.size:
        parts.append(clock_text(float(view.times[0]), decimals=1))
    if view.held_out:
        # Where there is no room for everything, this matters more than the kind.
        parts.insert(len(parts) if clock else 1, tr("held out"))
    return " · ".join(parts)


def region_text(region: FlightRegion | None, system: str) -> str:
    """Return where a disagreement grows; empty where it does so nowhere in particular."""
    return convert_text_units(region.words, system) if region is not None else ""


def p_value_text(p_value: float) -> str:
    """Return the chance that noise alone did it: ``chance 1 in 3,000``."""
    if not math.isfinite(p_value):
        return ""
    if p_value <= 0.0 or p_value < 1e-6:
        return tr("chance below 1 in a million")
    if p_value < 0.095:
        count = 1.0 / p_value
        digits = 10 ** max(math.floor(math.log10(count)) - 1, 0)
        return tr("chance 1 in {count:,.0f}").format(count=round(count / digits) * digits)
    return tr("chance {p_value}").format(p_value=percent_text(p_value))


def gap_closed_text(closed: float | None, std: float | None) -> str:
    """Return ``94 ± 3 % of the gap is closed``."""
    if closed is None:
        return tr("The gap is too small to tell which share is closed")
    if std is None:
        return tr("{closed} % of the gap is closed").format(closed=number_text(100 * closed, 0))
    decimals = 0 if 100 * std >= 0.95 else 1
    return tr("{closed} ± {std} % of the gap is closed").format(
        closed=number_text(100 * closed, decimals), std=number_text(100 * std, decimals)
    )


def join_with_and(words: Iterable[str]) -> str:
    """Return ``a, b and c``."""
    listed = list(words)
    if len(listed) < 2:
        return "".join(listed)
    return tr("{names} and {last}").format(names=", ".join(listed[:-1]), last=listed[-1])
