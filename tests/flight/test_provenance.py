"""Sums of files and folders: any byte that can change a number is seen, and named."""

from pathlib import Path

from gsapp.flight.provenance import find_changed_parts, hash_input_file


def flight(folder: Path) -> Path:
    (folder / "calibration").mkdir(parents=True)
    (folder / "cache").mkdir()
    for name, text in (
        ("raw.tlog", "frames"),
        ("calibration/alpha.toml", "volts"),
        ("cache/engineering.npz", "made"),
        ("events.jsonl", "a mark"),
    ):
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def test_of_a_folder_each_file_is_named(tmp_path: Path) -> None:
    folder = flight(tmp_path / "a")
    before = hash_input_file("flight", folder, name="a")
    assert sorted(before.parts) == ["calibration/alpha.toml", "events.jsonl", "raw.tlog"]
    (folder / "cache/engineering.npz").write_text("made again", encoding="utf-8")
    assert hash_input_file("flight", folder, name="a") == before
    (folder / "events.jsonl").write_text("another mark", encoding="utf-8")
    marked = hash_input_file("flight", folder, name="a")
    assert marked.sha256 != before.sha256
    assert find_changed_parts(before, marked) == ()
    (folder / "calibration/alpha.toml").write_text("others", encoding="utf-8")
    (folder / "onboard.bin").write_bytes(b"log")
    assert find_changed_parts(before, hash_input_file("flight", folder, name="a")) == (
        "a/calibration/alpha.toml",
        "a/onboard.bin",
    )
    # The same content in another order of directories is the same.
    assert hash_input_file("x", flight(tmp_path / "b")).sha256 == before.sha256


def test_a_file_is_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"abc")
    before = hash_input_file("flight", path)
    # Of FIPS 180-2.
    assert before.sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert before.name == str(path)
    path.write_bytes(b"abd")
    assert find_changed_parts(before, hash_input_file("flight", path)) == (str(path),)
