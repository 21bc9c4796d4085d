"""A lecturer's first week: what platforms give, what is graded of it, and what is given back."""

import csv
import functools
import importlib.util
import io
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
from pathlib import Path
from zipfile import ZipFile, ZipInfo

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
WHEEL = "freeseg-1.0.0-py3-none-any.whl"


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
            rows = list(csv.DictReader(stream))
        return {self.grade.handed_in.key_of(row): row for row in rows}


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


def test_a_lecturer_s_first_week(course, capsys):
    released, source = read_released(course), read("ps1")
    solved = solve(released, source)
    half = deepcopy(solved)
    nbgrader_cells(half)["answer-gap"].source = nbgrader_cells(released)["answer-gap"].source
    folder = course.submissions
    moodle = "{}_assignsubmission_file_"
    hand_in(folder / moodle.format("Ada Łovelace_71") / f"{PS1}.ipynb", solved)
    # An untouched one does not beat it, though it is newer.
    hand_in(folder / moodle.format("Ada Łovelace_71") / f"{PS1}-Copy1.ipynb", released, -1)
    hand_in(folder / moodle.format("Bo b_72") / f"{PS1} (1).ipynb", released, days_ago=3)
    hand_in(folder / moodle.format("Bo b_72") / f"{PS1} (2).ipynb", half)
    hand_in(folder / f"hoppergrace_LATE_73_9001_{PS1}-1.ipynb", tampered(solved))
    hand_in(folder / "a*b? [1]" / f"deep/{PS1.upper()}.IPYNB", tampered(released))
    hand_in(folder / moodle.format("Nobody Here_74") / f"{PS1}.ipynb", None, days_ago=3)
    hand_in(folder / "lost" / "essay.ipynb", solved)
    (folder / "empty").mkdir()
    roster = folder.parent / "roster.csv"
    roster.write_text(
        "First name,Last name,ID number,Email address\n"
        "Ada,Łovelace,71,ada@x.org\nBo,b,72,bo@x.org\nGrace,Hopper,73,grace@x.org\n"
        "Nobody,Here,74,n@x.org\nNever,Came,75,c@x.org\n",
        encoding="utf-8",
    )
    course.grade.main(["collect", str(folder), "--roster", str(roster)])
    told = re.sub(" +", " ", capsys.readouterr().out).splitlines()
    assert told[0] == "student name set date state file remarks"
    assert told[1].startswith(
        "71 Ada Łovelace ps1 2026-11-10 00:00 5 cells changed Ada Łovelace_71_"
    )
    assert "75 Never Came - - - - nothing handed in" in told
    rows = course.graded(roster=roster, due=datetime(2026, 11, 9))
    with course.grade.open_book(course.grade.open_course(course.folder)) as book:
        assert book.find_student("73").last_name == "Hopper"

    assert {who: row["ps1"] for who, row in rows.items()} == {
        "71": "20.0", "72": "16.0", "73": "20.0", "74": "", "75": "", "a*b? [1]": "0.0",
        "empty": "", "lost": "",
    }  # fmt: skip
    assert rows["71"]["Email address"] == "ada@x.org"
    assert [rows["72"][f"ps1.{test}"] for test in points_of("ps1")] == [
        "5.0",
        "5.0",
        "3.0",
        "0.0",
        "3.0",
    ]
    # No score is not zero; columns stand as the roster and the set have them.
    totals = {who: rows[who]["total"] for who in ("72", "74", "75", "a*b? [1]", "lost")}
    assert totals == {"72": "16.0", "74": "", "75": "", "a*b? [1]": "0.0", "lost": ""}
    assert list(rows["72"]) == [
        *("First name", "Last name", "ID number", "Email address", "total", "ps1", "ps1 of"),
        *(f"ps1.{test}" for test in points_of("ps1")),
        *("ps1 hours late", "ps1 to grade by hand", "ps1 remarks", "other remarks"),
    ]
    assert rows["72"]["ps1 hours late"] == "24.0"
    remarks = {who: row["ps1 remarks"] + row["other remarks"] for who, row in rows.items()}
    assert (
        f"{PS1}.ipynb of 2026-11-10 00:00 (5 cells changed) counts, the newest with answers; "
        f"not {PS1}-Copy1.ipynb of 2026-11-11 00:00 (as released)"
    ) in remarks["71"]
    assert f"{PS1} (2).ipynb of 2026-11-10" in remarks["72"].partition(" counts")[0]
    assert "late by the date of its file, 2026-11-10 00:00" in remarks["72"]
    assert "a hint: 100% as in the reference solution; a hint: 100% as in Ada Łove" in remarks["73"]
    assert "cell radii was missing" in remarks["73"]
    assert "not in the roster" in remarks["a*b? [1]"]
    assert "cannot be read (JSONDecodeError" in remarks["74"]
    assert "there is no notebook in this folder" in remarks["empty"]
    assert "lost/essay.ipynb is not <student>/" in remarks["lost"]
    feedback = course.folder / "build" / "feedback"
    for who, row in rows.items():
        assert (feedback / who / PS1 / f"{PS1}.html").exists() == (bool(row["ps1"]) or who == "74")
    with ZipFile(course.folder / "build" / f"feedback_{PS1}.zip") as archive:
        assert set(archive.namelist()) == {
            *(f"{moodle.format(one)}/{PS1}.html" for one in ("Bo b_72", "Nobody Here_74")),
            *(f"{moodle.format('Ada Łovelace_71')}/{PS1}.html", f"a*b? [1]/{PS1}.html"),
            f"hoppergrace_LATE_73_9001_{PS1}-1.html",
        }
        broken = archive.read(f"{moodle.format('Nobody Here_74')}/{PS1}.html").decode()
    assert "not graded: cannot be read" in broken
    page = unescape((feedback / "72" / PS1 / f"{PS1}.html").read_text(encoding="utf-8"))
    assert "not yet: The free segment between two rounded polygons" in page
    assert "data:image/png;base64" in page
    for told in ("Bo b: <b>16 of 20 points", "handed in 24 hours late", "handed in more than once"):
        assert told in page
    # No network, no link to what is not there, no formula to set, and nothing of anybody else.
    assert not re.search(r'<script|src="http|href="(?!#|https)|\$', page)
    assert page.count("<math") > 3
    for told in ("No response", " at 0x", "a hint", "Out[", "&lt;"):
        assert told not in page

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
        names = [f"{PS1}.ipynb", "lessons/01_model_the_robot.ipynb"]
        names += ["lessons/02_find_free_segments.ipynb", WHEEL]
        assert archive.namelist() == [f"problem_sets/{name}" for name in [*names, "README.md"]]
        text, lesson = (archive.read(f"problem_sets/{name}").decode() for name in names[:2])
        how_to = archive.read("problem_sets/README.md").decode()
        with ZipFile(io.BytesIO(archive.read(f"problem_sets/{WHEEL}"))) as wheel:
            packed = set(wheel.namelist())
    assert f'pip install "./{WHEEL}[notebooks]"' in how_to
    assert {"freeseg/teaching/ps1.py", "freeseg/_data/README.md"} <= packed
    assert not [name for name in packed if "assignments" in name or "tests" in name]
    assert "[01_model_the_robot](lessons/01_model_the_robot.ipynb)" in text
    cells = json.loads(lesson)["cells"]
    words = "".join("".join(one["source"]) for one in cells if one["cell_type"] == "markdown")
    assert set(re.findall(r"\]\((?!https?:|#)([^)]+)", words)) <= {Path(one).name for one in names}
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
    found = course.grade.handed_in.read_submission(file)
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


