"""Find who handed in what, in what a learning platform gives, and which are alike."""

import io
import json
import keyword
import os
import re
import time
import tokenize
import unicodedata
from dataclasses import dataclass
from datetime import datetime
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import uuid4
from zipfile import BadZipFile, ZipFile

import nbformat

#: A folder that Moodle makes for each student, and a file as Canvas names it.
MOODLE = re.compile(r"(?P<name>.+)_(?P<user>\d+)_assignsubmission_\w+")
CANVAS = re.compile(r"(?P<name>[^_]+)_(?:LATE_)?(?P<user>\d+)_\d+_(?P<file>.+)", re.I)
#: Columns of a roster that name a student; the first of them that is there and filled is used.
KEYS = ("student", "Username", "SIS Login ID", "SIS User ID", "ID number", "Email address", "ID")
#: What is said of who is in no row of it.
STRANGER = "not in the roster"
#: Tokens or words of a passage that is compared, passages of code and of words that are enough to
#: tell, and the share that is worth a look.
PASSAGE, ENOUGH, FEW, ALIKE = 10, 30, 10, 0.8
#: How a remark begins that says so.
HINT = "a hint:"


def cell_name(cell):
    """A cell's name in nbgrader, or None."""
    return (cell.metadata.get("nbgrader") or {}).get("grade_id")


def key_of(row):
    """By what name a student of a roster is graded."""
    return next((row[key] for key in KEYS if row.get(key)), "") or next(iter(row.values()), "")


def letters(name):
    """A name by its letters alone: small, and without accents."""
    plain = unicodedata.normalize("NFKD", name)
    return "".join(one for one in plain.lower() if one.isalnum())


def _names_of(row):
    """All that a roster calls a student, by letters."""
    # A first name alone may be that of several.
    parts = ("First name", "Last name", "Surname")
    names = {letters(value) for key, value in row.items() if value and key not in parts}
    first, last = row.get("First name", ""), row.get("Last name", row.get("Surname", ""))
    if row.get("Student"):  # Canvas: "Last, First"
        last, _, first = row["Student"].partition(",")
    return names | {letters(first + last), letters(last + first)} - {""}


def full_name(row):
    """What a student of a roster is called."""
    last, _, first = row.get("Student", "").partition(",")  # Canvas: "Last, First"
    first, last = row.get("First name", first), row.get("Last name", row.get("Surname", last))
    return f"{first.strip()} {last.strip()}".strip() or key_of(row)


@dataclass(frozen=True)
class File:
    """A notebook that was handed in."""

    #: Where it is, where it was in what the platform gave, and of which set it is.
    path: Path
    shown: str
    set: str
    #: What it holds, or why that cannot be read.
    notebook: nbformat.NotebookNode | None
    problem: str
    #: How many cells are not as they were released.
    changed: int

    @property
    def when(self):
        """When it was handed in, by its own date."""
        return datetime.fromtimestamp(self.path.stat().st_mtime)

    @property
    def state(self):
        """What is in it, in words."""
        if self.problem:
            return "cannot be read"
        return f"{self.changed} cell{'s' * (self.changed != 1)} changed" * bool(self.changed) or (
            "as released"
        )

    def __str__(self):
        return f"{self.path.name} of {self.when:%Y-%m-%d %H:%M} ({self.state})"


def open_file(path, shown, name, released):
    """A `File` of a set, with the released notebook to compare it with."""
    try:
        notebook = read_submission(path)
    except Exception as error:  # whatever a broken file makes nbformat raise
        why = f"{type(error).__name__}: {str(error)[:200]}"
        return File(path, shown, name, None, f"not graded: cannot be read ({why})", 0)
    given = {"", *(_without_id(cell.source) for cell in released.cells)}
    # What a lecturer corrected since is no answer.
    texts = {cell.id for cell in released.cells if not cell_name(cell)}
    changed = [
        cell
        for cell in notebook.cells
        if _without_id(cell.source) not in given and cell.id not in texts
    ]
    return File(path, shown, name, notebook, "", len(changed))


def _without_id(source):
    """A cell's source without comments and a student's id, which are no answer yet."""
    return re.sub(r"^(student = |#).*\n?", "", source, flags=re.M).strip()


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


def collect(source, released, roster, unpacked, use=()):
    """Which file is whose submission to which set.

    Parameters
    ----------
    source : Path
        A folder or a zip: of Moodle, with a folder ``Name_id_assignsubmission_file`` a student; of
        Canvas, with files ``lastfirst_id_id_set.ipynb``; or with one folder a student.
    released : dict
        Released notebooks by the names of the sets, with which the files' names begin.
    roster : list of dict
        Rows of a table of students, or none.
    unpacked : Path
        An empty folder, in which a zip is unpacked.
    use : list of str, optional
        Files of the source that a lecturer wants to count, the last word last.

    Returns
    -------
    found : dict
        `File` by (set, student).
    remarks : dict
        Lists of what should be known, by (set, student); the set is "" for what belongs to none.
    """
    if not source.is_dir():
        source = unpack(source, unpacked)
    students = {name: key_of(row) for row in roster for name in _names_of(row)}
    files = [
        file
        for file in sorted(source.rglob("*"))
        if file.suffix.lower() == ".ipynb"
        and file.is_file()
        and not {".ipynb_checkpoints", "__MACOSX"} & set(file.parts)
    ]
    folders = sorted(path for path in source.glob("*") if path.is_dir() and path.name != "__MACOSX")
    if not files and not folders:
        raise SystemExit(
            f"{source} has no notebooks; give what the platform gives, or one folder a student"
        )
    given, remarks = {}, {}
    for file in files:
        shown = file.relative_to(source)
        name, user, stem = _owner(shown)
        student = students.get(user) or students.get(letters(name)) or name
        which = next((one for one in released if stem.lower().startswith(one.lower())), "")
        notes = remarks.setdefault((which, student), [])
        if roster and student not in students.values() and not notes:
            notes.append(STRANGER)
        if which and name:
            opened = open_file(file, shown.as_posix(), which, released[which])
            given.setdefault((which, student), []).append(opened)
        else:
            notes.append(f"not graded: {shown} is not <student>/…/<set>.ipynb")
    for path in folders:
        if not any(path in file.parents for file in files):
            name, user, _ = _owner(Path(path.name, "none"))
            student = students.get(user) or students.get(letters(name)) or name
            remarks["", student] = ["not graded: there is no notebook in this folder"]
    found = {}
    for key, candidates in given.items():
        found[key], note = _which_counts(candidates, use)
        remarks[key] += [note] if note else []
    return found, remarks


