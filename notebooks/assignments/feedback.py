"""Write what a student gets back: a page that needs nothing else, no network and no program."""

import re
from html import unescape
from zipfile import ZIP_DEFLATED, ZipFile

import bleach
from jinja2 import pass_context
from latex2mathml.converter import convert
from nbconvert.exporters import HTMLExporter

#: Tags and attributes of formulas, of which none runs a program or loads anything.
MATHML = (
    *("math", "mrow", "mi", "mo", "mn", "mtext", "mspace", "msub", "msup", "msubsup", "mfrac"),
    *("msqrt", "mroot", "munder", "mover", "munderover", "mtable", "mtr", "mtd", "mstyle"),
    *("mpadded", "mphantom", "menclose"),
)
MATH_ATTRIBUTES = (
    *("display", "displaystyle", "scriptlevel", "mathvariant", "stretchy", "fence", "form"),
    *("separator", "accent", "lspace", "rspace", "minsize", "maxsize", "linethickness"),
    *("columnalign", "columnspacing", "rowspacing", "width", "xmlns"),
)
#: Formulas in a rendered text, and code, in which none are; and links to what is not beside a page.
FORMULA = re.compile(r"<(?:code|pre)\b.*?</(?:code|pre)>|\$\$(.+?)\$\$|\$([^$]+?)\$", re.S)
DEAD_LINK = re.compile(r'<a href="(?!https?:|mailto:|#)[^"]*"[^>]*>(.*?)</a>', re.S)

PAGE = """
{%- extends 'classic/base.html.j2' -%}
{%- set page = resources.page -%}
{%- block header -%}
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{{ page.title | e }}</title>
{% for css in resources.inlining.css %}<style>{{ css }}</style>{% endfor %}
<style>
body { font: 16px/1.5 sans-serif; max-width: 52em; margin: 2em auto; padding: 0 1em; }
pre { font-size: 14px; line-height: 1.35; white-space: pre-wrap; }
td, th { padding: 0.1em 1em 0.1em 0; text-align: left; }
img { max-width: 100%; }
div.prompt, a.anchor-link { display: none; }
div.input_area { background: #f6f6f6; padding: 0 0.8em; overflow-x: auto; }
div.graded { border-left: 4px solid #3b6ea5; padding-left: 0.8em; margin: 1em 0; }
p.comment { background: #fff6d6; padding: 0.5em 0.8em; }
</style>
</head>
{%- endblock header -%}
{%- block body -%}
<body>
<h1>{{ page.title | e }}</h1>
<p>{{ page.student | e }}: <b>{{ page.score | e }}</b></p>
{% if page.remarks %}
<ul>{% for remark in page.remarks %}<li>{{ remark | e }}</li>{% endfor %}</ul>
{% endif %}
{% if page.grades %}
<table>
{% for name, told in page.grades.items() %}
<tr><td><a href="#graded-{{ name | e }}">{{ name | e }}</a></td><td>{{ told | e }}</td></tr>
{% endfor %}
</table>
{% endif %}
<hr>
{{ super() }}
</body>
{%- endblock body -%}
{%- block any_cell scoped -%}
{%- set name = (cell.metadata.nbgrader or {}).get('grade_id') -%}
{%- if name in page.grades -%}
<div class="graded" id="graded-{{ name | e }}">
<p><b>{{ name | e }}: {{ page.grades[name] | e }}</b></p>
{{ super() }}
</div>
{%- else -%}
{{ super() }}
{%- endif -%}
{%- if page.comments.get(name) -%}
<p class="comment"><b>Comment:</b> {{ page.comments[name] | e }}</p>
{%- endif -%}
{%- endblock any_cell -%}
{%- block output_area_prompt -%}{%- endblock output_area_prompt -%}
{%- block execute_result -%}{#- points, which stand above -#}{%- endblock execute_result -%}
{%- block footer -%}
</html>
{%- endblock footer -%}
"""


def as_mathml(found):
    """A formula that was found in a text as what a browser draws by itself."""
    # What is unsafe was escaped in the notebook's text, and again when that was rendered.
    formula = unescape(unescape(found[1] or found[2] or ""))
    if not formula:  # code, in which dollars are dollars
        return found[0]
    try:
        drawn = convert(formula, display="block" if found[1] else "inline")
    except Exception:  # whatever a student's unfinished formula makes of it
        return found[0]
    return bleach.clean(drawn, tags=MATHML, attributes=list(MATH_ATTRIBUTES), strip=True)


class Page(HTMLExporter):
    """Writes judged notebooks as pages.

    Parameters
    ----------
    config : Config
        Of the course, as it says what is sanitised.
    """

    def __init__(self, config):
        super().__init__(config=config, template_name="classic", raw_template=PAGE)

    @pass_context
    def markdown2html(self, context, source):
        """Text with formulas that need no program, and without links to what is not there."""
        text = super().markdown2html(context, source)
        return DEAD_LINK.sub(r"\1", FORMULA.sub(as_mathml, text))

    def write(self, file, told, notebook):
        """Write a page.

        Parameters
        ----------
        file : Path
            The page.
        told : dict
            Texts: "title", "student", "score", a list of "remarks", and what is said of the grades
            and comments of cells by their names.
        notebook : NotebookNode
            The judged notebook; an empty one if it could not be read.
        """
        text, _ = self.from_notebook_node(notebook, {"page": told})
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def write_zip(file, pages):
    """Put pages into a zip by the names that a platform gave what was handed in.

    Parameters
    ----------
    file : Path
        The zip.
    pages : list of (Path, str)
        A page, and where that was for which it is: in a folder of Moodle, or a file of Canvas.
    """
    with ZipFile(file, "w", ZIP_DEFLATED) as archive:
        for page, shown in pages:
            folder, _, name = shown.partition("/")
            # Canvas knows whose a file is by its name.
            inside = f"{folder}/{page.name}" if name else f"{folder.rpartition('.')[0]}.html"
            archive.write(page, inside)
