"""Each check of what the package is given: good values in any dress, bad ones, and the messages."""

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import freeseg as fs
from freeseg import checks

#: More digits than Python prints, and more than a float holds.
HUGE = 10**5000

#: No number, whatever is asked of it.
NO_NUMBER = [
    None,
    "3",
    "",
    np.str_("3"),
    b"3",
    bytearray(b"3"),
    memoryview(b"3"),
    True,
    np.True_,
    np.array(True),
    np.array("3"),
    1j,
    np.complex128(1),
    np.complex64(1),
    np.array(1 + 0j),
    [3],
    (3,),
    [],
    {},
    np.array([3.0]),
    np.array([]),
    np.array(None),
    object(),
    math.nan,
    np.float64("nan"),
    np.array(np.nan),
    math.inf,
    -math.inf,
    HUGE,
    -HUGE,
]

#: Three, in every dress that a number may wear.
THREES = [
    3,
    3.0,
    np.int8(3),
    np.uint64(3),
    np.float32(3),
    np.float64(3),
    np.array(3),
    np.array(3.0),
    np.array(3, dtype=object),
    Fraction(3),
    Decimal(3),
]


def kind_of(value):
    """What a test is called: values may be too long to print."""
    return type(value).__name__


def message_of(check, *arguments, **options):
    """What a check says of a bad value: by the error that was asked for, and in short."""
    error = options.get("error", fs.InvalidParameter)
    with pytest.raises(error) as caught:
        check(*arguments, **options)
    assert type(caught.value) is error
    message = str(caught.value)
    assert len(message) < checks.LONGEST + 150
    return message


# --- one number ----------------------------------------------------------------------------------


@pytest.mark.parametrize("check", [checks.number, checks.positive, checks.not_negative])
@pytest.mark.parametrize("value", THREES, ids=repr)
def test_a_number_in_any_dress_becomes_a_float(check, value):
    found = check("gain", value)
    assert type(found) is float
    assert found == 3


@pytest.mark.parametrize("check", [checks.number, checks.positive, checks.not_negative])
@pytest.mark.parametrize("value", NO_NUMBER, ids=kind_of)
def test_what_is_no_finite_number(check, value):
    message = message_of(check, "gain", value)
    assert message.startswith(f"gain is {checks.shown(value)}; give a ")
    assert "finite number" in message


@pytest.mark.parametrize("zero", [0, 0.0, np.int64(0), np.array(0), np.array(0.0), Fraction(0)])
def test_zero_is_a_value_but_where_it_makes_no_sense(zero):
    assert checks.number("gain", zero) == 0
    assert checks.not_negative("gain", zero) == 0
    assert "; give a positive finite number" in message_of(checks.positive, "gain", zero)


@pytest.mark.parametrize("value", [-1, -1e-300, np.float64(-2), np.array(-3)])
def test_negative_numbers(value):
    assert checks.number("gain", value) == value
    assert message_of(checks.positive, "gain", value).startswith(f"gain is {value!r}; ")
    message = message_of(checks.not_negative, "gain", value)
    assert message == f"gain is {value!r}; give a finite number, zero or more"


def test_a_number_has_its_own_range_remedy_and_error():
    options = {"valid": lambda found: found < 1, "remedy": "less than 1", "error": fs.InvalidWorld}
    assert checks.number("slip", np.float32(0.5), **options) == 0.5
    assert message_of(checks.number, "slip", 1, **options) == "slip is 1; give less than 1"
    assert message_of(checks.number, "slip", None, **options) == "slip is None; give less than 1"
    assert "radius is -1" in message_of(checks.positive, "radius", -1, error=fs.InvalidWorld)


def test_a_range_is_not_asked_of_what_is_no_number():
    asked = []
    message_of(checks.number, "gain", math.nan, asked.append)
    assert asked == []


@pytest.mark.parametrize("value", NO_NUMBER[:-6], ids=kind_of)
def test_no_number_is_nan_as_a_float(value):
    assert math.isnan(checks.as_float(value))


def test_infinity_stays_itself_as_a_float():
    # Whether it makes sense is for the caller to say.
    assert checks.as_float(-math.inf) == -math.inf
    assert math.isnan(checks.as_float(HUGE))


