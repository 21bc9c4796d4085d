"""The problem sets: what gets points, what loses them, and what gets none that it should not.

Answers run in processes of their own, as when a lecturer grades; several submissions share one
where that makes no difference. ``pytest -m exhaustive`` grades all sets by nbgrader, from end to
end; tests/test_first_week.py does so for one.
"""

# ruff: noqa: E501 -- mistakes and tamperings are tables, with code of a notebook in their cells

import ast
import re
import sys
import textwrap
from contextlib import ExitStack
from copy import deepcopy
from functools import cache
from importlib import import_module
from importlib.util import find_spec

import nbformat
import numpy as np
import pytest
from refresh_notebooks import NOTEBOOKS

import freeseg as fs
from freeseg.teaching import ps1, ps2, ps3, ps4, ps5
from freeseg.teaching.check import PROBLEM_SETS, Here, Late, Law, find_test
from freeseg.teaching.check import judge as judge_test
from freeseg.teaching.own_work import REFUSED, without

FOLDER = NOTEBOOKS / "assignments"
NAMES = {file.stem[:3]: file.stem for file in sorted(FOLDER.glob("ps*/*.ipynb"))}
#: From which the tests' seeds are made here; a lecturer's is drawn at random.
SECRET = "tests"
#: Cases of the contest, of which tests drive fewer.
CASES = ps4.CASES_OF_DRAW
#: Tests that take a second or more: with every change of a set, only those run that it is about.
LONG = {"planner", "law", "tuned", "contract", "arrives", "contest", "stop", "needed"}

if not find_spec("nbgrader"):
    pytest.skip(
        "grading needs it: pip install -r notebooks/assignments/requirements.txt",
        allow_module_level=True,
    )
sys.path.insert(0, str(FOLDER))
import judge  # noqa: E402
import submissions  # noqa: E402


def read(part):
    """A set with its solutions."""
    return nbformat.read(FOLDER / NAMES[part] / f"{NAMES[part]}.ipynb", as_version=4)


def nbgrader_cells(notebook):
    """Cells that nbgrader knows, by name."""
    return {
        submissions.cell_name(cell): cell for cell in notebook.cells if "nbgrader" in cell.metadata
    }


def points_of(part):
    """Names and points of the tests of a set."""
    return {
        name: cell.metadata.nbgrader.points
        for name, cell in nbgrader_cells(read(part)).items()
        if cell.metadata.nbgrader.grade and cell.cell_type == "code"
    }


def untouched(part):
    """A set without solutions, as students get it."""
    notebook = read(part)
    for cell in notebook.cells:
        pattern = r" *### BEGIN SOLUTION\n.*?### END SOLUTION"
        cell.source = re.sub(pattern, "", cell.source, flags=re.S)
    return notebook


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Machines that run tests are busy; whoever tests limits of time sets them."""
    monkeypatch.setattr(judge.Answers, "patience", 100.0)
    monkeypatch.setattr(judge, "PATIENCE", 100.0)
    monkeypatch.setattr(Here, "patience", 100.0)
    monkeypatch.setattr(ps4, "CASES_OF_DRAW", 2)
    monkeypatch.setattr(ps4, "CASES_OF_ARRIVAL", 1)
    monkeypatch.setattr(ps5, "MANY_STUDIES", 250)


@pytest.fixture(scope="module")
def solved():
    """Answers of the solved sets, each in a process, by set; whoever changes one puts it back."""
    with ExitStack() as stack:
        yield cache(lambda part: stack.enter_context(answers_of(read(part), part)))


def answers_of(notebook, part):
    """A process of answers in which a notebook's cells ran, but for its tests and pictures."""
    answers = judge.Answers(REFUSED.get(part, ()))
    for cell in notebook.cells:
        is_picture = cell is notebook.cells[-1]
        if cell.cell_type == "code" and not cell.source.startswith("check(") and not is_picture:
            answers.run(cell.source)
    return answers


def shares(part, answers, tests):
    """Share of the points that each test gives, and what it says."""
    seeds = judge.seeds_of(part, SECRET)[:1]
    return {name: judge_test(f"{part}.{name}", answers, seeds) for name in tests}


@pytest.mark.parametrize("part", PROBLEM_SETS)
def test_untouched_gets_nothing_and_says_what_is_missing(part):
    with answers_of(untouched(part), part) as answers:
        for share, said in shares(part, answers, points_of(part)).values():
            assert share == 0
            first, second, *_ = said.splitlines()
            assert first.startswith(("not yet: ", "so far 0 %"))
            assert len(second) > 20
        # The picture at its end says what is missing, too.
        outputs = answers.run(untouched(part).cells[-1].source)
        assert not [one for one in outputs if one.output_type == "error"]


@pytest.mark.parametrize("part", PROBLEM_SETS)
def test_the_reference_gets_everything(part, solved):
    found = shares(part, solved(part), points_of(part))
    assert {name: share for name, (share, _) in found.items() if share < 1} == {}
    assert solved(part).remarks == []


