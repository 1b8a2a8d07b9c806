"""What several commands share: their options, how texts are read, JSON, and messages in words of the command line.

Imports what the commands do, but no command. One more shared option is declared in `options`.
"""
