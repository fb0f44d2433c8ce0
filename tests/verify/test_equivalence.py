"""``verify`` says yes to what is right, and no, with a smallest input, to what is wrong."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from fractions import Fraction

import pytest

from fuzzyspec import api
from fuzzyspec.exact.rational import membership
from fuzzyspec.lower import Options as LowerOptions
from fuzzyspec.verify import Options, Report, TheirC, as_json, as_text, verify
from fuzzyspec.verify.cases import batches
from tests.conftest import without
from tests.verify import verify_specs

Edit = Callable[[str], str]


def spec(name: str) -> api.Spec:
    """One of the specs beside this file."""
    return api.load(getattr(verify_specs, name))


def verify_edited(loaded: api.Spec, edit: Edit, cases: int = 2000, seconds: float = 20.0) -> Report:
    """Verify a C file that somebody edited, of loops and tables."""
    files = loaded.compile(LowerOptions(optimize="size", target="avr")).files
    source = files[f"{loaded.name}.c"].decode()
    edited = edit(source)
    assert edited != source
    theirs = TheirC({f"{loaded.name}.c": edited.encode()})
    options = Options(cases=cases, seconds=seconds)
    return verify(loaded.lowered.program, loaded._subjects, files, options, theirs)


@pytest.mark.parametrize("name", ["DANGER", "BYTES", "HOLDING"])
def test_generated_c_is_verified(name: str) -> None:
    """Controllers, sentence rules, lists, folds and states: no mismatch, every error within its bound."""
    report = spec(name).verify(cases=5000)
    assert report.failures == ()
    for found in report.functions:
        assert found.mismatches == 0
        assert found.cases >= 5000
        assert found.sanitized > 0
        assert any(output.largest_error for output in found.outputs)
        for output in found.outputs:
            if output.bound is not None:
                assert output.largest_error is not None
                assert output.largest_error <= output.bound


@pytest.mark.parametrize("name", ["fuzzyc", "runner", "batches", "harness", "main", "input"])
def test_modules_may_have_any_name(name: str) -> None:
    """Nothing of the build gets in the way of a module's own files and symbols."""
    loaded = api.load(verify_specs.DANGER.replace("module small", f"module {name}"))
    assert loaded.verify(cases=100, sanitize=False).ok


def test_small_input_spaces_are_tried_whole() -> None:
    """Two inputs of 8 bits are 65,536 cases, and then that is all of them."""
    found = spec("BYTES").verify().function("fan")
    assert found.kinds == {"every input": 65536}


def test_every_list_length_is_tried() -> None:
    """Lists of 0 up to two past the capacity, and of 255."""
    kinds = spec("HOLDING").verify(cases=1000).function("both").kinds
    assert {f"lists of {n}" for n in (0, 1, 2, 3, 4, 5, 255)} <= set(kinds)
    assert kinds["traces"] > 0


def test_a_changed_table_entry_is_found() -> None:
    """One cell with another consequent: the report shows an input that starts this very cell."""
    loaded = spec("DANGER")

    def edit(source: str) -> str:
        start = source.index("_rules[9]")
        at = source.index("2U", start)
        return source[:at] + "1U" + source[at + 2 :]

    report = verify_edited(loaded, edit)
    assert not report.ok
    failure = next(f for f in report.failures if f.kind == "c")
    assert failure.function == "danger"
    assert [d.what for d in failure.differences] == ["ddc"]
    assert failure.example is not None
    assert "smallest input found" in as_text(report)


def test_the_smallest_input_has_no_spare_elements() -> None:
    """A list fault that needs one element of kind 9 is shown with one element."""
    loaded = spec("HOLDING")

    def edit(source: str) -> str:
        trap = "if ((in->parts_count == 2U) && (in->parts[1].kind > 30000U)) { return 64U; }"
        return _with_first_statement(trap, "keeper_step(")(source)

    report = verify_edited(loaded, edit)
    failure = next(f for f in report.failures if f.kind == "c")
    assert failure.example is not None
    assert failure.example.inputs["parts.count"] == 2
    assert failure.example.inputs["x"] == 0
    assert failure.example.inputs["parts.size"] == (0, 0)


@pytest.mark.parametrize(
    "edit",
    [
        lambda source: source + "\n/* read and found good */\n",
        lambda source: source.replace("    ", "\t").replace("{\n", "{\n\n"),
        lambda source: source.replace("\n", "\r\n"),
    ],
    ids=["comment", "white space", "line ends"],
)
def test_edits_that_change_nothing_pass(edit: Edit) -> None:
    """Comments and layout are the user's own."""
    assert verify_edited(spec("DANGER"), edit).failures == ()


def test_c_that_does_not_compile_is_reported() -> None:
    """The compiler's own words, and no traceback."""
    report = verify_edited(spec("DANGER"), lambda source: source.replace("return", "retrun", 1))
    assert [f.kind for f in report.failures] == ["build"]
    assert "retrun" in report.failures[0].output


def _with_first_statement(statement: str, opening: str) -> Edit:
    def edit(source: str) -> str:
        body = source.index("{", source.index(opening))
        return source[: body + 1] + f"\n    {statement}" + source[body + 1 :]

    return edit


