"""Criteria as source text of other languages, which needs nothing of this package.

One more language is one file here with its page of text, a subclass of `language.Language`, and its line in
`languages.LANGUAGES`.
"""
