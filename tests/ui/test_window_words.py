"""Numbers, times and sizes as the crew reads them; keys and choices without a window."""

import ast
import errno
import math
import re
from datetime import date
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ui.commands
import ui.settings
from gsapp.foundation import FlightError
from gsapp.quantities import CHANNELS, channel
from gsapp.session.user_limit_store import UserLimitStore
from gsapp.telemetry.link_registry import parse_link
from ui.commands import COMMANDS
from ui.dialogs.flight_requests import check_folder, check_link, next_flight_name
from ui.flight.chart_layouts import LayoutStore
from ui.flight.chart_selection import (
    OVERVIEW_LAYOUT,
    SHIPPED_LAYOUT_NAMES,
    build_layout,
    create_shipped_layout,
    group_channels,
    list_layout_rows,
    matches_search,
    move_row,
    toggle_channel,
)
from ui.flight.controls import REPLAY_SPEEDS, next_speed
from ui.number_format import (
    DASH,
    bytes_text,
    channel_value_text,
    clock_text,
    duration_text,
    join_sentences,
    number_text,
    parse_clock,
    percent_text,
    plain_shortcut_text,
    sanitize_file_name,
    time_span_text,
)
from ui.settings import Settings, SettingsStore, layouts_path, limits_path, writable_folder
from ui.strips.chart_painter import visible_time_text
from ui.strips.strip_view import StripView


def test_a_missing_number_is_a_dash_and_never_a_number() -> None:
    for text in (
        number_text(math.nan, 1),
        clock_text(None),
        bytes_text(math.nan),
        duration_text(math.inf),
        percent_text(None),
        channel_value_text(channel("alpha"), math.nan, "US"),
        channel_value_text(channel("alpha"), None, "US"),
    ):
        assert text == DASH


def test_values_have_their_unit_and_no_more_digits_than_the_sensor_earns() -> None:
    assert channel_value_text(channel("alpha"), math.radians(-3.14159), "US") == "−3.1 °"
    assert channel_value_text(channel("V"), 30.48, "US") == "100.0 ft/s"
    assert channel_value_text(channel("V"), 30.48, "SI") == "30.5 m/s"
    assert channel_value_text(channel("an"), -9.80665, "SI", unit=False) == "−1.00"
    assert number_text(-0.001, 1) == "0.0"


@given(st.floats(0.0, 36_000.0))
@settings(max_examples=50, deadline=None)
def test_a_time_that_is_written_is_read_back(seconds: float) -> None:
    read = parse_clock(clock_text(seconds, decimals=1))
    assert 0.0 <= seconds - read < 0.1 + 1e-6 or abs(seconds - read) < 1e-6


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("247", 247.0), ("4:07.5", 247.5), ("1:00:00", 3600.0), ("0:61", None), ("x", None),
     ("", None), ("-3", None), ("1:2:3:4", None), ("4,5", 4.5)],
)  # fmt: skip
def test_times_as_typed(text: str, seconds: float | None) -> None:
    assert parse_clock(text) == seconds


def test_sizes_keep_three_digits() -> None:
    assert [bytes_text(size) for size in (0, 950, 12_400, 3_021_000, 118e9)] == [
        "0 B", "950 B", "12.4 kB", "3.02 MB", "118 GB",
    ]  # fmt: skip


def test_a_time_in_sight_is_said_as_it_was_chosen() -> None:
    assert [time_span_text(window) for window in (0.5, 30.0, 60.0, 90.0, 600.0, 7200.0)] == [
        "0.5 s", "30 s", "1 min", "1.5 min", "10 min", "2 h",
    ]  # fmt: skip
    for width, seconds in ((900, 60.0), (640, 120.0), (1000, 10.0), (700, 10.0)):
        view = StripView(width=width, window=seconds)
        assert visible_time_text(view) == f"{time_span_text(seconds)} shown"
        assert view.seconds == pytest.approx(seconds)


def test_remarks_become_sentences() -> None:
    said = join_sentences(["no link", "", "2 frames lost."])
    assert said == "No link. 2 frames lost."


def test_a_name_keeps_its_letters_at_the_beginning_of_a_sentence() -> None:
    for said in ("garbage.tlog holds nothing", "logs/a: empty", "first_flight: no clock",
                 "f16 has no map", "q was not calibrated", "q.2 is silent"):  # fmt: skip
        assert join_sentences([said]) == f"{said}."
    assert (
        join_sentences(["a gap of 2.5 s", "nothing is left"]) == "A gap of 2.5 s. Nothing is left."
    )


