"""The compiler's version, in one place: the wheel, ``fuzzyc --version`` and every generated header read it."""

__version__ = "0.1.0"