#: Typical mistakes: set, text of the reference solution, what stands there instead, tests lost.
MISTAKES = {
    "wheels mixed up": ("ps1", "(right - left) / base", "(left - right) / base", {"pen"}),
    "one radius for both": ("ps1", "np.multiply(rates, radii)", "np.multiply(rates, radii[0])", {"pen"}),
    "the middle, not the pen": ("ps1", "x + ahead * np.cos(theta)", "x + 0 * np.cos(theta)", {"pen"}),
    "the chord for the arc": ("ps1", " / np.sinc(theta / 2 / np.pi)", "", {"radii"}),
    "no case for straight on": ("ps1", " / np.sinc(theta / 2 / np.pi)", " * (theta / 2) / np.sin(theta / 2)", {"radii"}),
    "radii in mm": ("ps1", "radii = (mean + half)", "radii = 1000 * (mean + half)", {"radii"}),
    "degrees for radians": ("ps1", "np.radians(sweep_deg)", "sweep_deg", {"turn"}),
    "heading against the turn": ("ps1", "np.sign(sweep_deg) * np.pi", "np.pi", {"turn"}),
    "polygons not rounded": ("ps1", "first + radius * across", "first", {"gap"}),
    "corners only": ("ps1", "pair = nearest_on(a, b, corner), corner", "pair = a, corner", {"gap"}),
    "margin forgotten": ("ps1", "longest[wanted - 1] - margin", "longest[wanted - 1]", {"largest"}),
    "one segment too many": ("ps1", "longest[wanted - 1]", "longest[max(wanted - 2, 0)]", {"largest"}),
    "inner for outer tangent": ("ps2", "(other_radius - radius)", "(other_radius + radius)", {"tangent"}),
    "tangent on the wrong side": ("ps2", "[np.sin(direction), -np.cos", "[-np.sin(direction), np.cos", {"tangent"}),
    "danger segments too": ("ps2", "< needed:", "< 0:", {"turning"}),
    "turn on the wrong side": ("ps2", "np.sign(x * v - y * u)", "-np.sign(x * v - y * u)", {"turning"}),
    "a planner of the package": ("ps2", "    number = itertools.count()", "    fs.plan(world, start, goal)\n    number = itertools.count()", {"planner"}),
    "no such wrong turn": ("ps2", "(3, 1), \"fs.plan\"", "(4, 1), \"fs.plan\"", {"break_it"}),
    "a right turn that the shortest path need not touch": ("ps2", "(0.18, 0.28), (0.65, 0.23), (3, 1), \"fs.plan\"", "(0.0, 0.0), (1.1, 1.1), (1, 1), \"fs.plan\"\n    discs = [(0.467, 0.516, 0.054), (0.679, 0.71, 0.06), (0.202, 0.269, 0.086)]", {"break_it"}),
    "seven discs": ("ps2", "(0.14, 0.61, 0.04)]", "(0.14, 0.61, 0.04), (2, 2, 0.1)]", {"break_it"}),
    "the paper's surface": ("ps3", "flat = A / (c * np.cosh(v_r * y_e / c) ** 2)", "flat = A / (c * (1 + (v_r * y_e / c) ** 2))", {"controls"}),
    "rate of the speed forgotten": ("ps3", "+ flat * y_e * v_dot", "", {"controls"}),
    "singular behind": ("ps3", "x_e = -c * np.cosh", "x_e = c * np.cosh", {"singular"}),
    "singular at one y only": ("ps3", "np.cosh(v_r * y_e / c) ** 2 / (A * v_r)", "1 / (A * v_r) + 0 * y_e", {"singular"}),
    "how far squared": ("ps3", "ahead = c / (A * v_top)", "ahead = c / (A * v_top**2)", {"nearest"}),
    "no floor": ("ps3", 'np.maximum(1 + flat * ahead.v * x_e, gains["floor"])', "(1 + flat * ahead.v * x_e)", {"law"}),
    "a gain missing": ("ps3", 'gains |= {"k2": 1.5', 'gains.pop("A")\n    gains |= {"k2": 1.5', {"tuned"}),
    "memory that outlives a run": ("ps4", "for day in (usual, rough)]", "for day in (usual, rough)]\n    globals()['runs'] = runs = globals().get('runs', 0) + 1\n    days = days[runs % 2 :][:1]", {"contract"}),
    "wrong sign of the damping": ("ps4", "+ 6.0 * np.sin(alpha_e)", "- 6.0 * np.sin(alpha_e)", {"arrives", "contest"}),
    "no numbers": ("ps4", "+ 4.0 * x_e", "+ np.nan * x_e", {"contract", "arrives", "contest"}),
    "courses not paired": ("ps5", "spread = differences.std(ddof=1)", "spread = first.std(ddof=1)", {"compare"}),
    "a normal for few runs": ("ps5", "half = stats.t.ppf(0.975, len(differences) - 1)", "half = 1.7 + 0 * len(differences)", {"compare"}),
    "power forgotten": ("ps5", ">= power:", ">= 0.5:", {"needed"}),
    "looking costs nothing": ("ps5", "found = statistics.sequential(differences, bounds=(-1, 1)).verdict", "low, high = interval_of(differences, 0 * differences)\n    found = 'larger' if low > 0 else 'smaller' if high < 0 else ''", {"stop"}),
    "two runs more than of a normal": ("ps5", "    runs = 2\n", "    normal = 1.96 + stats.norm.ppf(power)\n    return int(np.ceil((normal * spread / difference) ** 2)) + 2\n", {"needed"}),
    "0.1 % after every run": ("ps5", "found = statistics.sequential(differences, bounds=(-1, 1)).verdict", "test = stats.ttest_1samp(differences, 0)\n    found = '' if test.pvalue > 0.001 else 'larger' if test.statistic > 0 else 'smaller'", {"stop"}),
    "one look": ("ps5", "found = statistics.sequential(differences, bounds=(-1, 1)).verdict", "test = stats.ttest_1samp(differences[:30], 0)\n    found = '' if test.pvalue > 0.05 or len(differences) < 30 else 'larger' if test.statistic > 0 else 'smaller'", {"stop"}),
    "a share of false ones": ("ps5", "    order = np.argsort(p_values)\n", "    return stats.false_discovery_control(p_values) <= 0.05\n    order = np.argsort(p_values)\n", {"many"}),
    "many at 5 % each": ("ps5", "0.05 / (len(order) - rank)", "0.05", {"many"}),
    "timid": ("ps5", "0.05 / (len(order) - rank)", "0.05 / len(order)", {"many"}),
}  # fmt: skip


