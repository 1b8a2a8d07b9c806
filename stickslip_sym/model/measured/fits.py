"""`Fits`: several laws fitted to the same measurements, ranked."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from stickslip_sym.core.numbers import lookup
from stickslip_sym.model.measured.fit import Fit
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output import markup
from stickslip_sym.output.drawing import picture
from stickslip_sym.output.tables import table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Fits"]


class Fits(Sequence[Fit]):
    """Fits of several laws to the same measurements, the best first.

    Attributes
    ----------
    measured : Measurements
    rejected : dict of str to str
        Laws that these measurements do not determine, each with the reason.
    """

    def __init__(self, fits: Sequence[Fit], measured: Measurements, rejected: Mapping[str, str]) -> None:
        ranked = sorted(fits, key=lambda fit: fit.aicc)
        likelihoods = np.exp([(ranked[0].aicc - fit.aicc) / 2 for fit in ranked])
        weights = likelihoods / likelihoods.sum()
        self._fits = tuple(replace(fit, weight=float(w)) for fit, w in zip(ranked, weights, strict=True))
        self.measured = measured
        self.rejected = dict(rejected)

    @property
    def best(self) -> Fit:
        """The fit with the least AICc."""
        return self._fits[0]

    @overload
    def __getitem__(self, place: int | str) -> Fit: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Fit]: ...
    def __getitem__(self, place: int | str | slice) -> Fit | Sequence[Fit]:
        """Return a fit by its rank from 0, or by its law's name."""
        if isinstance(place, str):
            return lookup("fit of the law", place, {fit.name: fit for fit in self._fits})
        return self._fits[place]

    def __len__(self) -> int:
        return len(self._fits)

    def __str__(self) -> str:
        header, rows = self._table()
        parts = [str(self.measured), table(header, rows)]
        parts += [f"warning: {fit.name}: {text}" for fit in self._fits[:1] for text in fit.warnings]
        if self.rejected:
            parts.append(table(["not fitted", "because"], [[name, why] for name, why in self.rejected.items()]))
        return "\n\n".join(parts)

    def __repr__(self) -> str:
        return f"Fits: {', '.join(f'{fit.name} ({fit.weight:.2g})' for fit in self._fits)}; {self.measured}"

    def _table(self) -> tuple[list[str], list[list[str]]]:
        rows = []
        for fit in self._fits:
            doubts = f"{len(fit.warnings)} warning{'s' * (len(fit.warnings) > 1)}" if fit.warnings else ""
            rows.append(
                [
                    fit.name,
                    f"{fit.aicc - self.best.aicc:.1f}",
                    f"{fit.weight:.3f}",
                    f"{fit.sigma:.3g}",
                    fit.values_in_words(),
                    doubts,
                ]
            )
        return ["law", "AICc above", "weight", "sigma", "values", ""], rows

    def _repr_html_(self) -> str:
        header, rows = self._table()
        drawn = picture(self.best._figure, f"measured friction and the fitted law {self.best.name}")
        rest = [f"not fitted: {name}: {why}" for name, why in self.rejected.items()]
        return markup.block(str(self.measured), markup.table(header, rows), drawn, *rest)

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw the best fit, as `Fit.plot` does."""
        return self.best.plot(path)

    def content(self) -> dict[str, object]:
        """Return all that the fits say as nested dictionaries and lists that JSON holds."""
        return {
            "measured": self.measured.understood,
            "fits": [fit.content() for fit in self._fits],
            "not_fitted": self.rejected,
        }

    def to_json(self) -> str:
        """Return all that the fits say as JSON."""
        return json.dumps(self.content(), indent=2, ensure_ascii=False, allow_nan=False)
