"""Which certificates a flight was read with, and which instruments had none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from calibration import Certificate, certificate_content
from gsapp.decoding.derived_channels import source_instruments
from gsapp.decoding.pipeline import ChannelSource
from gsapp.quantities import Block

VOLTS_SUFFIX = "_volts"
"""Ends the base id of a channel that holds an instrument's volts."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AppliedCertificates:
    """The certificates behind the numbers of a flight."""

    applied: Mapping[str, Certificate] = field(default_factory=dict)
    """Those in force, by channel."""
    override_source: str = ""
    """What was given in place of the flight's own: a folder, or a shipped set; empty if nothing."""
    recorded: Mapping[str, Certificate] | None = None
    """Those kept with the flight; None if none are."""

    @property
    def differing_channels(self) -> tuple[str, ...]:
        """Return the channels whose certificates are not those kept with the flight, sorted."""
        own = self.recorded or {}
        return tuple(
            sorted(
                name
                for name in {*own, *self.applied}
                if _content(own.get(name)) != _content(self.applied.get(name))
            )
        )

    @property
    def override_text(self) -> str:
        """Return that other certificates than the flight's own were used; empty if they were not.

        A result without this sentence comes from what was in force on the day.
        """
        if not self.override_source:
            return ""
        head = f"read with the certificates of '{self.override_source}' instead of"
        if self.recorded is None:
            return f"{head} those named by its channel map: the flight has none"
        changed = self.differing_channels
        if not changed:
            return f"{head} those of the flight, which are identical"
        gone = [name for name in changed if name not in self.applied]
        other = [name for name in changed if name in self.applied]
        parts = [
            text
            for text in (
                f"they differ for {', '.join(other)}" if other else "",
                f"missing: {', '.join(gone)}" if gone else "",
            )
            if text
        ]
        return f"{head} those of the flight; {' and '.join(parts)}"

    def to_json(self) -> dict[str, Any]:
        return {
            "certificates": {
                name: {"stamp": one.stamp.isoformat(), "who": one.who}
                for name, one in sorted(self.applied.items())
            },
            "given": self.override_source or None,
            "instead_of_own": list(self.differing_channels) if self.override_source else [],
        }


def _content(certificate: Certificate | None) -> dict[str, Any] | None:
    return None if certificate is None else certificate_content(certificate)


def uncalibrated_channels(sources: Mapping[str, ChannelSource]) -> tuple[str, ...]:
    """Return the channels whose instruments gave volts only, for want of a certificate, sorted."""
    return tuple(
        sorted(
            {each.uncalibrated_channel for each in sources.values() if each.uncalibrated_channel}
        )
    )


def calibration_remarks(
    used: AppliedCertificates, sources: Mapping[str, ChannelSource], block: Block | None = None
) -> tuple[str, ...]:
    """Return what is to be said of the calibration behind a flight's numbers, if anything is."""
    listed = ", ".join(uncalibrated_channels(sources))
    lacking = f"uncalibrated (no certificate), volts only: {listed}"
    beyond = "" if block is None else _out_of_range_text(used, sources, block)
    return tuple(text for text in (used.override_text, lacking if listed else "", beyond) if text)


def calibrated_ranges(
    used: AppliedCertificates, sources: Mapping[str, ChannelSource]
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return what the instruments behind each channel were calibrated for.

    By channel, derived ones among them: by instrument the lowest and highest value, SI. Channels
    without a certificate behind them are left out.
    """
    covered = {
        name: certificate.padded_value_range
        for name, certificate in used.applied.items()
        if name in sources and sources[name].calibrated
    }
    behind = source_instruments([name for name, each in sources.items() if each.kind != "derived"])
    found = {
        name: {one: covered[one] for one in behind.get(name, ()) if one in covered}
        for name in sources
    }
    return {name: ranges for name, ranges in found.items() if ranges}


def instruments_out_of_range(
    used: AppliedCertificates,
    sources: Mapping[str, ChannelSource],
    value_of: Callable[[str], float],
) -> tuple[str, ...]:
    """Return the instruments whose values lie beyond what they were calibrated for, sorted."""
    return tuple(
        name
        for name, certificate in sorted(used.applied.items())
        if name in sources and sources[name].calibrated and certificate.out_of_range(value_of(name))
    )


def count_samples_out_of_range(
    used: AppliedCertificates, sources: Mapping[str, ChannelSource], block: Block
) -> dict[str, int]:
    """Return how many samples lie beyond what was calibrated, by channel; those of none left out.

    A derived sample does where an instrument behind it does.
    """
    found = {}
    for name, ranges in calibrated_ranges(used, sources).items():
        if name not in block:
            continue
        outside = np.zeros(block.times.size, dtype=bool)
        for instrument, (low, high) in ranges.items():
            if instrument in block:
                values = block[instrument]
                outside |= (values < low) | (values > high)
        count = int(np.count_nonzero(outside & np.isfinite(block[name])))
        if count:
            found[name] = count
    return found


def _out_of_range_text(
    used: AppliedCertificates, sources: Mapping[str, ChannelSource], block: Block
) -> str:
    """Return which channels left the range that was calibrated, and how often; empty for none."""
    counts = count_samples_out_of_range(used, sources, block)
    if not counts:
        return ""
    shares = ", ".join(
        f"{name} {max(100.0 * count / np.count_nonzero(np.isfinite(block[name])), 0.1):.1f} %"
        for name, count in sorted(counts.items())
    )
    return f"outside the calibrated range (linear extrapolation), share of samples: {shares}"


def uncalibrated_columns(columns: Sequence[str]) -> dict[str, str]:
    """Return columns of volts whose channel is not among the columns, with that channel.

    A table keeps no certificates: volts (``q_volts``, ``q_volts.2``) without their channel are
    those of an instrument that was not calibrated.
    """
    there = set(columns)
    wanted = {column: _channel_of_volts(column) for column in columns}
    return {column: name for column, name in wanted.items() if name and name not in there}


def _channel_of_volts(column: str) -> str:
    base, dot, number = column.partition(".")
    return base.removesuffix(VOLTS_SUFFIX) + dot + number if base.endswith(VOLTS_SUFFIX) else ""