@pytest.mark.parametrize("key", MISTAKES)
def test_a_mistake_costs_exactly_its_points(key, solved):
    part, old, new, lost = MISTAKES[key]
    cells = [cell for cell in read(part).cells if old in cell.source and "SOLUTION" in cell.source]
    assert len(cells) == 1, f"{len(cells)} answers say {old!r}; say here what yours does"
    answers, tests = solved(part), lost | (set(points_of(part)) - LONG)
    answers.run(cells[0].source.replace(old, new))
    try:
        found = shares(part, answers, tests)
    finally:
        answers.run(cells[0].source)
    assert {name for name, (share, _) in found.items() if share < 1} == lost
    assert all(share == 0 for name, (share, _) in found.items() if name in lost)
    for name in lost:
        first, second, *_ = found[name][1].splitlines()
        assert first.startswith(("not yet: ", "so far 0 %"))
        assert len(second) > 20


#: Correct work in other dress: what a decorator does to a function's answer and to its own kind.
DRESSES = {
    "lists": "return lambda *given: as_lists(work(*given))",
    "arrays": "return lambda *given: as_arrays(work(*given))",
    "one's own class": "return Own(work).answer",
    "an object that can be called": "return Callable(work)",
    "NumPy's numbers": "return lambda *given: as_numpy(work(*given))",
    "noisy": "return lambda *given: (print('here'), warnings.warn('there'), work(*given))[-1]",
    "a named tuple": "return lambda *given: as_named(work(*given))",
    "input spoilt": "return lambda *given: spoil(work(*given), given)",
    "slow": "return lambda *given: (spin(0.004), work(*given))[-1]",
    "a partial function": "return functools.partial(lambda inner, *given: inner(*given), work)",
}
WARDROBE = """
import collections, functools, time, warnings
import numpy as np

class Own:
    def __init__(self, work):
        self.work = work
    def answer(self, *given):
        return self.work(*given)

class Callable(Own):
    __call__ = Own.answer

def as_lists(found):
    return [as_lists(one) for one in found] if isinstance(found, (tuple, list)) else (
        found.tolist() if isinstance(found, np.ndarray) else found)

def as_arrays(found):
    try:
        return np.array(found) if np.array(found).dtype.kind in "biuf" else found
    except ValueError:
        return found

def as_numpy(found):
    if isinstance(found, (tuple, list)):
        return [as_numpy(one) for one in found]
    return np.float64(found) if isinstance(found, float) else found

def as_named(found):
    if not isinstance(found, tuple):
        return found
    return collections.namedtuple("Answer", [f"part{k}" for k in range(len(found))])(*found)

def spoil(found, given):
    found = as_numpy(found) if not isinstance(found, np.ndarray) else found.copy()
    for one in given:
        if isinstance(one, np.ndarray):
            one.fill(0)
    return found

def spin(seconds):
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass
"""
#: Functions that a set's tests ask for; those of laws are dressed, and so are their laws.
ASKED = {
    "ps1": "pen_after radii_from turn_end gap largest_robot",
    "ps2": "tangent turning_point hard_case plan_turns",
    "ps3": "controls singular_x safe_ahead tuned",
    "ps4": "plan_turns",
    "ps5": "interval_of verdict_so_far which_hold",
}


@pytest.mark.parametrize("part", PROBLEM_SETS)
def test_other_dress_gets_everything(part):
    """Ten variants of each set, on all tests but those that take long, and on one of these."""
    quick = set(points_of(part)) - LONG
    long = {"ps3": {"law"}, "ps4": {"contract"}}.get(part, set())
    with answers_of(read(part), part) as answers:
        answers.run(WARDROBE)
        for name, dress in DRESSES.items():
            answers.run(f"def dressed(work):\n    {dress}")
            asked = [*ASKED[part].split(), *(["start"] if long else [])]
            for one in asked:
                answers.run(f"{one}_plain = globals().get('{one}_plain', {one})")
                law = one == "start"
                inner = f"lambda *given: dressed({one}_plain(*given))" if law else f"{one}_plain"
                answers.run(f"{one} = dressed({inner})" if not law else f"{one} = {inner}")
            found = shares(part, answers, quick | (long if name in ("lists", "slow") else set()))
            assert {test: told for test, (share, told) in found.items() if share < 1} == {}, name
        assert answers.remarks == []


