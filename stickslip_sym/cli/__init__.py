"""The command line, one file a command.

Imports everything. One more command is one file with its function, and its line in `program`.
"""
