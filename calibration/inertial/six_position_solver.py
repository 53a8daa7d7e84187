"""Accelerometers and how the aircraft lay, found together by least squares.

    v = z + K f,    f = R(tilt) e

z (3,) and K (3, 3) are common to all readings; each reading has two tilts of its own, known
beforehand to be small. Readings count by their noise, tilts by how well the aircraft is laid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray

_ROUNDS = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class SixPositionSolution:
    """What was found."""

    zero: FloatArray
    zero_std: FloatArray
    """Shape (3,). V, with standard deviations."""
    matrix: FloatArray
    matrix_std: FloatArray
    """Shape (3, 3). V/g; a row for each accelerometer, a column for each axis of the force."""
    tilts: FloatArray
    """Shape (n, 2). Of each reading toward the two axes that were to be level, rad."""
    misfit: float
    """Sum of squares of all residuals, each in its standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SixPositionProblem:
    """What was read."""

    force: FloatArray
    """Shape (n, 3). Specific force of each reading, had the aircraft lain as asked, g."""
    volts: FloatArray
    noise: FloatArray
    """Shape (n, 3). Means of the three accelerometers, with standard deviations, V."""
    tilt: float
    """Standard deviation with which the aircraft is laid, rad."""

    def solve(self) -> SixPositionSolution:
        """Solve by Gauss-Newton; the unknowns are z (3), K (9, by rows), and two tilts each."""
        n = len(self.force)
        level = np.column_stack([np.ones(n), self.force])
        start = np.linalg.lstsq(level, self.volts, rcond=None)[0]
        x = np.concatenate([start[0], start[1:].T.ravel(), np.zeros(2 * n)])
        for _ in range(_ROUNDS):
            residual, jacobian = self._linearized(x)
            step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
            x = x + step
            if np.max(np.abs(step)) < 1e-12:
                break
        residual, jacobian = self._linearized(x)
        std = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
        return SixPositionSolution(
            zero=x[:3],
            zero_std=std[:3],
            matrix=x[3:12].reshape(3, 3),
            matrix_std=std[3:12].reshape(3, 3),
            tilts=x[12:].reshape(n, 2),
            misfit=float(residual @ residual),
        )

    def _linearized(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what is left (3n + 2n,), each in its standard deviations, and its Jacobian."""
        n = len(self.force)
        matrix, tilts = x[3:12].reshape(3, 3), x[12:].reshape(n, 2)
        residual = np.zeros(5 * n)
        jacobian = np.zeros((5 * n, 12 + 2 * n))
        for k, nominal in enumerate(self.force):
            force, by_tilt = _tilted(nominal, tilts[k])
            for i in range(3):
                row = 3 * k + i
                residual[row] = x[i] + matrix[i] @ force - self.volts[k, i]
                jacobian[row, i] = 1.0
                jacobian[row, 3 + 3 * i : 6 + 3 * i] = force
                jacobian[row, 12 + 2 * k : 14 + 2 * k] = matrix[i] @ by_tilt
                residual[row] /= self.noise[k, i]
                jacobian[row] /= self.noise[k, i]
        own = np.arange(2 * n)
        residual[3 * n :] = x[12:] / self.tilt
        jacobian[3 * n + own, 12 + own] = 1.0 / self.tilt
        return residual, jacobian


def _tilted(nominal: FloatArray, tilt: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a force leaning by two tilts (sines) toward the other axes, and its derivatives."""
    axis = int(np.argmax(np.abs(nominal)))
    others = [index for index in range(3) if index != axis]
    size = float(np.linalg.norm(nominal))
    along = math.sqrt(max(1.0 - float(tilt @ tilt), 1e-6))
    force = nominal * along
    force[others] = size * tilt
    by_tilt = np.zeros((3, 2))
    by_tilt[axis] = -nominal[axis] * tilt / along
    by_tilt[others, [0, 1]] = size
    return force, by_tilt
