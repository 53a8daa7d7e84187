"""A wizard that is killed loses nothing: every place, every byte of the journal."""

import json
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import calibration.certificate_store
from calibration import CalibrationError, load_certificates
from calibration.certificate_store import CertificateStore
from calibration.wizard import CalibrationWizard, has_unfinished_calibration
from calibration.wizard.journal import Journal
from tests.calibration.wizard.wizard_kit import SMALL, Field, Operator

DOUBLE = SMALL.select_channels(["elevator_left"])


def run(crew: Operator) -> None:
    crew.until(lambda now: len(now.points) == 2)
    crew.press("undo")
    crew.until(lambda now: now.phase == "fit")
    crew.press("repeat")
    crew.until(lambda now: now.phase == "fit")
    crew.press("choose_degree", degree=2)
    crew.press("accept")
    crew.press("skip", reason="wire broken")
    crew.press("undo")
    crew.press("undo")
    crew.press("accept")


def told(wizard: CalibrationWizard) -> object:
    view = wizard.view
    return (
        view.phase,
        view.instrument,
        view.points,
        view.remaining,
        view.degree,
        view.accepted,
        view.skipped,
        {name: one.stamp for name, one in view.certificates.items()},
    )


def in_force(field: Field) -> dict[str, object]:
    store = field.store
    stamps: dict[str, object] = {name: one.stamp for name, one in store.in_force().items()}
    folder = store.in_force_folder
    if stamps:
        assert {name: one.stamp for name, one in load_certificates(folder).items()} == stamps
    else:
        assert not list(folder.glob("*.toml"))
    return {**stamps, **{name: one.reason for name, one in store.skipped_channels().items()}}


