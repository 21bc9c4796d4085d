"""A lecturer's first week: submissions as they come, in folders and files of any name."""

import json
import shutil
from copy import deepcopy

import nbformat
import pytest
from test_assignments import PS1, Course, read, solve


def as_bytes(notebook, ending="\n", mark=b"", minor=5):
    """A notebook's file with line ends in its cells, a byte order mark, and a minor version."""
    content = deepcopy(notebook)
    for cell in content.cells:
        cell.source = cell.source.replace("\n", ending)
    content["nbformat_minor"] = minor
    return mark + json.dumps(content, ensure_ascii=False).encode()


#: What is handed in by whom: folder, file, and how it was written.
HANDED_IN = {
    "team[12]": (f"{PS1}.ipynb", {}),
    "team1": (f"{PS1}.ipynb", {}),
    "a*b?": (f"{PS1}.ipynb", {}),
    "100% #1": (f"{PS1}.ipynb", {}),
    "Zoë Müller": (f"{PS1}.IPYNB", {}),
    "=5b=": (f"{PS1}.Ipynb", {}),
    "mark": (f"{PS1}.ipynb", {"mark": b"\xef\xbb\xbf"}),
    "old and new": (f"{PS1}.ipynb", {"minor": 4}),
    "windows": (f"{PS1}.ipynb", {"ending": "\r\n"}),
    ".hidden.": (f"deep/er/{PS1}.ipynb", {}),
    "all at once": (f"{PS1}.IPYNB", {"mark": b"\xef\xbb\xbf", "minor": 4, "ending": "\r\n"}),
}


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A course, released, in a folder whose name would mean something to nbgrader."""
    course = Course(tmp_path_factory.mktemp("week") / "odd [x]? 50% #1", PS1)
    course.release()
    return course


def hand_in(course, student):
    source = read(PS1)
    solved = solve(read(PS1, course.folder / "build" / "release"), source)
    file, how = HANDED_IN[student]
    target = course.submissions / student / file
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(as_bytes(solved, **how))


@pytest.mark.parametrize(
    "students",
    [["team[12]", "all at once"], pytest.param(list(HANDED_IN), marks=pytest.mark.exhaustive)],
    ids=["two", "all"],
)
def test_submissions_of_any_name_and_form_are_graded(course, students):
    for student in students:
        hand_in(course, student)
    rows = course.graded()
    assert set(rows) >= set(students)
    for student in students:
        row = rows[student]
        assert (float(row["score"]), row["remarks"]) == (20, ""), student
        feedback = course.folder / "build" / "feedback" / student / PS1 / f"{PS1}.html"
        assert feedback.exists(), student
    table = (course.folder / "build" / "grades.csv").read_bytes()
    # By this mark Excel knows the encoding.
    assert table.startswith(b"\xef\xbb\xbf")

    # Graded again, exported again, and somebody forgotten.
    shutil.rmtree(course.submissions / students[-1])
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


@pytest.mark.parametrize("how", [how for _, how in HANDED_IN.values() if how])
def test_a_notebook_is_read_however_it_was_written(course, tmp_path, how):
    original = read(PS1)
    file = tmp_path / "notebook.ipynb"
    file.write_bytes(as_bytes(original, **how))
    found = course.grade.read_submission(file)
    assert [cell.source for cell in found.cells] == [cell.source for cell in original.cells]
    assert course.grade.restore(found, original)[1] == []
