"""What a release promises: names documented, data with sources, links that lead somewhere."""

import csv
import importlib
import importlib.util
import inspect
import json
import re
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from refresh_notebooks import every_notebook

import freeseg as fs

ROOT = Path(__file__).parent.parent
PAGES = [
    *sorted([*ROOT.glob("*.md"), *ROOT.glob("data/*.md"), *ROOT.glob("docs/*.md")]),
    ROOT / "notebooks/assignments/README.md",
    *every_notebook(),
]
REFERENCE = sorted((ROOT / "docs/api").glob("*.rst"))
#: Packages and modules whose names are public as well.
PUBLIC = ["display", "maps", "metrics", "plotting", "reactive", "studies", "teaching", "trackers"]


def script(file):
    """A script of docs/, imported."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


course = script(ROOT / "docs/course.py")


def public_names(module):
    """What a module offers: its `__all__`, or else what it defines without an underscore."""
    defined = (
        name
        for name, value in vars(module).items()
        if not name.startswith("_") and getattr(value, "__module__", None) == module.__name__
    )
    return set(getattr(module, "__all__", defined))


def in_reference():
    """Full names of all that the reference shows, by the directives that it is made of."""
    names = set()
    for page in REFERENCE:
        module = ""
        lines = page.read_text(encoding="utf-8").splitlines()
        for line, below in zip(lines, [*lines[1:], ""], strict=True):
            found = re.match(r"\.\. (?:py:)?(currentmodule|auto\w+):: (\S+)", line)
            if not found:
                continue
            kind, name = found.groups()
            if kind == "currentmodule":
                module = name
            elif kind == "automodule":
                names.add(name)
                chosen = below.partition(":members:")[2].replace(",", " ").split()
                members = chosen or public_names(importlib.import_module(name))
                names |= {f"{name}.{member}" for member in members}
            elif "::" in name or name.startswith("freeseg."):
                names.add(name.replace("::", "."))
            else:
                names.add(f"{module}.{name}")
    return names


def test_the_reference_shows_every_public_name():
    shown = in_reference()
    wanted = {f"freeseg.{name}" for name in fs.__all__}
    for part in PUBLIC:
        module = importlib.import_module(f"freeseg.{part}")
        for name in public_names(module):
            # What the package itself offers is shown under the shorter name.
            short = name in fs.__all__ and getattr(fs, name) is getattr(module, name)
            wanted.add(f"freeseg.{name}" if short else f"freeseg.{part}.{name}")
    assert wanted - {"freeseg.trackers", "freeseg.reactive"} <= shown
    assert len(shown) > 200


def test_the_reference_shows_nothing_that_is_not_there():
    for name in in_reference():
        parts = name.split(".")
        value = fs
        for depth, part in enumerate(parts[1:], 2):
            # A function may hide the module of the same name: `freeseg.plan`.
            if not hasattr(value, part):
                value = importlib.import_module(".".join(parts[: depth - 1]))
            value = getattr(value, part)
        assert inspect.getdoc(value) or name == "freeseg.plotting.PALETTE", name


@pytest.mark.parametrize(
    "file",
    sorted(
        file.name for file in (ROOT / "data").iterdir() if file.suffix not in (".py", ".md", "")
    ),
)
def test_every_file_of_data_has_its_source(file):
    text = (ROOT / "data/README.md").read_text(encoding="utf-8")
    titles = re.findall(r"^## (.+)$", text, re.M)
    assert any(file in title for title in titles), f"data/README.md has no section on {file}"


def anchors(text):
    """What a page's headings are linked as."""
    titles = re.findall(r"^#+ (.+)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def text_of(file):
    """A page's text, without its code."""
    if file.suffix == ".ipynb":
        # Not by nbformat, which checks the outputs, too, and takes ten times as long.
        cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
        text = "\n\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
    else:
        text = file.read_text(encoding="utf-8")
    return re.sub(r"```.*?```|`[^`\n]*`|\$\$.*?\$\$|\$[^$\n]*\$", "", text, flags=re.S)


def broken_links(file, text):
    """Relative links of a page's text that lead nowhere."""
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        if re.match(r"\w+:", link):
            continue
        target = (file.parent / path).resolve() if path else file
        asked = anchor and target.suffix == ".md"
        if not target.exists() or (
            asked and anchor not in anchors(target.read_text(encoding="utf-8"))
        ):
            broken.append(link)
    return broken


@pytest.mark.parametrize("file", PAGES, ids=lambda file: str(file.relative_to(ROOT)))
def test_every_relative_link_leads_somewhere(file):
    assert broken_links(file, text_of(file)) == []


def test_broken_links_are_found():
    file = ROOT / "README.md"
    text = "[a](data/README.md) [b](gone.md) [c](#nowhere) [d](#cite-it) [e](https://x.org/y)"
    assert broken_links(file, text) == ["gone.md", "#nowhere"]


def test_all_that_names_the_version_names_the_same():
    read = {
        name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "CHANGELOG.md")
    }
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    zenodo = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    released = re.findall(r"^## \[(\d.*)\] - (\S+)$", read["CHANGELOG.md"], re.M)
    version, day = released[0]
    assert version == fs.__version__ == citation["version"] == zenodo["version"]
    assert day == str(citation["date-released"]) == zenodo["publication_date"]
    assert citation["title"] == zenodo["title"]
    assert f"version {fs.__version__}," in read["README.md"]


