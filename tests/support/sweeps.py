"""Sweeps over many cases: a few always, the others with ``pytest --thorough``."""

import pytest
from hypothesis import settings


def sweep(names, cases, *always, **options):
    """Parametrize a test over cases, of which all but those named last, or at those places, are `thorough`."""
    cases = list(cases)
    kept = [case if case in cases else cases[case] for case in always]
    thorough = pytest.mark.thorough
    rows = [case if isinstance(case, tuple) else (case,) for case in cases]
    marked = [
        pytest.param(*row, marks=[thorough] * (case not in kept)) for row, case in zip(rows, cases, strict=True)
    ]
    return pytest.mark.parametrize(names, marked, **options)


def fewer(examples):
    """Take so many examples of a property that is dear; with ``--thorough`` as many as of any."""
    usual = settings().max_examples
    return settings(max_examples=examples if usual < 100 else usual)