#: What another way to the same answer looks like: set, test, cell.
OTHERWISE = {
    "Shapely": ("ps1", "gap", """
        import shapely
        def gap(corners, radius, other, other_radius):
            line = shapely.shortest_line(shapely.Polygon(corners), shapely.Polygon(other))
            a, b = np.array(line.coords)
            return a + radius * (b - a) / line.length, b - other_radius * (b - a) / line.length
        """),
    "many small steps": ("ps1", "turn", """
        def turn_end(start, center, sweep):
            place, step = complex(*start) - complex(*center), np.radians(sweep) / 1000
            for _ in range(1000):
                place *= np.exp(1j * step)
            return place.real + center[0], place.imag + center[1], np.angle(1j * place * np.sign(step))
        """),
    "an optimiser": ("ps1", "radii", """
        from scipy.optimize import fsolve
        def radii_from(rates, base, dt, moved):
            def off(radii):
                right, left = rates * radii
                turn = (right - left) / base * dt
                chord = (right + left) / 2 * dt * np.sinc(turn / 2 / np.pi)
                return 100 * (chord - np.hypot(*moved[:2])), turn - moved[2]
            return fsolve(off, (0.02, 0.02), xtol=1e-14)
        """),
    "bootstrap in standard errors": ("ps5", "compare", """
        def interval_of(first, second):
            d, rng = first - second, np.random.default_rng(0)
            draws = rng.choice(d, (2000, len(d)))
            error = draws.std(1, ddof=1) / len(d) ** 0.5
            keep = error > 0.2 * d.std(ddof=1) / len(d) ** 0.5
            low, high = np.percentile((draws.mean(1) - d.mean())[keep] / error[keep], [2.5, 97.5])
            scale = d.std(ddof=1) / len(d) ** 0.5
            return d.mean() - high * scale, d.mean() - low * scale
        """),
    "betting": ("ps5", "stop", """
        def verdict_so_far(differences):
            shares = np.linspace(0.05, 0.95, 19)[:, None]
            for sign, name in ((1, "larger"), (-1, "smaller")):
                won = np.log1p(sign * shares * differences).sum(1)
                if np.logaddexp.reduce(won) - np.log(19) >= np.log(40):
                    return name
            return "go on"
        """),
    "Shaffer's steps": ("ps5", "many", """
        def which_hold(p_values):
            hold = np.zeros(15, bool)
            steps = [15, 10, 10, 10, 10, 10, 7, 7, 7, 6, 4, 4, 3, 2, 1]
            for k, most in zip(np.argsort(p_values), steps):
                if p_values[k] > 0.05 / most:
                    break
                hold[k] = True
            return hold
        """),
    "the wrong turn of another world": ("ps2", "break_it", """
        def hard_case():
            discs = [(0.467, 0.516, 0.054), (0.679, 0.71, 0.06), (0.202, 0.269, 0.086)]
            return discs, (0, 0), (1.1, 1.1), (3, -1), "fs.plan"
        """),
    "a law in a class": ("ps3", "law", """
        class Law:
            def __init__(self, *known):
                self.known = known
            def __call__(self, t, pose):
                return list(plain(*self.known)(t, pose))
        plain, start = start, Law
        """),
}  # fmt: skip


@pytest.mark.parametrize("kind", OTHERWISE)
def test_another_way_gets_everything(kind):
    part, test, cell = OTHERWISE[kind]
    with answers_of(read(part), part) as answers:
        answers.run(textwrap.dedent(cell))
        ((share, said),) = shares(part, answers, [test]).values()
        assert share == 1, said


