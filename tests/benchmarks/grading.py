"""Time the grading of a class: ``python tests/benchmarks/grading.py [students [set [jobs]]]``.

Releases a problem set, by default the first, hands in as many synthetic
submissions, every fourth one unsolved, and grades them in a folder of their
own, feedback and all, some at once.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from test_assignments import NAMES, read
from test_first_week import Course, hand_in, read_released, solve


def main(students=20, number=1, jobs=2):
    """Print the time of release and grading."""
    part = f"ps{number}"
    with TemporaryDirectory() as folder:
        course = Course(Path(folder).resolve(), NAMES[part])
        begin = time.perf_counter()
        course.release()
        print(f"release              {time.perf_counter() - begin:6.1f} s")
        unsolved = read_released(course, NAMES[part])
        solved = solve(unsolved, read(part))
        for k in range(students):
            file = course.submissions / f"student-{k:03d}" / f"{NAMES[part]}.ipynb"
            hand_in(file, solved if k % 4 else unsolved)
        begin = time.perf_counter()
        rows = course.graded(jobs=jobs).values()
        taken = time.perf_counter() - begin
    print(f"{students:3d} submissions      {taken:6.1f} s, {taken / students:.1f} s each")
    print(f"{sum(float(row[part]) > 0 for row in rows):3d} with points")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
