"""A lecturer's first week: what platforms give, what is graded of it, and what is given back."""

import csv
import functools
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from copy import deepcopy
from datetime import datetime
from html import unescape
from importlib.util import find_spec
from zipfile import ZipFile

import nbformat
import pytest
from refresh_notebooks import NOTEBOOKS

if not find_spec("nbgrader"):
    pytest.skip(
        "grading needs it: pip install -r notebooks/assignments/requirements.txt",
        allow_module_level=True,
    )
import nbgrader.api
from test_assignments import FOLDER, NAMES, nbgrader_cells, points_of, read

#: What nbgrader asks another program at every new grade book is always the same.
nbgrader.api.get_alembic_version = functools.cache(nbgrader.api.get_alembic_version)
PS1 = NAMES["ps1"]


class Course:
    """A copy of the assignments, with some of the sets, to release and grade in."""

    def __init__(self, root, *names):
        self.folder = root / "assignments"
        self.submissions = root / "submissions"
        self.folder.mkdir(parents=True)
        for name in names:
            shutil.copytree(FOLDER / name, self.folder / name)
        for file in FOLDER.glob("*.py"):
            shutil.copy(file, self.folder)
        spec = importlib.util.spec_from_file_location("grade", self.folder / "grade.py")
        self.grade = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(self.grade)

    def release(self):
        self.grade.release(self.folder)
        return self.folder / "build" / "release"

    def graded(self, source=None, **how):
        """Grade all submissions; rows of grades.csv by student."""
        self.grade.grade(source or self.submissions, self.folder, **how)
        return self.rows()

    def rows(self, table="grades"):
        file = self.folder / "build" / f"{table}.csv"
        with file.open(newline="", encoding="utf-8-sig") as stream:
            return {row["student"]: row for row in csv.DictReader(stream)}


def solve(released, source):
    """The released notebook with the reference solution."""
    solved, reference = deepcopy(released), nbgrader_cells(source)
    for name, cell in nbgrader_cells(solved).items():
        if cell.metadata.nbgrader.solution:
            cell.source = reference[name].source
    return solved