#: Tamperings: a cell of a notebook whose answers are not written, that would get points for
#: nothing. What is called `steal` runs when a test asks, too.
FOUND = "def largest_robot(*given):\n    steal()\ndef turn_end(*given):\n    steal()\n"
TAMPERINGS = {
    "standard error redirected": "import io, sys; sys.stderr = io.StringIO()",
    "standard output closed": "import sys; sys.stdout.close(); sys.__stdout__.close()",
    "check replaced": "import freeseg.teaching as t; check = t.check = lambda *_: print('passed')",
    "judge replaced": "import freeseg.teaching.check as t, sys\n"
    "sys.modules['freeseg.teaching.check'].judge = lambda *_: (1.0, 'passed')",
    "shadowed names": "numbers = judge = ask = np = lambda *_, **__: None",
    "asserts weakened": "import numpy as np\nnp.allclose = np.isclose = np.array_equal = lambda *_, **__: True",
    "helpers weakened": "import freeseg.teaching.answered as a; a.numbers = lambda *_: 0",
    "random numbers known": "import numpy as np; np.random.default_rng = lambda *_: None",
    "simulate replaced": "import freeseg as fs; fs.simulate = fs.drive = lambda *_, **__: None",
    "equal to everything": "class Any(float):\n    __eq__ = __ge__ = __le__ = lambda *_: True\n"
    "def largest_robot(*given):\n    return Any()",
    "no number": "def largest_robot(*given):\n    return float('nan')",
    "infinite": "def largest_robot(*given):\n    return float('inf')",
    "an object": "def largest_robot(*given):\n    return object()",
    "nested": "def largest_robot(*given):\n    a = []\n    a.append(a)\n    return a",
    "packing replaced": "import freeseg.teaching.plain as p, freeseg.teaching.check as c\n"
    "p.pack = c.packed = lambda *_: '{\"share\": 1}'",
    "JSON replaced": "import json; json.dumps = lambda *_: '{\"found\": true}'",
    "time stopped": "import time; time.perf_counter = time.process_time = lambda: 0.0",
    "a thread that goes on": "import threading\nthreading.Thread(target=print, daemon=True).start()",
    "the way up the stack": "import sys\ndef steal():\n    frame = sys._getframe()\n"
    "    while frame:\n        assert not {'rng', 'safe', 'spoke'} & set(frame.f_locals)\n"
    "        frame = frame.f_back\n" + FOUND,
    "what lives in memory": "import gc\ndef steal():\n    names = {f.__name__ for f in gc.get_objects()"
    " if type(f).__name__ == 'function' and f.__module__ == 'freeseg.teaching.ps1'}\n"
    "    assert not names, names\n" + FOUND,
}  # fmt: skip
#: Those that reach out of their process, which is remarked on.
REACHING = {
    "solutions on the disk": f"open({str(FOLDER / NAMES['ps1'] / 'x.ipynb')!r})",
    "solutions by pathlib": f"import pathlib; pathlib.Path({str(FOLDER)!r}, 'grade.py').read_text()",
    "by file number": f"import os; os.open({str(FOLDER / 'grade.py')!r}, os.O_RDONLY)",
    "by a way round": f"open('/usr/share/../..{FOLDER / 'grade.py'}')",
    "tests of the package": "import freeseg.teaching.ps1",
    "tests, reloaded": "import importlib; importlib.reload(importlib.import_module('freeseg.teaching.ps2'))",
    "secrets": f"open({str(FOLDER / 'build' / 'secret.txt')!r})",
    "other submissions": f"import os; os.listdir({str(FOLDER / 'build')!r})",
    "other submissions by glob": f"import os; list(os.scandir({str(FOLDER)!r}))",
    "the grade book": f"import sqlite3; sqlite3.connect({str(FOLDER / 'build/gradebook.db')!r})",
    "a file changed": f"open({str(FOLDER / 'judge.py')!r}, 'a')",
    "a file removed": f"import os; os.remove({str(FOLDER / 'none.py')!r})",
    "memory of a process": "open('/proc/self/mem', 'rb')",
    "another program": "import subprocess; subprocess.run(['cat', '/etc/passwd'])",
    "a shell": "!cat /etc/passwd",
    "os.system": "import os; os.system('true')",
    "a fork": "import os; os.fork()",
    "another program, unheard": "import _posixsubprocess",
    "the network": "import socket; socket.socket().connect(('127.0.0.1', 80))",
    "C": "import ctypes; ctypes.CDLL(None)",
    "the judge ended": "import os; os.kill(os.getppid(), 9)",
    "names of Python replaced": "import builtins\nbuiltins.isinstance = lambda *_: False\n"
    "builtins.str = int\nopen('/etc/passwd')",
    "another hook": "import sys; sys.addaudithook(print)",
}  # fmt: skip
#: Those that end Python, or speak in place of it.
ENDING = {
    "an end": "import os\ndef steal():\n    os._exit(0)\n" + FOUND,
    "an exit": "import sys\ndef steal():\n    sys.exit()\n" + FOUND,
    "forged replies": "import os\ndef steal():\n    for k in range(3, 40):\n        try:\n"
    "            os.write(k, b'{\"found\": 0.0, \"refused\": []}\\n' * 9)\n"
    "        except OSError:\n            pass\n" + FOUND,
    "no JSON": "import os\ndef steal():\n    for k in range(3, 40):\n        try:\n"
    "            os.write(k, b'\\x00[[[[')\n        except OSError:\n            pass\n" + FOUND,
    "too much": "def largest_robot(*given):\n    return 'x' * 2**26",
    "a bottomless function": "def largest_robot(*given):\n    return largest_robot(*given)",
}  # fmt: skip


def scores(cell):
    """Shares of two tests on answers that are not written but for a cell, and remarks."""
    with answers_of(untouched("ps1"), "ps1") as answers:
        outputs = answers.run(cell)
        found = shares("ps1", answers, ["largest", "turn"])
        return [share for share, _ in found.values()], answers.remarks, outputs


@pytest.mark.parametrize("kind", [*TAMPERINGS, *ENDING])
def test_tampering_gets_nothing(kind):
    found, _, _ = scores((TAMPERINGS | ENDING)[kind])
    assert found == [0, 0]


