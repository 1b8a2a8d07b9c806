"""`pure_slip_damping`: the damping that separates stick-slip from slip, by formula or by simulation."""

from dataclasses import dataclass

from stickslip_sym.closed_form import derive
from stickslip_sym.errors import InputError
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.grazing import grazing_damping
from stickslip_sym.oscillator import Oscillator
from stickslip_sym.values import lookup

__all__ = ["METHODS", "Threshold", "pure_slip_damping"]

METHODS = ("equilibrium", "least_squares", "harmonic", "simulation")


@dataclass(frozen=True)
class Threshold:
    """A threshold: its value, the method that gave it, and its estimated relative error.

    Attributes
    ----------
    value : float
        In kg/s.
    method : str
    error : float or None
        Estimated error against the exact threshold, relative; None where nothing is known of it.
    """

    value: float
    method: str
    error: float | None

    def __str__(self) -> str:
        accuracy = "unknown" if self.error is None else f"{self.error:.0e}"
        return f"{self.value:.10g} kg/s ({self.method}, relative error {accuracy})"


def pure_slip_damping(
    law: FrictionLaw,
    *,
    V: float,
    N: float,
    m: float | None = None,
    k: float | None = None,
    method: str,
    rtol: float = 1e-10,
) -> Threshold:
    """Return the pure-slip damping coefficient of a law in a scene.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    V, N : float
        Belt speed in m/s and normal force in N.
    m, k : float, optional
        Mass in kg and stiffness in N/m; only "simulation" needs them.
    method : {"equilibrium", "least_squares", "harmonic", "simulation"}
        A criterion in closed form, or the root in c of the lowest slip speed that the orbit from P
        comes down to: the orbit that grazes the belt's speed.
    rtol : float
        Relative tolerance of "simulation".

    Raises
    ------
    InputError
        For an unknown method, or numbers that are missing or unusable.
    NoThreshold
        If the orbit from P never returns, for any c >= 0.
    """
    lookup("method", method, dict.fromkeys(METHODS))
    if method != "simulation":
        return Threshold(derive(law, method)(V=V, N=N), method, None)
    if m is None or k is None:
        raise InputError('method="simulation" needs the mass m and the stiffness k')
    value, error = grazing_damping(law, Oscillator(m=m, k=k, V=V, N=N), rtol=rtol)
    return Threshold(value, method, error)
