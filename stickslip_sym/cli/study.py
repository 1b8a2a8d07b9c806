"""``stickslip study``: everything about an operating point, as one page."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip_sym.cli.fit import laws_to_fit
from stickslip_sym.cli.options import (
    DAMPING,
    LAW,
    POINT,
    Given,
    command,
    file_option,
    option,
    time_limit,
)  # fmt: skip
from stickslip_sym.cli.output import counted, echo_all, point_of
from stickslip_sym.cli.reading import (
    Point,
    assignments,
    law_described,
    measurements,
    points,
    reading_of,
)
from stickslip_sym.cli.words import in_options
from stickslip_sym.core.errors import InputError, InputWarning

if TYPE_CHECKING:
    from stickslip_sym.model.fitting.result import Fits
    from stickslip_sym.model.measured.measurements import Measurements

_PAGE = "study.html"


@command(
    "study", LAW, POINT, DAMPING,
    option("--fit", type=Path, metavar="FILE", help="Measured friction to fit LAW, or the catalogue, to."),
    file_option("--output", f"The page ({_PAGE}).", endings=(".html", ".htm", ".xhtml"), default=_PAGE),
    file_option("--pdf", "Print the page too, by chromium or chrome.", endings=(".pdf",)),
    time_limit("Seconds for each part (20)."),
)  # fmt: skip
def run(given: Given) -> None:
    """Write one page on one operating point: law, thresholds, motions, uncertainty, margins, formulas.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -c "2.3(1)". Several --point files make a page
    each, with their names. --name is the title of the page.

    Example: stickslip study exponential -V 0.5 -c 2.3 -p mu_s=0.50+/-0.02 -o study.html --pdf study.pdf
    """
    from stickslip_sym.comparison.study.study import study
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.output.browser import require_browser
    from stickslip_sym.output.drawing import require_matplotlib
    from stickslip_sym.output.page.render import require_templates

    require_matplotlib()
    require_templates()
    limit, output, pdf = given["time_limit"], given["output"], given["pdf"]
    if pdf is not None:
        require_browser()
    fits, measured, at = _described(given)
    contents = []
    for one in at:
        page, paper = (_named(path, one, len(at) > 1) for path in (output, pdf))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)  # they head what is printed
            found = study(
                one.law if fits is None else fits, Oscillator(**one.numbers), errors=one.texts, measured=measured,
                name=given["name"], defaults=(*one.typical, *one.defaults), time_limit=limit,
            )  # fmt: skip
        found.save(page or _PAGE)
        if paper is not None:
            found.print(paper)
        if given["json"]:
            contents.append({**point_of(one), "study": found, "page": page, "pdf": paper})
            continue
        click.echo(f"{one}\n\n{in_options(str(found))}")
        click.echo(f"{page}: {len(found.page) / 1000:.0f} kB, in {found.seconds:.1f} s")
        if paper is not None:
            click.echo(f"{paper}: the same, printed")
    if given["json"]:
        echo_all("study", contents)


def _described(given: Given) -> "tuple[Fits | None, Measurements | None, list[Point]]":
    """Return fits if they were asked for, the points that a law goes through, and the operating points."""
    from stickslip_sym.model.fitting.fit import fit
    from stickslip_sym.model.measured.measurements import read_measurements

    file = given["fit"]
    if file is None:
        at = points(given, c="0")
        passed = (
            None if given["from_csv"] is None else measurements(given.__getitem__, given["from_csv"]).averaged()
        )
        given.all_used()
        return None, passed, at
    if given["from_csv"] is not None:
        raise InputError(
            "the measurements are given twice, by --fit and by --from-csv; --fit fits a law to them, "
            "and --from-csv goes through the points"
        )
    reading, fixed = reading_of(given.__getitem__), assignments(given["parameter"])
    if given["law"] is None:
        laws = laws_to_fit((), fixed, given)
    else:
        laws = [law_described(given.__getitem__, given["law"]).bind(**fixed)]
    at = points(given, c="0", law=laws[0])
    given.all_used()
    measured = read_measurements(file, **reading)
    click.echo(measured.understood, err=True)
    with counted("laws") as progress:
        fits = fit(measured, laws=laws, progress=progress)
    return fits, None, [replace(one, law=fits.best.law) for one in at]


def _named(path: Path | None, point: Point, several: bool) -> Path | None:
    """Return the file of a page, with the name of its point where there are several."""
    if path is None or not several or point.file is None:
        return path
    return path.with_name(f"{path.stem}-{point.file.stem}{path.suffix}")
