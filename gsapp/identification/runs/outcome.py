"""What came of an estimation, for tables, figures, files and reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from gsapp.dynamics.linearization import LinearModel
from gsapp.flight.catalog import FlightEntry
from gsapp.flight.provenance import InputFile
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.compatibility import VanePosition
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.summary import CampaignSummary

SAME_SAMPLES_TEXT: Final = "the same samples stand in"
"""Begins a remark on flights that are one and the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunOutcome:
    """One estimation, done.

    Attributes
    ----------
    request : RunRequest
        With the maneuvers that were used.
    aircraft : str
        Name of the one that flew.
    result : CampaignResult
        Maneuver ids begin with the flight's number where there are several, ``2:M4``.
    summary : CampaignSummary
    models : mapping of str to LinearModel
        Linear models with the means, by axis; may be empty.
    remarks : tuple of str
        What is suspicious about the aircraft, of reading the flights, and why there is no linear
        model.
    number : int or None
        In the catalog; None where it was not kept.
    vanes : tuple of VanePosition
        Vanes that were used at another position than the aircraft file's.
    inputs : tuple of InputFile
        Flights and files that went in, with their sums when they were read.
    versions : mapping of str to str
        Of the program and what shapes its numbers.
    flights : tuple of FlightEntry
        What a catalog keeps of the flights.
    uncalibrated : tuple of str
        Which inputs and answers of the flights were volts only, in words.
    """

    request: RunRequest
    aircraft: str
    result: CampaignResult
    summary: CampaignSummary
    models: Mapping[LinearAxis, LinearModel] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    number: int | None = None
    vanes: tuple[VanePosition, ...] = ()
    inputs: tuple[InputFile, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    flights: tuple[FlightEntry, ...] = ()
    uncalibrated: tuple[str, ...] = ()
