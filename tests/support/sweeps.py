"""Sweeps over a whole catalogue: a few cases always, the others with ``pytest --thorough``."""

import pytest

__all__ = ["sweep"]


def sweep(names, cases, *always):
    """Parametrize a test over cases, of which all but those named last are `thorough`."""
    missing = [case for case in always if case not in cases]
    assert not missing, f"{missing} are none of the cases"
    marked = [
        pytest.param(
            *case if isinstance(case, tuple) else (case,), marks=() if case in always else pytest.mark.thorough
        )
        for case in cases
    ]
    return pytest.mark.parametrize(names, marked)