def test_the_citation_has_what_its_format_asks_for():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= citation.keys()
    assert citation["type"] in ("software", "dataset")


def pins(file):
    """Names and versions that a file of requirements pins."""
    lines = (line.split("#")[0].strip() for line in file.read_text(encoding="utf-8").splitlines())
    return {Requirement(line).name: line for line in lines if line and not line.startswith("-")}


def test_the_book_s_packages_are_pinned_beside_the_reader_s():
    book, reader = pins(ROOT / "docs/requirements.txt"), pins(ROOT / "environment.txt")
    assert book.keys() & reader.keys() == set()
    assert all(re.fullmatch(r"[a-z0-9-]+==[0-9][0-9a-z.]*", line) for line in book.values())


@pytest.mark.parametrize("file", sorted((ROOT / ".github").rglob("*.yml")), ids=lambda f: f.name)
def test_workflows_and_forms_can_be_read(file):
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    if file.parent.name == "workflows":
        commands = [
            step["run"]
            for job in content["jobs"].values()
            for step in job["steps"]
            if "run" in step
        ]
        for script in re.findall(r"[\w./]+/[\w.]+(?:\.py|run)\b", " ".join(commands)):
            assert (ROOT / script).exists(), script


def test_the_course_plan_says_what_follows_from_the_notebooks():
    text = course.COURSE.read_text(encoding="utf-8")
    assert course.written(text) == text, "run python docs/course.py"
    rule = course.WORDS_A_MINUTE, course.MINUTES_A_CELL, course.MINUTES_AN_EXERCISE
    told = r"(\d+) words of prose a minute, (\d+) minute[\s\S]+?(\d+) minutes for an exercise"
    assert re.search(told, text).groups() == tuple(map(str, rule))


def test_the_course_plan_lists_every_lesson_once():
    text = course.COURSE.read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[(\w+)\]", text, re.M)
    assert listed == [file.stem for file in course.lessons().values()]
    assert {"00", "18", "A1", "A2"} <= {name[:2] for name in listed}


def test_lessons_build_on_what_they_name():
    direct = course.needs()
    assert direct["12"] == {"08", "10", "11"}
    assert course.all_needs("12", direct) == {f"{one:02}" for one in range(1, 12)} - {"07"}
    assert direct["18"] == {"00"}  # 14 is said to help
    assert direct["17"] == set()


def test_hours_grow_with_words_cells_and_exercises(tmp_path):
    def lasts(words, cells, exercises):
        tasks = "".join(f"\n{one + 1}. x" for one in range(exercises))
        prose = "word " * (words - 1 - 2 * exercises) + f"\n\n## Exercises\n{tasks}"
        sources = [("markdown", prose), *[("code", "x")] * cells]
        found = [{"cell_type": kind, "source": [text]} for kind, text in sources]
        file = tmp_path / f"{words}_{cells}_{exercises}.ipynb"
        file.write_text(json.dumps({"cells": found}), encoding="utf-8")
        return course.hours(file)

    assert lasts(1200, 0, 0) == pytest.approx(1 / 6)
    assert lasts(1200, 30, 0) == pytest.approx(1 / 6 + 1 / 2)
    assert lasts(1200, 30, 3) == pytest.approx(1 / 6 + 1 / 2 + 3 / 2)