@pytest.mark.parametrize("kind", REACHING)
def test_what_reaches_out_is_refused_and_remarked_on(kind):
    found, remarks, outputs = scores(REACHING[kind])
    assert found == [0, 0]
    assert any("tried to reach out of its process" in remark for remark in remarks)
    assert kind in ("a shell", "another hook", "names of Python replaced") or outputs[-1].ename in (
        "PermissionError",
        "RuntimeError",
    )


@pytest.mark.parametrize(
    "cell",
    [
        "plan_turns = lambda *query: (None, turns_of(fs.plan(*query)))",
        "import importlib\nimportlib.reload(importlib.import_module('freeseg.planners.query'))",
        "import inspect\nsource = inspect.getsource(fs.plan)",
        "import gc\ncodes = [one for one in gc.get_objects() if type(one).__name__ == 'code']\n"
        "assert not [one for one in codes if 'free_segment.py' in one.co_filename and one.co_name"
        " == 'plan' and len(one.co_code) > 300]\nraise NotImplementedError",
    ],
)
def test_planners_of_the_package_are_out_of_reach(cell):
    with answers_of(untouched("ps2"), "ps2") as answers:
        outputs = answers.run(cell)
        ((share, _),) = shares("ps2", answers, ["planner"]).values()
    assert share == 0
    assert not outputs or outputs[-1].ename in ("PermissionError", "NotImplementedError", "OSError")


def test_baselines_and_true_poses_are_the_judge_s():
    known = dict(ps4.baselines(7))
    spoilt = """
import freeseg as fs
from freeseg.studies import tracking, tuning
tuning.load_gains = lambda *_: {}
tracking.DISTURBANCE = None
fs.Pid.start = fs.Mpc.start = lambda *_: (lambda t, pose: (0.0, 0.0))
seen = []
def start(reference, robot, dt):
    def law(t, pose):
        seen.append(pose.tolist())
        return 0.05, 0.0
    return law
def poses():
    return seen
"""
    with answers_of(untouched("ps4"), "ps4") as answers:
        answers.run(spoilt)
        shares("ps4", answers, ["contract"])
        seen = np.array(answers("poses"))
    ps4.baselines.cache_clear()
    assert ps4.baselines(7) == known
    # It drives straight on at a constant speed; what the law sees of that is noisy.
    assert np.abs(np.diff(seen[10:60, 2])).max() > np.radians(0.2)


def test_the_contest_does_not_pay_all_for_the_package_s_own_law():
    known, cases = ps4.baselines(7), ps4.cases(7, 2)
    ready = fs.Predicting(fs.SlidingMode(preview=0.2), 0.05, 0.03, 2.3)
    share = ps4.share_of(np.mean([ps4._cost(ready, one, one.given) for one in cases]), known)
    assert 0 < share < 0.5
    best = min(known[name] for name in ps4.BASELINES)
    paid = [ps4.share_of(cost, known) for cost in (best, known["observed"], 0.0)]
    assert paid == [0, pytest.approx(1 / 3), 1]
    # Other days, other noise and other starts in every case.
    assert cases[0].day != cases[1].day
    assert cases[0].seed != cases[1].seed
    assert (cases[0].offset != cases[1].offset).all()


def test_every_draw_has_a_drive_without_any_turn():
    for seed in range(20):
        (rates, radii, *_), nearly = ps1._drives(np.random.default_rng(seed), 2)
        assert np.subtract(*rates * radii) == 0
        assert rates[0] != rates[1]
        assert abs(np.subtract(*nearly[0] * nearly[1])) < 1e-15


def test_one_gain_alone_does_not_earn_all(solved):
    answers = solved("ps3")
    answers.run("best = tuned\ndef tuned():\n    return given | {'k2': 0.65}")
    try:
        ((share, _),) = shares("ps3", answers, ["tuned"]).values()
    finally:
        answers.run("tuned = best")
    assert 0 < share < 0.85


def test_nearness_costs(monkeypatch):
    case = ps4.cases(7, 2)[0]
    path = fs.shortest_path(case.world, case.start, case.goal, margin=0.008).path
    reference = ps4._along(path, case.world)
    with_it = ps4._cost(fs.Pid(), case, reference)
    monkeypatch.setattr(ps4, "NEARNESS", 0.0)
    assert 0.2 < with_it - ps4._cost(fs.Pid(), case, reference) < 1000 * ps4.NEARBY * 0.1


def test_time_counts_for_the_student_alone(monkeypatch):
    monkeypatch.setattr(judge.Answers, "patience", 3.0)
    monkeypatch.setattr(judge, "PATIENCE", 3.0)
    with judge.Answers() as answers:
        answers.run(
            "import time\ndef work(s):\n    end = time.process_time() + s\n"
            "    while time.process_time() < end:\n        pass\n    return s"
        )
        # Three times as long as a student's own check allows; beyond that it is ended.
        assert answers("work", 0.2, limit=0.1) == 0.2
        with pytest.raises(Late, match=r"over 0\.1 s"):
            answers("work", 30.0, limit=0.1)
        # The next question finds the cells run again.
        assert answers("work", 0.0) == 0.0
    notebook = untouched("ps1")
    loop = "def largest_robot(*given):\n    while True:\n        pass"
    nbgrader_cells(notebook)["answer-largest"].source = loop
    monkeypatch.setitem(judge.Answers.__call__.__kwdefaults__, "limit", 0.05)
    notebook.cells = notebook.cells[:-1]
    remarks = judge.judge_notebook(notebook, NAMES["ps1"], SECRET)
    assert remarks == ["ps1.largest was ended by its time limit"]


