"""The library: what a user's own script does with a spec."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyspec
from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.exact import dequantise
from fuzzyspec.fixed.quantise import quantise
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import RAW_LIMITS, CType, Raw, Variable

NAV = Path(__file__).parent.parent.parent / "examples" / "nav.fz"

KEEPER = """\
module keeper
controller hold {
    input  x in [-1, 1] { term low = ramp_down(-0.8, -0.3)  term high = ramp_up(0.2, 0.9) }
    output y in [0, 5] V { singletons A B  otherwise hold initial 2 V }
    infer { defuzzify = weighted_average }
    rules {
        if x is low then y is A
        if x is high then y is B
    }
}
"""


@pytest.fixture(scope="module")
def nav() -> fuzzyspec.Spec:
    """The example of the two layers."""
    return fuzzyspec.load(NAV)


def obstacles(n: int, m: int) -> dict[str, np.ndarray]:
    """A system's inputs in declared units."""
    draw = np.random.default_rng(3)
    return {
        "target_bearing": draw.uniform(-180, 180, n),
        "obstacles.distance": draw.uniform(0, 8, (n, m)),
        "obstacles.bearing": draw.uniform(-180, 180, (n, m)),
        "obstacles.speed": draw.uniform(0, 2, (n, m)),
        "obstacles.radius": draw.uniform(0, 1, (n, m)),
        "obstacles.count": draw.integers(0, m + 1, n),
    }


def test_importing_the_library_is_cheap() -> None:
    """``import fuzzyspec`` loads none of what only evaluation or parsing needs."""
    code = "import sys, fuzzyspec; print(*[n for n in ('numpy', 'lark', 'jinja2', 'cffi') if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_spec_tells_what_it_holds(nav: fuzzyspec.Spec) -> None:
    """Controllers and systems by name, in declared order."""
    assert nav.name == "nav"
    assert list(nav.controllers) == ["danger", "velocity"]
    assert list(nav.systems) == ["nav"]
    assert list(nav.functions) == ["danger", "velocity", "nav"]
    assert nav.default_function == "nav"


def test_three_meanings_of_one_system(nav: fuzzyspec.Spec) -> None:
    """C and integer program agree bit for bit; the exact meaning lies within the certified bounds of both."""
    inputs = obstacles(200, 5)
    native, fixed = nav.native("nav", inputs), nav.fixed("nav", inputs)
    at = nav.dequantise("nav", nav.quantise("nav", inputs))
    exact = nav.exact("nav", at, decisions=fixed.decisions)
    for name, raws in fixed.raws.items():
        np.testing.assert_array_equal(native.raws[name], raws)
        np.testing.assert_array_equal(native.outputs[name], fixed.outputs[name])
        if name != "acting":
            bound = nav.certificate("nav").output(name).error
            assert bound is not None
            assert np.abs(fixed.outputs[name] - exact.outputs[name]).max() <= bound
    np.testing.assert_array_equal(native.status, fixed.status)


def test_status_bits_have_names(nav: fuzzyspec.Spec) -> None:
    """A flag tells which cases saturated; an unknown one is a ValueError."""
    inputs = {**obstacles(3, 1), "target_bearing": np.array([-181.0, 0.0, 181.0])}
    found = nav.native("nav", inputs)
    assert found.flag("SATURATED_TARGET_BEARING").tolist() == [True, False, True]
    assert not found.flag("OVERRUN_OBSTACLES").any()
    with pytest.raises(ValueError, match="not in"):
        found.flag("NO_SUCH_BIT")


def test_numbers_stand_for_all_cases(nav: fuzzyspec.Spec) -> None:
    """A scalar is broadcast; with scalars alone there is one case; all elements count where no count is given."""
    many = nav.exact("danger", {"eta_t": [0.0, 3.0, 6.0], "eta_d": 4.0})
    one = nav.exact("danger", {"eta_t": 3.0, "eta_d": 4.0})
    assert many.outputs["ddc"].shape == (3,)
    assert one.outputs["ddc"].tolist() == [many.outputs["ddc"][1]]
    inputs = obstacles(4, 3)
    counted = nav.fixed("nav", {**inputs, "obstacles.count": [3, 3, 3, 3]})
    del inputs["obstacles.count"]
    np.testing.assert_array_equal(nav.fixed("nav", inputs).raws["v"], counted.raws["v"])


def test_raws_go_in_as_they_are(nav: fuzzyspec.Spec) -> None:
    """With ``raw`` the inputs are the C's own integers."""
    inputs = obstacles(50, 2)
    by_value = nav.native("nav", inputs)
    by_raw = nav.native("nav", nav.quantise("nav", inputs), raw=True)
    np.testing.assert_array_equal(by_value.raws["w"], by_raw.raws["w"])


