"""Where nbgrader finds and puts things: the sources are here, all else goes to build/."""

import json
import re
from pathlib import Path

from nbconvert.preprocessors.sanitize import SanitizeHTML
from nbgrader.preprocessors import NbGraderPreprocessor

c = get_config()  # noqa: F821

# Name of the course: another name makes other worlds. Change it before the first release.
c.CourseDirectory.course_id = "freeseg"

c.CourseDirectory.root = str(Path(__file__).resolve().parent)
c.CourseDirectory.source_directory = "."
for step in ("release", "submitted", "autograded", "feedback"):
    c.CourseDirectory[f"{step}_directory"] = f"build/{step}"
c.CourseDirectory.db_url = f"sqlite:///{Path(__file__).resolve().parent}/build/gradebook.db"

# Longest time that one cell of a submission may take (s); what takes longer gets no points.
c.Execute.timeout = 30
# A busy machine passes on late what a cell printed; nbgrader would give up the whole notebook.
c.Execute.iopub_timeout = 30
# Kernels talk to this machine alone; each would warn that it is not encrypted.
c.Execute.extra_arguments = ["--IPKernelApp.log_level=40"]
# Above it in the cell stands a value of the right shape, so that the notebook runs.
c.ClearSolutions.code_stub = {"python": "# YOUR CODE HERE"}
c.ClearSolutions.text_stub = "YOUR ANSWER HERE"

# A browser that shows an answer, in feedback or to grade it by hand, runs none of its code.
c.HTMLExporter.preprocessors = [SanitizeHTML]
c.SanitizeHTML.tags = [*SanitizeHTML().tags, "details", "summary"]


class SetCourse(NbGraderPreprocessor):
    """Write the course's name into the cell that makes the seed."""

    def preprocess_cell(self, cell, resources, cell_index):
        """Replace the line that names the course."""
        if cell.metadata.get("nbgrader", {}).get("grade_id") == "setup":
            converter = self.parent.parent
            name = json.dumps(converter.coursedir.course_id, ensure_ascii=False)
            line = f"course = {name}"
            cell.source = re.sub(r"^course = .*$", lambda _: line, cell.source, flags=re.M)
        return cell, resources


c.GenerateAssignment.preprocessors.prepend([SetCourse])
