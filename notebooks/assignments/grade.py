"""Release the problem sets and grade what comes back; README.md beside this file says when.

python notebooks/assignments/grade.py release          makes build/release/, and a zip for students
python notebooks/assignments/grade.py collect SOURCE   says what would be graded of whom
python notebooks/assignments/grade.py grade SOURCE     grades, then reports
python notebooks/assignments/grade.py report           writes build/grades.csv and feedback again
python notebooks/assignments/grade.py forget NAME      removes a student, as after a wrong folder

nbgrader keeps the grade book; judge.py judges, in its place, answers that run in another process.
"""

import argparse
import atexit
import csv
import io
import json
import logging
import os
import re
import secrets
import shutil
import subprocess
import sys
import warnings
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import nbformat
from tqdm import tqdm
from traitlets.config import PyFileConfigLoader

if missing := [name for name in ("nbgrader", "latex2mathml") if find_spec(name) is None]:
    raise SystemExit(
        f"{missing[0]} is not installed; in the folder of the collection's README, run: "
        "pip install -r notebooks/assignments/requirements.txt"
    )

from nbgrader.api import Gradebook, MissingEntry
from nbgrader.converters import Autograde, GenerateAssignment
from nbgrader.coursedir import CourseDirectory
from nbgrader.utils import capture_log

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import submissions as handed_in  # noqa: E402
from feedback import Page, write_zip  # noqa: E402
from judge import CELL, Judge, judged  # noqa: E402

import freeseg  # noqa: E402

# nbgrader runs alembic by its name: it is beside this Python, active environment or not.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
# Of SQLAlchemy, at every submission; nbgrader works with it all the same.
warnings.filterwarnings("ignore", module="nbgrader")
# What nbgrader logs is captured, not shown between the progress.
LOG = logging.getLogger("freeseg.assignments")
LOG.propagate = False

#: What a container for answers is made of: the package and answers.py, nothing of the course.
DOCKERFILE = """
FROM python:3.12-slim
WORKDIR /freeseg
COPY environment.txt pyproject.toml README.md LICENSE ./
COPY freeseg freeseg
COPY data data
RUN pip install --no-cache-dir -r environment.txt && chmod -R a+rX .
COPY notebooks/assignments/answers.py /answers/answers.py
"""
#: Its name, and what it may do: compute, and nothing else.
IMAGE = "freeseg-answers"
CONFINED = (
    "run -i --rm --network none --memory 4g --pids-limit 256 --read-only --tmpfs /tmp "
    "--cap-drop ALL --user 65534:65534 --env HOME=/tmp --env MPLCONFIGDIR=/tmp "
    "--env MPLBACKEND=module://matplotlib_inline.backend_inline"
)
#: Where the package and the lessons are.
ROOT = Path(freeseg.__file__).resolve().parent.parent
#: What students read beside the notebooks.
HOW_TO = """# Problem sets

1. Install Python 3.11 or newer, and open a terminal in this folder. Then:
   `pip install "./{wheel}[notebooks]"`
2. Open a set with `jupyter lab`, write your id into it, and your answers where it says so. The
   lessons that it needs are in `lessons/`, with all that they show.
3. Hand in the notebook under its own name. What you add, code or text, stays in it; cells named
   `check(...)` test your answers, and are run anew when your set is graded. Then each cell may work
   {seconds:g} s: leave no long search in it, but what that found.
"""
#: How remarks begin that are for the lecturer alone.
PRIVATE = (handed_in.HINT, handed_in.STRANGER, LOOK := "look at it:", "tried to reach out")


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


def secret_of(folder):
    """From which the seeds of a course's tests are made: drawn once, and told to nobody."""
    file = folder / "build" / "secret.txt"
    if not file.exists():
        file.write_text(secrets.token_hex(16), encoding="utf-8")
    return file.read_text(encoding="utf-8")


