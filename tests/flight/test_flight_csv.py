"""Flight CSV: what is written comes back, and every mistake is named with its place."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.flight.readers.columns import read_flight_csv
from gsapp.flight.readers.delimited_table import read_delimited_table
from gsapp.flight.writers import write_flight_csv
from gsapp.foundation import FileProblemsError, FlightError, UnmappedError
from gsapp.quantities import CHANNELS, Block, channel, from_si, to_si

DESIGN_HEADER = (
    "time [s],alpha [deg],beta [deg],p [deg/s],q [deg/s],r [deg/s],ax [g],ay [g],an [g],V [ft/s],"
    "qbar [lbf/ft^2],altitude [ft],phi [deg],theta [deg],psi [deg],de [deg],da [deg],dr [deg],"
    "throttle [],flap [deg]"
)


def write(tmp_path, text, name="flight.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return path


def problems_of(path):
    with pytest.raises(FileProblemsError) as caught:
        read_flight_csv(path)
    assert str(path) in str(caught.value)
    return caught.value.problems


def test_design_header_is_read_into_si(tmp_path):
    row = ",".join(str(k) for k in range(20))
    flight = read_flight_csv(write(tmp_path, f"{DESIGN_HEADER}\n{row}\n"))
    block = flight.block
    assert block.channels == tuple(
        cell.split(" ")[0] for cell in DESIGN_HEADER.split(",") if not cell.startswith("time")
    )
    assert block["alpha"][0] == pytest.approx(np.deg2rad(1.0))
    assert block["ax"][0] == pytest.approx(6 * 9.80665)
    assert block["V"][0] == pytest.approx(9 * 0.3048)
    assert block["qbar"][0] == pytest.approx(10 * 47.88025898)
    assert block["throttle"][0] == 18.0


def test_written_header_is_that_of_the_design(tmp_path):
    ids = [cell.split(" ")[0] for cell in DESIGN_HEADER.split(",")][1:]
    block = Block(channels=tuple(ids), times=np.zeros(1), values=np.zeros((1, len(ids))))
    path = write_flight_csv(tmp_path / "out.csv", block)
    assert path.read_text().splitlines()[0] == DESIGN_HEADER


def test_converting_leaves_no_dust_of_digits(tmp_path):
    angles = np.deg2rad([[0.1 * k] for k in range(200)])
    block = Block(channels=("alpha",), times=np.arange(200.0), values=angles)
    written = {
        units: [line.split(",")[1] for line in path.read_text().splitlines()[1:]]
        for units in ("us", "base")
        for path in [write_flight_csv(tmp_path / f"{units}.csv", block, units)]
    }
    assert written["us"] == [f"{k / 10:.15g}" for k in range(200)]
    assert [float(cell) for cell in written["base"]] == angles[:, 0].tolist()


@st.composite
def columns(draw):
    ids = draw(st.lists(st.sampled_from(sorted(CHANNELS)), min_size=1, max_size=6, unique=True))
    units = [draw(st.sampled_from(channel(i).allowed_units)) for i in ids]
    rows = draw(st.integers(1, 8))
    cell = st.none() | st.floats(-1e6, 1e6, allow_nan=False).map(lambda v: float(f"{v:.10g}"))
    cells = draw(
        st.lists(st.lists(cell, min_size=len(ids), max_size=len(ids)), min_size=rows, max_size=rows)
    )
    steps = draw(st.lists(st.integers(1, 10**6), min_size=rows, max_size=rows))
    end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    return ids, units, cells, np.cumsum(steps) / 1e4, end


@settings(max_examples=40, deadline=None)
@given(table=columns())
def test_any_subset_unit_and_gap_is_read(tmp_path_factory, table):
    ids, units, cells, times, end = table
    header = ",".join(["time [s]"] + [f"{i} [{u}]" for i, u in zip(ids, units, strict=True)])
    rows = [
        ",".join([repr(t)] + ["" if v is None else repr(v) for v in row])
        for t, row in zip(times.tolist(), cells, strict=True)
    ]
    path = tmp_path_factory.mktemp("csv") / "f.csv"
    path.write_bytes((end.join([header, *rows]) + end).encode())
    block = read_flight_csv(path).block
    assert block.channels == tuple(ids)
    assert np.array_equal(block.times, times)
    for name, unit, column in zip(ids, units, zip(*cells, strict=True), strict=True):
        expected = to_si(
            np.array([np.nan if v is None else v for v in column]), unit, channel(name).quantity
        )
        assert np.array_equal(block[name], expected, equal_nan=True)


@settings(max_examples=40, deadline=None)
@given(table=columns(), system=st.sampled_from(["us", "si", "base"]))
def test_round_trip(tmp_path_factory, table, system):
    ids, _, cells, times, _ = table
    values = np.array([[np.nan if v is None else v for v in row] for row in cells], dtype=float)
    block = Block(channels=tuple(ids), times=times, values=values)
    folder = tmp_path_factory.mktemp("trip")
    back = read_flight_csv(write_flight_csv(folder / "a.csv", block, system)).block
    assert back.channels == block.channels
    assert np.array_equal(back.times, block.times)
    assert np.array_equal(np.isnan(back.values), np.isnan(block.values))
    if system == "base":
        assert np.array_equal(back.values, block.values, equal_nan=True)
    for name in ids:
        spec = channel(name)
        # The digits printed are those of the displayed unit, whose zero may lie elsewhere (degF).
        unit = spec.us_display if system == "us" else spec.si_display
        shown = from_si(block[name], unit, spec.quantity)
        again = from_si(back[name], unit, spec.quantity)
        np.testing.assert_allclose(again, shown, rtol=2e-14, atol=1e-11)


def test_nan_and_blank_cells_are_missing(tmp_path):
    path = write(tmp_path, "q [deg/s],time [s],r [deg/s]\n,0,1\nNaN,1, \n3,2,nan\n")
    block = read_flight_csv(path).block
    assert np.array_equal(np.isnan(block["q"]), [True, True, False])
    assert np.array_equal(np.isnan(block["r"]), [False, True, True])


def test_marks_latin1_comments_and_quotes(tmp_path):
    """A byte-order mark, a Latin-1 degree sign, comment lines and quotation marks do no harm."""
    plain = read_flight_csv(write(tmp_path, "time [s],alpha [°]\n0,2\n1,3\n")).block
    for name, text, encoding in (
        ("bom.csv", "\ufefftime [s],alpha [°]\n0,2\n1,3\n", "utf-8"),
        ("latin.csv", "time [s],alpha [°]\n0,2\n1,3\n", "latin-1"),
        ("comment.csv", "# cut\n\ntime [s],alpha [deg]\n0,2\n\n1,3\n\n", "utf-8"),
        ("told.csv", "sep=,\r\ntime [s],alpha [deg]\r\n0,2\r\n1,3\r\n", "utf-8"),
        ("quotes.csv", '"time [s]","alpha [deg]"\n"0","2"\n1,3\n', "utf-8"),
    ):
        block = read_flight_csv(write(tmp_path, text, name, encoding)).block
        assert np.array_equal(block.values, plain.values), name
        assert np.array_equal(block.times, plain.times), name


@pytest.mark.parametrize(
    ("text", "where", "what", "remedy"),
    [
        ("", "file", "is empty", "header"),
        ("\n\n", "file", "is empty", "header"),
        ("time [s],q [deg/s]\n", "file", "no rows", "record"),
        ("time [s],q [ft]\n0,1\n", "line 1, column 2 (q [ft])", "'ft' is not a unit", "deg/s"),
        ("time [s],q\n0,1\n", "line 1, column 2 (q)", "has no unit", "rad/s"),
        ("time [s],aplha [deg]\n0,1\n", "line 1, column 2 (aplha [deg])", "'aplha'", "alpha"),
        ("time [s],Alpha [deg]\n0,1\n", "line 1, column 2 (Alpha [deg])", "'Alpha'", "'alpha'"),
        ("time [s],delta_e [deg]\n0,1\n", "column 2", "'delta_e'", "'de'"),
        ("Time [s],q [deg/s]\n0,1\n", "column 1", "'Time'", "'time'"),
        ("q [deg/s],r [deg/s]\n0,1\n", "line 1", "no column of time", "time [s]"),
        ("time [s]\n0\n", "line 1", "without any channel", "q [deg/s]"),
        ("time [s],q [deg/s],q [deg/s]\n0,1,2\n", "column 3", "already in column 2", "q.2"),
        ("time [s],q [deg/s],\n0,1,\n", "column 3", "has no name", "trailing comma"),
        ("time [furlong],q [deg/s]\n0,1\n", "column 1", "not a unit of time", "ms"),
        ("time [s],q [deg/s]\n0,1\n1,x\n", "line 3, column 2 (q [deg/s])", "'x'", "empty"),
        ("time [s],q [deg/s]\n0,1\n1,N/A\n", "line 3, column 2", "'N/A'", "leave the cell empty"),
        ("time [s],q [deg/s]\n0,1\n1,3deg\n", "line 3, column 2", "'3deg'", "header"),
        ("time [s],q [deg/s]\n9:40:01,1\n", "line 2, column 1", "'9:40:01'", "write seconds"),
        ("time [s],q [deg/s]\n2026-05-12 09:40,1\n", "line 2", "'2026-05", "write seconds"),
        ("time [s],q [deg/s]\n0,1\n1,inf\n", "line 3, column 2", "'inf'", "empty"),
        ("time [s],q [deg/s]\n0,1\n1,1_0\n", "line 3, column 2", "'1_0'", "number"),
        ("time [s],q [deg/s]\n0,1\n1,\u0661\n", "line 3, column 2", "\u0661", "number"),
        ("time [s],q [deg/s]\n0,1\n1\n2,3\n", "line 3", "1 cells where the header has 2", "empty"),
        ("time [s],q [deg/s]\n0,1\n1,2,3x\n", "line 3", "3 cells", "empty"),
        ("time [s],q [deg/s]\n0,0,1,2\n0,1,1,3\n", "line 2", "4 cells", "decimal commas"),
        ('time [s],q [deg/s]\n0,"1,5"\n', "line 2, column 2", "'1,5'", "decimal point"),
        (
            "time [s],q [deg/s]\n0,1\n0,2\n",
            "line 3, column 1",
            "repeats the time",
            "one of the two",
        ),
        ("time [s],q [deg/s]\n1,1\n0.5,2\n", "line 3, column 1", "goes back from 1 s", "sort"),
        ("time [s],q [deg/s]\n0,1\n,2\n", "line 3, column 1", "has no time", "row"),
        ("time [s],q [deg/s]\n0,1\0\n", "byte 23", "not text", "ending"),
    ],
)
def test_mistakes_are_named(tmp_path, text, where, what, remedy):
    problem = problems_of(write(tmp_path, text))[0]
    assert where in problem.where
    assert what in problem.what
    assert remedy in problem.remedy


def test_every_mistake_of_a_header_at_once(tmp_path):
    found = problems_of(write(tmp_path, "time [s],aplha [deg],q [kg],V\n0,1,2,3\n"))
    assert [problem.where.split(",")[1].split()[1] for problem in found] == ["2", "3", "4"]


@pytest.mark.parametrize("ragged", [0, 15, 30])
def test_many_mistakes_are_counted(tmp_path, ragged):
    rows = "".join("1,2,3\n" if k < ragged else f"{k},bad\n" for k in range(1000))
    found = problems_of(write(tmp_path, "time [s],q [deg/s]\n" + rows))
    assert [one.where.startswith("line") for one in found] == [True] * 20 + [False]
    assert sum("cells where" in one.what for one in found) == min(ragged, 20)
    assert "980 further problems" in found[-1].what


def test_utf16_missing_and_folder(tmp_path):
    utf16 = write(tmp_path, "time [s],q [deg/s]\n0,1\n", "u.csv", "utf-16")
    assert "UTF-16" in problems_of(utf16)[0].what
    assert "cannot be read" in problems_of(tmp_path / "no.csv")[0].what
    assert "cannot be read" in problems_of(tmp_path)[0].what


def test_torn_last_line_is_left_out_and_told(tmp_path):
    path = write(tmp_path, "time [s],q [deg/s],r [deg/s]\n0,1,2\n1,2,3\n2,")
    flight = read_flight_csv(path)
    assert flight.block.times.tolist() == [0.0, 1.0]
    assert "line 4" in flight.remarks[0]
    assert "torn" in flight.remarks[0]


def test_line_numbers_hold_in_long_files_with_blank_lines(tmp_path):
    """The line named is that of an editor, beyond the rows that are parsed at once."""
    rows = [f"{k},1" for k in range(9000)]
    rows[10] = ""
    rows[8000] = "8000,oops"
    path = write(tmp_path, "# a remark\ntime [s],q [deg/s]\n" + "\n".join(rows) + "\n")
    assert problems_of(path)[0].where.startswith("line 8003,")


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "flight.csv"
    block = Block(channels=("q",), times=np.arange(3.0), values=np.ones((3, 1)))
    write_flight_csv(path, block)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("gsapp.foundation.files.flush_to_disk", full)
    with pytest.raises(FlightError, match="No space left"):
        write_flight_csv(path, block, "base")
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["flight.csv"]


@settings(max_examples=50, deadline=None)
@given(
    edits=st.lists(
        st.tuples(st.integers(0, 10**6), st.binary(max_size=6), st.integers(0, 8)), max_size=12
    )
)
def test_damage_is_told_and_never_crashes(tmp_path_factory, edits):
    data = bytearray(b"time [s],alpha [deg],q [deg/s]\n" + b"0.0,1.5,2\n0.1,,3\n0.2,1.7,4\n")
    for place, new, length in edits:
        start = place % (len(data) + 1)
        data[start : start + length] = new
    path = tmp_path_factory.mktemp("csv") / "damaged.csv"
    path.write_bytes(data)
    try:
        block = read_flight_csv(path).block
    except UnmappedError as error:
        # Of the header nothing is left that a Flight CSV has.
        assert "damaged.csv" in str(error)  # noqa: PT017
    except FileProblemsError as error:
        assert "damaged.csv" in str(error)  # noqa: PT017
        assert all(problem.what for problem in error.problems)  # noqa: PT017
    else:
        assert np.all(np.diff(block.times) > 0)
        assert not np.isinf(block.values).any()


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_a_file_that_is_read_in_pieces_is_read_the_same(tmp_path, monkeypatch, ends, encoding):
    rows = ["time [s],alpha [rad]", "# 5 °", *(f"{n},0.{n}" for n in range(40)), ""]
    path = write(tmp_path, ends.join(rows), encoding=encoding)
    whole = read_delimited_table(path)
    monkeypatch.setattr("gsapp.flight.readers.delimited_table._BYTES_AT_ONCE", 7)
    assert read_delimited_table(path) == whole
    assert whole.lines == tuple(rows[1:])


@pytest.mark.parametrize(
    "text",
    [
        "time [s];q [deg/s]\n0;2,5\n0,5;3\n1;-1,25e1\n",
        "time [s];q [deg/s]\n0;2.5\n0.5;3\n1;-12.5\n",
        'time [s];"q [deg/s]"\n0;2.5\n0.5;"3"\n1;-12.5\n',
        "time [s]\tq [deg/s]\n0\t2.5\n0.5\t3\n1\t-12.5\n",
        "  time [s]   q [deg/s]\n  0.0   2.5\n  0.5   3 \n 1 -1.25e1\n",
        "% short period, run 7\n% time [s] q [deg/s]\n0 2.5\n.5 3\n1 -12.5\n",
        "Run seven\ntime [s] q [deg/s]\n[s] [deg/s]\n0 2.5\n.5 3\n1 -12.5\n",
        "# time [s],q [deg/s]\n0,2.5\n0.5,3\n1,-12.5\n",
    ],
)
def test_other_separators_and_places_of_the_header(tmp_path, text):
    """Semicolons, tabs and blanks; decimal commas; names in a comment, or with a line of units."""
    block = read_flight_csv(write(tmp_path, text)).block
    assert block.times.tolist() == [0.0, 0.5, 1.0]
    np.testing.assert_allclose(np.rad2deg(block["q"]), [2.5, 3.0, -12.5])


def test_a_torn_last_line_between_blanks_is_left_out(tmp_path):
    table = read_delimited_table(write(tmp_path, "time [s] q [deg/s]\n0 2.5\n0.5 3\n1"))
    assert table.numbers()[0].tolist() == [[0.0, 2.5], [0.5, 3.0]]
    assert "line 4" in table.remarks[0]


def test_mistakes_between_blanks_are_named_by_line(tmp_path):
    text = "# 2 columns\ntime [s] q [deg/s]\n0 2.5\n0.5 3 7\n1 x\n"
    found = problems_of(write(tmp_path, text))
    assert [problem.where for problem in found] == ["line 4", "line 5, column 2 (q [deg/s])"]


def test_columns_without_names_need_a_map(tmp_path):
    path = write(tmp_path, "  0.0  1e0 -3\n  0.1  2   -4\n")
    with pytest.raises(UnmappedError, match=r"column\[0\] to column\[2\]"):
        read_flight_csv(path)
    assert read_delimited_table(path).numbers()[0].tolist() == [[0.0, 1.0, -3.0], [0.1, 2.0, -4.0]]
