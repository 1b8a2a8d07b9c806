"""The version, in a file that costs nothing to import."""

__version__ = "1.1.0"
