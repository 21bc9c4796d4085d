"""The problem sets are released and graded as a lecturer does it, by nbgrader itself.

Every typical mistake is graded in this process, whose points nbgrader counts, and one of each set
by nbgrader from end to end. ``pytest -m exhaustive`` has it grade them all.
"""

import ast
import csv
import functools
import importlib.util
import io
import json
import re
import shutil
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout, suppress
from copy import deepcopy
from importlib.util import find_spec
from threading import Thread
from unittest.mock import patch

import nbformat
import numpy as np
import pytest
from refresh_notebooks import NOTEBOOKS

import freeseg as fs
from freeseg.studies import courses, tracking
from freeseg.teaching import check, variant_seed, without

if find_spec("nbgrader"):
    import nbgrader.api
    from nbgrader.utils import determine_grade

    #: What nbgrader asks another program at every new grade book is always the same.
    nbgrader.api.get_alembic_version = functools.cache(nbgrader.api.get_alembic_version)

FOLDER = NOTEBOOKS / "assignments"
PS1 = "ps1_kinematics_and_segments"
SETS = sorted(file.stem for file in FOLDER.glob("ps*/*.ipynb"))
#: Longest time of a cell (s) where one loops, and elsewhere, where the machine may be busy.
LOOPING, TIMEOUT = 8, 120
#: Longest time (s) of a test that is to be lost to a loop.
SOON = 1.0

#: Typical mistakes: set, text of the reference solution, what stands there instead, tests lost.
MISTAKES = {
    "wheel base halved": (
        "ps1_kinematics_and_segments",
        "(right - left) / L",
        "(right - left) / (L / 2)",
        {"test-to-body"},
    ),
    "wheel base halved twice": (
        "ps1_kinematics_and_segments",
        "v + L * omega / 2, v - L * omega / 2",
        "v + L / 2 * omega / 2, v - L / 2 * omega / 2",
        {"test-to-wheels"},
    ),
    "degrees for radians": (
        "ps1_kinematics_and_segments",
        "np.abs(np.radians(sweep_deg))",
        "np.abs(sweep_deg)",
        {"test-arc-length"},
    ),
    "mm for m": (
        "ps1_kinematics_and_segments",
        "(apart - radii_mm[:-1] - radii_mm[1:]) / 1000",
        "apart - radii_mm[:-1] - radii_mm[1:]",
        {"test-tables", "test-worlds"},
    ),
    "danger segments not ignored": (
        "ps1_kinematics_and_segments",
        "number = int(np.sum(is_safe(lengths, diameter, margin)))",
        "number = len(lengths)",
        {"test-ignored"},
    ),
    "turn on the wrong side": (
        "ps2_turning_points",
        "aside[0] > 0 else -1",
        "aside[0] < 0 else -1",
        {"test-side"},
    ),
    "tangent on the wrong side": (
        "ps2_turning_points",
        "- sense * np.arcsin",
        "+ sense * np.arcsin",
        {"test-tangent"},
    ),
    "an endless tangent": (
        "ps2_turning_points",
        "distance = np.hypot(*way)",
        "while True:\n        distance = np.hypot(*way)",
        {"test-tangent"},
    ),
    "danger segments among the turning points": (
        "ps2_turning_points",
        "usable = ends[safe].reshape(-1, 2)",
        "usable = ends.reshape(-1, 2)",
        {"test-turning-point"},
    ),
    "a planner of the package": (
        "ps2_turning_points",
        "ends, safe, owners = segments_of(world)",
        "found = fs.plan(world, start, goal, robot, margin).turning_points\n"
        "    return [(turn.center, turn.sense * turn.radius) for turn in found]",
        {"test-planner", "test-break"},
    ),
    "a planner that raises": (
        "ps2_turning_points",
        "while len(turns) < 2 * len(world):",
        "while True:\n        if len(turns) > 4:\n            raise ValueError('no way')",
        {"test-break"},
    ),
    "wrong sign of the heading error": (
        "ps3_sliding_mode",
        "wrap_angle(theta_r - theta)",
        "wrap_angle(theta - theta_r)",
        {"test-error"},
    ),
    "the package's error": (
        "ps3_sliding_mode",
        "cos, sin = np.cos(theta), np.sin(theta)",
        "return fs.tracking_error(reference_pose, pose)",
        {"test-error"},
    ),
    "the package's law": (
        "ps3_sliding_mode",
        "x_e, y_e, alpha_e = fs.tracking_error(here.pose, pose)",
        "gains = self.k1, self.k2, self.phi1, self.phi2, self.length_scale\n"
        "            law = fs.SlidingMode(*gains, floor=self.floor).start(reference, robot, dt)\n"
        "            return law(t, pose)",
        {"test-law"},
    ),
    "unit of length only once": ("ps3_sliding_mode", "c = unit**2", "c = unit", {"test-unit"}),
    "an endless unit": (
        "ps3_sliding_mode",
        "c = unit**2",
        "while True:\n        c = unit**2",
        {"test-unit"},
    ),
    "singularity not guarded": (
        "ps3_sliding_mode",
        "np.maximum(1 + flat * ahead.v * x_e, self.floor)",
        "(1 + flat * ahead.v * x_e)",
        {"test-law"},
    ),
    "rate of the reference's speed forgotten": (
        "ps3_sliding_mode",
        "+ flat * y_e * ahead.v_dot",
        "",
        {"test-law"},
    ),
    "error in mm": (
        "ps3_sliding_mode",
        'rms = numbers["position_rms_m"].mean()',
        'rms = 1000 * numbers["position_rms_m"].mean()',
        {"test-switching"},
    ),
    "wrong sign of the heading's damping": (
        "ps4_beat_the_baseline",
        "+ 55.0 * np.sin(alpha_e)",
        "- 55.0 * np.sin(alpha_e)",
        {"test-arrives", "test-cost-curve"},
    ),
    "degrees for radians in a gain": (
        "ps4_beat_the_baseline",
        "55.0 * np.sin(alpha_e)",
        "55.0 * np.sin(np.degrees(alpha_e))",
        {"test-arrives", "test-cost-curve"},
    ),
    "no number": (
        "ps4_beat_the_baseline",
        "+ 6.0 * x_e",
        "+ np.nan * x_e",
        {"test-contract", "test-arrives", "test-cost-curve"},
    ),
    "memory that outlives a run": (
        "ps4_beat_the_baseline",
        "share, learning = 0.2 * self.gain, 50.0",
        "globals()['runs'] = runs = globals().get('runs', 0) + 1\n"
        "        share, learning = 0.2 * self.gain, 50.0 + runs % 2",
        {"test-contract"},
    ),
    "path through an obstacle's margin": (
        "ps4_beat_the_baseline",
        "margin = 0.01",
        "return fs.Path([fs.path.Line(start, goal)])",
        {"test-contract", "test-arrives", "test-cost-curve"},
    ),
    "a baseline with another name": (
        "ps4_beat_the_baseline",
        "share, learning = 0.2 * self.gain, 50.0",
        "return fs.Pid().start(reference, robot, dt)\n        share, learning = 0.2, 50.0",
        {"test-contract", "test-arrives", "test-cost-curve"},
    ),
    "m for mm": (
        "ps4_beat_the_baseline",
        '1000 * numbers["position_rms_m"]',
        'numbers["position_rms_m"]',
        {"test-cost"},
    ),
    "an endless cost": (
        "ps4_beat_the_baseline",
        "cost += max(-0.3, run.t[-1] - case.duration)",
        "while True:\n        cost += max(-0.3, run.t[-1] - case.duration)",
        {"test-cost"},
    ),
    "touching is free": (
        "ps4_beat_the_baseline",
        'numbers["clearance_m"] < robot.radius',
        'numbers["clearance_m"] < 0',
        {"test-cost"},
    ),
}


