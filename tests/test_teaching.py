"""What the problem sets share: seeds, what travels between judge and answers, the check."""

import signal
import sys
from contextlib import suppress
from threading import Thread

import numpy as np
import pytest

import freeseg as fs
from freeseg.teaching import check, quietly, variant_seed
from freeseg.teaching.check import Here, Late, judge
from freeseg.teaching.plain import NotPlain, pack, unpack


def test_seeds():
    assert variant_seed("robotics", "ada") == variant_seed(" Robotics", "ADA ")
    names = [("robotics", "ada"), ("robotics", "bob"), ("control", "ada"), ("roboticsa", "da")]
    assert len({variant_seed(*pair) for pair in names}) == len(names)
    for wrong in ("", "  ", 7, None):
        with pytest.raises(fs.InvalidParameter, match="give a name in quotes"):
            variant_seed("robotics", wrong)
        with pytest.raises(fs.InvalidParameter, match="course is"):
            variant_seed(wrong, "ada")


@pytest.mark.parametrize(
    "value", [None, True, 3, 2.5, "text", [1, [2]], {"k1": 0.4}, float("inf"), -(2**70)]
)
def test_plain_data_comes_back(value):
    assert unpack(pack(value)) == value


def test_arrays_and_numbers_of_numpy_come_back():
    array = np.random.default_rng(0).normal(size=(3, 4))
    assert np.array_equal(unpack(pack(array)), array)
    assert unpack(pack(np.array([True, False]))).dtype == bool
    assert unpack(pack(np.float64(0.1))) == 0.1
    assert unpack(pack((np.int64(3), (4,)))) == [3, [4]]
    assert np.isnan(unpack(pack(np.nan)))


def test_questions_may_hold_worlds_and_references_and_answers_may_not():
    world = fs.World([fs.Disc((0, 0), 1), fs.Polygon([(2, 0), (3, 0), (3, 1)])])
    found = unpack(pack(world), question=True)
    assert [type(one) for one in found] == [fs.Disc, fs.Polygon]
    assert np.array_equal(found[1].vertices, world[1].vertices)
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]), fs.KheperaIV())
    again = unpack(pack(reference), question=True)
    assert np.array_equal(again.at(1.23).pose, reference.at(1.23).pose)
    assert again.robot == reference.robot
    assert isinstance(unpack(pack(world)), dict)


@pytest.mark.parametrize(
    "value", [object(), {1: 2}, {"a": lambda: 0}, [1j], np.array(["text"]), {1, 2}, b"bytes"]
)
def test_nothing_else_travels(value):
    with pytest.raises(NotPlain, match="give numbers"):
        pack(value)


def test_lists_without_an_end_do_not_travel():
    endless = []
    endless.append(endless)
    with pytest.raises(NotPlain):
        pack(endless)
    for text in (b"", b"no JSON", b"[" * 10**5, b'{"$array": [[1], [2, 3]]}'):
        with pytest.raises(NotPlain, match="no plain data"):
            unpack(text)


def test_check_says_what_is_wrong_and_goes_on(monkeypatch, capsys):
    names = vars(sys.modules["__main__"])
    monkeypatch.setitem(names, "student", "ada")
    check("ps1.largest")
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.startswith("not yet: The largest robot")
    assert "there is no function largest_robot" in said.out

    def largest_robot(lengths, margin, wanted):
        print("aside")
        longest = sorted(lengths, reverse=True)
        return max(0.0, longest[wanted - 1] - margin) if wanted <= len(longest) else 0

    monkeypatch.setitem(names, "largest_robot", largest_robot)
    check("ps1.largest", largest_robot)
    assert capsys.readouterr() == (
        "passed: The largest robot for which enough segments are safe\n",
        "",
    )
    monkeypatch.setitem(names, "student", "write your id here")
    check("ps1.largest")
    assert "write your id" in capsys.readouterr().out


def test_a_name_that_is_none():
    for wrong, remedy in (("ps1.none", "largest"), ("ps9.gap", "such as"), (7, "such as")):
        with pytest.raises(fs.InvalidParameter, match=remedy):
            check(wrong)


def test_what_raises_and_what_gives_nothing_back():
    def raises(*_):
        return {}["key"]

    _, said = judge("ps1.largest", Here({"largest_robot": raises}), [1])
    assert said.splitlines()[1].startswith("largest_robot raised KeyError: 'key'")
    _, said = judge("ps1.pen", Here({"pen_after": lambda *_: None}), [1])
    assert "gives back nothing" in said
    _, said = judge("ps1.pen", Here({"pen_after": lambda *_: object()}), [1])
    assert "look at what pen_after gives back: this is a object" in said
    _, said = judge("ps1.gap", Here({"gap": lambda *_: [[1, 2], [3]]}), [1])
    assert "give back both ends" in said


def test_time_is_limited():
    def ends_never():
        while True:
            with suppress(Exception):
                sum(range(1000))

    with pytest.raises(Late, match=r"over 0\.1 s: is there a loop"), quietly(0.1):
        ends_never()
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_it_works_in_another_thread():
    found = []

    def work():
        with quietly(0.1):
            found.append(1)

    thread = Thread(target=work)
    thread.start()
    thread.join()
    assert found == [1]
