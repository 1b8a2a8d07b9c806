"""`MadeOfMeasurements`: laws that go through measured points, and files of them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Self

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.numbers import Number
from stickslip_sym.model.measured.measurements import Measurements, read_measurements
from stickslip_sym.model.samples import SampledCurve


class MadeOfMeasurements:
    """A law that can be made of measured points, and of a file of them."""

    expr: Expr
    curve: SampledCurve | None

    @classmethod
    def from_curve(cls, curve: SampledCurve, **about: str | None) -> Self:
        """Return the law that a piecewise cubic is; `about` is its name, source and validity."""
        law = cls(0, **about)  # type: ignore[call-arg]  # as the constructor of a law has it
        law.expr, law.curve = curve.expr, curve
        return law

    @classmethod
    def from_samples(
        cls,
        v: Iterable[Number],
        mu: Iterable[Number],
        *,
        extrapolate: bool = False,
        name: str = "samples",
        source: str | None = None,
    ) -> Self:
        """Return the law through measured points: a piecewise cubic that rises and falls only where they do.

        Parameters
        ----------
        v : sequence of 4 to 60 numbers
            Slip speeds in m/s, ascending, the first one 0 unless `extrapolate`.
        mu : sequence of as many numbers
            Coefficients of friction. The first one is mu(0+); a higher static coefficient is no slip speed's.
        extrapolate : bool
            Hold the first coefficient down to v = 0, and the last one for all higher speeds. Otherwise
            speeds beyond the last are errors: a criterion at the belt speed V needs mu up to 2 V.
        name, source : str, optional

        Warns
        -----
        InputWarning
            If a coefficient is held below the first measured speed.

        References
        ----------
        F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic interpolants,
        SIAM J. Sci. Stat. Comput. 5 (1984), as `scipy.interpolate.PchipInterpolator` has it.
        """
        return cls.from_curve(SampledCurve.through(v, mu, extrapolate=extrapolate), name=name, source=source)

    @classmethod
    def from_csv(
        cls,
        path: str | Path | Measurements,
        *,
        extrapolate: bool = False,
        source: str | None = None,
        name: str | None = None,
    ) -> Self:
        """Return the law through the points in a file of measurements, or through what was read of it.

        The file is read as by `read_measurements`; points of one speed are averaged. The law has the file's name
        unless it is given one. Decimal numbers are taken exactly as they are written. What `from_samples` refuses
        is refused here.
        """
        measured = path if isinstance(path, Measurements) else read_measurements(path)
        name = name or measured.name or "samples"
        return cls.from_samples(*measured.points(), extrapolate=extrapolate, name=name, source=source)
