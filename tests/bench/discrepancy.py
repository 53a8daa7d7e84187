"""Blind cases: what was hidden in flights, and what the program made of them.

Truth is flown by JSBSim (`tests/discrepancy/blind`); the program gets flights, aircraft file and
baseline model. Sizes are in standard deviations that an effect shows once the baseline's own
parameters are projected out. Hours of CPU; results are kept by case and taken up again as long as
neither the program nor the cases change. With ``--quick`` a stratified tenth.

Alone: ``python tests/bench/discrepancy.py [--quick] [--tune] [--only TEXT] [--processes N]``;
``--tune`` takes the seeds that are never reported. ``GSAPP_BLIND_CACHE`` names the folder. Set
OPENBLAS_NUM_THREADS=1.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.discrepancy.blind.answering import fingerprint, kept
from tests.discrepancy.blind.cases import (
    Case,
    Series,
    airframe_cases,
    all_cases,
    tenth,
    virtual_cases,
)
from tests.discrepancy.blind.judging import Marks, Outcome, judge
from tests.discrepancy.blind.sensitivity import cache_folder, with_sizes

PROCESSES = 2
STRONG = 10.0
FEW = 100
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    case: Case
    outcome: Outcome
    marks: Marks


def run(cases: Sequence[Case], processes: int) -> list[Row]:
    """Answer all cases, several at a time."""
    folder = cache_folder() / "answers" / fingerprint()
    folder.mkdir(parents=True, exist_ok=True)
    print(f"{len(cases)} cases; answers in {folder}", flush=True)
    # Those of one plan and one air after another: what a process knows of them it keeps.
    ordered = sorted(cases, key=lambda one: (one.plan, str(one.recording), one.id))
    outcomes: dict[str, Outcome] = {}
    started = time.monotonic()
    with ProcessPoolExecutor(max_workers=processes) as pool:
        waiting = {pool.submit(kept, case, folder): case for case in ordered}
        for count, done in enumerate(as_completed(waiting), start=1):
            outcomes[waiting[done].id] = done.result()
            if count % 25 == 0:
                spent = time.monotonic() - started
                print(f"  {count} of {len(cases)}, {spent:.0f} s", flush=True)
    rows = []
    for case in cases:
        sized = with_sizes(case)
        outcome = outcomes[case.id]
        rows.append(Row(case=sized, outcome=outcome, marks=judge(sized, outcome)))
    return rows


# --- what is printed -----------------------------------------------------------------------------


def share(values: Iterable[bool | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{100.0 * sum(known) / len(known):5.1f} %/{len(known):<4}" if known else "     -     "


def middle(values: Iterable[float | None], scale: float = 100.0) -> str:
    known = [value for value in values if value is not None]
    return f"{scale * float(np.median(known)):7.1f}" if known else "      -"


COLUMNS: Mapping[str, Callable[[Sequence[Row]], str]] = {
    "first": lambda rows: share(row.marks.first for row in rows),
    "first or": lambda rows: share(row.marks.first_or_ambiguous for row in rows),
    "in three": lambda rows: share(row.marks.three for row in rows),
    "false name": lambda rows: share(row.marks.false_name for row in rows),
    "coefficient": lambda rows: share(row.marks.coefficient for row in rows),
    "maneuver": lambda rows: share(row.marks.maneuver for row in rows),
    "covered": lambda rows: share(row.marks.covered for row in rows),
    "closed %": lambda rows: middle(row.marks.closed for row in rows),
    "size off %": lambda rows: middle(row.marks.size_error for row in rows),
}


def table(title: str, rows: Sequence[Row], key: Callable[[Row], str]) -> None:
    print(f"\n{title}")
    print(f"{'':30}" + "".join(f"{name:>13}" for name in COLUMNS))
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    for name, group in groups.items():
        print(f"{name:30}" + "".join(f"{text(group):>13}" for text in COLUMNS.values()))


def print_hidden(rows: Sequence[Row]) -> None:
    """Print how effects were named: overall, by effect, size and air."""
    given = [row for row in rows if row.case.airframe]
    if given:
        table("beside another aircraft's own kinks, sizes as given", given, lambda _: "all")
        table("by effect", given, lambda row: row.case.kind)
    strong = [row for row in rows if row.case.sigma >= STRONG]
    if not strong:
        return
    print("\n'first or': named first, or listed among effects said not to be told apart")
    table("one effect of 10 sigma and more (asked: first 95, three 99 %)", strong, lambda _: "all")
    table("by size", rows, lambda row: f"{row.case.sigma:g} sigma")
    table("by air, 10 sigma and more", strong, lambda row: row.case.air)
    table("by baseline, 10 sigma and more", strong, lambda row: row.case.baseline)
    table(
        "by recorder, 10 sigma and more",
        strong,
        lambda row: (
            f"noise x{row.case.noise:g} {'colored' if row.case.colored else 'white'} "
            f"{row.case.rate} Hz"
        ),
    )
    table("by effect, 10 sigma and more", strong, lambda row: row.case.kind)
    said = [row for row in rows if row.marks.ambiguity is not None]
    print(f"\nsaid not to be told apart: {len(said)} of {len(rows)}")
    print(f"  the truth among them   {share(row.marks.ambiguity for row in said)}")
    print(f"  truly not to be told   {share(row.marks.deserved for row in said)}")


def print_nothing(rows: Sequence[Row]) -> None:
    """Print false names where nothing is hidden."""
    if not rows:
        return
    print("\nnothing hidden (asked: false names at most 0.5 %)")
    print(f"{'':30}{'right verdict':>15}{'false name':>13}   verdicts")
    groups: dict[str, list[Row]] = {"all": list(rows)}
    for row in rows:
        groups.setdefault(row.case.kind, []).append(row)
    for name, group in groups.items():
        verdicts: dict[str, int] = {}
        for row in group:
            verdicts[row.outcome.verdict] = verdicts.get(row.outcome.verdict, 0) + 1
        right = share(row.marks.verdict for row in group)
        false = share(row.marks.false_name for row in group)
        text = ", ".join(f"{key} {count}" for key, count in sorted(verdicts.items()))
        print(f"{name:30}{right:>15}{false:>13}   {text}")
    for gust in (0.1, 0.3, 1.0):
        said = [row.outcome.gust for row in rows if row.case.gust == gust]
        if said:
            print(f"  gusts of {gust:g} m/s: said {np.median(said):.2f} m/s (median)")


def print_outside(rows: Sequence[Row]) -> None:
    if not rows:
        return
    print("\noutside the catalog (asked: abstention 95 %)")
    groups: dict[str, list[Row]] = {"all": list(rows)}
    for row in rows:
        groups.setdefault(row.case.kind, []).append(row)
    for name, group in groups.items():
        taken: dict[str, int] = {}
        for row in group:
            for one in row.outcome.named:
                taken[one.effect] = taken.get(one.effect, 0) + 1
        text = ", ".join(f"{key} {count}" for key, count in taken.items()) or "nothing"
        print(f"{name:30}{share(row.marks.abstained for row in group):>13}   named: {text}")


def print_confidence(rows: Sequence[Row]) -> None:
    said = [pair for row in rows for pair in row.marks.confidences]
    print("\nconfidence: said, right, names")
    for low, high in pairwise(BINS):
        inside = [
            pair for pair in said if low <= pair[0] < high or (high == 1.0 and pair[0] == 1.0)
        ]
        if inside:
            mean = float(np.mean([pair[0] for pair in inside]))
            right = float(np.mean([pair[1] for pair in inside]))
            print(f"  {100.0 * mean:5.1f} %  {100.0 * right:5.1f} %  {len(inside)}")


def report(rows: Sequence[Row]) -> None:
    """Print everything."""
    of = {
        group: [row for row in rows if row.case.group == group]
        for group in ("hidden", "nothing", "outside", "pair")
    }
    print_hidden(of["hidden"])
    print_nothing(of["nothing"])
    print_outside(of["outside"])
    if of["pair"]:
        table("two and three effects, all named", of["pair"], lambda row: row.case.kind)
        table("two and three effects, all", of["pair"], lambda _: "all")
    print_confidence(rows)
    spent = [row.outcome.cpu for row in rows]
    print(f"\nCPU s a case: median {np.median(spent):.1f}, worst {max(spent):.1f} (asked: 10)")
    failed = [row.outcome for row in rows if row.outcome.verdict == "failed"]
    for outcome in failed:
        print(f"failed: {outcome.id}: {outcome.error}")


def main(*arguments: str) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(prog="discrepancy")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--tune", action="store_true", help="seeds that are never reported")
    parser.add_argument("--only", default="", help="cases whose id holds this")
    parser.add_argument("--processes", type=int, default=PROCESSES)
    chosen = parser.parse_args(arguments)
    series: Series = "tune" if chosen.tune else "report"
    flown = {
        "truth flown by JSBSim: these rows decide": all_cases(series),
        "truth flown by the program's own equations": virtual_cases(series),
        "aerodynamics of JSBSim's own aircraft, with kinks of their own": airframe_cases(series),
    }
    for title, cases in flown.items():
        taken = tenth(cases) if chosen.quick and len(cases) > FEW else cases
        taken = tuple(case for case in taken if chosen.only in case.id)
        if taken:
            print(f"\n{title}{', seeds to tune on' if chosen.tune else ''}")
            report(run(taken, chosen.processes))


if __name__ == "__main__":
    main(*sys.argv[1:])