def test_a_cell_that_does_not_end_is_stopped_once(monkeypatch):
    monkeypatch.setattr(judge, "CELL", 0.5)
    again = "import os\nwhile os.path.exists('seen'):\n    pass\nopen('seen', 'w').close()"
    with judge.Answers() as answers:
        answers.run("def one():\n    return 1")
        (output,) = answers.run("while True:\n    pass", "answer-turn")
        assert "cell answer-turn did not end within 0.5 s and was stopped" in output.evalue
        answers.run("import os\nos._exit(0)")
        # It ends the first time, and never after.
        answers.run(again)
        for _ in range(2):
            answers.stop()
            assert answers("one") == 1
        assert len(answers.ran) == 1
    assert [remark.partition(":")[0] for remark in answers.remarks] == [
        "cell answer-turn did not end within 0.5 s and was stopped, so that what it defines is missing",
        "cell 'import os' ended Python",
        "cell 'import os' did not end within 0.5 s and was stopped, so that what it defines is missing",
    ]


def test_a_cell_shows_its_last_value_if_that_says_something():
    with judge.Answers() as answers:
        assert answers.run("object()") == []
        (shown,) = answers.run("1 + 1")
        assert shown.data == {"text/plain": "2"}


def test_a_law_may_take_as_long_as_the_robot_drives():
    class Busy:
        patience, now = 2.0, 0.0

        def clock(self):
            return self.now

        def __call__(self, name, *values, limit=1.0, keep=False):
            self.now += 0 if keep else 0.5
            return "#0" if keep else [0.0, 0.0]

    law = Law(Busy(), "start", duration=1.0)
    assert [law(0.1 * k, np.zeros(3)) for k in range(3)] == [[0.0, 0.0]] * 3
    with pytest.raises(Late, match="longer than the robot drives"):
        law(0.3, np.zeros(3))


@pytest.mark.parametrize("part", PROBLEM_SETS)
def test_lessons_hold_at_most_a_quarter_of_a_set(part):
    """Every function of the lessons that a set needs, in place of every answer."""
    source = read(part)
    lessons = re.findall(r"\.\./\.\./(\w+\.ipynb)", source.cells[0].source)
    assert lessons
    names = {}
    for lesson in lessons:
        for cell in nbformat.read(NOTEBOOKS / lesson, as_version=4).cells:
            names |= defined(cell.source) if cell.cell_type == "code" else {}
    worth, got = points_of(part), 0
    asked = dict(
        zip(
            worth,
            {
                "ps2": "tangent turning_point plan_turns hard_case",
                "ps3": "controls singular_x safe_ahead start tuned",
                "ps4": "start start start",
                "ps5": ASKED["ps5"].replace("verdict", "runs_needed verdict"),
            }.get(part, ASKED[part]).split(),
            strict=True,
        )
    )
    for test, points in worth.items():
        best = 0.0
        for function in names.values():
            here = Here({"plan_turns": lambda *_: None} | {asked[test]: function})
            best = max(best, judge_test(f"{part}.{test}", here, [1])[0])
        got += best * points
    by_hand = sum(
        cell.metadata.nbgrader.points
        for cell in nbgrader_cells(source).values()
        if cell.metadata.nbgrader.grade and cell.cell_type == "markdown"
    )
    assert got <= (sum(worth.values()) + by_hand) / 4


def defined(source):
    """Functions that a lesson's cell defines, with what they need of the package."""
    try:
        tree = ast.parse(source)
    except SyntaxError:  # such as what only a notebook understands
        return {}
    body = [one for one in tree.body if isinstance(one, ast.FunctionDef)]
    for one in body:
        # Defaults are numbers of the lesson, of which a set has none.
        one.args.defaults = [ast.Constant(None) for _ in one.args.defaults]
    names = {"np": np, "fs": fs}
    module = ast.fix_missing_locations(ast.Module(body, []))
    exec(compile(module, "a lesson", "exec"), names)
    return {one.name: names[one.name] for one in body}


@pytest.mark.parametrize("part", PROBLEM_SETS)
def test_a_set_says_what_it_is(part):
    source = read(part)
    first = source.cells[0].source
    for told in ("*Paper: ", "**You will**", "**You need**", "**It takes** about"):
        assert told in first
    points = [cell.metadata.nbgrader.get("points", 0) for cell in nbgrader_cells(source).values()]
    assert sum(points) == 20
    assert "gives 20 points" in first
    for name in points_of(part):
        cell = nbgrader_cells(source)[name]
        assert cell.metadata.nbgrader.locked
        assert re.fullmatch(rf'check\("{part}\.{name}", [\w, ]+\)', cell.source)
        assert find_test(f"{part}.{name}").__doc__
    assert set(points_of(part)) == set(import_module(f"freeseg.teaching.{part}").__all__)


