"""Where nbgrader finds and puts things: the sources are here, all else goes to build/."""

import sys
from pathlib import Path

from nbconvert.preprocessors.sanitize import SanitizeHTML
from nbgrader.apps.api import NbGraderAPI
from nbgrader.preprocessors import CheckCellMetadata, LimitOutput, SaveAutoGrades

sys.path.insert(0, str(Path(__file__).resolve().parent))
from judge import Judge

c = get_config()  # noqa: F821

# Name of the course in the grade book.
c.CourseDirectory.course_id = "freeseg"

c.CourseDirectory.root = str(Path(__file__).resolve().parent)
c.CourseDirectory.source_directory = "."
for step in ("release", "submitted", "autograded", "feedback"):
    c.CourseDirectory[f"{step}_directory"] = f"build/{step}"
c.CourseDirectory.db_url = f"sqlite:///{Path(__file__).resolve().parent}/build/gradebook.db"

# Answers are not executed here, but judged from outside of the process in which they run.
c.Autograde.autograde_preprocessors = [Judge, LimitOutput, SaveAutoGrades, CheckCellMetadata]
# Above it in the cell stands a value of the right shape, so that the notebook runs.
c.ClearSolutions.code_stub = {"python": "# YOUR CODE HERE"}
c.ClearSolutions.text_stub = "YOUR ANSWER HERE"

# A browser that shows an answer, in feedback or to grade it by hand, runs none of its code.
c.HTMLExporter.preprocessors = [SanitizeHTML]
c.SanitizeHTML.tags = [*SanitizeHTML().tags, "details", "summary"]

# What is made here is no assignment.
sources = NbGraderAPI.get_source_assignments
NbGraderAPI.get_source_assignments = lambda api: sources(api) - {"build", "__pycache__"}