def release(folder=HERE):
    """Write what students get to build/release/ and a zip, and the tests into the grade book."""
    course = open_course(folder)
    secret_of(folder)
    released, lessons = folder / "build" / "release", set()
    for name in tqdm(names_of_sets(folder), desc="release", unit="set"):
        if log := convert(GenerateAssignment, course, name):
            raise SystemExit(f"{name} cannot be released:\n{log}")
    with ZipFile(released / "problem_sets.zip", "w") as archive:
        for name in names_of_sets(folder):
            file = released / name / f"{name}.ipynb"
            text = file.read_text(encoding="utf-8")
            lessons |= set(re.findall(r"\]\(\.\./\.\./(\w+\.ipynb)\)", text))
            # What comes back is compared with it.
            file.write_text(text.replace("](../../", "](lessons/"), encoding="utf-8")
            _put(archive, file.name, file.read_bytes())
        for name in sorted(lessons):
            _put(archive, f"lessons/{name}", _lesson(ROOT / "notebooks" / name, lessons))
        name, content = build_wheel()
        _put(archive, name, content)
        _put(archive, "README.md", HOW_TO.format(wheel=name, seconds=CELL))
    print(f"for students: {released / 'problem_sets.zip'}")


def _put(archive, name, content):
    """Put a file into the zip for students, with the same bytes every time."""
    archive.writestr(ZipInfo(f"problem_sets/{name}"), content, ZIP_DEFLATED)


def _lesson(file, beside):
    """A lesson's text, with links only to those beside it."""
    lesson = nbformat.read(file, as_version=4)
    for cell in lesson.cells:
        if cell.cell_type == "markdown":
            cell.source = re.sub(
                r"(?<!!)\[([^][]+)\]\((?!https?:|#)([^)#]+)[^)]*\)",
                lambda link: link[0] if link[2] in beside else link[1],
                cell.source,
            )
    return nbformat.writes(lesson)


@cache
def build_wheel():
    """Name and bytes of the package's wheel; built from a copy, for setuptools leaves files."""
    if not (ROOT / "pyproject.toml").exists():
        raise SystemExit(
            f"freeseg is installed in {ROOT} without its sources; install environment.txt of the "
            "collection, which leaves it where it is"
        )
    with TemporaryDirectory() as folder:
        copy = Path(folder, "copy")
        build = "from setuptools import build_meta as b; b.build_wheel('.')"
        skipped = shutil.ignore_patterns("__pycache__")
        for name in ("freeseg", "data"):
            shutil.copytree(ROOT / name, copy / name, ignore=skipped)
        for name in ("pyproject.toml", "README.md", "LICENSE"):
            shutil.copy(ROOT / name, copy)
        # A date that is always the same, and the first that a zip can have.
        told = {"env": os.environ | {"SOURCE_DATE_EPOCH": "315619200"}, "capture_output": True}
        done = subprocess.run(
            [sys.executable, "-c", build], cwd=copy, check=False, text=True, **told
        )
        if done.returncode:
            raise SystemExit(f"freeseg cannot be built:\n{done.stderr}")
        (wheel,) = copy.glob("*.whl")
        return wheel.name, wheel.read_bytes()


def released_sets(folder):
    """Notebooks that were given out, by name."""
    return {name: _given_out(folder, name) for name in names_of_sets(folder)}


def _given_out(folder, name):
    """A set as it was released."""
    file = folder / "build" / "release" / name / f"{name}.ipynb"
    if not file.exists():
        raise SystemExit(f"{name} is not released yet; run: grade.py release")
    return nbformat.read(file, as_version=4)