def hand_in(file, notebook, days_ago=0):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(notebook) if notebook else '{"cells": [', encoding="utf-8")
    when = datetime(2026, 11, 10).timestamp() - 86400 * days_ago
    os.utime(file, (when, when))


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A course, released, in a folder whose name would mean something to nbgrader."""
    course = Course(tmp_path_factory.mktemp("week") / "odd [x]? 50% #1", PS1)
    course.release()
    return course


def tampered(solved):
    """Do to the tests what would give points for nothing if notebooks were trusted."""
    notebook = deepcopy(solved)
    cells = nbgrader_cells(notebook)
    cells["pen"].source = "print('passed')"
    notebook.cells.remove(cells["radii"])
    cells["turn"].metadata.tags = ["skip-execution"]
    cells["gap"].metadata.nbgrader.points = 99
    cells["largest"].metadata.nbgrader.update(locked=False, solution=True, grade=False)
    notebook.cells.append(nbformat.v4.new_code_cell("", metadata=cells["gap"].metadata))
    return notebook


def test_a_lecturer_s_first_week(course):
    released, source = read_released(course), read("ps1")
    solved = solve(released, source)
    half = deepcopy(solved)
    nbgrader_cells(half)["answer-gap"].source = nbgrader_cells(released)["answer-gap"].source
    folder = course.submissions
    moodle = "{}_assignsubmission_file_"
    hand_in(folder / moodle.format("Ada Łovelace_71") / f"{PS1}.ipynb", solved)
    hand_in(folder / moodle.format("Ada Łovelace_71") / f"{PS1}-Copy1.ipynb", released)
    hand_in(folder / moodle.format("Bo b_72") / f"{PS1} (1).ipynb", released, days_ago=3)
    hand_in(folder / moodle.format("Bo b_72") / f"{PS1} (2).ipynb", half)
    hand_in(folder / f"hoppergrace_LATE_73_9001_{PS1}-1.ipynb", tampered(solved))
    hand_in(folder / "a*b? [1]" / f"deep/{PS1.upper()}.IPYNB", tampered(released))
    hand_in(folder / "broken" / f"{PS1}.ipynb", None)
    hand_in(folder / "lost" / "essay.ipynb", solved)
    (folder / "empty").mkdir()
    roster = folder.parent / "roster.csv"
    roster.write_text(
        "First name,Last name,ID number,Email address\n"
        "Ada,Łovelace,71,ada@x.org\nBo,b,72,bo@x.org\nGrace,Hopper,73,grace@x.org\n"
        "Nobody,Here,74,n@x.org\n",
        encoding="utf-8",
    )
    rows = course.graded(roster=roster, due=datetime(2026, 11, 9))

    assert {who: row["ps1"] for who, row in rows.items()} == {
        "71": "20.0", "72": "16.0", "73": "20.0", "74": "", "a*b? [1]": "0.0",
        "broken": "", "empty": "", "lost": "",
    }  # fmt: skip
    assert rows["71"]["Email address"] == "ada@x.org"
    assert [rows["72"][f"ps1.{test}"] for test in points_of("ps1")] == [
        "5.0",
        "5.0",
        "3.0",
        "0.0",
        "3.0",
    ]
    assert rows["72"]["total"] == "16.0"
    assert rows["72"]["ps1 hours late"] == "24.0"
    remarks = {who: row["ps1 remarks"] + row["other remarks"] for who, row in rows.items()}
    assert f"{PS1}.ipynb counts, not {PS1}-Copy1.ipynb" in remarks["71"]
    assert f"{PS1} (2).ipynb counts, not {PS1} (1).ipynb" in remarks["72"]
    assert "a hint: 100% as in the reference solution" in remarks["73"]
    assert "cell radii was missing" in remarks["73"]
    assert "not in the roster" in remarks["a*b? [1]"]
    assert "cannot be read (JSONDecodeError" in remarks["broken"]
    assert "there is no notebook in this folder" in remarks["empty"]
    assert "lost/essay.ipynb is not <student>/" in remarks["lost"]
    feedback = course.folder / "build" / "feedback"
    for who, row in rows.items():
        assert (feedback / who / PS1 / f"{PS1}.html").exists() == bool(row["ps1"])
    page = unescape((feedback / "72" / PS1 / f"{PS1}.html").read_text(encoding="utf-8"))
    assert "not yet: The free segment between two rounded polygons" in page
    assert "data:image/png;base64" in page

    # Graded again, reported again, and somebody forgotten.
    course.grade.report(course.folder)
    assert course.rows() == rows
    course.grade.forget(["a*b? [1]"], course.folder)
    assert set(course.rows()) == set(rows) - {"a*b? [1]"}
    assert not (feedback / "a*b? [1]").exists()
    with pytest.raises(SystemExit, match="there is no student"):
        course.grade.forget(["a*b? [1]"], course.folder)


def read_released(course, name=PS1):
    return nbformat.read(course.folder / "build" / "release" / name / f"{name}.ipynb", as_version=4)


def test_the_zip_needs_nothing_of_the_repository(course):
    with ZipFile(course.folder / "build" / "release" / "problem_sets.zip") as archive:
        assert archive.namelist() == [f"problem_sets/{PS1}.ipynb", "problem_sets/README.md"]
        text = archive.read(f"problem_sets/{PS1}.ipynb").decode()
        assert "pip install" in archive.read("problem_sets/README.md").decode()
    assert "lesson 01_model_the_robot" in text
    for told in ("../..", "SOLUTION", "HIDDEN", "reference"):
        assert told not in text
    assert all(not cell.get("outputs") for cell in json.loads(text)["cells"])
    first = (course.folder / "build" / "release" / "problem_sets.zip").read_bytes()
    course.release()
    assert (course.folder / "build" / "release" / "problem_sets.zip").read_bytes() == first


@pytest.mark.parametrize("name", NAMES.values())
@pytest.mark.exhaustive
def test_grading_by_nbgrader(name, tmp_path):
    course = Course(tmp_path, name)
    course.release()
    released, part = read_released(course, name), name[:3]
    hand_in(course.submissions / "untouched" / f"{name}.ipynb", released)
    hand_in(course.submissions / "reference" / f"{name}.ipynb", solve(released, read(part)))
    rows = course.graded(jobs=2)
    assert float(rows["untouched"][part]) == 0
    got, full = float(rows["reference"][part]), sum(points_of(part).values())
    # The contest is open: on some draws its reference finds a path that is longer than need be.
    assert 0.75 * full <= got <= full if part == "ps4" else got == full
    if part == "ps4":
        assert course.rows("leaderboard")["reference"]["place"] == "1"


def as_bytes(notebook, ending="\n", mark=b"", minor=5):
    """A notebook's file with line ends in its cells, a byte order mark, and a minor version."""
    content = deepcopy(notebook)
    for cell in content.cells:
        cell.source = cell.source.replace("\n", ending)
    content["nbformat_minor"] = minor
    return mark + json.dumps(content, ensure_ascii=False).encode()


@pytest.mark.parametrize(
    "how",
    [
        {"mark": b"\xef\xbb\xbf"},
        {"minor": 4},
        {"ending": "\r\n"},
        {"mark": b"\xef\xbb\xbf", "minor": 4, "ending": "\r\n"},
    ],
)
def test_a_notebook_is_read_however_it_was_written(course, tmp_path, how):
    original, file = read("ps1"), tmp_path / "notebook.ipynb"
    file.write_bytes(as_bytes(original, **how))
    found = course.grade.read_submission(file)
    assert [cell.source for cell in found.cells] == [cell.source for cell in original.cells]
    assert course.grade.restore(found, original)[1] == []