_REVIEW_PAGES = {
    **dict.fromkeys(
        ("review_flights", "review_flight", "review_maneuver", "review_part", "review_open"),
        "maneuvers",
    ),
    **dict.fromkeys(("review_panel", "review_ready", "review_run"), "estimate"),
    **dict.fromkeys(("review_figure", "review_picture", "review_point"), "figures"),
    **dict.fromkeys(("review_results", "review_written"), "summary"),
}
"""Page of the review whose commands need this; the others serve on all of its pages."""


def _place(needs: str) -> str:
    if needs in ("search", "review_busy"):
        # One key stops whichever work is on screen; the window sees to it.
        return f"running {needs}"
    if needs.startswith("review"):
        return f"review {_REVIEW_PAGES.get(needs, '')}"
    if needs in ("preflight", "checklist", "checklist_ticked", "cards", "card"):
        return "preflight"
    if needs.startswith(("gap", "pilot")):
        return needs.partition("_")[0]
    return "flight" if needs == "charts" else ""


def test_no_key_has_two_meanings_and_every_command_can_be_found() -> None:
    meanings: dict[str, list[str]] = {}
    for command in COMMANDS:
        for key in command.shortcuts:
            meanings.setdefault(key, []).append(_place(command.requirement))
    # A key may serve several places, of which one is on screen; everywhere means everywhere.
    for key, places in meanings.items():
        assert len(places) == len(set(places)), key
        assert "" not in places or len(places) == 1, key
        # What serves on all pages of the review leaves no key to one of them.
        of_review = [place for place in places if place.startswith("review")]
        assert "review " not in of_review or len(of_review) == 1, key
    assert len({command.id for command in COMMANDS}) == len(COMMANDS)
    assert all(command.text and command.menu for command in COMMANDS)


def test_speeds_step_through_the_list_and_stay_at_its_ends() -> None:
    assert next_speed(1.0, 1) == 2.0
    assert next_speed(0.1, -1) == 0.1
    assert next_speed(50.0, 1) == REPLAY_SPEEDS[-1] == next_speed(REPLAY_SPEEDS[-1], 1)
    assert next_speed(REPLAY_SPEEDS[-1], -1) == 50.0


# Charts


def test_overview_has_sixteen_charts_and_other_layouts_only_what_the_flight_has() -> None:
    assert len(create_shipped_layout(OVERVIEW_LAYOUT, tuple(CHANNELS)).strips) == 16
    for name in SHIPPED_LAYOUT_NAMES:
        assert set(create_shipped_layout(name, ("alpha", "V")).channels) <= {"alpha", "V"}
        assert create_shipped_layout(name, None).strips


def test_charts_are_added_to_the_group_of_their_kind_and_taken_away() -> None:
    layout = create_shipped_layout("Longitudinal", tuple(CHANNELS))
    more = toggle_channel(layout, "battery", True)
    assert more.groups[-1].name == "Health"
    assert more.channels == (*layout.channels, "battery")
    assert toggle_channel(more, "battery", True) is more
    assert toggle_channel(more, "battery", False).channels == layout.channels


@given(st.integers(0, 9), st.integers(-12, 12))
@settings(max_examples=50, deadline=None)
def test_moving_a_row_loses_no_chart(place: int, steps: int) -> None:
    """However headings and charts are moved, every chart is there once and under one heading."""
    layout = create_shipped_layout("Longitudinal", tuple(CHANNELS))
    order = list_layout_rows(layout)
    after = build_layout(layout, move_row(order, place, steps))
    assert sorted(after.channels) == sorted(layout.channels)


def test_channels_are_listed_by_group_and_found_by_any_word() -> None:
    groups = group_channels(("q", "q.2", "alpha", "alpha_volts"))
    assert [spec.id for spec in groups["Rates"]] == ["q", "q.2"]
    assert matches_search(channel("alpha"), "angle attack")
    assert matches_search(channel("alpha_volts"), "volt")
    assert not matches_search(channel("alpha"), "attack rate")


