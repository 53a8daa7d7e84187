"""The recorder's converter: what volts stand for each quantity after 12 bits."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from calibration.adc import quantize
from calibration.certificate import Certificate
from gsapp.foundation import UnknownNameError
from gsapp.quantities import INSTRUMENTS, Block, FloatArray

DAQ_CHANNELS = (*INSTRUMENTS, "excitation", "battery")
"""Channel of each input of the converter, in order."""

_DIVIDERS = {"excitation": 1.0, "battery": 0.2}
"""Inputs that see their voltage directly, or through a divider."""


class AnalogDigitalConverter:
    """Instruments' outputs into counts, and back through the certificates.

    There is one for each input that is not a plain voltage; raise UnknownNameError if one is
    missing.
    """

    def __init__(self, certificates: Mapping[str, Certificate]) -> None:
        missing = [
            name for name in DAQ_CHANNELS if name not in _DIVIDERS and name not in certificates
        ]
        if missing:
            raise UnknownNameError(
                f"there is no calibration certificate for {', '.join(missing)}; "
                "calibrate, or take the shipped set 'b777'"
            )
        self._certificates = dict(certificates)

    def volts(self, instruments: Mapping[str, FloatArray]) -> FloatArray:
        """Return the converted volts, shape (n, 20), of all inputs, by `calibration.adc.quantize`.

        What each instrument shows, of all `DAQ_CHANNELS`, is in SI, shape (n,). NaN is an open
        input, which the converter reads as nothing.
        """
        excitation = instruments["excitation"]
        columns = []
        for name in DAQ_CHANNELS:
            values = instruments[name]
            if name in _DIVIDERS:
                columns.append(values * _DIVIDERS[name])
            else:
                columns.append(self._certificates[name].volts(values, excitation))
        raw = np.nan_to_num(np.column_stack(columns), nan=0.0)
        return quantize(raw)

    def convert_volts(self, volts: FloatArray) -> dict[str, FloatArray]:
        """Return what the ground makes of converted volts, shape (n, 20): channel -> (n,)."""
        excitation = volts[:, DAQ_CHANNELS.index("excitation")]
        values = {}
        for index, name in enumerate(DAQ_CHANNELS):
            if name in _DIVIDERS:
                values[name] = volts[:, index] / _DIVIDERS[name]
            else:
                values[name] = self._certificates[name].evaluate(volts[:, index], excitation)
        return values

    def convert_to_block(self, times: FloatArray, volts: FloatArray) -> Block:
        """Return `convert_volts` as a block over times (s), shape (n,)."""
        values = self.convert_volts(volts)
        return Block(
            channels=DAQ_CHANNELS, times=times, values=np.column_stack(list(values.values()))
        )
