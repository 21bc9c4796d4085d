"""Find who handed in what, in what a learning platform gives, and which are alike."""

import io
import keyword
import os
import re
import time
import tokenize
import unicodedata
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZipFile

#: A folder that Moodle makes for each student, and a file as Canvas names it.
MOODLE = re.compile(r"(?P<name>.+)_(?P<user>\d+)_assignsubmission_\w+")
CANVAS = re.compile(r"(?P<name>[^_]+)_(?:LATE_)?(?P<user>\d+)_\d+_(?P<file>.+)", re.I)
#: Columns of a roster that name a student; the first of them that is there and filled is used.
KEYS = ("student", "Username", "SIS Login ID", "SIS User ID", "ID number", "Email address", "ID")
#: Tokens of a passage that is compared, passages that are enough to tell, and the share that is
#: worth a look.
PASSAGE, ENOUGH, ALIKE = 10, 30, 0.8


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


def collect(source, sets, roster, unpacked):
    """Which file is whose submission to which set.

    Parameters
    ----------
    source : Path
        A folder or a zip: of Moodle, with a folder ``Name_id_assignsubmission_file`` a student; of
        Canvas, with files ``lastfirst_id_id_set.ipynb``; or with one folder a student.
    sets : collection of str
        Names of the sets, with which the notebooks' names begin.
    roster : list of dict
        Rows of a table of students, or none.
    unpacked : Path
        An empty folder, in which a zip is unpacked.

    Returns
    -------
    found : dict
        File by (set, student).
    remarks : dict
        Lists of what should be known, by (set, student); the set is "" for what belongs to none.
    """
    if source.suffix.lower() == ".zip":
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
        which = next((one for one in sets if stem.lower().startswith(one.lower())), "")
        notes = remarks.setdefault((which, student), [])
        if roster and student not in students.values() and not notes:
            notes.append("not in the roster")
        if which and name:
            given.setdefault((which, student), []).append((stem.lower() != which.lower(), file))
        else:
            notes.append(f"not graded: {shown} is not <student>/…/<set>.ipynb")
    for path in folders:
        if not any(path in file.parents for file in files):
            name, user, _ = _owner(Path(path.name, "none"))
            student = students.get(user) or students.get(letters(name)) or name
            remarks["", student] = ["not graded: there is no notebook in this folder"]
    found = {}
    for key, candidates in given.items():
        # The set's own name comes first, then the newest.
        ranked = sorted(candidates, key=lambda one: (one[0], -one[1].stat().st_mtime))
        found[key] = ranked[0][1]
        if others := ", ".join(file.name for _, file in ranked[1:]):
            remarks[key].append(f"handed in more than once: {found[key].name} counts, not {others}")
    return found, remarks


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
    with ZipFile(archive) as opened:
        for info in opened.infolist():
            path = opened.extract(info, folder)
            when = time.mktime((*info.date_time, 0, 0, -1))
            os.utime(path, (when, when))
    return folder


def show(source, sets, roster):
    """Print which file is whose, and what should be known."""
    with TemporaryDirectory() as unpacked:
        found, remarks = collect(source, sets, roster, Path(unpacked))
        for key in sorted(remarks):
            file = found[key].name if key in found else "-"
            print(" | ".join([key[1], key[0], file, *remarks[key]]))


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
    given = passages(released)
    known = {name: passages(one) - given for name, one in (originals | notebooks).items()}
    found = []
    for first, second in combinations(known, 2):
        least = min(len(known[first]), len(known[second]))
        both = len(known[first] & known[second])
        if least >= ENOUGH and both >= ALIKE * least:
            for one, other in ((first, second), (second, first)):
                if one in notebooks:
                    found.append((one, f"a hint: {both / least:.0%} as in {other}"))
    return found


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
    return {tuple(kinds[k : k + PASSAGE]) for k in range(len(kinds) - PASSAGE + 1)}
