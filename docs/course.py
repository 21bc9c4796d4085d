"""Write the hours and what builds on what into the course plan: ``python docs/course.py``.

The tables of ``docs/teach_a_course.md`` are written by hand, but for what follows from the
notebooks: what a lesson builds on, from its line "You need", and how long a student takes, which
is an estimate by a rule. A test compares.
"""

import json
import math
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COURSE = ROOT / "docs/teach_a_course.md"
SETS = ROOT / "notebooks/assignments/README.md"
#: The rule: how fast one reads, and what it takes to run, read and change a cell, and to solve an
#: exercise. The course plan says these numbers, too.
WORDS_A_MINUTE = 120
MINUTES_A_CELL = 1
MINUTES_AN_EXERCISE = 30
KINDS = ("given", "due")


@cache
def cells(lesson, kind):
    """Sources of a lesson's cells of one kind."""
    found = json.loads(lesson.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in found if cell["cell_type"] == kind]


def lessons():
    """Files of the numbered lessons and appendices, by number."""
    found = sorted((ROOT / "notebooks").glob("[0-9A]*_*.ipynb"))
    return {file.name.partition("_")[0]: file for file in found}


def exercises(prose):
    """How many exercises a lesson's prose ends with."""
    part = re.search(r"^## Exercises$(.*?)(?=^## |\Z)", prose, re.M | re.S)
    return len(re.findall(r"^\d+\. ", part[1], re.M)) if part else 0


def hours(lesson):
    """How long a student takes for a lesson by the rule (h)."""
    prose = "\n\n".join(cells(lesson, "markdown"))
    reading = len(re.findall(r"\w+", prose)) / WORDS_A_MINUTE
    running = len(cells(lesson, "code")) * MINUTES_A_CELL
    return (reading + running + exercises(prose) * MINUTES_AN_EXERCISE) / 60


def needs():
    """Numbers of the lessons that each lesson's line "You need" names."""
    direct = {}
    for number, file in lessons().items():
        line = re.search(r"\*\*You need\*\*(.*?)(?=\n\*|\Z)", cells(file, "markdown")[0], re.S)[1]
        # What stands after a semicolon helps, and is not needed.
        asked = re.findall(r"\]\((\w\d)_\w+\.ipynb\)", line.partition(";")[0])
        direct[number] = set(asked)
    return direct


def all_needs(number, direct):
    """Numbers of all lessons that one builds on, through others too."""
    return direct[number].union(*(all_needs(one, direct) for one in direct[number]))


def sets():
    """Of each problem set, by number: the lessons that it needs, and its hours."""
    found = {}
    for row in re.findall(r"^\| \[ps\d.*$", SETS.read_text(encoding="utf-8"), re.M):
        name, _, asked, length, _ = (part.strip() for part in row.strip("|").split("|"))
        found[int(name[3])] = set(expand(asked)), float(length)
    return found


def expand(text):
    """Numbers of lessons in a text such as "01 to 03, 05"."""
    for first, last in re.findall(r"(\w\d) to (\w\d)", text):
        yield from (f"{number:02}" for number in range(int(first), int(last) + 1))
    yield from re.findall(r"\b\w\d\b", text)


def in_short(numbers):
    """Numbers of lessons as a text, three or more in a row as "01 to 03"."""
    runs = []
    for number in sorted(numbers):
        if runs and number.isdigit() and int(number) == int(runs[-1][-1]) + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    parts = [[f"{run[0]} to {run[-1]}"] if len(run) > 2 else run for run in runs]
    return ", ".join(one for part in parts for one in part)


def half_hours(length):
    """A length (h) as a text, to the next half hour above."""
    return f"{math.ceil(2 * length) / 2:g}"


def weeks(text):
    """Rows of a plan by weeks: lessons to read, lessons to choose from, sets given and due."""
    for row in re.findall(r"^\| \d+ \|.*$", text, re.M):
        parts = [part.strip() for part in row.strip("|").split("|")]
        read, _, chosen = parts[1].partition("one of")
        numbers = [re.findall(r"\[(\w\d)\]", part) for part in (read, chosen)]
        yield row, *numbers, *(set(map(int, re.findall(rf"(\d) {w}", parts[4]))) for w in KINDS)


def with_hours(text):
    """A plan by weeks with the hours of each, and of all weeks together.

    A set counts evenly in the weeks after that in which it is given; of a choice, the longest.
    """
    plan, files = list(weeks(text)), lessons()
    given = {one: week for week, (*_, kinds, _) in enumerate(plan) for one in kinds}
    due = {one: week for week, (*_, kinds) in enumerate(plan) for one in kinds}
    total = 0
    for week, (row, read, chosen, *_) in enumerate(plan):
        length = sum(hours(files[one]) for one in read)
        length += max((hours(files[one]) for one in chosen), default=0)
        for one, (_, long) in sets().items():
            if one in due and given[one] < week <= due[one]:
                length += long / (due[one] - given[one])
        total += length
        text = text.replace(row, re.sub(r"[^|]*\|$", f" {half_hours(length)} |", row))
    return re.sub(r"(In all, )[\d.]+( hours)", rf"\g<1>{round(total)}\2", text)


def with_lessons(text):
    """The table of lessons with the hours of each and what it builds on."""
    direct, files = needs(), lessons()
    for row in re.findall(r"^\| \[\w\d_.*$", text, re.M):
        parts = row.split(" | ")
        number = parts[0][3:5]
        first, all_of_them = direct[number], all_needs(number, direct)
        rest = f" ({in_short(all_of_them - first)})" if all_of_them - first else ""
        parts[1:3] = half_hours(hours(files[number])), (in_short(first) or "–") + rest
        text = text.replace(row, " | ".join(parts))
    return text


def written(text):
    """The text of the course plan, with all that follows from the notebooks."""
    parts = re.split(r"(?=^## )", text, flags=re.M)
    return "".join(with_lessons(with_hours(part)) for part in parts)


if __name__ == "__main__":
    COURSE.write_text(written(COURSE.read_text(encoding="utf-8")), encoding="utf-8")
