"""``python -m fuzzyspec`` is ``fuzzyc``."""

from fuzzyspec.cli.main import entry

entry()