def plans():
    """Plans by weeks, by their titles."""
    parts = re.split(r"^## (.+)$", course.COURSE.read_text(encoding="utf-8"), flags=re.M)
    titles = zip(parts[1::2], parts[2::2], strict=True)
    return {title: plan for title, text in titles if (plan := list(course.weeks(text)))}


@pytest.mark.parametrize("title", plans())
def test_no_week_needs_a_lesson_or_a_set_that_comes_later(title):
    direct, sets, done, open_sets = course.needs(), course.sets(), set(), set()
    for row, read, chosen, given, due in plans()[title]:
        for number in read:
            assert direct[number] <= done, row
            done.add(number)
        assert all(direct[number] <= done for number in chosen), row
        assert due <= open_sets, row
        assert all(sets[one][0] <= done for one in given), row
        open_sets = open_sets - due | given
    assert not open_sets


def test_there_are_plans_of_ten_and_of_four_weeks():
    assert sorted(map(len, plans().values())) == [4, 10]
    ten = next(plan for plan in plans().values() if len(plan) == 10)
    assert set().union(*(due for *_, due in ten)) == set(course.sets())
    assert {one for _, read, chosen, *_ in ten for one in read + chosen} == set(course.lessons())


def commands():
    """Of each file of data/ in the table of how to compute it again: its row's second column."""
    text = (ROOT / "docs/compute_again.md").read_text(encoding="utf-8")
    rows = [row.strip("|").split("|") for row in re.findall(r"^\| `.*\|$", text, re.M)]
    return {file: row[1] for row in rows for file in re.findall(r"`(\S+)`", row[0])}


def test_every_file_of_data_has_a_row_that_says_how_it_is_written():
    kept = {
        file.name for file in (ROOT / "data").iterdir() if file.suffix not in (".py", ".md", "")
    }
    assert commands().keys() - {"codecheck.yml", "ro-crate-metadata.json"} == kept


@pytest.mark.parametrize(("file", "command"), commands().items())
def test_the_command_that_writes_a_file_is_there_and_names_it(file, command):
    if "by hand" in command or " -c " in command:
        return
    name, *told = re.search(r"`python (\S+)(.*?)`", command).groups()
    text = (ROOT / name).read_text(encoding="utf-8")
    for option in re.findall(r"--\w+", " ".join(told)):
        assert f'"{option}"' in text, option
    assert file in text or f"data/{file}" in command
    sources = (ROOT / "data/README.md").read_text(encoding="utf-8")
    assert Path(name).name in sources or file.endswith((".yml", ".json"))


def test_the_map_s_command_writes_the_map(tmp_path):
    code = re.search(r"-c '(.+?)'", commands()["floor_plan.pgm"])[1]
    exec(code.replace("data/floor_plan.yaml", str(tmp_path / "floor_plan.yaml")), {})
    for file in ("floor_plan.yaml", "floor_plan.pgm"):
        assert (tmp_path / file).read_bytes() == (ROOT / "data" / file).read_bytes()


def test_the_readme_s_example_of_a_finding_is_one():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    version, claim, number, file = re.search(
        r"> freeseg (\S+), claim (C\d+) \(notebook (\w\d)\), (data/\S+)\.$", text, re.M
    ).groups()
    assert version == fs.__version__
    crate = json.loads((ROOT / "ro-crate-metadata.json").read_text(encoding="utf-8"))["@graph"]
    (review,) = (one for one in crate if one["@id"] == f"#{claim}-verdict")
    notebook, *files = (one["@id"] for one in review["isBasedOn"])
    assert notebook.startswith(f"notebooks/{number}_")
    assert file in files


def terms():
    """Rows of the book's terms, each with the section that teaches it."""
    with (ROOT / "docs/terms.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.parametrize("row", terms(), ids=lambda row: row["term"])
def test_a_term_of_the_book_has_a_section_that_names_it(row):
    file = ROOT / row["page"]
    text = text_of(file.with_suffix(".ipynb" if file.parent.name == "notebooks" else ".md"))
    if row["page"] == "docs/index":
        text += text_of(ROOT / "README.md")
    # Without code in headings, as `text_of` is.
    heads = [" ".join(title.split()) for title in re.findall(r"^#+ (.+)$", text, re.M)]
    assert any(" ".join(row["heading"].replace("sat ", "").split()) == one for one in heads)
    assert all(word[:5].lower() in text.lower() for word in row["term"].split())


def test_no_term_of_the_book_stands_twice():
    names = [row["term"] for row in terms()]
    assert len(names) == len(set(names)) > 50
