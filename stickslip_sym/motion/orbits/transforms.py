"""Sums of sines and cosines on the midpoints of cells of the phase, by NumPy's Fourier transform.

The phases are theta_j = (j + 1/2) pi / size; rows are transformed one by one. SciPy has the same as `dct` and
`dst`, but takes longer to import than a threshold takes to compute.
"""

import numpy as np

from stickslip_sym.core.aliases import ComplexArray, FloatArray

__all__ = ["cosines", "from_cosines", "from_sines", "sines"]


def sines(values: FloatArray) -> FloatArray:
    """Return coefficients of sin(n theta), n = 0 to size - 1."""
    return -_spectrum(values, -1).imag


def cosines(values: FloatArray) -> FloatArray:
    """Return coefficients of cos(n theta), n = 0 to size - 1, the mean as it is."""
    result = _spectrum(values, 1).real
    result[:, 0] /= 2
    return result


def from_sines(coefficients: FloatArray) -> FloatArray:
    """Return the sum of coefficients times sin(n theta) at the phases; that of n = 0 does not count."""
    return _sum(-1j * coefficients)


def from_cosines(coefficients: FloatArray) -> FloatArray:
    """Return the sum of coefficients times cos(n theta) at the phases."""
    doubled = coefficients.astype(np.complex128)
    doubled[:, 0] *= 2
    return _sum(doubled)


def _spectrum(values: FloatArray, sign: int) -> ComplexArray:
    """Transform values that go on beyond pi as an even or an odd function; the phases begin half a cell late."""
    size = values.shape[1]
    whole = np.concatenate([values, sign * values[:, ::-1]], axis=1)
    spectrum: ComplexArray = np.fft.rfft(whole, axis=1)[:, :size] * _half_a_cell(size).conj() / size
    return spectrum


def _sum(amplitudes: ComplexArray) -> FloatArray:
    size = amplitudes.shape[1]
    spectrum = np.pad(amplitudes * _half_a_cell(size) * size, ((0, 0), (0, 1)))
    values: FloatArray = np.fft.irfft(spectrum, 2 * size, axis=1)[:, :size]
    return values


def _half_a_cell(size: int) -> ComplexArray:
    shift: ComplexArray = np.exp(0.5j * np.pi / size * np.arange(size))
    return shift