# --- several numbers -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "values",
    [
        (1, 0),
        [1, 0],
        np.array([1, 0]),
        np.array([1.0, 0.0]),
        (np.float32(1), np.array(0)),
        (Fraction(1), Decimal(0)),
        iter([1, 0]),
    ],
    ids=kind_of,
)
def test_numbers_in_any_dress_become_a_tuple_of_floats(values):
    found = checks.numbers("center", values, 2)
    assert found == (1.0, 0.0)
    assert type(found) is tuple
    assert [type(value) for value in found] == [float, float]


@pytest.mark.parametrize(
    "values",
    [
        None,
        3,
        np.array(3.0),
        "12",
        b"12",
        bytearray(b"12"),
        (),
        [],
        np.array([]),
        (1,),
        (1, 2, 3, 4),
        (1, 2, 0),
        (1, None),
        (1, "2"),
        (1, True),
        (1, 2j),
        (1, math.nan),
        (math.inf, 1),
        (1, HUGE),
        (1, [2]),
        ([1, 2], [3]),
        np.ones((2, 2)),
        np.array([True, False]),
        np.array(["1", "2"]),
    ],
    ids=kind_of,
)
def test_what_is_not_so_many_numbers(values):
    message = message_of(checks.numbers, "center", values, 2, error=fs.InvalidWorld)
    assert message == f"center is {checks.shown(values)}; give 2 finite numbers"


# --- whole numbers -------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [3, np.int8(3), np.uint64(3), np.array(3)], ids=repr)
def test_a_whole_number_in_any_dress_becomes_an_int(value):
    found = checks.whole("horizon", value, 1)
    assert type(found) is int
    assert found == 3


def test_whole_numbers_begin_at_their_least():
    assert checks.whole("n", 0) == checks.whole("n", np.int64(0)) == 0
    assert checks.whole("n", -2, least=-2) == -2
    assert message_of(checks.whole, "n", -1) == "n is -1; give a whole number from 0 on"
    assert message_of(checks.whole, "n", 0, 1) == "n is 0; give a whole number from 1 on"
    assert message_of(checks.whole, "n", 0, 1, "a few") == "n is 0; give a few"
    # It knows no largest.
    assert checks.whole("n", HUGE) == HUGE


@pytest.mark.parametrize(
    "value",
    [*(value for value in NO_NUMBER if value is not HUGE), 2.5, 3.0, np.float64(3), Fraction(3)],
    ids=kind_of,
)
def test_what_is_no_whole_number(value):
    message = message_of(checks.whole, "n", value)
    assert message == f"n is {checks.shown(value)}; give a whole number from 0 on"


# --- choices -------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [True, np.True_, False, np.False_], ids=repr)
def test_a_bool_in_any_dress_is_a_flag(value):
    found = checks.flag("anti_windup", value)
    assert type(found) is bool
    assert found == value


@pytest.mark.parametrize(
    "value",
    [None, 0, 1, 1.0, np.int64(1), "True", "", [], [True], np.array([True]), math.nan, HUGE],
    ids=kind_of,
)
def test_what_is_no_flag(value):
    message = message_of(checks.flag, "anti_windup", value)
    assert message == f"anti_windup is {checks.shown(value)}; give True or False"


@pytest.mark.parametrize("value", ["sat", np.str_("sat")])
@pytest.mark.parametrize("choices", [("tanh", "sat"), ["sat", "tanh"], {"sat": 1, "tanh": 2}])
def test_a_text_is_a_choice(value, choices):
    assert checks.choice("switching", value, choices) == "sat"


@pytest.mark.parametrize(
    "value",
    [None, "", "SAT", b"sat", ["sat"], {}, 0, True, math.nan, np.array(["sat"]), HUGE],
    ids=kind_of,
)
def test_what_is_no_choice(value):
    message = message_of(checks.choice, "switching", value, ("tanh", "sat"))
    assert message == f"switching is {checks.shown(value)}; choose one of ['sat', 'tanh']"


def test_an_instance_is_itself_and_anything_else_an_error():
    robot = fs.KheperaIV()
    assert checks.instance("robot", robot, fs.Robot, "a Robot") is robot
    for value in (None, "robot", fs.KheperaIV, HUGE, [robot]):
        message = message_of(
            checks.instance,
            "robot",
            value,
            fs.Robot,
            "a Robot",
            error=fs.InvalidQuery,
        )
        assert message == f"robot is {checks.shown(value)}; give a Robot"


