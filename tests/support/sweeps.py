"""Sweeps over many cases: a few always, the others with ``pytest --thorough``."""

import pytest
from hypothesis import settings


def sweep(names, cases, *always, **options):
    """Parametrize a test over cases, of which all but those named last are `thorough`."""
    cases = list(cases)
    unknown = [case for case in always if case not in cases]
    if unknown:
        raise ValueError(f"always to be run, but not among the cases: {unknown}")
    rows = []
    for case in cases:
        arguments = case if isinstance(case, tuple) else (case,)
        rows.append(pytest.param(*arguments, marks=() if case in always else pytest.mark.thorough))
    return pytest.mark.parametrize(names, rows, **options)


def sample(count):
    """Take so many cases of a test, at even distances; with ``--thorough`` all. It stands above the cases."""
    return pytest.mark.sample(count)


def outside_samples(items):
    """Return the tests that no sample takes: the others of each test function that is sampled."""
    functions = {}
    for item in items:
        if item.get_closest_marker("sample"):
            functions.setdefault(item.function, []).append(item)
    left = set()
    for function, cases in functions.items():
        count = next(mark.args[0] for mark in function.pytestmark if mark.name == "sample")
        left.update(set(cases) - {cases[len(cases) * number // count] for number in range(count)})
    return left


def some(cases, count):
    """Take so many of the cases that a test goes through, at even distances; with ``--thorough`` all."""
    cases = list(cases)
    if settings().max_examples >= 100:
        return cases
    return [cases[len(cases) * number // count] for number in range(count)]


def fewer(examples):
    """Take so many examples of a property that is dear; with ``--thorough`` as many as of any."""
    usual = settings().max_examples
    return settings(max_examples=examples if usual < 100 else usual)
