"""Release the problem sets and grade what comes back; README.md beside this file says when.

python notebooks/assignments/grade.py release         makes build/release/
python notebooks/assignments/grade.py grade FOLDER    grades, then reports
python notebooks/assignments/grade.py report          writes build/grades.csv and build/feedback/
python notebooks/assignments/grade.py forget NAME     removes a student, as after a wrong folder

nbgrader does the work; its exit codes do not tell what happened to whom, so what is reported is
read from its grade book, and what it would trust in a submission is put right before.
"""

import argparse
import ast
import atexit
import csv
import dis
import json
import logging
import os
import re
import shutil
import sys
import warnings
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import uuid4

import nbformat
from IPython.core.inputtransformer2 import TransformerManager
from tqdm import tqdm
from traitlets.config import PyFileConfigLoader

if find_spec("nbgrader") is None:
    raise SystemExit(
        "nbgrader, which grades, is not installed; in the folder of the collection's README, run: "
        "pip install -r notebooks/assignments/requirements.txt"
    )

from nbgrader.api import Gradebook, MissingEntry
from nbgrader.converters import Autograde, GenerateAssignment, GenerateFeedback
from nbgrader.coursedir import CourseDirectory
from nbgrader.utils import capture_log

HERE = Path(__file__).resolve().parent
COLUMNS = ["set", "student", "score", "max_score", "to_grade_by_hand", "remarks"]

# nbgrader runs alembic by its name: it is beside this Python, active environment or not.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
# Kernels that inherit this, which many CI systems set, draw no picture into the notebook.
os.environ.pop("MPLBACKEND", None)
# Of SQLAlchemy, at every submission; nbgrader works with it all the same.
warnings.filterwarnings("ignore", module="nbgrader")
# What nbgrader logs is captured, not shown between the progress.
LOG = logging.getLogger("freeseg.assignments")
LOG.propagate = False


def open_course(folder):
    """The course in a folder, as its nbgrader_config.py sets it up."""
    (folder / "build").mkdir(exist_ok=True)
    config = PyFileConfigLoader("nbgrader_config.py", str(folder)).load_config()
    root = _plain(folder)
    config.CourseDirectory.root = str(root)
    config.CourseDirectory.db_url = f"sqlite:///{root.as_posix()}/build/gradebook.db"
    return CourseDirectory(config=config)


@cache
def _plain(folder):
    """A folder, by a link to it where its own path would mean something else to nbgrader.

    nbgrader makes glob patterns and URLs of paths.
    """
    if not re.search(r"[][*?#%]", str(folder)):
        return folder
    links = TemporaryDirectory(prefix="freeseg-")
    atexit.register(links.cleanup)
    link = Path(links.name, "course")
    link.symlink_to(folder, target_is_directory=True)
    return link


def _alias(student):
    """A student's name as nbgrader can have it: what is special in a pattern or URL as =hex."""
    return re.sub(r"[^\w ',.-]|^[ .]|[ .]$", lambda found: f"={ord(found[0]):x}=", student)


def open_book(course):
    """nbgrader's grade book of a course; close it with `with`."""
    return Gradebook(course.db_url, course.course_id)


def convert(converter, course, name, student="."):
    """Run one of nbgrader's steps for one set and student; None, or its log if it failed."""
    course.assignment_id, course.student_id = name, _alias(student)
    step = converter(coursedir=course, config=course.config, log=LOG, force=True)
    result = capture_log(step)
    return None if result["success"] else result.get("log", "") + result["error"]


def names_of_sets(folder):
    """Names of the problem sets: a folder each, with a notebook of the same name."""
    return sorted(file.stem for file in folder.glob("*/*.ipynb") if file.stem == file.parent.name)


def release(folder=HERE):
    """Write what students get to build/release/, and the tests into the grade book."""
    course = open_course(folder)
    for name in tqdm(names_of_sets(folder), desc="release", unit="set"):
        if log := convert(GenerateAssignment, course, name):
            raise SystemExit(f"{name} cannot be released:\n{log}")