def test_layouts_are_kept_by_name_and_damaged_ones_named(tmp_path: Path) -> None:
    store = LayoutStore(tmp_path)
    layout = create_shipped_layout("Lateral", tuple(CHANNELS))
    store.save(layout, "Dutch roll / spiral")
    store.save(layout, "dutch roll: spiral")
    store.save(layout, "Aux")  # no file can be called that on Windows
    # Whoever asks Windows for this one is told that it exists.
    assert "aux.toml" not in [path.name for path in tmp_path.iterdir()]
    store.delete("Aux")
    (tmp_path / "broken.toml").write_text("groups = 3")
    again = LayoutStore(tmp_path)
    assert again.names == ("Dutch roll / spiral", "dutch roll: spiral")
    assert again.load("Dutch roll / spiral").channels == layout.channels
    assert "broken.toml" in again.read_errors[0]
    again.delete("Dutch roll / spiral")
    assert LayoutStore(tmp_path).names == ("dutch roll: spiral",)
    with pytest.raises(FlightError, match="another name"):
        again.save(layout, OVERVIEW_LAYOUT)


# Settings


def test_settings_are_remembered(tmp_path: Path) -> None:
    store = SettingsStore(tmp_path / "window.toml")
    store.change(theme="dark", scale=175, geometry="01ff", muted=True)
    store.replace(store.current.with_link("udpin:127.0.0.1:14550").with_link("tcp:127.0.0.1:5760"))
    again = SettingsStore(tmp_path / "window.toml")
    assert again.current == store.current
    assert again.current.links == ("tcp:127.0.0.1:5760", "udpin:127.0.0.1:14550")
    assert not again.error_text


def test_two_windows_leave_each_others_settings_alone(tmp_path: Path) -> None:
    path = tmp_path / "window.toml"
    one, other = SettingsStore(path), SettingsStore(path)
    one.change(theme="dark", flights="/flights")
    other.change(scale=150)
    one.change(muted=True)
    assert SettingsStore(path).current == Settings(
        theme="dark", flights="/flights", scale=150, muted=True
    )
    assert (one.current.scale, other.current.theme) == (100, "daylight")


def test_what_a_full_disk_refused_is_written_with_the_next_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    path = tmp_path / "window.toml"
    store = SettingsStore(path)
    store.change(scale=125)
    with monkeypatch.context() as full:
        full.setattr(ui.settings, "write_toml", refuse)
        store.change(theme="dark")
    store.change(muted=True)
    assert SettingsStore(path).current == Settings(scale=125, theme="dark", muted=True)


def test_damaged_settings_are_kept_aside_and_told(tmp_path: Path) -> None:
    path = tmp_path / "window.toml"
    path.write_text('theme = "dark"\nscale = 999\n')
    store = SettingsStore(path)
    assert store.current == Settings(theme="dark")
    assert "scale" in store.error_text
    assert (tmp_path / "window.damaged.toml").read_text().startswith("theme")
    store.change(scale=125)
    again = SettingsStore(path)
    assert again.current == Settings(theme="dark", scale=125)
    assert not again.error_text


@pytest.mark.parametrize("content", [b"this is not [", b"\xff\xfe\x00", b"theme = "])
def test_settings_that_are_no_settings_are_told_in_one_plain_sentence(
    tmp_path: Path, content: bytes
) -> None:
    path = tmp_path / "window.toml"
    path.write_bytes(content)
    store = SettingsStore(path)
    assert store.current == Settings()
    assert (tmp_path / "window.damaged.toml").read_bytes() == content
    assert str(path) in store.error_text
    assert "window.damaged.toml" in store.error_text
    assert "line 1" in store.error_text
    assert not any(word in store.error_text for word in ("byte", "TOML", "codec"))


def test_keys_of_a_later_version_cost_nothing(tmp_path: Path) -> None:
    path = tmp_path / "window.toml"
    path.write_text(
        'theme = "dark"\nhologram = true\ngeometry = "zz"\nlinks = [3]\n'
        '[review_estimate]\nmethod = "guess"\nbound_factor = "2"\nsmell = 1\n'
    )
    store = SettingsStore(path)
    assert store.current.theme == "dark"
    assert store.current.review_estimate.bound_factor == "2"
    for key in ("geometry", "links", "review_estimate.method"):
        assert key in store.error_text
    for text in ("hologram", "smell", "pattern", "known"):
        assert text not in store.error_text


def test_settings_that_cannot_be_read_hold_up_nothing(tmp_path: Path) -> None:
    store = SettingsStore(tmp_path / ("x" * 300) / "window.toml")
    assert store.current == Settings()
    store.change(theme="dark")
    assert store.current.theme == "dark"
    assert not UserLimitStore(limits_path(store.path)).limits
    assert not LayoutStore(layouts_path(store.path)).names


