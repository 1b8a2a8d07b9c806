"""The exceptions of the package: each message says what was got, what was required and what to try."""


class StickSlipError(Exception):
    """Base of every error that this package raises on purpose."""


class InputError(StickSlipError, ValueError):
    """A law, a number, a name or a file that cannot be used as given."""


class NoClosedForm(StickSlipError):
    """The criterion of this law has no closed form that could be found and verified."""


class NoThreshold(StickSlipError):
    """No damping c >= 0 separates stick-slip from slip at this operating point."""


class NotConverged(StickSlipError):
    """A bound on the work was reached before the accuracy that was asked for."""


class OutOfTime(StickSlipError):
    """The time limit of a call was reached before its result."""


NO_RESULT = (InputError, NoClosedForm, NoThreshold, NotConverged)
"""Every error that more time would not mend: all but `OutOfTime`."""


class InputWarning(UserWarning):
    """A law or a file that can be used as given, and is probably not what was meant."""