def read(name, folder=FOLDER):
    return nbformat.read(folder / name / f"{name}.ipynb", as_version=4)


def nbgrader_cells(notebook):
    """Cells that nbgrader knows, by name."""
    return {
        cell.metadata.nbgrader.grade_id: cell
        for cell in notebook.cells
        if "nbgrader" in cell.metadata
    }


@pytest.fixture(params=SETS, ids=lambda name: name.split("_")[0])
def name(request):
    return request.param


def need_nbgrader():
    """Skip a test that grades if nbgrader, which only lecturers need, is not installed.

    One that is installed and broken is an error.
    """
    if not find_spec("nbgrader"):
        pytest.skip("grading needs it: pip install -r notebooks/assignments/requirements.txt")


class Course:
    """A copy of the assignments, with some of the sets, to release and grade in."""

    def __init__(self, root, *names, timeout=TIMEOUT, course="freeseg"):
        need_nbgrader()
        self.folder = root / "assignments"
        self.submissions = root / "submissions"
        self.folder.mkdir(parents=True)
        for name in names:
            shutil.copytree(FOLDER / name, self.folder / name)
        for file in FOLDER.glob("*.py"):
            text = file.read_text(encoding="utf-8")
            text = text.replace("c.Execute.timeout = 30", f"c.Execute.timeout = {timeout}")
            text = text.replace('course_id = "freeseg"', f'course_id = "{course}"')
            (self.folder / file.name).write_text(text, encoding="utf-8")
        spec = importlib.util.spec_from_file_location("grade", self.folder / "grade.py")
        self.grade = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(self.grade)

    def release(self):
        self.grade.release(self.folder)
        return self.folder / "build" / "release"

    def submit(self, student, name, notebook):
        file = self.submissions / student / f"{name}.ipynb"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(notebook) if notebook else '{"cells": [', encoding="utf-8")

    def graded(self):
        """Grade all submissions; rows of grades.csv by student."""
        self.grade.grade(self.submissions, self.folder)
        return self.rows()

    def rows(self):
        with (self.folder / "build" / "grades.csv").open(
            newline="", encoding="utf-8-sig"
        ) as stream:
            return {row["student"]: row for row in csv.DictReader(stream)}

    def points(self, student, name):
        """Points and worth of every graded cell, from nbgrader's grade book."""
        with self.grade.open_book(self.grade.open_course(self.folder)) as book:
            submission = book.find_submission_notebook(name, name, student)
            return {grade.name: (grade.score, grade.max_score) for grade in submission.grades}

    def grade_by_hand(self, student, name):
        """Full points for every answer that waits for the lecturer."""
        with self.grade.open_book(self.grade.open_course(self.folder)) as book:
            for grade in book.find_submission_notebook(name, name, student).grades:
                if grade.needs_manual_grade:
                    grade.manual_score, grade.needs_manual_grade = grade.max_score, False
            book.db.commit()

    def said(self, student, name):
        """What every cell printed to the error stream."""
        return complaints(read(name, self.folder / "build" / "autograded" / student))


