"""Cases put to the program; answers kept by case, as long as program and cases stay the same."""

import hashlib
import json
import os
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np

import gsapp
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.foundation import GroundStationError
from tests.discrepancy.blind.cases import Case
from tests.discrepancy.blind.closing import closed_gap
from tests.discrepancy.blind.flying import fly_case
from tests.discrepancy.blind.judging import Named, Outcome, outcome_of
from tests.discrepancy.blind.sensitivity import with_sizes

ROOT = Path(gsapp.__file__).parents[1]


def fingerprint() -> str:
    digest = hashlib.sha256()
    folders = [ROOT / "gsapp" / one for one in ("discrepancy", "dynamics", "identification")]
    for folder in (*folders, Path(__file__).parent):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def answer(case: Case) -> Outcome:
    sized = with_sizes(case)
    flown = fly_case(sized)
    started = time.process_time()
    try:
        search = Investigation(flown.maneuvers, flown.aircraft, flown.model)
        found = search.run(DiscrepancySettings())
    except (GroundStationError, ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        spent = time.process_time() - started
        words = f"{type(error).__name__}: {error}"
        return Outcome(id=case.id, verdict="failed", cpu=spent, error=words)
    spent = time.process_time() - started
    return outcome_of(sized, found, closed=closed_gap(search, flown, found), cpu=spent)


def read(path: Path) -> Outcome:
    content = json.loads(path.read_text("utf-8"))
    content["named"] = tuple(Named(**one) for one in content["named"])
    for name in ("ranking", "values"):
        content[name] = tuple(content[name])
    content["open"] = tuple(tuple(one) for one in content["open"])
    return Outcome(**content)


def kept(case: Case, folder: Path) -> Outcome:
    path = folder / f"{case.id}.json"
    if path.exists():
        return read(path)
    found = answer(case)
    waiting = path.with_suffix(f".{os.getpid()}")
    waiting.write_text(json.dumps(asdict(found)), "utf-8")
    waiting.replace(path)
    return found
