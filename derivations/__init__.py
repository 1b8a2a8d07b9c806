"""The paper's mathematics, proved step by step.

Read the files in the order of `CHAPTERS`; ``python -m derivations`` runs them. Each has a function
`derivation`, which computes its chapter when asked. It takes printed equations to be used in place of
the paper's, by their numbers: that is how the tests see that a wrong equation is refuted.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from stickslip_sym.formula.derivation import Derivation

__all__ = ["CERTIFICATES", "CHAPTERS", "chapter"]

CHAPTERS = {
    "energy_balance": "d1_energy_balance",
    "linearised_force": "d2_linearised_force",
    "least_squares": "d3_least_squares",
    "slope_average": "d4_slope_average",
    "exponential_law": "d5_exponential_law",
    "polynomial_law": "d6_polynomial_law",
    "units": "d7_units",
    "second_order": "d8_second_order",
    "hopf": "d9_hopf",
    "one_threshold": "d10_one_threshold",
}
"""Name of a chapter to the module that holds it, in reading order."""


CERTIFICATES = [(law, name) for law in ("exponential", "polynomial") for name in ("least_squares", "harmonic")]
"""The closed forms (17), (18), and those of the harmonic criterion, whose proofs are scripts in `certificates`.

``stickslip export exponential --criterion harmonic --certificate exponential_harmonic.py`` writes one. The
linearisation (15) for any law has another: ``python -m derivations least_squares --certificate`` prints it.
"""


def chapter(name: str) -> Callable[[Mapping[str, Any]], Derivation]:
    """Return the function that computes a chapter; it takes equations that replace the paper's."""
    function: Callable[[Mapping[str, Any]], Derivation] = import_module(f"derivations.{CHAPTERS[name]}").derivation
    return function