def grade(submissions, folder=HERE):
    """Grade every notebook below a folder of folders, one of each student; then report.

    Parameters
    ----------
    submissions : Path
        The first folder below it names the student, the notebook's own name the set.
    folder : Path, optional
        Where the course is.
    """
    course = open_course(folder)
    released = {}
    for name in names_of_sets(folder):
        file = folder / "build" / "release" / name / f"{name}.ipynb"
        if not file.exists():
            raise SystemExit(f"{name} is not released yet; run: grade.py release")
        released[name] = nbformat.read(file, as_version=4)
    files = [
        file
        for file in sorted(submissions.rglob("*"))
        if file.suffix.lower() == ".ipynb"
        and file.is_file()
        and not {".ipynb_checkpoints", "__MACOSX"} & set(file.parts)
    ]
    folders = sorted(path for path in submissions.glob("*") if path.is_dir())
    if not files and not folders:
        raise SystemExit(f"{submissions} has no notebooks; give a folder with one folder a student")
    handed_in = {file.relative_to(submissions).parts[0] for file in files}
    remarks = {
        ("", path.name): ["not graded: there is no notebook in this folder"]
        for path in folders
        if path.name not in handed_in
    }
    taken = {}
    for file in tqdm(files, desc="grade", unit="submission"):
        shown = file.relative_to(submissions)
        student, *_ = shown.parts
        name = next((name for name in released if file.stem.startswith(name)), "")
        notes = remarks.setdefault((name, student), [])
        if not name or file.parent == submissions:
            notes.append(f"not graded: {shown} is not <student>/…/<set>.ipynb")
            continue
        if (name, student) in taken:
            notes.append(f"it is there twice: {taken[name, student]} counts, {shown} does not")
            continue
        taken[name, student] = shown
        try:
            submitted = read_submission(file)
            restored, changes = restore(submitted, released[name])
        except Exception as error:  # whatever a broken file makes nbformat raise
            notes.append(f"not graded: cannot be read ({type(error).__name__}: {str(error)[:200]})")
            _forget(course, name, student)
            continue
        notes += changes
        if _names_nobody(submitted, released[name]):
            notes.append("no id is written in it: its worlds are those of all such submissions")
        target = folder / "build" / "submitted" / _alias(student) / name / f"{name}.ipynb"
        target.parent.mkdir(parents=True, exist_ok=True)
        nbformat.write(restored, target)
        if log := convert(Autograde, course, name, student):
            # A traceback's last line, as nbgrader's log indents it, says what happened.
            causes = re.findall(r"^ {4}(\w[\w.]*: .*)$", log, re.M) or [log.strip()]
            notes.append(f"not graded: nbgrader stopped ({causes[-1]})")
            _forget(course, name, student)
            continue
        graded = nbformat.read(
            folder / "build" / "autograded" / _alias(student) / name / f"{name}.ipynb", as_version=4
        )
        notes += _oddities(graded)
    report(folder, remarks)


def read_submission(file):
    """A notebook as a student's computer wrote it: whatever its byte order mark and line ends."""
    # Some editors give cells ids and keep the minor version, in which there are none.
    content = json.loads(file.read_text(encoding="utf-8-sig"))
    if content.get("nbformat") == 4:
        content["nbformat_minor"] = max(content.get("nbformat_minor", 0), 5)
    notebook = nbformat.reads(json.dumps(content), as_version=4)
    for cell in notebook.cells:
        cell.source = cell.source.replace("\r\n", "\n").replace("\r", "\n")
        cell.setdefault("id", uuid4().hex[:8])
    nbformat.validate(notebook)
    return notebook


def _names_nobody(submitted, released):
    """Whether the cell for the student's id is as it was given out."""
    before, after = (
        [cell.source for cell in notebook.cells if _id(cell) == "student"]
        for notebook in (released, submitted)
    )
    return before == after


