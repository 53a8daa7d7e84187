"""`CueGenerator`: all watches of a flight, joined."""

from __future__ import annotations

import bisect
from collections import deque
from collections.abc import Iterable, Sequence

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.alerts.alert import Alert
from gsapp.excitation.alerts.alert_monitor import AlertMonitor
from gsapp.excitation.alerts.geofence import Geofence
from gsapp.excitation.announcer import Announcement, Announcer
from gsapp.excitation.cueing.card_selector import CardSelector, assign_card, input_duration
from gsapp.excitation.cueing.estimation_progress import EstimationProgress
from gsapp.excitation.cues import CueEvent, CueLog, CueSnapshot
from gsapp.excitation.debrief import EvaluatedManeuver, extract_curves
from gsapp.excitation.doublets.doublet_monitor import DoubletMonitor
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.flight_rows import FlightRows, FlightRowStream, RecentRows, mask_implausible
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.settings import CUES
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.excitation.trim.trim_monitor import TrimMonitor
from gsapp.flight.cards import CardSet, CardSetProgress
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean, join_names
from gsapp.quantities import SURFACE_NAMES, Block, channel

NO_AIRCRAFT = "no aircraft file: stall, sensor ranges and stick shares are not known"
NO_MODEL = "no model: inputs are judged by the card and by their shape, bounds are not predicted"
NO_CARDS = "no test cards: any speed is a test point"