def test_killed_at_any_place_it_goes_on_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk as it is before and after each write: resumed, state and certificates are whole.

    What a killed process leaves on the disk is what was written until then. So the disk is copied
    at every place between two writes, and a wizard resumed from each copy.
    """
    field = Field(tmp_path / "work")
    places: list[tuple[Path, int]] = []
    steps = 0

    def copy() -> None:
        place = tmp_path / f"killed-{len(places)}"
        shutil.copytree(tmp_path / "work", place)
        places.append((place, steps))

    def spied(function: Callable[..., object], *, is_step: bool = False) -> Callable[..., object]:
        def spy(*arguments: object, **named: object) -> object:
            nonlocal steps
            copy()
            result = function(*arguments, **named)
            steps += is_step
            copy()
            return result

        return spy

    crew = field.begin()
    monkeypatch.setattr(Journal, "append", spied(Journal.append, is_step=True))
    for name in ("write_certificate", "write_toml", "write_atomically"):
        monkeypatch.setattr(
            calibration.certificate_store, name, spied(getattr(calibration.certificate_store, name))
        )
    expected = [(told(crew.wizard), in_force(field))]
    make = crew.wizard._ledger.execute

    def watched(step: object) -> None:
        make(step)  # type: ignore[arg-type]
        expected.append((None, in_force(field)))

    monkeypatch.setattr(crew.wizard._ledger, "execute", watched)
    feed, act = crew.wizard.feed, crew.wizard.act

    def note(call: Callable[..., None]) -> Callable[..., None]:
        def noted(argument: object) -> None:
            call(argument)
            expected[-1] = (told(crew.wizard), expected[-1][1])

        return noted

    crew.wizard.feed, crew.wizard.act = note(feed), note(act)  # type: ignore[method-assign]
    run(crew)
    monkeypatch.undo()
    assert steps == len(expected) - 1 == 18
    assert len(places) > 2 * steps
    for place, done in places:
        killed = Field(place)
        open_ended = has_unfinished_calibration(killed.journal)
        wizard = killed.resume().wizard
        assert open_ended == (wizard.phase != "done")
        assert (told(wizard), in_force(killed)) == expected[done], (place, done)


@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
@pytest.mark.parametrize("kill_at", [1, 9])
def test_a_process_that_dies_loses_nothing(tmp_path: Path, kill_at: int) -> None:
    """A real process ends without a farewell; the next one ends up with the same certificate."""
    child = os.fork()
    if child == 0:
        try:
            crew = Field(tmp_path, DOUBLE).begin()
            steps = 0
            append = Journal.append

            def dying(self: Journal, step: object) -> None:
                nonlocal steps
                append(self, step)  # type: ignore[arg-type]
                steps += 1
                if steps == kill_at:
                    os._exit(9)

            Journal.append = dying  # type: ignore[method-assign, assignment]
            crew.until(lambda now: now.phase == "done")
        finally:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9
    field = Field(tmp_path, DOUBLE)
    lines = field.journal.read_bytes().splitlines()
    assert len(lines) == 1 + kill_at
    crew = field.resume()
    kept = crew.wizard.view.points
    crew.bench.angle["elevator_left"] = -24.0
    if crew.wizard.view.phase == "fit":
        crew.press("accept")
    view = crew.until(lambda now: now.phase == "done")
    certificate = field.store.in_force()["elevator_left"]
    for before, after in zip(kept, certificate.points, strict=False):
        assert (before.value, before.direction) == (after.value, after.direction)
        assert before.volts == pytest.approx(after.volts, abs=1e-3)
    assert view.certificates.keys() == {"elevator_left"}


def test_a_journal_cut_at_every_byte_keeps_every_whole_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("calibration.wizard.journal.flush_to_disk", lambda _: None)
    field = Field(tmp_path / "whole", DOUBLE)
    crew = field.begin()
    crew.until(lambda now: len(now.points) == 3)
    data = field.journal.read_bytes()
    steps = Journal(field.journal).read()
    assert len(steps) == 6
    path = tmp_path / "torn.jsonl"
    # Every byte of the last line; those before are made alike.
    dense = data[:-1].rindex(b"\n")
    for cut in (*range(0, dense, 50), *range(dense, len(data) + 1)):
        path.write_bytes(data[:cut])
        whole = data[:cut].count(b"\n")
        assert Journal(path).recover() == steps[:whole]
        torn = data[:cut].rpartition(b"\n")[2]
        assert path.with_name("torn.jsonl.damaged").exists() == bool(torn)
        path.with_name("torn.jsonl.damaged").unlink(missing_ok=True)
        if whole and cut % 10 == 0:
            Journal(path).append(steps[-1])
            assert Journal(path).read() == (*steps[:whole], steps[-1])
        if not torn:
            assert has_unfinished_calibration(path) == (whole > 0)


def test_damage_within_a_journal_ends_it_there_and_is_kept(tmp_path: Path) -> None:
    field = Field(tmp_path, DOUBLE)
    field.begin().until(lambda now: len(now.points) == 3)
    lines = field.journal.read_bytes().splitlines(keepends=True)
    lines[4] = lines[4].replace(b'"', b"\xff", 3)
    field.journal.write_bytes(b"".join(lines))
    view = field.resume().wizard.view
    assert (view.phase, len(view.points)) == ("points", 1)
    assert field.journal.with_name("wizard.jsonl.damaged").read_bytes() == b"".join(lines)
    assert field.journal.read_bytes() == b"".join(lines[:4])


def test_a_new_calibration_keeps_the_former_journal(tmp_path: Path) -> None:
    field = Field(tmp_path, DOUBLE)
    field.begin().until(lambda now: len(now.points) == 1)
    content = field.journal.read_bytes()
    field.begin()
    assert [path.read_bytes() for path in tmp_path.glob("wizard-*.jsonl")] == [content]
    assert len(Journal(field.journal).read()) == 1


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "contains no unfinished calibration"),
        (
            [{"step": "point", "channel": "", "stamp": "2026-05-12T08:00:00"}],
            "no unfinished calibration",
        ),
        ([{"step": "calibration", "channel": "", "stamp": "2026-05-12T08:00:00"}], "version"),
    ],
)
def test_what_is_no_journal_says_so(tmp_path: Path, lines: list[object], words: str) -> None:
    path = tmp_path / "other.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    assert not has_unfinished_calibration(path)
    with pytest.raises(CalibrationError, match=words):
        CalibrationWizard.resume(
            path, CertificateStore(tmp_path, "small"), now=Field(tmp_path).clock
        )


def test_a_full_disk_makes_no_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A step that cannot be written did not happen; once there is room it is made."""
    crew = Field(tmp_path, DOUBLE).begin()
    crew.until(lambda now: len(now.points) == 1)

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("calibration.wizard.journal.flush_to_disk", full)
        with pytest.raises(CalibrationError, match="No space left"):
            crew.press("delete")
        assert len(crew.wizard.view.points) == 1
    assert len(Field(tmp_path, DOUBLE).resume().wizard.view.points) == 1
    assert len(crew.press("delete").points) == 0


def test_certificates_that_cannot_be_written_are_written_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    field = Field(tmp_path, DOUBLE)
    crew = field.begin()
    crew.until(lambda now: now.phase == "fit")

    def full(*arguments: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(calibration.certificate_store, "write_certificate", full)
        with pytest.raises(CalibrationError, match="disk"):
            crew.press("accept")
        with pytest.raises(CalibrationError, match="disk"):
            crew.wait(0.2)
    assert field.store.in_force() == {}
    crew.wait(0.2)
    assert set(field.store.in_force()) == {"elevator_left"}