# --- arrays --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "values",
    [
        [[0, 1], [2, 3]],
        ((0, 1), (2, 3)),
        [np.array([0, 1]), (2.0, np.float32(3))],
        np.array([[0, 1], [2, 3]], dtype=np.uint8),
        np.array([[0, 1], [2, 3]], dtype=np.float32),
        np.array([[0, 1], [2, 3]], dtype=object),
        [[Fraction(0), Decimal(1)], [np.array(2), 3]],
        np.array([[0.0, 2.0], [1.0, 3.0]]).T,
    ],
)
def test_an_array_in_any_dress_becomes_one_of_floats(values):
    found = checks.array("points", values, (None, 2))
    assert_array_equal(found, [[0, 1], [2, 3]])
    assert found.dtype == float
    assert not found.flags.writeable


def test_an_array_is_a_copy():
    given = np.zeros(3)
    found = checks.array("pose", given, (3,))
    given[0] = 1
    assert found[0] == 0
    assert given.flags.writeable


def test_whole_numbers_beyond_64_bits_are_numbers():
    assert checks.array("points", [[10**20, 1]], (None, 2))[0, 0] == 1e20


@pytest.mark.parametrize(
    "values",
    [
        None,
        "12",
        b"12",
        object(),
        {},
        ["1", "2"],
        [1, "2"],
        [1, None],
        [True, False],
        np.array([1, True], dtype=object),
        np.array([1, "2"], dtype=object),
        [1j, 2],
        np.array([1j, 2], dtype=object),
        [[1, 2], [3]],
        [1, HUGE],
        [1, [2]],
        np.array(["2026-01-01"], dtype="datetime64[D]"),
    ],
    ids=kind_of,
)
def test_what_is_no_array_of_numbers(values):
    message = message_of(checks.array, "points", values, (2,), (None, 2), unit="m, rad")
    assert message == f"points is {checks.shown(values)}; give numbers (m, rad)"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_every_number_of_an_array_is_finite(value):
    message = message_of(checks.array, "pose", [0, 1, value], (3,))
    assert message == f"pose is [0.0, 1.0, {value}]; every number must be finite (m)"


@pytest.mark.parametrize(
    "values",
    [3, np.array(3.0), [], [[]], np.empty((0, 2)), [1, 2], [[1, 2, 3]], np.zeros((1, 2, 2))],
    ids=lambda values: str(np.shape(values)),
)
def test_an_array_of_another_shape(values):
    message = message_of(
        checks.array, "points", values, (3,), (None, 2), error=fs.InvalidWorld, unit="m"
    )
    shape = np.shape(values)
    assert message == f"points has shape {shape}; expected 3 or n x 2 numbers (m)"


def test_an_array_raises_the_error_asked_for():
    for values in (None, [1, 2], [1, 2, math.nan]):
        assert message_of(checks.array, "a", values, (3,), error=fs.InvalidWorld).startswith("a ")


# --- seeds ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0, (0, 0)),
        (7, (7, 0)),
        (np.int64(7), (7, 0)),
        (np.array(7), (7, 0)),
        ((7, 3), (7, 3)),
        ([np.uint8(7), np.array(3)], (7, 3)),
        ((0, 0), (0, 0)),
        (HUGE, (HUGE, 0)),
    ],
    ids=kind_of,
)
def test_a_seed_is_a_whole_number_or_a_pair(value, expected):
    found = checks.seed(value)
    assert found == expected
    assert [type(entry) for entry in found] == [int, int]
    # A checked seed is one, too.
    assert checks.seed(found) == expected


@pytest.mark.parametrize(
    "value",
    [
        None,
        "7",
        b"7",
        True,
        np.True_,
        -1,
        -HUGE,
        7.0,
        math.nan,
        math.inf,
        1j,
        (),
        [],
        (7,),
        (1, 2, 3, 4),
        (1, 2, 0),
        (7, -1),
        (7, None),
        (7, "3"),
        (True, 0),
        (7, 0.5),
        np.array([7, 3]),
        np.random.default_rng(0),
    ],
    ids=kind_of,
)
def test_what_is_no_seed(value):
    message = message_of(checks.seed, value)
    assert message.startswith(f"seed is {checks.shown(value)}; give a whole number from 0 on, or ")
    assert "a pair of them: the seed, and the index of the first robot; or three" in message


