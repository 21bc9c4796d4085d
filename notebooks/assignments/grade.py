"""Release the problem sets and grade what comes back; README.md beside this file says when.

python notebooks/assignments/grade.py release          makes build/release/, and a zip for students
python notebooks/assignments/grade.py collect SOURCE   says what would be graded of whom
python notebooks/assignments/grade.py grade SOURCE     grades, then reports
python notebooks/assignments/grade.py report           writes build/grades.csv and build/feedback/
python notebooks/assignments/grade.py forget NAME      removes a student, as after a wrong folder

nbgrader keeps the grade book; judge.py judges, in its place, answers that run in another process.
"""

import argparse
import atexit
import csv
import json
import logging
import os
import re
import secrets
import shutil
import subprocess
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import uuid4
from zipfile import ZipFile, ZipInfo

import nbformat
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
sys.path.insert(0, str(HERE))
import submissions as handed_in  # noqa: E402
from judge import Judge, judged  # noqa: E402

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
#: What students read beside the notebooks.
HOW_TO = """# Problem sets

1. Install Python 3.11 or newer, then: `pip install "freeseg[notebooks]"`
2. Open a set with `jupyter lab`, write your id into it, and your answers where it says so.
3. Hand in the notebook under its own name. What you add, code or text, stays in it; cells named
   `check(...)` test your answers, and are run anew when your set is graded.
"""


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
    released = folder / "build" / "release"
    for name in tqdm(names_of_sets(folder), desc="release", unit="set"):
        if log := convert(GenerateAssignment, course, name):
            raise SystemExit(f"{name} cannot be released:\n{log}")
    with ZipFile(released / "problem_sets.zip", "w") as archive:
        for name in names_of_sets(folder):
            text = (released / name / f"{name}.ipynb").read_text(encoding="utf-8")
            # Whoever has the zip has no lessons beside it.
            text = re.sub(r"\[(\w+)\]\(\.\./\.\./\w+\.ipynb\)", r"lesson \1", text)
            archive.writestr(ZipInfo(f"problem_sets/{name}.ipynb"), text)
        archive.writestr(ZipInfo("problem_sets/README.md"), HOW_TO)


