"""Cut, merge, resample, filter, rename: what a record goes through between tools."""

from gsapp.flight.processing.channels import rename_channels, without_channels
from gsapp.flight.processing.cutting import Window, cut_windows, parse_window
from gsapp.flight.processing.merging import append_in_time, beside_each_other, shifted
from gsapp.flight.processing.sampling import check_rate, low_pass, resample

__all__ = [
    "Window",
    "append_in_time",
    "beside_each_other",
    "check_rate",
    "cut_windows",
    "low_pass",
    "parse_window",
    "rename_channels",
    "resample",
    "shifted",
    "without_channels",
]
