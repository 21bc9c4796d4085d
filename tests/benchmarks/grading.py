"""Time the grading of a class: ``python tests/benchmarks/grading.py [students [set]]``.

Releases a problem set, by default the first, hands in as many synthetic
submissions, every fourth one unsolved, and grades them in a folder of their
own, feedback and all.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from test_assignments import SETS, Course, read, solve


def main(students=20, number=1):
    """Print the time of release and grading."""
    name = SETS[number - 1]
    with TemporaryDirectory() as folder:
        course = Course(Path(folder).resolve(), name, timeout=30)
        begin = time.perf_counter()
        unsolved = read(name, course.release())
        print(f"release              {time.perf_counter() - begin:6.1f} s")
        solved = solve(unsolved, read(name))
        for k in range(students):
            course.submit(f"student-{k:03d}", name, solved if k % 4 else unsolved)
        begin = time.perf_counter()
        rows = course.graded().values()
        taken = time.perf_counter() - begin
    print(f"{students:3d} submissions      {taken:6.1f} s, {taken / students:.1f} s each")
    print(f"{sum(float(row['score']) > 0 for row in rows):3d} with points")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