def grade(source, folder=HERE, roster=None, due=None, command=None, jobs=1):
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
        When they were to be handed in; by default, as the last time.
    command : list of str, optional
        What starts the answers' process.
    jobs : int, optional
        How many submissions are judged at once.
    """
    course, released = open_course(folder), {}
    for name in names_of_sets(folder):
        file = folder / "build" / "release" / name / f"{name}.ipynb"
        if not file.exists():
            raise SystemExit(f"{name} is not released yet; run: grade.py release")
        released[name] = nbformat.read(file, as_version=4)
    if roster:
        shutil.copyfile(roster, folder / "build" / "roster.csv")
    with TemporaryDirectory() as unpacked:
        found, remarks = handed_in.collect(source, released, _roster(folder), Path(unpacked))
        notebooks = {}
        for key, file in found.items():
            try:
                submitted = read_submission(file)
                notebooks[key], changes = restore(submitted, released[key[0]])
            except Exception as error:  # whatever a broken file makes nbformat raise
                why = f"{type(error).__name__}: {str(error)[:200]}"
                remarks[key].append(f"not graded: cannot be read ({why})")
                _forget(course, *key)
                continue
            remarks[key] += changes
            _submit(folder, *key, notebooks[key], file.stat().st_mtime)
    if due:
        with open_book(course) as book:
            for name in {name for name, _ in notebooks}:
                book.update_or_create_assignment(name, duedate=str(due.astimezone(UTC)))
    for name in sorted({name for name, _ in notebooks}):
        originals = {"the reference solution": _reference(folder, name)}
        alike = handed_in.similar(
            {who: notebook for (one, who), notebook in notebooks.items() if one == name},
            released[name],
            originals,
        )
        for who, note in alike:
            remarks[name, who].append(note)
    _judge_all(folder, notebooks, command, jobs)
    for name, student in tqdm(sorted(notebooks), desc="grade", unit="submission"):
        if log := convert(Autograde, course, name, student):
            # A traceback's last line, as nbgrader's log indents it, says what happened.
            causes = re.findall(r"^ {4}(\w[\w.]*: .*)$", log, re.M) or [log.strip()]
            remarks[name, student].append(f"not graded: nbgrader stopped ({causes[-1]})")
            _forget(course, name, student)
            continue
        remarks[name, student] += _oddities(_graded(folder, name, student))
    report(folder, remarks)


def _reference(folder, name):
    """The solved set, as far as it is here."""
    return nbformat.read(folder / name / f"{name}.ipynb", as_version=4)


def _submit(folder, name, student, notebook, when):
    """Write a submission where nbgrader looks for it, with the time (s) at which it came."""
    target = folder / "build" / "submitted" / _alias(student) / name / f"{name}.ipynb"
    target.parent.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, target)
    stamp = datetime.fromtimestamp(when, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    target.with_name("timestamp.txt").write_text(stamp, encoding="utf-8")


def _judge_all(folder, notebooks, command, jobs):
    """Let `Judge` know what was judged beforehand, several at once; or how to do it."""
    Judge.command, Judge.done = command, {}
    if jobs == 1 or len(notebooks) < 2:
        return
    secret = secret_of(folder)
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        asked = {
            (name, _alias(student)): pool.submit(judged, notebook, name, secret, command)
            for (name, student), notebook in notebooks.items()
        }
        for key, found in tqdm(asked.items(), desc="judge", unit="submission"):
            Judge.done[key] = found.result()


def _graded(folder, name, student):
    """A submission as it was judged."""
    file = folder / "build" / "autograded" / _alias(student) / name / f"{name}.ipynb"
    return nbformat.read(file, as_version=4)


def _roster(folder):
    """Rows of the roster, if there is one."""
    return _read_table(folder / "build" / "roster.csv")


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


def _oddities(graded):
    """What a lecturer should know of a graded notebook."""
    found = list(graded.metadata.get("remarks", ()))
    for cell in filter(handed_in.cell_name, graded.cells):
        errors = [o.ename for o in cell.get("outputs", ()) if o.output_type == "error"]
        if errors:
            found.append(f"look at it: cell {handed_in.cell_name(cell)} raised {errors[0]}")
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


def report(folder=HERE, remarks=None):
    """Write build/grades.csv, build/leaderboard.csv and build/feedback/ from the grade book.

    Parameters
    ----------
    folder : Path, optional
        Where the course is.
    remarks : dict, optional
        Lists of remarks by set and student: feedback is written for these,
        and other remarks stay as they were. By default, for all.
    """
    course, file = open_course(folder), folder / "build" / "remarks.json"
    known = {(name, who): notes for name, who, notes in _read_json(file)}
    # What had no set before may have one now.
    seen = {student for _, student in remarks or ()}
    known = {(name, who): notes for (name, who), notes in known.items() if name or who not in seen}
    known |= remarks or {}
    with open_book(course) as book:
        graded = {key: _grades(book, *key) for key in known}
    for key in tqdm(
        sorted(known if remarks is None else remarks), desc="report", unit="submission"
    ):
        if graded[key] and not _write_feedback(course, folder, *key):
            known[key].append("no feedback: nbgrader stopped")
    file.write_text(json.dumps([[*key, notes] for key, notes in known.items()]), encoding="utf-8")
    _write_grades(folder, known, graded)
    _write_leaderboard(folder, [key for key, found in graded.items() if found])
    print(f"grades: {folder / 'build' / 'grades.csv'}\nfeedback: {folder / 'build' / 'feedback'}")


def _grades(book, name, student):
    """Points by exercise, their sum, what waits for the lecturer and hours late; or None."""
    try:
        submission = book.find_submission(name, _alias(student))
    except MissingEntry:
        return None
    part = name.partition("_")[0]
    grades = [one for notebook in submission.notebooks for one in notebook.grades]
    points = {f"{part}.{one.name}": round(one.score, 2) for one in grades}
    return {
        part: round(submission.score, 2),
        f"{part} of": submission.max_score,
        f"{part} to grade by hand": sum(one.needs_manual_grade for one in grades),
        f"{part} hours late": round(submission.total_seconds_late / 3600, 1),
        **points,
    }


def _write_grades(folder, remarks, graded):
    """Write build/grades.csv: a row for each student, a column for each exercise."""
    roster = _roster(folder)
    keys = {handed_in.key_of(row): row for row in roster}
    rows = {student: {"student": student} for student in sorted({*keys, *(w for _, w in remarks)})}
    for (name, student), notes in sorted(remarks.items()):
        part = name.partition("_")[0] or "other"
        row = rows[student] | (graded[name, student] or {}) | {f"{part} remarks": "; ".join(notes)}
        row["total"] = row.get("total", 0) + ((graded[name, student] or {}).get(part) or 0)
        rows[student] = row
    columns = ["student", "total", *sorted({key for row in rows.values() for key in row})]
    lms = list(roster[0]) if roster else []
    columns = list(dict.fromkeys([*lms, *columns]))
    for student, row in rows.items():
        rows[student] = keys.get(student, {}) | row
    # With the mark by which Excel knows the encoding.
    table = folder / "build" / "grades.csv"
    with table.open("w", newline="", encoding="utf-8-sig") as stream:
        write = csv.DictWriter(stream, columns, restval="")
        write.writeheader()
        write.writerows(rows.values())


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


def _write_feedback(course, folder, name, student):
    """Write a student's feedback to a set, below the student's own name; whether that was done."""
    made, given = (folder / "build" / "feedback" / who / name for who in (_alias(student), student))
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
    course, file = open_course(folder), folder / "build" / "remarks.json"
    rows = _read_json(file)
    known = {student for _, student, _ in rows}
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


def _read_table(table):
    """Rows of a CSV, if it is there."""
    if not table.exists():
        return []
    with table.open(newline="", encoding="utf-8-sig") as stream:
        return list(csv.DictReader(stream))


def build_container(root):
    """What starts the answers' process in a container, which is built before."""
    engine = shutil.which("podman") or shutil.which("docker")
    if not engine:
        raise SystemExit("there is neither podman nor docker; install one, or grade without")
    subprocess.run(
        [engine, "build", "-t", IMAGE, "-f", "-", root], input=DOCKERFILE.encode(), check=True
    )
    return [engine, *CONFINED.split(), IMAGE, "python", "/answers/answers.py"]