def test_settings_that_cannot_be_written_are_told_once(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("no folder")
    told: list[str] = []
    store = SettingsStore(tmp_path / "taken" / "window.toml")
    store.on_write_error = told.append
    assert "will be lost" in store.error_text
    store.change(theme="dark")
    assert told == []
    later = SettingsStore(tmp_path / "later" / "window.toml")
    later.on_write_error = told.append
    (tmp_path / "later").write_text("no folder")
    later.change(theme="dark")
    later.change(theme="daylight")
    assert len(told) == 1
    assert "will be lost" in told[0]


# What is typed into the dialogs


def test_links_are_judged_while_they_are_typed() -> None:
    assert check_link("udpin:127.0.0.1:14550", parse_link, ()).state == "good"
    assert not check_link("udp:14550", parse_link, ()).is_valid
    assert not check_link("  ", parse_link, ()).is_valid
    unplugged = check_link("serial:/dev/ttyUSB7:57600", parse_link, ("/dev/ttyUSB0",))
    assert unplugged.state == "caution"
    assert "plugged in" in unplugged.message
    assert check_link("tcpin:0.0.0.0:5760", parse_link, ()).state == "caution"


def test_a_folder_that_cannot_be_written_gives_way_to_the_usual_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual, blocked = tmp_path / "usual", tmp_path / "file" / "flights"
    monkeypatch.setattr("ui.settings.default_flights_folder", lambda: usual)
    assert writable_folder(tmp_path / "mine") == (tmp_path / "mine", "")
    (tmp_path / "file").touch()
    folder, why = writable_folder(blocked)
    assert folder == usual
    assert str(tmp_path / "file") in why


def test_flight_folders_get_the_next_free_name_and_a_verdict(tmp_path: Path) -> None:
    day = date(2026, 5, 12)
    assert next_flight_name(tmp_path, day) == "2026-05-12-a"
    (tmp_path / "2026-05-12-a").mkdir()
    assert next_flight_name(tmp_path, day) == "2026-05-12-b"
    assert check_folder(str(tmp_path), "new").state == "good"
    assert check_folder(str(tmp_path), "2026-05-12-a").state == "caution"
    assert not check_folder(str(tmp_path), " ").is_valid
    assert not check_folder("", "x").is_valid
    assert sanitize_file_name('a/b:c"') == "a-b-c-"
    # Windows takes these for devices, whatever follows the dot.
    assert [sanitize_file_name(name) for name in ("Aux", "com1", "nul.x", "console", "com10")] == [
        "Aux-", "com1-", "nul-.x", "console", "com10",
    ]  # fmt: skip
    assert "'con-'" in check_folder(str(tmp_path), "con").message
    assert "'a-b'" in check_folder(str(tmp_path), "a/b").message
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert not check_folder(str(blocked), "x").is_valid


def test_sentences_name_keys_as_the_system_does() -> None:
    """A key written out would be another one on a Mac: `key_text` makes its name."""
    for keys in ("Ctrl+L", "Ctrl+Shift+T", "Alt+4"):
        assert plain_shortcut_text(keys, "linux") == plain_shortcut_text(keys, "win32") == keys
    assert plain_shortcut_text("Ctrl+L", "darwin") == "⌘L"
    assert plain_shortcut_text("Ctrl+Shift+T", "darwin") == "⇧⌘T"
    assert plain_shortcut_text("Alt+4", "darwin") == "⌥4"
    assert plain_shortcut_text("Ctrl+L") == ui.commands.shortcut_text("Ctrl+L")
    written = []
    for path in sorted(Path(ui.commands.__file__).parent.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        spoken_of = {  # docstrings
            id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)
        }
        written += [
            f"{path.name}: {node.value}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in spoken_of
            and re.search(r"(Ctrl|Alt|Shift)\+", node.value)
            and " " in node.value
        ]
    assert written == []


def test_every_menu_has_room_below_the_bar_of_a_small_screen_at_200_percent() -> None:
    rows: dict[tuple[str, str], set[str]] = {}
    for command in COMMANDS:
        rows.setdefault((command.menu, ""), set()).add(command.submenu or command.id)
        if command.submenu:
            rows.setdefault((command.menu, command.submenu), set()).add(command.id)
    assert {place: len(found) for place, found in rows.items() if len(found) > 12} == {}