def test_feedback_runs_no_code_of_a_student(course, tmp_path, capsys):
    attack = "<img src='x' onerror='alert(1)'><script>alert(2)</script> $x^2$"
    notebook = read_released(course)
    shows = f'from IPython.display import HTML, display\ndisplay(HTML("{attack}"))'
    notebook.cells.append(nbformat.v4.new_code_cell(shows))
    notebook.cells.append(nbformat.v4.new_markdown_cell(attack))
    formula = r"$\text{<script>alert(3)</script>} \href{javascript:alert(4)}{x}$"
    notebook.cells.append(nbformat.v4.new_markdown_cell(formula))
    hand_in(tmp_path / "mallory" / f"{PS1}.ipynb", notebook)
    with course.grade.open_book(course.grade.open_course(course.folder)) as book:
        book.update_or_create_assignment(PS1, duedate=None)
    # Where no day is known, nobody is in time, nor late.
    assert course.graded(tmp_path)["mallory"]["ps1 hours late"] == ""
    assert f"no day is known for {PS1}" in capsys.readouterr().out
    file = course.folder / "build" / "feedback" / "mallory" / PS1 / f"{PS1}.html"
    page = file.read_text(encoding="utf-8")
    assert "<msup><mi>x</mi><mn>2</mn></msup>" in page
    assert not re.search(r"<[^<>]*onerror|<script>alert|<[^<>]*javascript:", page)


