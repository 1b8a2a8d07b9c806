"""Criteria as source text of other languages, which needs nothing of this package.

One more language is an entry in `languages.LANGUAGES`, its words, and a page of text.
"""
