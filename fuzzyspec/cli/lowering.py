"""How a spec is compiled: the options that commands share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from fuzzyspec.cli.spec import percent

if TYPE_CHECKING:
    from fuzzyspec.lower import Options


def add_lowering(parser: argparse.ArgumentParser, *words: str) -> None:
    """Add them; ``words`` are the option strings by which the machine to choose for is named, besides ``--for``."""
    parser.add_argument(
        "--bounds",
        choices=("quick", "thorough"),
        default="quick",
        help="how hard to work for the certified errors (default: quick)",
    )
    parser.add_argument(
        "--optimize",
        choices=("speed", "balanced", "size"),
        default="balanced",
        help="what to choose the strategies for (default: balanced)",
    )
    parser.add_argument(
        "--for",
        *words,
        dest="chosen_for",
        choices=("generic", "cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr"),
        default="generic",
        help="the machine to choose the strategies for; the C runs on all of them (default: generic)",
    )
    add_tolerance(parser)


def add_tolerance(parser: argparse.ArgumentParser) -> None:
    """Add the one of them that changes what is computed, for commands that compute and do not compile."""
    parser.add_argument(
        "--tolerance",
        metavar="PERCENT",
        type=percent,
        help="an error of every output that you can live with, in percent of its range: where it can be certified, "
        "fewer bits are computed",
    )


def lowering(arguments: argparse.Namespace) -> Options:
    """What was asked for."""
    from fuzzyspec.lower import Options

    return Options(arguments.bounds, arguments.optimize, arguments.chosen_for, tolerance=arguments.tolerance)
