"""`fit`: friction laws fitted to measurements, and ranked."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from numpy.typing import ArrayLike

from stickslip_sym.core.errors import InputError
from stickslip_sym.model.fitting.one_law import fit_law
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.laws import laws as catalogue
from stickslip_sym.model.measured.measurements import Measurements

__all__ = ["fit"]


def fit(
    v: ArrayLike | Measurements,
    mu: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    laws: str | FrictionLaw | Iterable[str | FrictionLaw] | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Fits:
    """Fit friction laws to measurements by least squares, and rank them by AICc.

    Parameters
    ----------
    v : array_like of shape (n,) or Measurements
        Slip speeds in m/s; or measurements as `read_measurements` returns them, without `mu` and `sigma`.
    mu : array_like of shape (n,)
        Coefficients of friction.
    sigma : float or array_like of shape (n,), optional
        Standard deviation of each coefficient. Without it, it is one for all rows, and estimated.
    laws : name, formula, FrictionLaw, or several of them, optional
        What to fit; every law of the catalogue by default. Parameters that have a value keep it.
    progress : callable, optional
        Called with the number of laws that are done, and of all.

    Returns
    -------
    Fits
        The best first; `Fits.rejected` says which laws these measurements do not determine, and why.

    Raises
    ------
    InputError
        For what is no measurement or law, or if no law can be fitted.

    Notes
    -----
    The sum of ((mu_i - mu(v_i; p)) / sigma_i)^2 is minimised by SciPy's ``least_squares``, with exact
    derivatives, from several starts. Parameters that are declared positive stay so. Laws with
    mu(0) = 0 are fitted only where the speeds reach below the one at which their friction has built up.

    Examples
    --------
    >>> import numpy as np
    >>> v = np.linspace(0, 1, 50)
    >>> mu = 0.2 + 0.3 * np.exp(-3 * v) + 0.01 * np.cos(50 * v)
    >>> fits = fit(v, mu, laws=["exponential", "gaussian"])
    >>> fits.best.name, f"{fits.best.values['alpha']:.1f}"
    ('exponential', '3.1')
    """
    measured = _measured(v, mu, sigma)
    chosen = _laws(laws)
    fits: list[Fit] = []
    rejected: dict[str, str] = {}
    for done, (name, law) in enumerate(chosen.items()):
        if progress is not None:
            progress(done, len(chosen))
        result = fit_law(law, measured)
        if isinstance(result, str):
            rejected[name] = result
        else:
            fits.append(result)
    if progress is not None:
        progress(len(chosen), len(chosen))
    if not fits:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in list(rejected.items())[:3])
        raise InputError(f"no law could be fitted to {len(measured)} rows: {reasons}")
    return Fits(fits, measured, rejected)


def _measured(v: ArrayLike | Measurements, mu: ArrayLike | None, sigma: ArrayLike | None) -> Measurements:
    if isinstance(v, Measurements):
        if mu is not None or sigma is not None:
            raise InputError("mu and sigma are given twice: measurements have their own")
        return v
    if mu is None:
        raise InputError("mu is missing; give fit(v, mu), or fit(read_measurements(path))")
    return Measurements.of(v, mu, sigma)


def _laws(given: str | FrictionLaw | Iterable[str | FrictionLaw] | None) -> dict[str, FrictionLaw]:
    """Return the laws to fit, each by its name or its formula."""
    if given is None:
        return dict(catalogue)
    laws: dict[str, FrictionLaw] = {}
    for one in [given] if isinstance(given, str) or not isinstance(given, Iterable) else given:
        law = as_law(one)
        name = law.name or law.text
        if law.curve is not None:
            raise InputError(
                f"{name} goes through measured points, and has nothing to fit; name a law or a formula"
            )
        if name in laws:
            raise InputError(f"the law {name} is given twice; give each once, or another name")
        laws[name] = law
    if not laws:
        raise InputError("there is no law to fit; leave laws out for those of the catalogue")
    return laws