def complaints(notebook):
    """What every cell that nbgrader knows printed to the error stream."""
    return {
        cell_name: "".join(output.text for output in cell.outputs if output.get("name") == "stderr")
        for cell_name, cell in nbgrader_cells(notebook).items()
        if cell.cell_type == "code"
    }


def lost(points):
    """Cells that gave less than all their points."""
    return {cell for cell, (score, worth) in points.items() if score < worth}


def outputs_of(source, names):
    """What a cell prints, shows and raises in this process; `names` are those given before it."""
    streams, outputs, value = {"stdout": io.StringIO(), "stderr": io.StringIO()}, [], None
    with redirect_stdout(streams["stdout"]), redirect_stderr(streams["stderr"]):
        try:
            body = ast.parse(source).body
            last = body.pop() if isinstance(body[-1], ast.Expr) else None
            exec(compile(ast.Module(body, []), "a cell", "exec"), names)
            if last:
                value = eval(compile(ast.Expression(last.value), "a cell", "eval"), names)
        except Exception as error:
            told = {"ename": type(error).__name__, "evalue": str(error), "traceback": []}
            outputs.append(nbformat.v4.new_output("error", **told))
    for stream, text in streams.items():
        if text.getvalue():
            printed = nbformat.v4.new_output("stream", name=stream, text=text.getvalue())
            outputs.append(printed)
    if value is not None:
        shown = nbformat.v4.new_output("execute_result", data={"text/plain": repr(value)})
        outputs.append(shown)
    return outputs


def grade_here(notebook, name, folder, looping):
    """Points and complaints of a solved notebook whose cells run in this process.

    Neither kernels nor nbgrader's own steps take part, but nbgrader's rule for points does.

    Parameters
    ----------
    notebook : NotebookNode
        With the hidden tests.
    name, folder : str, Path
        As `grade_by_nbgrader` has them; not used.
    looping : set of str
        Tests that are to be lost to a loop: they are ended soon.

    Returns
    -------
    points : dict
        Score and worth of every graded cell; one that waits for the lecturer has no score yet.
    said : dict
        What every cell printed to the error stream.
    """
    need_nbgrader()
    ran, names = deepcopy(notebook), {"__name__": "__main__"}
    cells = nbgrader_cells(ran)
    for cell_name, cell in cells.items():
        if cell.cell_type == "code":
            with patch.dict(check.__kwdefaults__, {"limit": SOON} if cell_name in looping else {}):
                cell.outputs = outputs_of(cell.source, names)
    graded = {
        cell_name: determine_grade(cell)
        for cell_name, cell in cells.items()
        if cell.metadata.nbgrader.grade
    }
    points = {cell_name: (score or 0.0, worth) for cell_name, (score, worth) in graded.items()}
    return points, complaints(ran)


def grade_by_nbgrader(notebook, name, folder, looping):
    """Points and complaints as `grade_here` gives them, by nbgrader from end to end."""
    course = Course(folder, name)
    course.submit("student", name, solve(read(name, course.release()), notebook))
    row, points = course.graded()["student"], course.points("student", name)
    assert row["remarks"] == ""
    assert float(row["score"]) == pytest.approx(sum(score for score, _ in points.values()))
    assert (course.folder / "build" / "feedback" / "student" / name / f"{name}.html").exists()
    return points, course.said("student", name)


