"""Time the grading of a class: ``python tests/benchmarks/grading.py [students]``.

Releases the first problem set, hands in as many synthetic submissions, every
fourth one unsolved, and grades them in a folder of their own, feedback and all.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from test_assignments import PS1, Course, read, solve


def main(students=20):
    """Print the time of release and grading."""
    with TemporaryDirectory() as folder:
        course = Course(Path(folder).resolve(), PS1, timeout=30)
        begin = time.perf_counter()
        unsolved = read(PS1, course.release())
        print(f"release              {time.perf_counter() - begin:6.1f} s")
        solved = solve(unsolved, read(PS1))
        for number in range(students):
            course.submit(f"student-{number:03d}", PS1, solved if number % 4 else unsolved)
        begin = time.perf_counter()
        rows = course.graded().values()
        taken = time.perf_counter() - begin
    print(f"{students:3d} submissions      {taken:6.1f} s, {taken / students:.1f} s each")
    print(f"{sum(row['score'] == row['max_score'] for row in rows):3d} with full marks")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
