"""The page of promises names tests that exist, for every promise."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8")
PROMISES = re.split(r"^\*\*(?=P\d+\. )", PAGE.split("## What is not promised")[0], flags=re.MULTILINE)[1:]


def test_promises_are_numbered_in_order() -> None:
    """P1, P2, .. without a gap, so that a number once given can be cited."""
    assert [p.partition(".")[0] for p in PROMISES] == [f"P{k}" for k in range(1, len(PROMISES) + 1)]


def test_every_promise_names_a_test() -> None:
    """Each says which test tries to break it."""
    assert [p.partition(".")[0] for p in PROMISES if "::test_" not in p] == []


def test_the_named_tests_exist() -> None:
    """Every `path::name` on the page is a test function of that file."""
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)
    assert len(named) > len(PROMISES)
    for path, name in named:
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        assert name in {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}, f"{path}::{name}"


def test_the_named_make_targets_exist() -> None:
    """What is run behind a make target can be run."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"`make ([a-z-]+)`", PAGE)) <= targets
