"""``fuzzyc sim``: robots that run the generated C, in words, numbers and pictures."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzyspec.diagnostics.refusal import MissingTool, Refusal

if TYPE_CHECKING:
    from firmware_sim.trial import Trial


def register(subparsers: Any) -> None:
    """Add the command."""
    from firmware_sim.scenario import SCENARIOS

    parser = subparsers.add_parser(
        "sim",
        help="run robots under the generated C, and draw what happened",
        description="Run robots under a controller, side by side with its exact meaning.",
        epilog="exit status: 0 everybody arrived and nobody touched, 1 otherwise",
    )
    parser.add_argument("scenario", choices=sorted(SCENARIOS), help="who starts where and wants to go where")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="write pictures (PNG) and numbers (CSV) there")
    parser.add_argument(
        "--controller",
        choices=("c", "exact", "both"),
        default="both",
        help="what is in the loop: the generated C, the exact meaning, or one run of each (default)",
    )
    parser.add_argument(
        "--spec", metavar="FILE", type=Path, help="a spec with nav.fz's inputs and outputs (default: nav.fz)"
    )
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the scenario, print, write."""
    if arguments.output is not None and importlib.util.find_spec("matplotlib") is None:
        raise MissingTool("the pictures need matplotlib", "pip install 'fuzzyc[sim]', or leave out -o")
    from firmware_sim.controllers import Unfit
    from firmware_sim.scenario import SCENARIOS
    from firmware_sim.trial import as_data, as_text, carry_out
    from fuzzyspec.api import load

    spec = load(_nav() if arguments.spec is None else arguments.spec)
    try:
        trial = carry_out(SCENARIOS[arguments.scenario], spec, arguments.controller)
    except Unfit as error:
        raise Refusal(str(error)) from error
    files: list[str] = []
    if arguments.output is not None:
        from fuzzyspec.emit.plan import Plan, write

        files = write(Plan(_files(trial)), arguments.output)
    if arguments.format == "json":
        import json

        print(json.dumps({**as_data(trial), "files": files}, indent=2))
    else:
        print("\n".join(as_text(trial)))
        if files:
            print(f"in {arguments.output}: {', '.join(files)}")
    return 0 if trial.succeeded else 1


def _nav() -> Path:
    """The example nav.fz, in the checkout or in the wheel."""
    from fuzzyspec.resources import folder

    return Path(str(folder("examples").joinpath("nav.fz")))


def _files(trial: Trial) -> dict[str, bytes]:
    """Pictures of the first run, and every run's numbers."""
    from firmware_sim.pictures import draw
    from firmware_sim.record import as_csv, as_recording
    from firmware_sim.trial import LABELS

    main, beside = trial.main, trial.beside
    labels = (LABELS[main.meaning], "" if beside is None else LABELS[beside.meaning])
    found = draw(main.run, main.ddc, None if beside is None else beside.run, labels)
    for outcome in trial.outcomes:
        found[f"run_{outcome.meaning}.csv"] = as_csv(outcome.run, outcome.ddc).encode()
    for track in main.run.tracks:
        found[f"readings_{track.errand.robot}.csv"] = as_recording(track).encode()
    return found
