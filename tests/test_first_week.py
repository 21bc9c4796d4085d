"""A lecturer's first week: submissions as they come, in folders and files of any name."""

import json
import re
import shutil
from collections import Counter
from copy import deepcopy
from html import unescape

import nbformat
import pytest
from test_assignments import MISTAKES, PS1, Course, read, replace_once, solve


def as_bytes(notebook, ending="\n", mark=b"", minor=5):
    """A notebook's file with line ends in its cells, a byte order mark, and a minor version."""
    content = deepcopy(notebook)
    for cell in content.cells:
        cell.source = cell.source.replace("\n", ending)
    content["nbformat_minor"] = minor
    return mark + json.dumps(content, ensure_ascii=False).encode()


#: Kinds of submissions that are read in full: the file's name, and how it was written.
WRITTEN = {
    "plain": (f"{PS1}.ipynb", {}),
    "capitals": (f"{PS1}.IPYNB", {}),
    "deep": (f"deep/er/{PS1} (1).ipynb", {}),
    "a mark": (f"{PS1}.ipynb", {"mark": b"\xef\xbb\xbf"}),
    "old and new": (f"{PS1}.ipynb", {"minor": 4}),
    "windows": (f"{PS1}.ipynb", {"ending": "\r\n"}),
    "all at once": (f"deep/{PS1}.Ipynb", {"mark": b"\xef\xbb\xbf", "minor": 4, "ending": "\r\n"}),
}
#: Score and remark of the other kinds: of the late ones when they have folders of their own.
OTHERWISE = {
    "a mistake": ("18.0", ""),
    "untouched": ("0.0", "no id is written in it: "),
    "twice": ("20.0", "it is there twice: "),
    "broken": ("", "not graded: cannot be read (JSONDecodeError: "),
    "empty": ("", "not graded: there is no notebook in this folder"),
    "late": ("20.0", ""),
}
#: Which kind is whose: names that mean something to a pattern, URL, shell or spreadsheet, beside
#: names that they could be taken for.
HANDED_IN = {
    "team[12]": "all at once",
    "Ada": "late",
    "team1": "a mistake",
    "team2": "plain",
    "a*b?": "plain",
    "a?b*": "a mistake",
    "100% #1": "plain",
    "50%20#2": "old and new",
    "=5b=": "old and new",
    "=5b=12=5d=": "windows",
    "C:\\windows": "windows",
    "=SUM(1;2)": "all at once",
    "Zoë Müller": "capitals",
    "Jürgen Groß": "capitals",
    "Łukasz": "a mark",
    "O'Neil, Ann": "a mark",
    ".hidden.": "deep",
    " blank ": "deep",
    "Grace": "late",
    "twice": "twice",
    "tw  ice": "twice",
    "{broken}": "broken",
    "$broken": "broken",
    "empty": "empty",
    "~empty": "empty",
    "untouched": "untouched",
    "un&touched": "untouched",
}


def released_in(root):
    """A course, released, in a folder whose name would mean something to nbgrader."""
    course = Course(root / "odd [x]? 50% #1", PS1)
    course.release()
    return course


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    return released_in(tmp_path_factory.mktemp("week"))


def in_quotes(student):
    return json.dumps(student, ensure_ascii=False)


def work_of(course, student, kind):
    """What a student wrote, with the student's name in it."""
    released = read(PS1, course.folder / "build" / "release")
    if kind == "untouched":
        return released
    solved = replace_once(solve(released, read(PS1)), '"reference"', in_quotes(student))
    if kind == "a mistake":
        _, old, new, _ = MISTAKES["degrees for radians"]
        solved = replace_once(solved, old, new)
    return solved


def hand_in(course, student, kind, folder="."):
    """Write what a student hands in below a folder of the submissions."""
    target = course.submissions / folder / student
    target.mkdir(parents=True, exist_ok=True)
    file, how = WRITTEN.get(kind, WRITTEN["plain"])
    files = {"empty": [], "twice": [file, f"{PS1}-Copy1.ipynb"]}.get(kind, [file])
    content = as_bytes(work_of(course, student, kind), **how)
    for file in files:
        (target / file).parent.mkdir(parents=True, exist_ok=True)
        (target / file).write_bytes(content[: 1000 if kind == "broken" else None])


