"""Levels of probability, each with one meaning wherever noise or a choice of laws is judged."""

from statistics import NormalDist

USUAL_PROBABILITY = 0.95  # of an interval, and of what is taken for certain
UNLIKELY = 0.01  # of what noise shows, or of a law beside the best: what is less is worth a remark
VERY_UNLIKELY = 0.001  # the same, where what noise could show would be taken for a fault
_NORMAL_DISTRIBUTION = NormalDist()
NORMAL = _NORMAL_DISTRIBUTION.inv_cdf((1 + USUAL_PROBABILITY) / 2)
"""Standard errors on either side, within which a normal distribution has the usual probability."""
FAR_OFF = _NORMAL_DISTRIBUTION.inv_cdf(1 - VERY_UNLIKELY / 2)
"""Standard errors beyond which noise is very unlikely."""