# --- messages ------------------------------------------------------------------------------------


def test_short_values_are_shown_whole():
    for value in (None, 0.1, "a text", [1, 2], "x" * (checks.LONGEST - 2)):
        assert checks.shown(value) == repr(value)


@pytest.mark.parametrize(
    "value",
    [10**1000, "x" * 10_000, list(range(10_000)), b"y" * 10_000, np.arange(900.0)],
    ids=kind_of,
)
def test_long_values_are_cut(value):
    shown = checks.shown(value)
    assert len(shown) == checks.LONGEST + 1
    assert shown.endswith("…")
    assert repr(value).startswith(shown[:-1])


@pytest.mark.parametrize(("value", "kind"), [(HUGE, "int"), ([1, HUGE], "list")], ids=kind_of)
def test_what_python_does_not_print_is_named_by_its_type(value, kind):
    assert checks.shown(value) == f"<{kind} too long to print>"


@pytest.mark.parametrize(
    ("check", "options"),
    [
        (checks.number, ()),
        (checks.positive, ()),
        (checks.not_negative, ()),
        (checks.numbers, (2,)),
        (checks.whole, ()),
        (checks.flag, ()),
        (checks.choice, (("a", "b"),)),
        (checks.instance, (fs.World, "a World")),
        (checks.array, ((3,),)),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
@pytest.mark.parametrize(
    "value",
    ["x" * 10_000, ["x"] * 10_000, -(10**400), [HUGE] * 3],
    ids=["text", "texts", "whole", "unprintable"],
)
def test_messages_are_short_whatever_the_value(check, options, value):
    message = message_of(check, "the thing", value, *options)
    assert message.startswith("the thing is ")
    assert "; " in message[-60:]


def test_a_run_of_more_steps_than_python_prints_is_refused():
    with pytest.raises(fs.InvalidParameter, match="steps is <int too long to print>; give at most"):
        fs.drive(lambda t, pose: (0, 0), (0, 0, 0), 0.05, HUGE)


# --- kinds of more than one number ---------------------------------------------------------------


def test_one_number_stands_for_a_pair():
    bounds = (lambda found: found < 1), "below 1"
    for value in (0.5, [0.5, 0.5], np.array([0.5, 0.5]), np.float32(0.5)):
        assert checks.pair("slip", value, *bounds) == (0.5, 0.5)
    for value in (1, (0, 1), (0, 0, 0), "00", None, math.nan):
        assert message_of(checks.pair, "slip", value, *bounds).endswith("; give below 1")


def test_signals_come_component_by_component():
    assert checks.signal("wheels", [[1, 2], [3, 4]], "two", 2).shape == (2, 2)
    for value in ([1, 2, 3], 1, [], [1, math.inf], [1, 1e200], "12", [[1], [2, 3]]):
        message = message_of(checks.signal, "wheels", value, "two speeds", 2)
        assert (
            message == f"wheels is {checks.shown(value)}; give two speeds, finite"[: len(message)]
        )


def test_shapes_that_do_not_broadcast_are_named():
    checks.together(pose=(3,), wheels=())
    with pytest.raises(fs.InvalidParameter, match=r"pose \(3,\) and wheels \(2,\)"):
        checks.together(pose=(3,), wheels=(2,))


def test_indices_are_below_their_count():
    assert checks.indices("group", range(3), 3, "obstacles") == (0, 1, 2)
    for value in ([3], [-1], 2, [0.0], "01", [True], None):
        message = message_of(checks.indices, "group", value, 3, "obstacles")
        assert message.endswith("; give indices of obstacles, below 3")


def test_a_function_takes_the_arguments_that_it_will_get():
    for value in (lambda t, pose: 0, lambda *all: 0, lambda t, pose, more=1: 0, max, np.add):
        assert checks.function("law", value, "law(t, pose)", 0.0, None) is value
    for value in (None, 3, "law", lambda: 0, lambda t: 0, lambda t, pose, more: 0, len):
        message = message_of(checks.function, "law", value, "law(t, pose)", 0.0, None)
        assert message == f"law is {checks.shown(value)}; give law(t, pose)"


def test_a_robot_is_shown_in_short():
    assert checks.shown(fs.KheperaIV()) == "<KheperaIV, 0.1408 m wide>"
    assert checks.shown(fs.KheperaIV) == repr(fs.KheperaIV)
