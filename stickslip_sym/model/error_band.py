"""The band that standard errors of a law's values leave open about mu."""

import numpy as np
from uncertainties import covariance_matrix

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.probabilities import NORMAL
from stickslip_sym.model.law import FrictionLaw


def error_band(law: FrictionLaw, v: FloatArray, quantile: float = NORMAL) -> tuple[FloatArray, FloatArray]:
    """Return mu less and plus so many of its standard errors, which are those of the parameters to first order."""
    mu = law.at_speeds(v)
    half = np.zeros(v.shape)
    if law.uncertain:
        covariance = np.array(covariance_matrix(list(law.uncertain.values())))
        by = np.array([law.partial(name).at_speeds(v) for name in law.uncertain])
        half = quantile * np.sqrt(np.einsum("in,ij,jn->n", by, covariance, by))
    return mu - half, mu + half
