"""What computed a page, and when."""

import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

from stickslip_sym.core.version import __version__

__all__ = ["now", "versions"]

_PACKAGES = ("sympy", "mpmath", "numpy", "scipy", "matplotlib")


def versions(*more: str) -> dict[str, str]:
    """Return what computes here: Python, packages and more of them, as far as they are installed, the machine."""
    found = {"python": platform.python_version(), "stickslip_sym": __version__}
    for name in (*_PACKAGES, *more):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found | {"platform": platform.platform(), "machine": platform.machine()}


def now() -> str:
    """Return the time as pages tell it."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