def test_a_state_is_handed_on() -> None:
    """What one step holds the next one starts from; without a state a step is the first one."""
    spec = fuzzyspec.load(KEEPER)
    for step in (spec.fixed, spec.native):
        first = step("hold", {"x": 0.0})
        assert first.outputs["y"].tolist() == [2.0]
        fired = step("hold", {"x": 1.0})
        assert fired.outputs["y"].tolist() == [5.0]
        held = step("hold", {"x": 0.0}, fired.state)
        assert held.outputs["y"].tolist() == [5.0]
        assert held.flag("HELD_Y").tolist() == [True]
    assert spec.dequantise("hold", fired.state)["y"].tolist() == [5.0]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"eta_t": [1.0]}, "`danger` wants an input `eta_d`"),
        ({"eta_t": [1.0], "eta_d": [1.0], "x": [1.0]}, "no input `x`; it has eta_t, eta_d"),
        ({"eta_t": [1.0, 2.0], "eta_d": [1.0, 2.0, 3.0]}, "differ in length: 2, 3"),
        ({"eta_t": [[1.0]], "eta_d": [1.0]}, r"`eta_t` has shape \(1, 1\)"),
        ({"eta_t": [float("nan")], "eta_d": [1.0]}, "`eta_t` holds NaN"),
    ],
)
def test_signals_that_do_not_fit_are_named(inputs: dict[str, object], message: str, nav: fuzzyspec.Spec) -> None:
    """A ValueError says which signal, and what was wanted."""
    with pytest.raises(ValueError, match=message):
        nav.fixed("danger", inputs)


def test_lists_that_do_not_fit_are_named(nav: fuzzyspec.Spec) -> None:
    """Widths that differ, and counts beyond the fields."""
    inputs = obstacles(4, 3)
    with pytest.raises(ValueError, match="the fields of `obstacles` differ in width"):
        nav.fixed("nav", {**inputs, "obstacles.speed": np.zeros((4, 2))})
    with pytest.raises(ValueError, match="reaches 4, but the fields hold 3"):
        nav.fixed("nav", {**inputs, "obstacles.count": [0, 4, 0, 0]})


def test_unknown_functions_are_key_errors(nav: fuzzyspec.Spec) -> None:
    """A name that is neither controller nor system."""
    with pytest.raises(KeyError, match="no controller or system `x`"):
        nav.exact("x", {})


def test_broken_specs_give_every_diagnostic() -> None:
    """``diagnose`` lists, ``load`` raises, and both say the same; syntax and names come in one run."""
    text = (
        "module m\ncontroller c {\n  input x in [0, 1] { partition A B }\n  output y in [1, 0] { partition A B }\n}\n"
    )
    found = fuzzyspec.diagnose(text)
    with pytest.raises(fuzzyspec.SpecError) as caught:
        fuzzyspec.load(text)
    assert caught.value.diagnostics == found
    assert any(d.severity == "error" for d in found)


def test_a_plan_is_a_value(nav: fuzzyspec.Spec) -> None:
    """Compiling writes nothing and gives the same bytes again, also from the text alone."""
    plan = nav.compile()
    assert sorted(plan.files) == ["nav.c", "nav.h", "nav_selftest.c"]
    assert nav.compile().files == plan.files


def test_missing_files_are_os_errors(tmp_path: Path) -> None:
    """A path that is not there."""
    with pytest.raises(FileNotFoundError):
        fuzzyspec.load(tmp_path / "none.fz")


VARIABLES = st.builds(
    lambda ctype, step, origin: Variable(
        "x", Fraction(-100), Fraction(100), ONE, Raw(ctype, step, origin, *RAW_LIMITS[ctype]), Span(0, 0)
    ),
    st.sampled_from(sorted(RAW_LIMITS)),
    st.fractions(min_value=-4, max_value=4, max_denominator=1000).filter(bool),
    st.fractions(min_value=-9, max_value=9, max_denominator=1000),
)


@given(VARIABLES, st.data())
def test_raws_survive_the_way_through_values(variable: Variable, data: st.DataObject) -> None:
    """Quantising the value of a raw gives the raw, for any step and origin."""
    ctype: CType = variable.raw.ctype
    raws = np.array(data.draw(st.lists(st.integers(*RAW_LIMITS[ctype]), min_size=1)))
    np.testing.assert_array_equal(quantise(variable, dequantise(variable, raws)), raws)


@given(VARIABLES, st.floats(min_value=-1e6, max_value=1e6))
def test_values_go_to_the_nearest_raw(variable: Variable, value: float) -> None:
    """No other raw is nearer, and of two that are equally near the higher is taken."""
    raw = int(quantise(variable, [value])[0])
    low, high = RAW_LIMITS[variable.raw.ctype]
    distance = abs(variable.raw.position(Fraction(value)) - raw)
    assert all(abs(variable.raw.position(Fraction(value)) - other) > distance for other in (raw + 1,) if other <= high)
    assert all(abs(variable.raw.position(Fraction(value)) - other) >= distance for other in (raw - 1,) if other >= low)
