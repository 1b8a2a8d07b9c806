"""`Critical`: a value of one quantity or parameter at which a given damping is just the pure-slip damping."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.output import markup

__all__ = ["Critical"]


@dataclass(frozen=True)
class Critical:
    """A value of one quantity or parameter at which the given damping is just the pure-slip damping.

    Attributes
    ----------
    of : str
        Which one.
    value : float
        In SI units.
    unit : str or None
    method : str
    relative_error : float or None
        Estimated error, relative; with "proof" a bound; None where nothing is known of it.
    sensitivity : mapping of str to float
        How the value changes with c and with everything else, by name.
    enclosure : Enclosure or None
        With "proof": two values, at one of which the slip from P returns to the belt's speed and at the other not.
    """

    of: str
    value: float
    unit: str | None
    method: str
    relative_error: float | None
    sensitivity: Mapping[str, float] = field(repr=False)
    enclosure: Enclosure | None = None

    def __str__(self) -> str:
        accuracy = "unknown" if self.relative_error is None else f"{self.relative_error:.0e}"
        unit = "" if self.unit in (None, "1") else f" {self.unit}"
        proof = "" if self.enclosure is None else ", PROVED"
        return f"{self.of} = {self.value:.10g}{unit} ({self.method}, relative error {accuracy}{proof})"

    def __repr__(self) -> str:
        return f"Critical: {self}"

    def _repr_html_(self) -> str:
        return markup.block(f"critical value: {self}")