#: Both ways of grading; the second takes far longer.
BOTH_WAYS = pytest.mark.parametrize(
    "grade",
    [
        pytest.param(grade_here, id="here"),
        pytest.param(grade_by_nbgrader, id="nbgrader", marks=pytest.mark.exhaustive),
    ],
)


def solve(released, source, only=None):
    """The released notebook with the reference solution, or with that of some cells."""
    solved, reference = deepcopy(released), nbgrader_cells(source)
    for cell_name, cell in nbgrader_cells(solved).items():
        if cell.metadata.nbgrader.solution and (only is None or cell_name in only):
            cell.source = reference[cell_name].source
    return solved


def replace_once(notebook, old, new):
    """A copy of a notebook in which a solution says something else."""
    changed = deepcopy(notebook)
    found = [cell for cell in nbgrader_cells(changed).values() if old in cell.source]
    found = [cell for cell in found if cell.metadata.nbgrader.solution]
    assert len(found) == 1, f"{len(found)} solutions say {old!r}; say here what yours does"
    (cell,) = found
    cell.source = cell.source.replace(old, new)
    return changed


def worth_of(source):
    """Points that every graded cell of a set is worth."""
    return {
        cell_name: cell.metadata.nbgrader.points
        for cell_name, cell in nbgrader_cells(source).items()
        if cell.metadata.nbgrader.grade
    }


def waiting_in(source):
    """Answers of a set that wait for the lecturer."""
    cells = nbgrader_cells(source)
    return {cell for cell in worth_of(source) if cells[cell].metadata.nbgrader.solution}


def assert_helpful(said):
    """Whoever loses points reads of what, and why."""
    for cell_name, message in said.items():
        if message:
            first, second, *_ = message.splitlines()
            assert first.startswith("not yet: ")
            assert len(second) > 20, cell_name
            assert "AssertionError" not in message


def assert_costs(key, points, said):
    """A mistake loses the tests that it should, and the tests say why."""
    name, *_, tests = MISTAKES[key]
    source = read(name)
    assert {cell: worth for cell, (_, worth) in points.items()} == worth_of(source)
    assert lost(points) == tests | waiting_in(source)
    # The curve of the last set gives a part of its points; every other test all or none.
    assert all(points[test][0] == 0 for test in tests - {"test-cost-curve"})
    assert sum(points[test][1] - points[test][0] for test in tests) > 0
    assert_helpful(said)


@BOTH_WAYS
@pytest.mark.parametrize("key", MISTAKES)
def test_a_mistake_costs_its_points(key, grade, tmp_path):
    name, old, new, tests = MISTAKES[key]
    looping = tests if key.startswith("an endless") else set()
    points, said = grade(replace_once(read(name), old, new), name, tmp_path, looping)
    assert_costs(key, points, said)
    assert all("is there a loop that does not end?" in said[test] for test in looping)