def grade(source, folder=HERE, roster=None, due=None, command=None, jobs=1, use=()):
    """Grade every notebook of a download; then report.

    Parameters
    ----------
    source : Path
        As for `submissions.collect`.
    folder : Path, optional
        Where the course is.
    roster : Path, optional
        Table of the students; by default, that of the last time.
    due : datetime, optional
        When the sets of this download were to be handed in; by default, as the last time.
    command : list of str, optional
        What starts the answers' process.
    jobs : int, optional
        How many submissions are judged at once.
    use : list of str, optional
        Files of the source that count, whichever would; they are remembered.
    """
    course, released = open_course(folder), released_sets(folder)
    rows = read_table(roster) if roster else _roster(folder)
    chosen = [*(one for one in _read_json(folder / "build" / "use.json") if one not in use), *use]
    with TemporaryDirectory() as unpacked:
        found, remarks = handed_in.collect(source, released, rows, Path(unpacked), chosen)
        if missing := set(use) - {file.shown for file in found.values()}:
            raise SystemExit(
                f"there is no {min(missing)!r}; collect shows the files as they are named"
            )
        (folder / "build" / "use.json").write_text(json.dumps(chosen), encoding="utf-8")
        if roster and roster.resolve() != (folder / "build" / "roster.csv").resolve():
            shutil.copyfile(roster, folder / "build" / "roster.csv")
        notebooks, places = {}, {key: file.shown for key, file in found.items()}
        for key, file in found.items():
            if file.problem:
                remarks[key].append(file.problem)
                _forget(course, *key)
                continue
            notebooks[key], changes = restore(file.notebook, released[key[0]])
            remarks[key] += changes
            _submit(folder, *key, notebooks[key], file.when.timestamp())
        with open_book(course) as book:
            _tell_book(book, notebooks, rows, due)
            if source.is_dir():
                for key in notebooks:
                    remarks[key] += _doubtful_date(book, key[0], found[key].when)
    names = {handed_in.key_of(row): handed_in.full_name(row) for row in rows}
    _judge_all(folder, notebooks, command, jobs, names)
    with tqdm(sorted(notebooks), desc="grade", unit="submission") as bar:
        for name, student in bar:
            bar.set_postfix_str(names.get(student, student))
            if log := convert(Autograde, course, name, student):
                # A traceback's last line, as nbgrader's log indents it, says what happened.
                causes = re.findall(r"^ {4}(\w[\w.]*: .*)$", log, re.M) or [log.strip()]
                remarks[name, student].append(f"not graded: nbgrader stopped ({causes[-1]})")
                _forget(course, name, student)
                continue
            remarks[name, student] += _oddities(_graded(folder, name, student))
    report(folder, remarks, places)


def _tell_book(book, keys, roster, due):
    """Write into the grade book when sets were due, and what students are called."""
    if due:
        for name in {name for name, _ in keys}:
            book.update_or_create_assignment(name, duedate=str(due.astimezone(UTC)))
    rows = {handed_in.key_of(row): row for row in roster}
    for student in {student for _, student in keys} & set(rows):
        first, _, last = handed_in.full_name(rows[student]).partition(" ")
        book.update_or_create_student(_alias(student), first_name=first, last_name=last)


def _doubtful_date(book, name, when):
    """A remark on a file in a folder that is late by its date, for copies have new dates."""
    due = book.find_assignment(name).duedate
    if not due or when.astimezone(UTC) <= due.replace(tzinfo=UTC):
        return []
    return [f"late by the date of its file, {when:%Y-%m-%d %H:%M}: a copy may have a new date"]


def _reference(folder, name):
    """The solved set, as far as it is here."""
    return nbformat.read(folder / name / f"{name}.ipynb", as_version=4)


def _submitted(folder, name, student):
    """Where nbgrader looks for a submission."""
    return folder / "build" / "submitted" / _alias(student) / name / f"{name}.ipynb"