def list_limitations(
    aircraft: Aircraft | None,
    model: Model | None,
    *,
    has_cards: bool,
    trim: TrimCue | None,
    dangers: Sequence[Alert] = (),
    outlook: Outlook | None = None,
    unseen: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return what cannot be judged, the gravest first; `unseen` are surfaces that nothing shows."""
    found: list[str] = []
    doubted = dict.fromkeys(name for danger in dangers for name in danger.channels)
    if doubted:
        found.append(f"ignored: {', '.join(channel(name).title for name in doubted)}")
    if unseen:
        text = join_names([SURFACE_NAMES[name] for name in unseen])
        found.append(f"inputs of {text}: the surface is not measured")
    found += [] if trim is None else trim.limitations
    found += [NO_AIRCRAFT] if aircraft is None else []
    found += [NO_MODEL] if model is None else []
    found += [] if has_cards else [NO_CARDS]
    found += [] if outlook is None else outlook.remarks
    return _without_duplicates(found)


def _without_duplicates(words: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(words))


class TrimHistory:
    """Keeps one cue for each tick."""

    def __init__(self) -> None:
        self._cues: deque[TrimCue] = deque(maxlen=round(CUES.cue_retention / CUES.tick))

    def clear(self) -> None:
        self._cues.clear()

    def add(self, cue: TrimCue) -> None:
        self._cues.append(cue)

    def deviations_at(self, time: float) -> dict[str, float]:
        """Return what was off at a flight time (s), in tolerances, signed."""
        before = [cue for cue in self._cues if cue.time <= time]
        if not before:
            return {}
        return {
            off.quantity: off.tolerance_ratio if off.amount > 0.0 else -off.tolerance_ratio
            for off in before[-1].deviations
        }

    def go_before(self, time: float) -> float | None:
        """Return when the GO was given that an input at a flight time (s) answers to."""
        for cue in reversed(self._cues):
            if cue.time <= time:
                if cue.state == "go":
                    return cue.since
                if cue.time < time - CUES.go_memory:
                    return None
        return None


class CueGenerator:
    """Tells the crew of a flight as it comes in: trimmed? go; how was that input; what next.

    It is a consumer of a session's feed. Rows are judged tick by tick of flight time, and what one
    watch says to another takes effect with the next tick, so that what comes out depends on the
    samples alone: a live flight, its replay and a headless run give the same.

    Without an aircraft cues go by the usual figures for one of this size, and say so; without a
    model nothing is known of wanted amplitudes beyond the cards, nor of bounds. `announcements` are
    all that was to be heard so far, by flight time, and `maneuvers` all inputs judged, for the
    debrief; `reset` alone takes something away.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        model: Model | None,
        rate: float,
        *,
        cards: CardSet | None = None,
        fence: Geofence | None = None,
        system: str = "US",
    ) -> None:
        self._aircraft = aircraft
        self._model = model
        self._rate = rate
        self._stream = FlightRowStream(rate)
        self._card_selector = CardSelector(aircraft, model, cards, system)
        self._trim = TrimMonitor(aircraft, rate)
        self._dangers = AlertMonitor(aircraft, rate, fence=fence or Geofence(), system=system)
        self._doublets = DoubletMonitor(
            aircraft, rate, model=model, wanted_for=self._card_selector.target_for, system=system
        )
        self._lessons = EstimationProgress(aircraft, model, rate, system)
        self._announcer = Announcer(system)
        self._changes = CueLog(system)
        self._recent = RecentRows()
        self._trims = TrimHistory()
        self._choices: list[tuple[float, str]] = []
        self._forget()

    def _forget(self) -> None:
        self._time: float | None = None
        self._verdicts: list[InputVerdict] = []
        self._chosen = 0  # how many choices were applied
        self._announced_count = 0  # of events
        self._noisy = False  # whether the noise of the day is known
        self._doubted: dict[str, float] = {}  # when each channel was last not believed, s
        self.announcements: list[Announcement] = []
        self.maneuvers: list[EvaluatedManeuver] = []
        self._aim()

    # --- the consumer of a feed -----------------------------------------------------------------

    def feed(self, block: Block) -> None:
        for rows in self._stream.feed(mask_implausible(block)):
            self._take(rows)

    def process_step(self) -> None:
        ticks = 0
        for rows in self._stream.take_complete_rows():
            self._take(rows)
            ticks += len(rows) // self._stream.tick
        # Live, what was just judged is to be told at once; the look ahead has the steps between.
        if not ticks or ticks > CUES.replay_ticks:
            self._lessons.run_slice()

    def has_pending_work(self, time: float) -> bool:
        """Return whether a look ahead is unfinished that is shown by a flight time, s.

        Each `process_step` goes on with it by a slice; what is not done by then is done at once.
        """
        return self._lessons.has_pending_work(time)

    def finish(self) -> None:
        """Judge what was held back: nothing more comes."""
        for rows in self._stream.finish():
            self._take(rows)
        self._doublets.finish()
        self._conclude()

    def reset(self) -> None:
        self._stream.restart()
        for part in (self._trim, self._dangers, self._doublets, self._card_selector, self._lessons):
            part.restart()
        self._announcer.restart()
        self._changes.restart()
        self._recent.clear()
        self._trims.clear()
        self._forget()

    # --- what the crew does ---------------------------------------------------------------------

    def select_card(self, card_id: str, *, at: float | None = None) -> float:
        """Let the crew's choice of a card count until that card is flown; an empty one ends it.

        It counts from the flight time `at`, by default from now on; returns that time.
        """
        if card_id and (self.cards is None or self.cards.card(card_id) is None):
            known = [] if self.cards is None else [card.id for card in self.cards.cards]
            hint = did_you_mean(card_id, known, "choose one of the flight's cards")
            raise UnknownNameError(f"no test card '{card_id}'; {hint}")
        # Between the tick that was judged last and the next, which is the first to know of it.
        now = 0.0 if self._time is None else self._time + 0.5 * CUES.tick
        time = now if at is None else at
        # Those applied stay as they are: what was said cannot be unsaid.
        index = bisect.bisect_right(self._choices, time, lo=self._chosen, key=lambda one: one[0])
        self._choices.insert(index, (time, card_id))
        return time

    def use_cards(self, cards: CardSet | None) -> None:
        """Take other test cards; what was flown so far counts for them."""
        self._choices.clear()
        self._chosen = 0
        self._card_selector.use_cards(cards)
        self._card_selector.update_progress(self._verdicts)
        self._card_selector.update_selection(self._lessons.outlook)
        self._aim()

    def use_units(self, system: str) -> None:
        """Say everything from now on in these units, ``US`` or ``SI``; the log stays as it is."""
        self._changes.system = self._announcer.system = system
        self._doublets.system = self._dangers.system = system
        self._card_selector.use_units(system)
        self._lessons.use_units(system)
        if self._doublets.input_in_progress is None and self._card_selector.update_selection(
            self._lessons.outlook, stay=True
        ):
            self._aim()

    # --- what it tells --------------------------------------------------------------------------

    @property
    def log(self) -> Sequence[CueEvent]:
        """Return all that changed so far, by flight time; `reset` alone takes something away."""
        return self._changes.events

    @property
    def verdicts(self) -> tuple[InputVerdict, ...]:
        return tuple(self._verdicts)

    @property
    def cards(self) -> CardSet | None:
        return self._card_selector.cards

    @property
    def card_progress(self) -> CardSetProgress | None:
        """Return how the test cards stand; None without cards."""
        return self._card_selector.card_progress

    def snapshot(self) -> CueSnapshot:
        """Return what is to be told now."""
        trim, dangers, outlook = self._trim.cue, self._dangers.active_alerts, self._lessons.outlook
        speed, alpha = (self._shown(name) for name in ("V", "alpha"))
        progress = () if self.card_progress is None else self.card_progress.cards
        return CueSnapshot(
            time=self._time,
            trim=trim,
            input_in_progress=self._doublets.input_in_progress,
            verdict=self._verdicts[-1] if self._verdicts else None,
            card=self._card_selector.next_card,
            outlook=outlook,
            alerts=dangers,
            speed=speed,
            alpha=alpha,
            guidance=self._card_selector.guidance_text(speed, alpha),
            judged_by=() if trim is None else trim.judged_by,
            limitations=list_limitations(
                self._aircraft,
                self._model,
                has_cards=self.cards is not None,
                trim=trim,
                dangers=dangers,
                outlook=outlook,
                unseen=self._doublets.unmeasured_surfaces,
            ),
            unmeasured_surfaces=self._doublets.unmeasured_surfaces,
            good_repeats=sum(min(one.good_count, one.card.repeats) for one in progress),
            requested_repeats=sum(one.card.repeats for one in progress),
            event_count=len(self._changes.events),
        )

    def _shown(self, channel: str) -> float | None:
        doubted = channel in self._dangers.invalid_channels
        return None if doubted else self._recent.mean(channel, CUES.display_averaging)

    # --- ticks ----------------------------------------------------------------------------------

    def _take(self, rows: FlightRows) -> None:
        tick = self._stream.tick
        # A stretch may end within a tick, of which nothing can be said.
        for start in range(0, len(rows) - tick + 1, tick):
            self._tick(rows.slice_rows(start, start + tick))

    def _tick(self, rows: FlightRows) -> None:
        time = float(rows.times[-1])
        self._time = time
        self._recent.add(rows)
        self._dangers.process_rows(rows)
        distrusted = self._dangers.invalid_channels
        self._doubted.update(dict.fromkeys(distrusted, time))
        self._trim.set_invalid_channels(distrusted)
        self._doublets.set_invalid_channels(distrusted)
        self._trim.process_rows(rows)
        self._doublets.process_rows(rows)
        believed = rows.mask_channels(distrusted)
        self._card_selector.process_rows(believed)
        if self._lessons.process_rows(believed):
            self._card_selector.set_estimates(self._lessons.estimates)
        if not self._noisy and (noise := self._doublets.noise):
            self._noisy = True
            self._card_selector.set_noise(noise)
        under_way = self._doublets.input_in_progress
        if under_way is not None:
            self._trim.inhibit_go(time + under_way.hands_off_left + CUES.go_delay)
        self._note(time, under_way)
        self._conclude()
        self._choose(time, under_way)
        self._announce(time, moving=under_way is not None and under_way.phase == "moving")

    def _conclude(self) -> None:
        for verdict in self._doublets.verdicts[len(self._verdicts) :]:
            self._judge(verdict)

    def _note(self, time: float, under_way: InputInProgress | None) -> None:
        cue = self._trim.cue
        self._changes.log_alerts(time, self._dangers.active_alerts)
        if cue is not None:
            self._trims.add(cue)
            self._changes.log_trim(cue)
        self._changes.log_input(time, under_way)

    def _judge(self, verdict: InputVerdict) -> None:
        """Take in a verdict: its card, what it brought, what the debrief shows of it."""
        self._verdicts.append(verdict)
        self._card_selector.update_progress(self._verdicts)
        if self._card_selector.card_progress is not None:
            verdict = assign_card(verdict, self._card_selector.card_progress)
            self._verdicts[-1] = verdict
        rows = self._recent.segment(verdict.t_start, verdict.t_end)
        go_at = self._trims.go_before(verdict.t_input)
        self.maneuvers.append(
            EvaluatedManeuver(
                verdict=verdict,
                target_input=self._card_selector.target_of(verdict),
                point=self._card_selector.point_of(verdict),
                go_at=go_at,
                trim_deviations=self._trims.deviations_at(verdict.t_input),
                curves=extract_curves(rows, verdict.surfaces, self._rate),
            )
        )
        card = None if self.cards is None else self.cards.card(verdict.card)
        doubted = [name for name, when in self._doubted.items() if when >= verdict.t_start]
        self._lessons.add_maneuver(verdict, self._recent, card, self.card_progress, doubted)
        self._changes.log_verdict(verdict, go_at)

    def _choose(self, time: float, under_way: InputInProgress | None) -> None:
        """Settle which card is to be flown; not while an input is under way."""
        for at, card_id in self._choices[self._chosen :]:
            if at <= time:
                self._card_selector.select_card(card_id)
                self._chosen += 1
        settled = self._lessons.update_outlook(time, self.card_progress)
        if under_way is None and self._card_selector.update_selection(
            self._lessons.outlook, stay=not settled
        ):
            self._aim()
        self._changes.log_card(
            time,
            self._card_selector.next_card,
            all_done=bool(self.card_progress and self.card_progress.is_complete),
        )

    def _aim(self) -> None:
        now = self._card_selector.next_card
        point, wanted, card = (now.point, now.target_input, now.card) if now else (None, None, None)
        self._trim.set_test_point(point)
        self._trim.require_leg_time(input_duration(wanted))
        self._doublets.expect(wanted, point, card)

    def _announce(self, time: float, *, moving: bool) -> None:
        events = self._changes.events
        fresh, self._announced_count = events[self._announced_count :], len(events)
        self.announcements += self._announcer.update(
            time, fresh, self._trim.cue, self._dangers.active_alerts, moving=moving
        )