def test_grading_by_nbgrader(name, tmp_path):
    course = Course(tmp_path, name)
    released, source = read(name, course.release()), read(name)
    worth = sum(worth_of(source).values())
    solutions = [
        cell_name
        for cell_name, cell in nbgrader_cells(source).items()
        if cell.metadata.nbgrader.solution and not cell.metadata.nbgrader.grade
    ]
    solved = solve(released, source)
    course.submit("untouched", name, released)
    course.submit("reference", name, solved)
    course.submit("half", name, solve(released, source, solutions[: (1 + len(solutions)) // 2]))
    key, (_, old, new, _) = next(item for item in MISTAKES.items() if item[1][0] == name)
    course.submit(key, name, replace_once(solved, old, new))
    rows = course.graded()

    assert set(rows) == {"untouched", "reference", "half", key}
    remarks = {student: row["remarks"] for student, row in rows.items()}
    assert remarks.pop("untouched").startswith("no id is written in it")
    assert set(remarks.values()) == {""}
    assert float(rows["untouched"]["score"]) == 0
    assert float(rows["untouched"]["max_score"]) == worth
    unsolved = read(name, course.folder / "build" / "autograded" / "untouched")
    assert not [
        o for cell in unsolved.cells for o in cell.get("outputs", ()) if o.output_type == "error"
    ]
    assert_helpful(course.said("untouched", name))

    by_hand = int(rows["reference"]["to_grade_by_hand"])
    assert by_hand == len(waiting_in(source))
    final = rows["reference"]
    if by_hand:
        course.grade_by_hand("reference", name)
        course.grade.report(course.folder)
        final = course.rows()["reference"]
    assert float(final["score"]) == float(final["max_score"]) == worth
    assert final["to_grade_by_hand"] == "0"
    assert 0 < float(rows["half"]["score"]) < float(rows["reference"]["score"])

    points = course.points(key, name)
    assert_costs(key, points, course.said(key, name))
    assert float(rows[key]["score"]) == pytest.approx(sum(score for score, _ in points.values()))
    for student in rows:
        assert (course.folder / "build" / "feedback" / student / name / f"{name}.html").exists()


#: A planner of one's own: it stands for one, by putting back what refuses to work.
OWN_PLANNER = """
from freeseg.planners import tangent_graph

codes = {part: part.__code__ for part in (fs.shortest_path, tangent_graph.TangentGraph.shortest)}


def own(*query):
    refusing = {part: part.__code__ for part in codes}
    try:
        for part, code in codes.items():
            part.__code__ = code
        return fs.shortest_path(*query)
    finally:
        for part, code in refusing.items():
            part.__code__ = code


"""

#: What is as good as the reference solution: set, and what stands there instead of what.
AS_GOOD = {
    "a complete planner, and a world on which the search through a triangulation fails": (
        "ps2_turning_points",
        {
            "ends, safe, owners = segments_of(world)": "found = own(world, start, goal)\n"
            "    return [(turn.center, turn.sense * turn.radius) for turn in found.turning_points]",
            "def plan_turns(": OWN_PLANNER + "def plan_turns(",
            "# A pocket round the start, open behind it; all of its gaps are danger.": "world = "
            "fs.random_world(20, 14, area=0.05)\n    return (world, *fs.random_query(world, 14))",
        },
    ),
    "a planner of one's own with a baseline": (
        "ps4_beat_the_baseline",
        {
            "return Mine()": 'return tuned("Mpc")',
            "margin = 0.01": "return own(world, start, goal, robot, 0.01).path",
            "def my_path(": OWN_PLANNER + "def my_path(",
        },
    ),
}


@BOTH_WAYS
@pytest.mark.parametrize("kind", AS_GOOD)
def test_other_solutions_get_the_points_too(kind, grade, tmp_path):
    name, changes = AS_GOOD[kind]
    solved = read(name)
    for old, new in changes.items():
        solved = replace_once(solved, old, new)
    points, _ = grade(solved, name, tmp_path, set())
    by_hand = {"why", "discussion"} & set(points)
    # On paths about as good as the given ones, the best baseline has 5.7 of the curve's 8 points.
    assert lost(points) - {"test-cost-curve"} == by_hand
    assert points.get("test-cost-curve", (8, 8))[0] > 5.5


def tamper(notebook):
    """Do to every test of the first set what would give points for nothing."""
    notebook = deepcopy(notebook)
    cells = nbgrader_cells(notebook)
    cells["test-to-body"].source = "print('passed')"
    notebook.cells.remove(cells["test-to-wheels"])
    notebook.cells.remove(cells["setup"])
    cells["test-straight"].metadata.tags = ["skip-execution"]
    notebook.cells[notebook.cells.index(cells["test-arc"])] = nbformat.v4.new_markdown_cell(
        cells["test-arc"].source, metadata=cells["test-arc"].metadata
    )
    cells["test-arc-length"].metadata.nbgrader.points = 99
    cells["test-tables"].metadata.nbgrader.grade = False
    fake = nbformat.v4.new_code_cell("", metadata=cells["test-worlds"].metadata)
    notebook.cells.append(fake)
    cells["test-safe"].metadata.nbgrader.update(locked=False, solution=True)
    del cells["test-ignored"].metadata["nbgrader"]
    shadow = "%matplotlib inline\ncheck = points = lambda *anything: print('passed')"
    notebook.cells.insert(notebook.cells.index(cells["wheels"]), nbformat.v4.new_code_cell(shadow))
    return notebook


def test_tampering_is_put_right_and_reported(tmp_path):
    course = Course(tmp_path, PS1)
    released = read(PS1, course.release())
    course.submit("tampered", PS1, tamper(solve(released, read(PS1))))
    course.submit("tampered and unsolved", PS1, tamper(released))
    rows = course.graded()
    assert float(rows["tampered"]["score"]) == float(rows["tampered"]["max_score"]) == 20
    assert float(rows["tampered and unsolved"]["score"]) == 0
    for student in ("tampered", "tampered and unsolved"):
        for cell in nbgrader_cells(released).values():
            assert "it redefines what the tests use: check" in rows[student]["remarks"]
            named = f"cell {cell.metadata.nbgrader.grade_id} " in rows[student]["remarks"]
            assert named == (cell.metadata.nbgrader.grade or cell == released.cells[1])


def test_what_goes_wrong_is_reported(tmp_path, capfd):
    course = Course(tmp_path, PS1, timeout=LOOPING)
    released, source = read(PS1, course.release()), read(PS1)
    solved = solve(released, source)
    body = "length = radius * np.abs(np.radians(sweep_deg))"
    course.submit("a broken file", PS1, None)
    course.submit("a dead kernel", PS1, replace_once(solved, body, "import os; os._exit(1)"))
    loop = replace_once(solved, body, "while True: pass")
    course.submit("a loop", PS1, loop)
    limit = f'student = "reference"\ncheck.__kwdefaults__["limit"] = {SOON}'
    limited = replace_once(loop, 'student = "reference"', limit)
    course.submit("a loop that its test ends", PS1, limited)
    quiet = replace_once(
        released, "student = ", "import io, sys; sys.stderr = io.StringIO()\nstudent = "
    )
    course.submit("quiet", PS1, quiet)
    breaking = deepcopy(solved)
    breaking.cells.insert(0, nbformat.v4.new_code_cell("import sys; sys.modules['freeseg'] = None"))
    course.submit("nothing imports", PS1, breaking)
    course.submit("twice", f"{PS1}-Copy1", solved)
    course.submit("twice", f"{PS1}-Copy2", solved)
    course.submit("unknown", "essay", solved)
    (course.submissions / "empty").mkdir()
    rows = course.graded()
    assert "9/9" in capfd.readouterr().err  # the progress, over all files

    for student, why in (
        ("a broken file", "cannot be read"),
        ("a dead kernel", "Kernel died"),
        ("unknown", "unknown/essay.ipynb is not <student>/"),
        ("empty", "there is no notebook in this folder"),
    ):
        assert rows[student]["remarks"].startswith("not graded: ")
        assert why in rows[student]["remarks"]
        assert rows[student]["score"] == ""

    for student in ("a loop", "a loop that its test ends"):
        assert lost(course.points(student, PS1)) == {"test-arc-length"}
        assert float(rows[student]["score"]) == 20 - 2
        assert rows[student]["remarks"] == ""
        ended = "loop that does not end?" in course.said(student, PS1)["test-arc-length"]
        assert ended == (student != "a loop")

    assert "cell setup, which was given, raised Module" in rows["nothing imports"]["remarks"]
    tests = [
        name for name, cell in nbgrader_cells(released).items() if cell.metadata.nbgrader.grade
    ]
    assert all(f"test {test} printed nothing" in rows["quiet"]["remarks"] for test in tests)

    assert float(rows["twice"]["score"]) == 20
    first, second = (f"twice/{PS1}-Copy{k}.ipynb" for k in (1, 2))
    assert rows["twice"]["remarks"] == f"it is there twice: {first} counts, {second} does not"

    # Handed in again, under its right name, and broken.
    shutil.rmtree(course.submissions)
    course.submit("unknown", PS1, solved)
    course.submit("twice", PS1, None)
    rows = course.graded()
    assert float(rows["unknown"]["score"]) == 20
    assert rows["twice"]["score"] == ""
    feedback = course.folder / "build" / "feedback"
    assert (feedback / "unknown" / PS1).exists()
    assert not (feedback / "twice" / PS1).exists()
    assert (course.folder / "build" / "grades.csv").read_text().count("unknown,") == 1


def test_feedback_has_pictures_and_runs_no_code_of_a_student(tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")  # which kernels must not inherit
    name = "ps2_turning_points"
    course = Course(tmp_path, name)
    answer = read(name, course.release())
    attack = "<img src='x' onerror='alert(1)'><script>alert(2)</script> $x^2$"
    nbgrader_cells(answer)["why"].source = attack
    shows = f'from IPython.display import HTML, display\ndisplay(HTML("{attack}"))'
    answer.cells.append(nbformat.v4.new_code_cell(shows))
    course.submit("mallory", name, answer)
    course.graded()
    file = course.folder / "build" / "feedback" / "mallory" / name / f"{name}.html"
    page = file.read_text(encoding="utf-8")
    assert "$x^2$" in page
    assert "data:image/png;base64" in page
    assert "<details>" in page
    assert "&lt;img src=" in page  # shown as text
    assert not re.search(r"<[^<>]*onerror|<script>alert", page)


def test_restoring_keeps_what_is_the_student_s(tmp_path):
    restore = Course(tmp_path).grade.restore
    released = read("ps2_turning_points")
    assert restore(released, released)[1] == []
    submitted = deepcopy(released)
    cells = nbgrader_cells(submitted)
    picture = {"figure.png": {"image/png": "AAAA"}}
    cells["why"].update(source="![](attachment:figure.png)", attachments=picture)
    own = nbformat.v4.new_code_cell("helper = 1", metadata={"tags": ["skip-execution"]})
    submitted.cells.insert(submitted.cells.index(cells["planner"]) + 1, own)
    submitted.cells.insert(0, nbformat.v4.new_raw_cell("notes"))
    # What JupyterLab adds when it saves.
    cells["test-side"].metadata.update(trusted=True, execution={"iopub.status.busy": "2030"})
    restored, changes = restore(submitted, released)
    nbformat.validate(restored)
    assert changes == []
    sources = [cell.source for cell in restored.cells]
    assert sources[0] == "notes"
    after = nbgrader_cells(restored)
    assert after["why"].attachments == picture
    assert sources[restored.cells.index(after["planner"]) + 1] == "helper = 1"
    assert not any("tags" in cell.metadata for cell in restored.cells)

    own.source = "def way(start, turns, goal):\n    return None"
    assert restore(submitted, released)[1] == ["look at it: it redefines what the tests use: way"]


def test_nothing_released_nothing_submitted(tmp_path):
    course = Course(tmp_path, PS1)
    course.submissions.mkdir()
    with pytest.raises(SystemExit, match="not released yet"):
        course.graded()
    course.release()
    with pytest.raises(SystemExit, match="has no notebooks"):
        course.graded()


def test_releases_are_the_same_twice_and_tell_nothing(tmp_path):
    here, there = Course(tmp_path / "a", *SETS), Course(tmp_path / "b", *SETS, course="robotics")
    folder = here.release()
    first = {file.name: file.read_bytes() for file in folder.rglob("*.*")}
    here.release()
    assert first == {file.name: file.read_bytes() for file in folder.rglob("*.*")}
    assert sorted(first) == [f"{name}.ipynb" for name in SETS]
    there.release()
    for name in SETS:
        released, source = read(name, folder), read(name)
        for cell in released.cells:
            assert not cell.get("outputs")
            assert "SOLUTION" not in cell.source
            assert "HIDDEN" not in cell.source
        hidden = [cell for cell in source.cells if "BEGIN HIDDEN TESTS" in cell.source]
        assert len(hidden) >= 3
        assert nbgrader_cells(released)["setup"].source.endswith('course = "freeseg"')
        other = read(name, there.folder / "build" / "release")
        assert nbgrader_cells(other)["setup"].source.endswith('course = "robotics"')
        assert read(name, folder).cells[2:] == other.cells[2:]


def test_a_set_says_what_it_is(name):
    source = read(name)
    assert len(source.cells) <= 35
    first = source.cells[0].source
    for part in ("*Paper: ", "**You will**", "**You need**", "**It takes** about"):
        assert part in first
    points = sum(
        cell.metadata.nbgrader.get("points", 0) for cell in nbgrader_cells(source).values()
    )
    assert f"gives {points} points" in first


def test_every_test_says_what_is_wrong(name):
    for cell in nbgrader_cells(read(name)).values():
        if cell.metadata.nbgrader.grade and cell.cell_type == "code":
            assert cell.metadata.nbgrader.locked
            assert cell.source.startswith("from freeseg.teaching import check\n")
            for node in ast.walk(ast.parse(cell.source)):
                if isinstance(node, ast.Assert):
                    assert node.msg is not None, ast.unparse(node)


def run_without_nbgrader(module, *arguments):
    """Run a module in a process of its own, in which nbgrader is not installed."""
    code = (
        f"import runpy, sys; sys.argv = {['', *arguments]}; sys.modules['nbgrader'] = None; "
        f"sys.path[0] = {str(FOLDER)!r}; runpy.run_module({module!r}, run_name='__main__')"
    )
    told = {"cwd": FOLDER.parent.parent, "capture_output": True, "text": True}
    return subprocess.run([sys.executable, "-c", code], check=False, **told)


def test_without_nbgrader_only_tests_that_grade_are_skipped():
    own = "releases_are_the_same or a_mistake_costs or lecturer_s_first or test_seeds"
    files = ("tests/test_assignments.py", "tests/test_first_week.py")
    done = run_without_nbgrader("pytest", "-n0", "-rs", "-k", own, *files)
    assert done.returncode == 0, done.stdout
    assert "grading needs it: pip install -r notebooks/assignments/requirements.txt" in done.stdout
    assert f" 1 passed, {len(MISTAKES) + 2} skipped, " in done.stdout


@pytest.mark.parametrize("command", ["release", "grade", "report", "forget"])
def test_without_nbgrader_a_lecturer_is_told_what_to_install(command):
    done = run_without_nbgrader("grade", command, "here")
    assert done.returncode == 1
    assert done.stderr.endswith("pip install -r notebooks/assignments/requirements.txt\n")


def test_every_mistake_belongs_to_a_set():
    assert {name for name, *_ in MISTAKES.values()} <= set(SETS)


def test_model_answers_say_what_is_measured():
    *_, answer, measuring, _ = read("ps3_sliding_mode").cells
    (output,) = measuring.outputs
    for seconds in re.findall(r"below 10 mm after (.*?) s", output.text):
        assert f"after {seconds} s" in answer.source
    *_, measuring, _ = read("ps4_beat_the_baseline").cells
    (output,) = measuring.outputs
    # Error and cost, disturbed and not, of the three baselines and of the reference solution.
    found = re.findall(r"(\d\.\d\d) and (\d\.\d\d)", output.data["text/markdown"])
    *others, mine = np.array(found[:8], float).reshape(4, 2, 2)
    assert all((mine[0] < other[0]).all() for other in others)  # error and cost
    assert all(np.diff(mine[0]) < np.diff(other[0]) for other in others)  # work of the wheels
    assert all((mine[1] > other[1]).all() for other in others[1:])  # undisturbed, not for PID


def test_prose_names_the_constants_it_means():
    task = read("ps4_beat_the_baseline").cells[3].source
    assert courses.OBSTACLES == 8
    assert "eight obstacles" in task
    assert f"margin of {1000 * courses.WIDE_MARGIN:.0f} mm" in task
    distance, angle = courses.OFFSET
    assert f"up to {1000 * distance:.0f} mm and {np.degrees(angle):.0f}° off" in task
    assert f"take {1000 * tracking.DISTURBANCE.delay:.0f} ms to arrive" in task
    answer, gains = read("ps3_sliding_mode").cells[25].source, fs.SlidingMode()
    assert "the defaults' 4 1/s for the way and for the angle" in answer
    assert gains.k1 / gains.phi1 == gains.k2 / gains.phi2 == 4
    assert f"from {1000 * gains.length_scale:.0f} to 60 mm" in answer


def test_without():
    class Own(fs.SlidingMode):
        """Law of the package with another name."""

    tracker = Own()
    reference = fs.make_reference(fs.Path([fs.path.Line((0, 0), (1, 0))]))
    kept = [fs.plan]
    with without(fs.SlidingMode, fs.plan):
        for call in (
            lambda: tracker.start(reference, None, 0.05),
            lambda: fs.plan(None, None, None),
            lambda: kept[0](None, None, None),
        ):
            with pytest.raises(AssertionError, match="do it yourself, without fs"):
                call()
        fs.Pid().start(reference, fs.KheperaIV(), 0.05)
    tracker.start(reference, None, 0.05)
    assert fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75)).turning_points


def test_seeds():
    assert variant_seed("robotics", "ada") == variant_seed(" Robotics", "ADA ")
    names = [("robotics", "ada"), ("robotics", "bob"), ("control", "ada"), ("roboticsa", "da")]
    assert len({variant_seed(*pair) for pair in names}) == len(names)
    for wrong in ("", "  ", 7, None):
        with pytest.raises(fs.InvalidParameter, match="give a name in quotes"):
            variant_seed("robotics", wrong)
        with pytest.raises(fs.InvalidParameter, match="course is"):
            variant_seed(wrong, "ada")


def test_check_says_what_is_wrong_and_goes_on(capsys):
    drawn = []

    def passes(rng):
        """The title.

        No more than this.
        """
        print("aside")
        np.log(np.zeros(1))  # warns
        drawn.append(rng.random())

    check(passes, 1, 2, 1)
    assert capsys.readouterr() == ("passed: The title.\n", "")
    assert drawn[0] == drawn[2] != drawn[1]

    def fails(rng):
        """what fails"""
        raise AssertionError("turn left")

    check(fails, 1, 2)
    assert capsys.readouterr() == ("", "not yet: what fails\nturn left\n")

    def raises(rng):
        """what raises"""
        return 1 / 0

    check(raises, 1)
    assert capsys.readouterr().err.endswith(
        "your code raised ZeroDivisionError: division by zero\n"
    )

    def broken():
        raise KeyError("none")

    def calls(rng):
        """what calls"""
        broken()

    check(calls, 1)

    def forgets(rng):
        """what forgets"""
        _, _ = print()

    line = broken.__code__.co_firstlineno + 1
    assert capsys.readouterr().err.endswith(
        f"your code raised KeyError: 'none' (in broken, line {line} of its cell)\n"
    )

    check(forgets, 1)
    assert "does a function of yours end without a return?" in capsys.readouterr().err

    def ends_never(rng):
        """what ends never"""
        while True:
            with suppress(Exception):
                sum(range(1000))

    check(ends_never, 1, limit=0.1)
    assert capsys.readouterr().err.startswith(
        "not yet: what ends never\nyour code takes over 0.1 s: is there a loop"
    )
    check(passes, 1)  # and nothing rings later
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)

    def says_nothing(rng):
        """what says nothing"""
        raise AssertionError

    check(says_nothing, 1)
    assert "has no message" in capsys.readouterr().err


def test_check_works_in_another_thread(capsys):
    def passes(rng):
        """The title."""

    thread = Thread(target=check, args=(passes, 1))
    thread.start()
    thread.join()
    assert capsys.readouterr() == ("passed: The title.\n", "")