def _submit(folder, name, student, notebook, when):
    """Write a submission where nbgrader looks for it, with the time (s) at which it came."""
    target = _submitted(folder, name, student)
    target.parent.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, target)
    stamp = datetime.fromtimestamp(when, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    target.with_name("timestamp.txt").write_text(stamp, encoding="utf-8")


def _judge_all(folder, notebooks, command, jobs, names):
    """Let `Judge` know what was judged beforehand, several at once; or how to do it."""
    Judge.command, Judge.done = command, {}
    if jobs == 1 or len(notebooks) < 2:
        return
    secret = secret_of(folder)
    with (
        ProcessPoolExecutor(jobs, get_context("spawn")) as pool,
        tqdm(total=len(notebooks), desc="judge", unit="submission") as bar,
    ):
        asked = {
            pool.submit(judged, notebook, name, secret, command): (name, student)
            for (name, student), notebook in notebooks.items()
        }
        waiting = set(asked)
        while waiting:
            done, waiting = wait(waiting, 1.0, FIRST_COMPLETED)
            bar.update(len(done))
            busy = [asked[one][1] for one in waiting if one.running()]
            bar.set_postfix_str(", ".join(sorted(names.get(who, who) for who in busy)))
        for one, (name, student) in asked.items():
            Judge.done[name, _alias(student)] = one.result()


def _graded(folder, name, student):
    """A submission as it was judged."""
    file = folder / "build" / "autograded" / _alias(student) / name / f"{name}.ipynb"
    return nbformat.read(file, as_version=4)


def _roster(folder):
    """Rows of the roster, if there is one."""
    table = folder / "build" / "roster.csv"
    return read_table(table) if table.exists() else []


def _oddities(graded):
    """What a lecturer should know of a graded notebook."""
    found = list(graded.metadata.get("remarks", ()))
    for cell in filter(handed_in.cell_name, graded.cells):
        errors = [o.ename for o in cell.get("outputs", ()) if o.output_type == "error"]
        # The judge remarks on a cell that was ended.
        if errors and errors[0] not in ("Late", "Gone"):
            found.append(f"{LOOK} cell {handed_in.cell_name(cell)} raised {errors[0]}")
    return found


def _forget(course, name, student):
    """Remove a submission that could not be graded from the grade book: no score is not zero."""
    feedback = Path(course.root, "build", "feedback", student, name)
    shutil.rmtree(feedback, ignore_errors=True)
    with open_book(course) as book, suppress(MissingEntry):
        book.remove_submission(name, _alias(student))


def restore(submitted, released):
    """A student's answers in the notebook that was released.

    nbgrader stumbles where cells were deleted or turned into others. Nothing that a student
    changes has an influence on the judge, so that only answers and their places are put right.

    Parameters
    ----------
    submitted, released : NotebookNode
        What came back, and what was given out.

    Returns
    -------
    restored : NotebookNode
        The released cells in their order, with the source of the submitted answers; cells that
        the student added stay where they were, as plain ones, but for text below an answer in
        words, which belongs to it.
    changes : list of str
        What had to be put right.
    """
    name_of = handed_in.cell_name
    originals = {name_of(cell): cell for cell in released.cells if name_of(cell)}
    given = {cell.source for cell in released.cells}
    answers, added, changes, last = {}, {None: []}, [], None
    for cell in submitted.cells:
        if name_of(cell) in originals and name_of(cell) not in answers:
            last = name_of(cell)
            answers[last], added[last] = cell, []
            continue
        if name_of(cell):
            changes.append(f"a copy of cell {name_of(cell)} is no test and no answer")
        new = getattr(nbformat.v4, f"new_{cell.cell_type}_cell")
        added[last].append(new(id=f"added-{len(added)}-{len(added[last])}", **_content(cell)))
    cells = added[None]
    for name, original in originals.items():
        cell = original.copy()
        if name not in answers:
            changes.append(f"cell {name} was missing and is put back")
        elif original.metadata.nbgrader.solution:
            cell.update(_content(answers[name]))
        more = added.get(name, [])
        if original.metadata.nbgrader.grade and original.cell_type == "markdown":
            cell.source, more = _with_text_below(cell.source, original.source, more, given)
        cells += [cell, *more]
    return nbformat.v4.new_notebook(cells=cells, metadata=released.metadata), changes


def _with_text_below(answer, stub, below, given):
    """An answer in words with the text in the cells below it, and the other cells."""
    texts = [
        cell.source
        for cell in below
        if cell.cell_type == "markdown" and cell.source.strip() and cell.source not in given
    ]
    others = [cell for cell in below if cell.source not in texts]
    return "\n\n".join([*([answer] if answer != stub or not texts else []), *texts]), others


def _content(cell):
    """What is kept of a student's cell: not its metadata, for a tag can have it skipped."""
    return {key: cell[key] for key in ("source", "attachments") if key in cell}


def report(folder=HERE, remarks=None, places=None):
    """Write build/grades.csv, build/leaderboard.csv and feedback from the grade book.

    Parameters
    ----------
    folder : Path, optional
        Where the course is.
    remarks : dict, optional
        Lists of remarks by set and student: feedback is written for these,
        and other remarks stay as they were. By default, for all.
    places : dict, optional
        Where submissions were in what the platform gave, by set and student.
    """
    course, file = open_course(folder), folder / "build" / "remarks.json"
    rows = _read_json(file)
    # What had no set before may have one now.
    seen = {student for _, student in remarks or ()}
    rows = [row for row in rows if row[0] or row[1] not in seen]
    known = {(name, who): notes for name, who, notes, *_ in rows} | (remarks or {})
    places = {(row[0], row[1]): row[3] for row in rows if row[3:]} | (places or {})
    with open_book(course) as book:
        graded = {key: _grades(book, *key) for key in known}
    names = {handed_in.key_of(row): handed_in.full_name(row) for row in _roster(folder)}
    page, todo = Page(course.config), sorted(known if remarks is None else remarks)
    for key in tqdm(todo, desc="report", unit="submission"):
        if key[0]:
            _write_feedback(page, folder, key, names, known[key], graded[key])
    file.write_text(
        json.dumps([[*key, notes, places.get(key, "")] for key, notes in known.items()]),
        encoding="utf-8",
    )
    _write_grades(folder, known, graded, names)
    _write_leaderboard(folder, [key for key, found in graded.items() if found])
    print(f"grades: {folder / 'build' / 'grades.csv'}")
    for name in sorted({name for name, _ in todo or known} - {""}):
        pages = [(_page_of(folder, *key), places[key]) for key in places if key[0] == name]
        write_zip(folder / "build" / f"feedback_{name}.zip", pages)
        print(f"feedback: {folder / 'build' / f'feedback_{name}.zip'}")
    for name in sorted({name for (name, _), found in graded.items() if found and not found["due"]}):
        print(f"no day is known for {name}: hours late are empty; grade it again with --due")


def _page_of(folder, name, student):
    """Where a student's feedback is."""
    return folder / "build" / "feedback" / student / name / f"{name}.html"


def _grades(book, name, student):
    """Points, comments and lateness of a submission, as the grade book has them; or None."""
    try:
        submission = book.find_submission(name, _alias(student))
    except MissingEntry:
        return None
    grades = [one for notebook in submission.notebooks for one in notebook.grades]
    comments = [one for notebook in submission.notebooks for one in notebook.comments]
    due = submission.assignment.duedate
    return {
        "score": round(submission.score, 2),
        "of": submission.max_score,
        "due": due,
        "late": round(submission.total_seconds_late / 3600, 1) if due else "",
        "points": {one.name: round(one.score, 2) for one in grades},
        "most": {one.name: one.max_score for one in grades},
        "waiting": [one.name for one in grades if one.needs_manual_grade],
        "comments": {one.name: one.manual_comment for one in comments if one.manual_comment},
    }


def _exercises(notebook):
    """Names of a notebook's graded cells, in their order."""
    cells = [cell.metadata.get("nbgrader") or {} for cell in notebook.cells]
    return [cell["grade_id"] for cell in cells if cell.get("grade")]


def _write_feedback(page, folder, key, names, notes, grades):
    """Write a student's page for a set: what was graded, or why nothing was."""
    told = {
        "title": key[0],
        "student": names.get(key[1], key[1]),
        "score": "no score",
        "remarks": [note for note in notes if not note.startswith(PRIVATE)],
        "grades": {},
        "comments": {},
    }
    notebook = nbformat.v4.new_notebook()
    if grades:
        notebook, waiting = _graded(folder, *key), grades["waiting"]
        most = {name: grades["most"][name] for name in _exercises(notebook)}
        for name, points in most.items():
            told["grades"][name] = f"{grades['points'][name]:g} of {points:g} points"
            if name in waiting:
                told["grades"][name] = f"not graded yet, {points:g} points"
        told["score"] = f"{grades['score']:g} of {grades['of']:g} points"
        if waiting:
            more = sum(most[name] for name in waiting)
            told["score"] += f" so far; answers for {more:g} points are not graded yet"
        told["comments"] = grades["comments"]
        if grades["late"]:
            told["remarks"].insert(0, f"handed in {grades['late']:g} hours late")
    page.write(_page_of(folder, *key), told, notebook)


def _hints(folder, keys, names):
    """What is alike in submissions, by set and student."""
    found = {}
    for name in {name for name, _ in keys}:
        notebooks = {
            who: nbformat.read(_submitted(folder, name, who), as_version=4)
            for one, who in keys
            if one == name
        }
        called = {f"{names[who]} ({who})" if who in names else who: who for who in notebooks}
        for one, hint in handed_in.similar(
            {label: notebooks[who] for label, who in called.items()},
            _given_out(folder, name),
            {"the reference solution": _reference(folder, name)},
        ):
            found.setdefault((name, called[one]), []).append(hint)
    return found


def _write_grades(folder, remarks, graded, names):
    """Write build/grades.csv: a row for each student, a column for each exercise."""
    roster = _roster(folder)
    rows = {handed_in.key_of(row): dict(row) for row in roster}
    # Who is in no row is named where the others are.
    named = next((key for key in handed_in.KEYS if any(row.get(key) for row in roster)), "student")
    named = named if not roster or named in roster[0] else next(iter(roster[0]))
    hints = _hints(folder, [key for key, found in graded.items() if found], names)
    columns = [*(roster[0] if roster else [named]), "total"]
    for name in sorted({name for name, _ in remarks} - {""}):
        part = name.partition("_")[0]
        columns += [part, f"{part} of"]
        columns += [f"{part}.{one}" for one in _exercises(_given_out(folder, name))]
        columns += [f"{part} {what}" for what in ("hours late", "to grade by hand", "remarks")]
    columns += ["other remarks"] * any(not name for name, _ in remarks)
    for (name, student), notes in remarks.items():
        part, row = name.partition("_")[0] or "other", rows.setdefault(student, {named: student})
        row[f"{part} remarks"] = "; ".join([*notes, *hints.get((name, student), ())])
        if found := graded[name, student]:
            row |= {f"{part}.{one}": points for one, points in found["points"].items()}
            row |= {part: found["score"], f"{part} of": found["of"]}
            row |= {f"{part} hours late": found["late"]}
            row |= {f"{part} to grade by hand": len(found["waiting"])}
            # Who has no score has no total, which is not zero.
            row["total"] = row.get("total", 0) + found["score"]
    # With the mark by which Excel knows the encoding.
    table = folder / "build" / "grades.csv"
    with table.open("w", newline="", encoding="utf-8-sig") as stream:
        # A test that a set has no more has no column.
        write = csv.DictWriter(stream, columns, restval="", extrasaction="ignore")
        write.writeheader()
        write.writerows(row for _, row in sorted(rows.items()))


def _write_leaderboard(folder, keys):
    """Write build/leaderboard.csv of the contest: what costs least comes first."""
    entries = []
    for name, student in keys:
        for cell in _graded(folder, name, student).cells:
            texts = [one.text for one in cell.get("outputs", ()) if "text" in one]
            if handed_in.cell_name(cell) == "contest" and texts:
                found = re.search(r"^r = (-?[\d.]+): (.*)$", texts[0], re.M)
                entries += [(float(found[1]), student, found[2])] if found else []
    if entries:
        table = folder / "build" / "leaderboard.csv"
        with table.open("w", newline="", encoding="utf-8-sig") as stream:
            write = csv.writer(stream)
            write.writerow(["place", "student", "r", "costs"])
            write.writerows(
                [place, student, r, costs]
                for place, (r, student, costs) in enumerate(sorted(entries), 1)
            )


def forget(students, folder=HERE):
    """Remove students from the grade book, from build/grades.csv and from build/feedback/."""
    course, file = open_course(folder), folder / "build" / "remarks.json"
    rows = _read_json(file)
    known = {student for _, student, *_ in rows}
    if missing := [student for student in students if student not in known]:
        raise SystemExit(f"there is no student {missing[0]!r}; there are {sorted(known)}")
    with open_book(course) as book:
        for student in students:
            with suppress(MissingEntry):
                book.remove_student(_alias(student))
            for step in ("submitted", "autograded"):
                shutil.rmtree(folder / "build" / step / _alias(student), ignore_errors=True)
            shutil.rmtree(folder / "build" / "feedback" / student, ignore_errors=True)
    kept = [row for row in rows if row[1] not in students]
    file.write_text(json.dumps(kept), encoding="utf-8")
    report(folder, {})


def _read_json(file):
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else []


def read_table(table):
    """Rows of a CSV, whether commas, semicolons or tabs are between its columns."""
    try:
        text = table.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SystemExit(f"{table} is not there; give the list of participants as CSV") from None
    except UnicodeDecodeError:
        raise SystemExit(f"{table} is no text in UTF-8; save the list so, as CSV") from None
    delimiter = max(",;\t", key=text.partition("\n")[0].count)
    return list(csv.DictReader(io.StringIO(text), delimiter=delimiter))


def build_container(root):
    """What starts the answers' process in a container, which is built before."""
    without = "or leave --container away: then answers run with your rights, on this machine"
    engines = [found for name in ("podman", "docker") if (found := shutil.which(name))]
    if not engines:
        raise SystemExit(f"there is neither podman nor docker; install one, {without}")
    told = {"capture_output": True, "text": True, "check": False}
    asked = {engine: subprocess.run([engine, "info"], **told) for engine in engines}
    running = [engine for engine in engines if not asked[engine].returncode]
    if not running:
        name, said = Path(engines[-1]).name, asked[engines[-1]].stderr.strip().splitlines()
        raise SystemExit(
            f"{name} is there but does not run ({said[-1] if said else 'it says nothing'}); "
            f"start it, {without}"
        )
    command = [running[0], "build", "-t", IMAGE, "-f", "-", root]
    if subprocess.run(command, input=DOCKERFILE.encode(), check=False).returncode:
        raise SystemExit(
            f"the container cannot be built, for the reason above; put it right, {without}"
        )
    return [running[0], *CONFINED.split(), IMAGE, "python", "/answers/answers.py"]


def day(text):
    """A day and time, such as "2026-11-01 23:59"; of a day alone, its last minute."""
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'{text!r} is no day and time; give year, month and day, such as "2026-11-01 23:59"'
        ) from None
    return found if ":" in text else found.replace(hour=23, minute=59)