def assert_graded(course, row, student, kind):
    """A row has the score and remark of its kind, and the feedback is the student's own."""
    score, remark = OTHERWISE.get(kind, ("20.0", ""))
    assert row["score"] == score, student
    assert row["remarks"].startswith(remark), student
    assert bool(row["remarks"]) == bool(remark), student
    feedback = course.folder / "build" / "feedback" / student / PS1 / f"{PS1}.html"
    assert feedback.exists() == bool(score), student
    if score and kind != "untouched":
        shown = unescape(re.sub(r"<[^>]+>", "", feedback.read_text(encoding="utf-8")))
        assert f"student = {in_quotes(student)}" in shown, student


def test_every_kind_of_submission_is_handed_in_twice():
    kinds = Counter(HANDED_IN.values())
    assert kinds.keys() == WRITTEN.keys() | OTHERWISE.keys()
    assert min(kinds.values()) >= 2


@pytest.mark.parametrize(
    "students",
    [list(HANDED_IN)[:2], pytest.param(list(HANDED_IN), marks=pytest.mark.exhaustive)],
    ids=["two", "all"],
)
def test_a_lecturer_s_first_week(students, tmp_path):
    course = released_in(tmp_path)
    kinds = {student: HANDED_IN[student] for student in students}
    # Who is late is collected into a folder of its own, which is then taken for one student.
    for student, kind in kinds.items():
        hand_in(course, student, kind, "late ones" if kind == "late" else ".")
    rows = course.graded()
    late = {student for student, kind in kinds.items() if kind == "late"}
    assert set(rows) == set(students) - late | {"late ones"}
    for student in set(students) - late:
        assert_graded(course, rows[student], student, kinds[student])
    assert rows["late ones"]["score"] == "20.0"
    assert rows["late ones"]["remarks"].count("it is there twice") == len(late) - 1
    table = (course.folder / "build" / "grades.csv").read_bytes()
    # By this mark Excel knows the encoding.
    assert table.startswith(b"\xef\xbb\xbf")

    # Corrected: the folder, and what did not open.
    course.grade.forget(["late ones"], course.folder)
    for file in (course.submissions / "late ones").iterdir():
        file.rename(course.submissions / file.name)
    (course.submissions / "late ones").rmdir()
    again = {student for student, kind in kinds.items() if kind == "broken"}
    for student in again:
        kinds[student] = "plain"
        hand_in(course, student, "plain")
    first, rows = rows, course.graded()
    assert set(rows) == set(students)
    for student in students:
        assert_graded(course, rows[student], student, kinds[student])
        if student not in late | again:
            assert rows[student] == first[student]

    # Graded again, exported again, and somebody forgotten.
    for student in students[1:]:
        shutil.rmtree(course.submissions / student)
    assert course.graded() == rows
    course.grade.report(course.folder)
    assert course.rows() == rows
    course.grade.forget(students[:1], course.folder)
    assert set(course.rows()) == set(rows) - set(students[:1])
    course.grade.report(course.folder)
    assert set(course.rows()) == set(rows) - set(students[:1])
    assert not (course.folder / "build" / "feedback" / students[0]).exists()
    with pytest.raises(SystemExit, match="has no student"):
        course.grade.forget(students[:1], course.folder)


def test_a_folder_graded_by_mistake_leaves_nothing_behind(course, tmp_path):
    (tmp_path / "holidays").mkdir()
    nbformat.write(nbformat.v4.new_notebook(), tmp_path / "holidays" / "beach.ipynb")
    course.grade.grade(tmp_path, course.folder)
    assert "holidays" in course.rows()
    course.grade.forget(["holidays"], course.folder)
    assert "holidays" not in course.rows()


@pytest.mark.parametrize("how", [how for _, how in WRITTEN.values() if how])
def test_a_notebook_is_read_however_it_was_written(course, tmp_path, how):
    original = read(PS1)
    file = tmp_path / "notebook.ipynb"
    file.write_bytes(as_bytes(original, **how))
    found = course.grade.read_submission(file)
    assert [cell.source for cell in found.cells] == [cell.source for cell in original.cells]
    assert course.grade.restore(found, original)[1] == []