def main(arguments=None):
    """Run one command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("release", help="make build/release/ from all sets, and a zip")
    for name, told in (("collect", "say what would be graded"), ("grade", "grade, then report")):
        command = commands.add_parser(name, help=told)
        command.add_argument("source", type=Path, help="folder or zip, as a platform gives it")
        command.add_argument("--roster", type=Path, help="table of the students, as CSV")
    command.add_argument("--due", type=datetime.fromisoformat, help='such as "2026-11-01 23:59"')
    command.add_argument("--container", action="store_true", help="run answers in containers")
    command.add_argument("--jobs", type=int, default=os.cpu_count(), help="judged at once")
    commands.add_parser("report", help="write grades and feedback again, after grading by hand")
    forgetting = commands.add_parser("forget", help="remove students from grades and feedback")
    forgetting.add_argument("students", nargs="+", metavar="NAME")
    chosen = parser.parse_args(arguments)
    if chosen.command == "release":
        release()
    elif chosen.command == "collect":
        rows = _read_table(chosen.roster) if chosen.roster else _roster(HERE)
        handed_in.show(chosen.source.resolve(), names_of_sets(HERE), rows)
    elif chosen.command == "grade":
        command = build_container(HERE.parent.parent) if chosen.container else None
        grade(chosen.source.resolve(), HERE, chosen.roster, chosen.due, command, chosen.jobs)
    elif chosen.command == "forget":
        forget(chosen.students)
    else:
        report()


if __name__ == "__main__":
    main()