def main(arguments=None):
    """Run one command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("release", help="make build/release/ from all sets, and a zip")
    for name, told in (("collect", "say what would be graded"), ("grade", "grade, then report")):
        command = commands.add_parser(name, help=told)
        command.add_argument("source", type=Path, help="folder or zip, as a platform gives it")
        command.add_argument("--roster", type=Path, help="table of the students, as CSV")
    command.add_argument("--due", type=day, help='of its sets, such as "2026-11-01 23:59"')
    command.add_argument("--use", action="append", default=[], metavar="FILE", help="what counts")
    command.add_argument("--container", action="store_true", help="run answers in containers")
    command.add_argument("--jobs", type=int, default=os.cpu_count(), help="judged at once")
    commands.add_parser("report", help="write grades and feedback again, after grading by hand")
    forgetting = commands.add_parser("forget", help="remove students from grades and feedback")
    forgetting.add_argument("students", nargs="+", metavar="NAME")
    chosen = parser.parse_args(arguments)
    if chosen.command == "release":
        release()
    elif chosen.command == "collect":
        rows = read_table(chosen.roster) if chosen.roster else _roster(HERE)
        use = _read_json(HERE / "build" / "use.json")
        handed_in.show(chosen.source.resolve(), released_sets(HERE), rows, use)
    elif chosen.command == "grade":
        command = build_container(HERE.parent.parent) if chosen.container else None
        how = {"command": command, "jobs": chosen.jobs, "use": chosen.use}
        grade(chosen.source.resolve(), HERE, chosen.roster, chosen.due, **how)
    elif chosen.command == "forget":
        forget(chosen.students)
    else:
        report()


if __name__ == "__main__":
    main()