def _which_counts(files, use):
    """Which of a student's files counts, and a remark if there are several."""

    def rank(file):
        chosen = use.index(file.shown) + 1 if file.shown in use else 0
        # Nobody loses answers to a file without any; nor is one that may have some passed over.
        worth = 2 if file.changed else 1 if file.problem else 0
        own_name = file.path.stem.lower() == file.set.lower()
        return chosen, worth, file.when, own_name

    first, *others = sorted(files, key=rank, reverse=True)
    if not others:
        return first, ""
    why = (
        "as you chose"
        if first.shown in use
        else "the newest with answers"
        if first.changed
        else "for it may have answers"
        if first.problem
        else "the newest, none has answers"
    )
    return first, (
        f"handed in more than once: {first} counts, {why}; not {', '.join(map(str, others))}"
    )


def _owner(shown):
    """Whose a file is, the number that the platform has for them, and what the file is called."""
    if len(shown.parts) == 1:
        match = CANVAS.fullmatch(shown.name)
        # Without a folder and without such a name it is nobody's.
        return (match["name"], match["user"], Path(match["file"]).stem) if match else ("", "", "")
    match = MOODLE.fullmatch(shown.parts[0].rstrip("_"))
    return (match["name"], match["user"], shown.stem) if match else (shown.parts[0], "", shown.stem)


def unpack(archive, folder):
    """Unpack a zip, with the times of its files; they tell which is the newest."""
    if not archive.exists():
        raise SystemExit(f"{archive} is not there; give the zip of a platform, or a folder")
    try:
        with ZipFile(archive) as opened:
            for info in opened.infolist():
                path = opened.extract(info, folder)
                when = time.mktime((*info.date_time, 0, 0, -1))
                os.utime(path, (when, when))
    except BadZipFile:
        raise SystemExit(
            f"{archive} is no zip, or not all of it; download it again, or give a folder"
        ) from None
    return folder


def show(source, released, roster, use):
    """Print which file is whose, what is in it, and what should be known."""
    rows = [("student", "name", "set", "date", "state", "file", "remarks")]
    names = {key_of(row): full_name(row) for row in roster}
    with TemporaryDirectory() as unpacked:
        found, remarks = collect(source, released, roster, Path(unpacked), use)
        for name, who in sorted(remarks, key=lambda key: key[::-1]):
            file, notes = found.get((name, who)), "; ".join(remarks[name, who])
            told = (f"{file.when:%Y-%m-%d %H:%M}", file.state, file.shown) if file else ("-",) * 3
            rows.append(
                (who or "-", names.get(who, "-"), name.partition("_")[0] or "-", *told, notes)
            )
    came = {who for _, who in remarks}
    rows += [(who, names[who], *"----", "nothing handed in") for who in names if who not in came]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (text.ljust(width) for text, width in zip(row, widths, strict=True))
        print("  ".join(cells).rstrip())


def similar(notebooks, released, originals):
    """Hints that submissions are alike, whatever their names, numbers and comments.

    Parameters
    ----------
    notebooks : dict
        Notebooks by student.
    released : NotebookNode
        What was given out, of which nothing counts.
    originals : dict
        Notebooks that were handed in by nobody, by what they are called.

    Returns
    -------
    list of (str, str)
        Student and hint.
    """
    found = []
    for kind, least, told in ((passages, ENOUGH, ""), (sayings, FEW, "its words are ")):
        given = kind(released)
        known = {name: kind(one) - given for name, one in (originals | notebooks).items()}
        for first, second in combinations(known, 2):
            fewer = min(len(known[first]), len(known[second]))
            both = len(known[first] & known[second])
            if fewer >= least and both >= ALIKE * fewer:
                for one, other in ((first, second), (second, first)):
                    if one in notebooks:
                        found.append((one, f"{HINT} {told}{both / fewer:.0%} as in {other}"))
    return found


def _runs(parts):
    """All that stand next to each other, as many as make a passage."""
    return {tuple(parts[k : k + PASSAGE]) for k in range(len(parts) - PASSAGE + 1)}


def sayings(notebook):
    """Short passages of a notebook's answers in words."""
    texts = [
        cell.source.lower()
        for cell in notebook.cells
        if cell.cell_type == "markdown" and (cell.metadata.get("nbgrader") or {}).get("solution")
    ]
    return set().union(*(_runs(re.findall(r"\w+", text)) for text in texts))


def passages(notebook):
    """Short passages of a notebook's code, in which all names are one, and all numbers."""
    kinds = []
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        try:
            for token in tokenize.generate_tokens(io.StringIO(cell.source).readline):
                if token.type == tokenize.OP or keyword.iskeyword(token.string):
                    kinds.append(token.string)
                elif token.type in (tokenize.NAME, tokenize.NUMBER, tokenize.STRING):
                    kinds.append(tokenize.tok_name[token.type])
        except (tokenize.TokenError, SyntaxError):
            continue
    return _runs(kinds)