def _oddities(graded):
    """What in a graded notebook makes its score doubtful."""
    found = []
    for cell in filter(_id, graded.cells):
        errors = [o.ename for o in cell.get("outputs", ()) if o.output_type == "error"]
        if cell.metadata.nbgrader.grade and cell.get("outputs") == []:
            found.append(
                f"look at it: test {_id(cell)} printed nothing, for which nbgrader gives all points"
            )
        elif _is_given(cell) and errors:
            found.append(f"look at it: cell {_id(cell)}, which was given, raised {errors[0]}")
    return found


def _forget(course, name, student):
    """Remove a submission that could not be graded from the grade book: no score is not zero."""
    feedback = Path(course.root, "build", "feedback", student, name)
    shutil.rmtree(feedback, ignore_errors=True)
    with open_book(course) as book, suppress(MissingEntry):
        book.remove_submission(name, _alias(student))


def restore(submitted, released):
    """A student's answers in the notebook that was released.

    nbgrader restores a test whose text was changed. It does not mind one that is tagged to be
    skipped, and it stumbles where cells were deleted or turned into others.

    Parameters
    ----------
    submitted, released : NotebookNode
        What came back, and what was given out.

    Returns
    -------
    restored : NotebookNode
        The released cells in their order, with the source of the submitted answers; cells that
        the student added stay where they were, as plain ones.
    changes : list of str
        What had to be put right.
    """
    originals = {cell.metadata.nbgrader.grade_id: cell for cell in released.cells if _id(cell)}
    answers, added, changes, last = {}, {None: []}, [], None
    for cell in submitted.cells:
        if _id(cell) in originals and _id(cell) not in answers:
            last = _id(cell)
            answers[last] = cell
            added[last] = []
            continue
        if _id(cell):
            changes.append(f"a copy of cell {_id(cell)} is no test and no answer")
        new = getattr(nbformat.v4, f"new_{cell.cell_type}_cell")
        added[last].append(new(id=f"added-{len(added)}-{len(added[last])}", **_content(cell)))
    cells = added[None]
    for name, original in originals.items():
        cell = original.copy()
        if name not in answers:
            changes.append(f"cell {name} was missing and is put back")
        elif original.metadata.nbgrader.solution:
            cell.update(_content(answers[name]))
        elif not _same(answers[name], original):
            changes.append(f"cell {name} was changed and is put back")
        cells += [cell, *added.get(name, [])]
    given = {"check"}.union(*(_names(cell) for cell in originals.values() if _is_given(cell)))
    own = [cell for cell in cells if not cell.metadata.get("nbgrader", {}).get("locked")]
    if hidden := given & set().union(*map(_names, own)):
        changes.append(f"look at it: it redefines what the tests use: {', '.join(sorted(hidden))}")
    return nbformat.v4.new_notebook(cells=cells, metadata=released.metadata), changes


def _content(cell):
    """What is kept of a student's cell: not its metadata, for a tag can have it skipped."""
    return {key: cell[key] for key in ("source", "attachments") if key in cell}


def _is_given(cell):
    """Whether a cell is neither a test nor an answer, and was not to be changed."""
    return cell.metadata.nbgrader.locked and not cell.metadata.nbgrader.grade


