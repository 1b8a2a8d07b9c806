"""The exceptions of the package: each message says what was got, what was required and what to try."""

from stickslip_sym.core.remedies import Remedy


class _Message(Exception):
    """A message in parts: texts, remedies, which read as the interface in use words them, and other messages."""

    def __init__(self, *parts: "str | Remedy | _Message") -> None:
        super().__init__(
            *(item for part in parts for item in (part.args if isinstance(part, _Message) else [part]))
        )

    @property
    def remedies(self) -> tuple[Remedy, ...]:
        """What it advises, as data."""
        return tuple(part for part in self.args if isinstance(part, Remedy))

    def __str__(self) -> str:
        return "".join(map(str, self.args))


class StickSlipError(_Message):
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


class InputWarning(_Message, UserWarning):
    """A law or a file that can be used as given, and is probably not what was meant."""
