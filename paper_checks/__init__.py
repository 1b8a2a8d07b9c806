"""The claims of the paper, checked: ``pytest paper_checks``."""
