"""What the exit code of a command says."""

BAD_INPUT, NO_RESULT = 2, 1
SIGNALLED = 128
"""What shells add to the number of a signal, for the exit code of what it ended."""