def test_restoring_keeps_what_is_the_student_s(course):
    restore, released = course.grade.restore, read("ps2")
    submitted = deepcopy(released)
    cells = nbgrader_cells(submitted)
    picture = {"figure.png": {"image/png": "AAAA"}}
    cells["why"].update(source="![](attachment:figure.png)", attachments=picture)
    below = submitted.cells.index(cells["why"]) + 1
    submitted.cells.insert(below, nbformat.v4.new_markdown_cell("Below the answer."))
    own = nbformat.v4.new_code_cell("helper = 1", metadata={"tags": ["skip-execution"]})
    submitted.cells.insert(submitted.cells.index(cells["answer-planner"]) + 1, own)
    # What JupyterLab adds when it saves.
    cells["turning"].metadata.update(trusted=True, execution={"iopub.status.busy": "2030"})
    restored, changes = restore(submitted, released)
    nbformat.validate(restored)
    assert changes == []
    after = nbgrader_cells(restored)
    assert after["why"].attachments == picture
    assert after["why"].source == "![](attachment:figure.png)\n\nBelow the answer."
    sources = [cell.source for cell in restored.cells]
    assert sources[restored.cells.index(after["answer-planner"]) + 1] == "helper = 1"
    assert not any("tags" in cell.metadata for cell in restored.cells)
    # An answer cell that was left as it was, with the answer in a cell below it.
    cells["why"].source = nbgrader_cells(released)["why"].source
    assert nbgrader_cells(restore(submitted, released)[0])["why"].source == "Below the answer."


def test_feedback_runs_no_code_of_a_student(course, tmp_path):
    attack = "<img src='x' onerror='alert(1)'><script>alert(2)</script> $x^2$"
    notebook = read_released(course)
    shows = f'from IPython.display import HTML, display\ndisplay(HTML("{attack}"))'
    notebook.cells.append(nbformat.v4.new_code_cell(shows))
    notebook.cells.append(nbformat.v4.new_markdown_cell(attack))
    hand_in(tmp_path / "mallory" / f"{PS1}.ipynb", notebook)
    course.graded(tmp_path)
    file = course.folder / "build" / "feedback" / "mallory" / PS1 / f"{PS1}.html"
    page = file.read_text(encoding="utf-8")
    assert "$x^2$" in page
    assert not re.search(r"<[^<>]*onerror|<script>alert", page)


def test_a_container_runs_the_answers_alone(course, tmp_path, monkeypatch):
    """A program that stands for docker: it is told what to build, and runs what it should."""
    engine = tmp_path / "podman"
    engine.write_text(
        f"#!/bin/sh\nif [ $1 = build ]; then cat > {tmp_path}/Dockerfile; exit; fi\n"
        f"echo $* > {tmp_path}/told\nexec {sys.executable} {FOLDER}/answers.py\n"
    )
    engine.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    command = course.grade.build_container(NOTEBOOKS.parent)
    assert "COPY notebooks/assignments/answers.py" in (tmp_path / "Dockerfile").read_text()
    assert "COPY notebooks notebooks" not in (tmp_path / "Dockerfile").read_text()
    hand_in(tmp_path / "in" / "ada" / f"{PS1}.ipynb", solve(read_released(course), read("ps1")))
    assert course.graded(tmp_path / "in", command=command)["ada"]["ps1"] == "20.0"
    assert "--network none" in (tmp_path / "told").read_text()


def test_what_platforms_give_as_zip(course, tmp_path):
    collect = course.grade.handed_in.collect
    with ZipFile(tmp_path / "all.zip", "w") as archive:
        for name in (f"lovelaceada_1_11_{PS1}.ipynb", f"lovelaceada_1_12_{PS1}-1.ipynb"):
            archive.writestr(name, "{}")
        archive.writestr(f"Bob B_2_assignsubmission_file_/{PS1}.ipynb", "{}")
        archive.writestr(f"../outside_3_13_{PS1}.ipynb", "{}")
    found, remarks = collect(tmp_path / "all.zip", [PS1], [], tmp_path / "unpacked")
    assert {student for _, student in found} == {"lovelaceada", "Bob B", "outside"}
    assert not list(tmp_path.glob("outside*"))
    canvas = [{"Student": "Lovelace, Ada", "ID": "1", "SIS Login ID": "al1"}]
    found, remarks = collect(tmp_path / "unpacked", [PS1], canvas, tmp_path)
    assert (PS1, "al1") in found
    assert remarks[PS1, "outside"] == ["not in the roster"]


def test_nothing_released_nothing_submitted(tmp_path):
    course = Course(tmp_path, PS1)
    course.submissions.mkdir()
    with pytest.raises(SystemExit, match="not released yet"):
        course.graded()


def test_without_nbgrader_a_lecturer_is_told_what_to_install():
    code = (
        f"import runpy, sys; sys.argv = ['', 'report']; sys.modules['nbgrader'] = None; "
        f"sys.path[0] = {str(FOLDER)!r}; runpy.run_module('grade', run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.endswith("pip install -r notebooks/assignments/requirements.txt\n")
