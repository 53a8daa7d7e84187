"""Cut, merge, resample, filter, rename: what a record goes through between tools."""

from gsapp.flight.processing.channels import drop_channels, rename_channels
from gsapp.flight.processing.record_merge import append_records, merge_records, shift_time
from gsapp.flight.processing.resample_filter import check_sample_rate, low_pass, resample
from gsapp.flight.processing.time_windows import TimeWindow, cut_windows, parse_time_window

__all__ = [
    "TimeWindow",
    "append_records",
    "check_sample_rate",
    "cut_windows",
    "drop_channels",
    "low_pass",
    "merge_records",
    "parse_time_window",
    "rename_channels",
    "resample",
    "shift_time",
]
