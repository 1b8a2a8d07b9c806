"""``stickslip study``: everything about one operating point, as one page."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.fit import laws_to_fit, progress_of_laws
from stickslip_sym.cli.shared import json_answers, json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, SceneOptions, file_option
from stickslip_sym.cli.shared.reading import read_numbers, require_writable
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from stickslip_sym.comparison.study.study import Study
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.measured.fit import Fit
    from stickslip_sym.model.measured.measurements import Measurements

__all__ = ["study"]

_PAGE = "study.html"


def study(
    law: LawOptions,
    scene: SceneOptions,
    c: Annotated[str | None, typer.Option("-c", metavar="KG/S", help="Damping (0).")] = None,
    fit: Annotated[
        Path | None,
        file_option("--fit", "Measured friction: LAW is fitted to it; without LAW the best of the catalogue."),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help=f"The page ({_PAGE}).")] = Path(
        _PAGE
    ),
    pdf: Annotated[Path | None, file_option("--pdf", "Print the page too, by chromium or chrome.")] = None,
    time_limit: Annotated[
        str | None, typer.Option("--time-limit", metavar="S", help="Seconds for each part (20).")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write one page on one operating point: law, thresholds, motions, uncertainty, margins, formulas.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -c "2.3(1)".

    Example: stickslip study exponential -V 0.5 -c 2.3 -p mu_s=0.50+/-0.02 -o study.html --pdf study.pdf
    """
    from stickslip_sym.comparison.study.parts import study as compute
    from stickslip_sym.core.uncertain import nominal_text
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.output.browser import require_browser
    from stickslip_sym.output.drawing import require_matplotlib

    texts = scene.texts() | {"c": "0" if c is None else c}
    osc = Oscillator(**read_numbers({name: nominal_text(text, name) for name, text in texts.items()}))
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    require_writable(output, pdf)
    require_matplotlib()
    if pdf is not None:
        require_browser()
    friction, measured = _law(law, fit)
    given = {**vars(scene), "c": c}
    found = compute(
        friction,
        osc,
        errors=texts,
        measured=measured,
        assumed=_assumed(law, friction, [name for name in "cVNmk" if given[name] is None]),
        time_limit=limit,
    )
    found.save(output)
    if pdf is not None:
        found.print(pdf)
    if as_json:
        known = {"law": json_output.law(found.law), "scene": json_output.values(texts)}
        json_output.echo("study", **known, **_as_json(found), page=str(output), pdf=pdf and str(pdf))
        return
    typer.echo(in_options(str(found)))
    typer.echo(f"{output}: {len(found.page) / 1000:.0f} kB, in {found.seconds:.1f} s")
    if pdf is not None:
        typer.echo(f"{pdf}: the same, printed")


def _as_json(found: "Study") -> json_output.Json:
    """Return what the page says in numbers; what could not be computed is in "refused", with the reason."""
    return {
        "verdict": found.verdict,
        "attractors": None if found.regime is None else list(map(json_answers.attractor, found.regime.attractors)),
        "thresholds": [
            json_answers.threshold(one.method, one.threshold or one.refused, one.seconds) for one in found.answers
        ],
        "margins": None if found.margins is None else json_answers.margins(found.margins),
        "formulas": {name: json_output.form(form) for name, form in found.forms.items()},
        "refused": {part: in_options(why) for part, why in found.refused.items()},
        "warnings": list(found.doubts),
        "assumed": list(found.assumed),
        "seconds": found.seconds,
    }


def _law(law: LawOptions, fit: Path | None) -> "tuple[FrictionLaw | Fit, Measurements | None]":
    """Return the law with its values, or the best fit, and the measured points that a law goes through."""
    from stickslip_sym.model.fit import fit as fitted
    from stickslip_sym.model.measured.measurements import read_measurements

    if fit is None:
        points = None if law.from_csv is None else read_measurements(law.from_csv).averaged()
        return law.bound(), points
    if law.from_csv is not None:
        raise InputError(
            "the measurements are given twice, by --fit and by --from-csv; --fit fits a law to them, "
            "and --from-csv goes through the points"
        )
    measured = read_measurements(fit)
    if law.law is None:
        chosen = laws_to_fit([], law.values, {})
    else:
        one = law.law_of(law.law)
        chosen = [one.bind(**law.values)]
    typer.echo(measured.understood, err=True)
    with progress_of_laws() as progress:
        return fitted(measured, laws=chosen, progress=progress).best, None


def _assumed(law: LawOptions, friction: "FrictionLaw | Fit", left_out: list[str]) -> list[str]:
    """Say which values were not given."""
    from stickslip_sym.model.law import FrictionLaw

    sentences = []
    if isinstance(friction, FrictionLaw) and (typical := friction.parameters.keys() - law.values.keys()):
        names = ", ".join(name for name in friction.parameters if name in typical)
        sentences.append(f"Typical values of the law, for they were not given: {names}.")
    if left_out:
        sentences.append(f"Not given, and taken as they stand above: {', '.join(left_out)}.")
    return sentences