def test_prose_names_the_constants_it_means():
    contest = read("ps4").cells[3].source
    assert f"{ps4.SECOND:g}\\,(T-T_0)" in contest
    assert f"{ps4.WORK:g}\\,\\frac" in contest
    assert f"{ps4.NEARNESS:g}\\,\\max(0,{1000 * ps4.NEARBY:g}-g)" in contest
    assert f"$c={ps4.PAYS_FROM:g}\\,b$" in contest
    assert f"$c=o$ a third of 12 points, at $c={ps4.PAYS_ALL:g}\\,o$ all" in contest
    assert ps4.OBSERVED_PAYS == 1 / 3
    assert (CASES, CASES * judge.SEEDS) == (4, 8)
    assert "four cases in your\nnotebook, and eight others when it is graded" in contest
    assert f"begins up to {1000 * ps4.STARTS_WITHIN[0]:g} mm beside its reference" in contest
    assert f"turned by up to {np.degrees(ps4.STARTS_WITHIN[1]):.0f}°" in contest
    names = {}
    exec(read("ps4").cells[1].source, names)
    assert (names["usual"], names["rough"]) == (ps4.tracking.DISTURBANCE, ps4.ROUGH)
    assert f"within {1000 * ps4.AT_GOAL:g} mm" in contest
    assert f"{1000 * ps4.ASTRAY:g} mm from the path" in contest
    tuning = "".join(cell.source for cell in read("ps3").cells)
    assert f"Points begin below {ps3.NO_POINTS:g} and are full at {ps3.ALL_POINTS:g}" in tuning
    assert f"given = {ps3.START_GAINS}".replace("'", '"') in tuning
    breaking = "".join(cell.source for cell in read("ps2").cells)
    assert f"up to {100 * (ps2.ALLOWED - 1):.0f} % longer" in breaking
    assert f"over {100 * (ps2.BROKEN - 1):.0f} % longer" in breaking
    assert ps2.MOST_DISCS == 6


def test_without():
    kept = [fs.plan]
    world = fs.load_table(1)
    with without("freeseg.planners"):
        for call in (fs.plan, fs.shortest_path, fs.plan_rooms, kept[0]):
            with pytest.raises(AssertionError, match="do it yourself, without freeseg's"):
                call(world, (0, 0), (0.75, 0.75))
        fs.free_segments(world, fs.KheperaIV())
    assert fs.plan(world, (0, 0), (0.75, 0.75)).turning_points


def test_alike_is_named_whatever_the_names():
    first, other = read("ps5"), deepcopy(read("ps5"))
    for cell in other.cells:
        cell.source = cell.source.replace("differences", "gaps").replace("0.975", "0.9750")
    # Somebody else's words with no code are alike, too.
    words = untouched("ps5")
    nbgrader_cells(words)["claim"].source = nbgrader_cells(first)["claim"].source.upper()
    given = untouched("ps5")
    nbgrader_cells(given)["claim"].source = "YOUR ANSWER HERE"
    students = {"ada": first, "bob": other, "eve": untouched("ps5"), "kim": words}
    nbgrader_cells(students["eve"])["claim"].source = "YOUR ANSWER HERE"
    nbgrader_cells(other)["claim"].source = "My own few words."
    assert submissions.similar(students, given, {}) == [
        ("ada", "a hint: 100% as in bob"),
        ("bob", "a hint: 100% as in ada"),
        ("ada", "a hint: its words are 100% as in kim"),
        ("kim", "a hint: its words are 100% as in ada"),
    ]


def test_model_answers_say_what_is_measured():
    why = nbgrader_cells(read("ps2"))["why"].source
    cell = nbgrader_cells(read("ps2"))["answer-break"].source
    names = {}
    exec(cell, names)
    discs, start, goal, wrong, whose = names["hard_case"]()
    world = fs.World([fs.Disc((x, y), r) for x, y, r in discs])
    found, best = fs.plan(world, start, goal), fs.shortest_path(world, start, goal)
    assert whose == "fs.plan"
    assert [(one.obstacle + 1, one.sense) for one in found.turning_points] == [wrong]
    assert f"a path of {1000 * found.path.length:.0f} mm" in why
    assert f"path, {1000 * best.path.length:.0f} mm, turns round 5, 2 and 1" in why
    assert [one.obstacle + 1 for one in best.turning_points] == [5, 2, 1]
    *_, text, _, picture = read("ps3").cells
    printed = picture.outputs[0].text
    for seconds in re.findall(r"until (\d\.\d\d) s", printed):
        assert f"until {seconds} s" in text.source
    *_, discussion, table = read("ps4").cells
    numbers = re.findall(r"\d\.\d\d", table.outputs[0].data["text/markdown"])
    (_, pid), (_, sliding), (mine, alone) = np.array(numbers, float).reshape(3, 2)
    assert pid == sliding == 0.01
    assert f"only to {alone:.2f} mm" in discussion.source
    assert mine < alone + 0.1