def _names(cell):
    """Names that a code cell gives a value to, outside of functions."""
    source = cell.source if cell.cell_type == "code" else ""
    try:
        # With what only a notebook understands: magics, shell commands, await outside of functions.
        python = TransformerManager().transform_cell(source)
        code = compile(python, "", "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
    except (SyntaxError, ValueError):  # it does not run either
        return set()
    return {step.argval for step in dis.get_instructions(code) if step.opname == "STORE_NAME"}


def _id(cell):
    """A cell's name in nbgrader, or None."""
    return (cell.metadata.get("nbgrader") or {}).get("grade_id")


def _same(cell, original):
    """Whether a cell is what was given out, whatever an editor adds to its metadata."""
    return (
        cell.source == original.source
        and cell.cell_type == original.cell_type
        and cell.metadata.nbgrader == original.metadata.nbgrader
        and cell.metadata.get("tags", []) == original.metadata.get("tags", [])
    )


def report(folder=HERE, remarks=None):
    """Write build/grades.csv and build/feedback/ from the grade book.

    Parameters
    ----------
    folder : Path, optional
        Where the course is.
    remarks : dict, optional
        Lists of remarks by set and student: feedback is written for these,
        and other remarks stay as they were. By default, for all.
    """
    course = open_course(folder)
    table = folder / "build" / "grades.csv"
    rows = {(row["set"], row["student"]): row["remarks"] for row in _read_grades(table)}
    # What had no set before may have one now.
    seen = {student for _, student in remarks or ()}
    rows = {(name, who): notes for (name, who), notes in rows.items() if name or who not in seen}
    rows |= {key: "; ".join(notes) for key, notes in (remarks or {}).items()}
    # With the mark by which Excel knows the encoding.
    with open_book(course) as book, table.open("w", newline="", encoding="utf-8-sig") as stream:
        write = csv.writer(stream)
        write.writerow(COLUMNS)
        for (name, student), notes in tqdm(sorted(rows.items()), desc="report", unit="submission"):
            numbers = ["", "", ""]
            try:
                submission = book.find_submission(name, _alias(student))
            except MissingEntry:
                pass
            else:
                by_hand = sum(
                    grade.needs_manual_grade
                    for notebook in submission.notebooks
                    for grade in notebook.grades
                )
                numbers = [submission.score, submission.max_score, by_hand]
                new = remarks is None or (name, student) in remarks
                if new and not _write_feedback(course, folder, name, student):
                    notes = "; ".join(filter(None, [notes, "no feedback: nbgrader stopped"]))
            write.writerow([name, student, *numbers, notes])
    print(f"grades: {table}\nfeedback: {folder / 'build' / 'feedback'}")


def _write_feedback(course, folder, name, student):
    """Write a student's feedback to a set, below the student's own name; whether that was done."""
    made, given = (
        folder / "build" / "feedback" / who / name for who in (_alias(student), student)
    )
    if convert(GenerateFeedback, course, name, student):
        return False
    if made != given:
        shutil.rmtree(given, ignore_errors=True)
        given.parent.mkdir(exist_ok=True)
        made.rename(given)
        made.parent.rmdir()
    return True


def forget(students, folder=HERE):
    """Remove students from the grade book, from build/grades.csv and from build/feedback/."""
    course = open_course(folder)
    table = folder / "build" / "grades.csv"
    known = {row["student"] for row in _read_grades(table)}
    if missing := [student for student in students if student not in known]:
        raise SystemExit(f"{table} has no student {missing[0]!r}; it has {sorted(known)}")
    with open_book(course) as book:
        for student in students:
            with suppress(MissingEntry):
                book.remove_student(_alias(student))
            for step in ("submitted", "autograded"):
                shutil.rmtree(folder / "build" / step / _alias(student), ignore_errors=True)
            shutil.rmtree(folder / "build" / "feedback" / student, ignore_errors=True)
    rows = [row for row in _read_grades(table) if row["student"] not in students]
    with table.open("w", newline="", encoding="utf-8-sig") as stream:
        write = csv.DictWriter(stream, COLUMNS)
        write.writeheader()
        write.writerows(rows)


def _read_grades(table):
    """Rows of build/grades.csv, if it is there."""
    if not table.exists():
        return []
    with table.open(newline="", encoding="utf-8-sig") as stream:
        return list(csv.DictReader(stream))


def main(arguments=None):
    """Run one command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("release", help="make build/release/ from all sets")
    grading = commands.add_parser("grade", help="grade a folder of submissions, then report")
    grading.add_argument("submissions", type=Path, help="folder with one folder a student")
    commands.add_parser("report", help="write grades and feedback again, after grading by hand")
    forgetting = commands.add_parser("forget", help="remove students from grades and feedback")
    forgetting.add_argument("students", nargs="+", metavar="NAME")
    chosen = parser.parse_args(arguments)
    if chosen.command == "release":
        release()
    elif chosen.command == "grade":
        grade(chosen.submissions.resolve())
    elif chosen.command == "forget":
        forget(chosen.students)
    else:
        report()


if __name__ == "__main__":
    main()