def test_c_that_hangs_is_reported() -> None:
    """An endless loop ends with the time limit, and the input is shown."""
    edit = _with_first_statement("while (in->near > 40000U) { }", "small_danger(")
    report = verify_edited(spec("DANGER"), edit, seconds=2.0)
    failure = next(f for f in report.failures if f.function == "danger")
    assert failure.kind == "death"
    assert "no end after 2 s" in failure.message
    assert failure.example is not None
    near = failure.example.inputs["near"]
    assert isinstance(near, int)
    assert near > 40000


def test_c_that_crashes_is_reported() -> None:
    """A crash is told by its signal, with a small input."""
    edit = _with_first_statement("if (in->near > 40000U) { *(volatile int *)0 = 1; }", "small_danger(")
    report = verify_edited(spec("DANGER"), edit)
    failure = next(f for f in report.failures if f.kind == "death")
    assert "SIGSEGV" in failure.message
    assert failure.example is not None
    assert failure.example.inputs["gap"] == 0


def test_undefined_behaviour_is_reported() -> None:
    """What happens to give the right value, but is undefined, fails under the sanitizers."""
    edit = _with_first_statement("volatile int big = 2147483647 - 40000; big = big + in->near;", "small_danger(")
    report = verify_edited(spec("DANGER"), edit)
    if "undefined" not in report.sanitizers:
        without("this compiler has no sanitizers")
    assert any("signed integer overflow" in f.message for f in report.failures)


def test_an_unset_output_is_reported() -> None:
    """An output that is not written at all does not pass by luck."""
    report = verify_edited(spec("DANGER"), lambda source: source.replace("out->ddc =", "(void)", 1))
    assert any(f.kind == "c" for f in report.failures)


def test_a_bound_that_does_not_hold_is_reported() -> None:
    """With a certificate that promises too much the verification fails and shows the error."""
    loaded = spec("DANGER")
    subject = loaded._subjects[0]
    bound = dataclasses.replace(subject.certificate.outputs[0], error=Fraction(1, 10**6))
    false = dataclasses.replace(subject, certificate=dataclasses.replace(subject.certificate, outputs=(bound,)))
    report = verify(loaded.lowered.program, [false], loaded.compile().files, Options(cases=2000, sanitize=False))
    assert [f.kind for f in report.failures] == ["bound"]
    assert float(report.failures[0].differences[0].got) > 1e-6


def test_a_band_that_does_not_hold_is_reported() -> None:
    """A decision that differs without a band to allow it fails, too."""
    loaded = spec("BYTES")
    subject = loaded._subjects[0]
    moved = dataclasses.replace(subject.model, fires_at=Fraction(1, 7))
    false = dataclasses.replace(subject, model=moved, certificate=dataclasses.replace(subject.certificate, bands=()))
    report = verify(loaded.lowered.program, [false], loaded.compile().files, Options(cases=2000, sanitize=False))
    assert "band" in [f.kind for f in report.failures]


def test_same_seed_same_report() -> None:
    """A seed is all it takes to see the same again; another one sees something else."""
    loaded = spec("DANGER")
    once, again, other = (loaded.verify(cases=3000, seed=seed, sanitize=False) for seed in (5, 5, 6))
    assert as_json(once) == as_json(again)
    assert as_json(once)["functions"] != as_json(other)["functions"]


def test_data_says_what_the_text_says() -> None:
    """The JSON form carries bounds as exact fractions, bands and every count."""
    report = spec("HOLDING").verify(cases=1000)
    data = as_json(report)
    assert data["ok"] is True
    assert data["cases"] == sum(f["cases"] for f in data["functions"])
    hold = next(f for f in data["functions"] if f["function"] == "hold")
    bound = spec("HOLDING").certificate("hold").output("y").error
    assert bound is not None
    assert Fraction(hold["outputs"][0]["bound_exact"]) == bound
    assert [d["key"] for d in hold["decisions"]] == ["fires.y"]


def test_rare_faults_are_found_in_bulk() -> None:
    """A fault at one input in 260,000 is beyond the few aimed cases asked for, but not beyond a million in bulk."""
    trap = "if ((((in->near * 419U) & 511U) == 7U) && (((in->gap * 419U) & 511U) == 9U)) { return 64U; }"
    report = verify_edited(spec("DANGER"), _with_first_statement(trap, "small_danger("), cases=20_000)
    assert [f.kind for f in report.failures] == ["c"]
    assert report.failures[0].example is not None


def test_every_cell_of_a_table_is_started_alone() -> None:
    """Whatever the number of cells, the peaks of its terms meet."""
    loaded = spec("DANGER")
    first = next(iter(batches(loaded._subjects[0], 1, 10)))
    assert first.kind == "peaks"
    assert len({(int(a), int(b)) for a, b in zip(first.inputs["near"], first.inputs["gap"], strict=True)}) == 9
    for at in range(9):
        for name in ("near", "gap"):
            assert max(controller_degrees(loaded, name, int(first.inputs[name][at]))) >= 1 - Fraction(1, 2000)


def controller_degrees(loaded: api.Spec, name: str, raw: int) -> list[Fraction]:
    """The degrees of one input's terms, from the definition."""
    item = next(i for i in loaded.controllers["danger"].inputs if i.name == name)
    value = item.variable.raw.value(raw)
    return [membership(term.shape, value) for term in item.terms]