def test_a_container_runs_the_answers_alone(course, tmp_path, monkeypatch):
    """A program that stands for docker: it is told what to build, and runs what it should."""
    engine = tmp_path / "podman"
    engine.write_text(
        f"#!/bin/sh\nif [ $1 = build ]; then cat > {tmp_path}/Dockerfile; exit; fi\n"
        "if [ $1 = info ]; then exit; fi\n"
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
    collect, released = course.grade.handed_in.collect, {PS1: read_released(course)}
    with ZipFile(tmp_path / "all.zip", "w") as archive:
        for name in (f"lovelaceada_1_11_{PS1}.ipynb", f"lovelaceada_1_12_{PS1}-1.ipynb"):
            archive.writestr(name, "{}")
        archive.writestr(f"Bob B_2_assignsubmission_file_/{PS1}.ipynb", "{}")
        archive.writestr(f"../outside_3_13_{PS1}.ipynb", "{}")
    found, remarks = collect(tmp_path / "all.zip", released, [], tmp_path / "unpacked")
    assert {student for _, student in found} == {"lovelaceada", "Bob B", "outside"}
    assert not list(tmp_path.glob("outside*"))
    canvas = [{"Student": "Lovelace, Ada", "ID": "1", "SIS Login ID": "al1"}]
    found, remarks = collect(tmp_path / "unpacked", released, canvas, tmp_path)
    assert (PS1, "al1") in found
    assert remarks[PS1, "outside"] == ["not in the roster"]


def test_the_newest_file_with_answers_counts(course, tmp_path):
    """Names and days of a student's two files, and the words for the first, which counts."""
    empty = read_released(course)
    full = solve(empty, read("ps1"))
    with_id = deepcopy(empty)
    nbgrader_cells(with_id)["student"].source = "student = 'ada'"
    with_id.cells[0].source += " As it was before somebody corrected it."
    own, copy = f"{PS1}.ipynb", f"{PS1}-Copy1.ipynb"
    cases = {
        "answers in the newer copy": (
            (copy, full, 14),
            (own, empty, 13),
            "the newest with answers",
        ),
        "answers in the older copy": (
            (copy, full, 13),
            (own, with_id, 14),
            "the newest with answers",
        ),
        "answers in both": ((copy, full, 14), (own, full, 13), "the newest with answers"),
        "answers nowhere": ((copy, empty, 14), (own, with_id, 13), "the newest, none has answers"),
        "one broken": ((copy, None, 13), (own, empty, 14), "for it may have answers"),
        "as chosen": ((own, empty, 13), (copy, full, 14), "as you chose"),
    }
    archive = tmp_path / "all.zip"
    with ZipFile(archive, "w") as opened:
        for who, (*files, _) in cases.items():
            for name, notebook, day in files:
                info = ZipInfo(f"{who}/{name}", (2026, 11, day, 20, 11, 0))
                opened.writestr(info, json.dumps(notebook) if notebook else "{")
    found, remarks = course.grade.handed_in.collect(
        archive, {PS1: empty}, [], tmp_path / "unpacked", [f"as chosen/{own}"]
    )
    for who, ((first, _, day), (other, _, another), why) in cases.items():
        assert found[PS1, who].shown == f"{who}/{first}"
        (remark,) = remarks[PS1, who]
        assert re.fullmatch(
            rf"handed in more than once: {first} of 2026-11-{day} 20:11 \(.+\) counts, {why}; "
            rf"not {other} of 2026-11-{another} 20:11 \(.+\)",
            remark,
        )
    with pytest.raises(SystemExit, match=r"there is no 'ada/none\.ipynb'; collect"):
        course.graded(archive, use=["ada/none.ipynb"])


def test_a_slip_is_answered_by_what_to_give(course, tmp_path, monkeypatch, capsys):
    main, broken, latin = course.grade.main, tmp_path / "half.zip", tmp_path / "latin.csv"
    broken.write_text("PK")
    latin.write_text("student;name\nada;Łovelace\n", encoding="iso-8859-2")
    for line, told in {
        "collect nothere.zip": "nothere.zip is not there; give the zip",
        f"grade {broken}": "half.zip is no zip, or not all of it; download",
        f"collect {tmp_path} --roster nothere.csv": "nothere.csv is not there; give the list",
        f"grade {tmp_path} --roster {latin}": "latin.csv is no text in UTF-8; save",
    }.items():
        with pytest.raises(SystemExit, match=told):
            main(line.split())
    with pytest.raises(SystemExit):
        main(["grade", "x", "--due", "15.11.2026"])
    assert "'15.11.2026' is no day and time; give year, month" in capsys.readouterr().err
    assert course.grade.day("2026-11-15") == datetime(2026, 11, 15, 23, 59)
    table = tmp_path / "roster.csv"
    table.write_text("student;name\nada;Łovelace, A.\n", encoding="utf-8-sig")
    assert course.grade.read_table(table) == [{"student": "ada", "name": "Łovelace, A."}]
    # Docker is there, and its service does not run.
    engine = tmp_path / "docker"
    engine.write_text("#!/bin/sh\necho Cannot connect to the Docker daemon >&2\nexit 1\n")
    engine.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SystemExit, match=r"docker is there but does not run \(Cannot connect"):
        main(["grade", str(tmp_path), "--container"])


def test_the_formgrader_lists_the_sets_alone(course):
    from nbgrader.apps.api import NbGraderAPI

    assert NbGraderAPI(course.grade.open_course(course.folder)).get_source_assignments() == {PS1}


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
