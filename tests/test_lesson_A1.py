"""Notebook A1: its inequalities are what the worlds measure, and its sizes those of the file."""

import numpy as np
from lessons import lesson
from numpy.testing import assert_allclose
from scipy.optimize import linprog

import freeseg as fs
from freeseg.segments import MARGIN
from freeseg.studies.sizes import LEAST_SIZE, Statements, random_sizes

STEM = "A1_rebuild_the_worlds"
NAMES = "d", "row", "rows", "labels", "A", "tiny", "largest_m", "solve", "best", "u", "radii"
D, _, _, LABELS, A, _, _, _, BEST, _, RADII, B, LEVEL, NARROWEST = lesson(
    STEM, *NAMES, "b", "level", "narrowest", "table_5"
)[:14]


def test_rows_are_the_statements():
    assert len(set(LABELS)) == len(A) == 12 + 7 + 7 * 32 + 5 * 21
    for sizes in random_sizes(20, seed=7):
        slack = B - A[:, :8] @ np.append(sizes, MARGIN)
        # The package asks a little more of starts and goals, and of the smallest obstacle.
        less = [LEAST_SIZE if "size" in k else MARGIN / 2 if "free" in k else 0 for k in LABELS]
        assert_allclose((slack - less).min(), Statements("disc").slack(sizes), atol=1e-12)


def test_the_captions_of_tables_2_to_4_follow():
    for k in (2, 3, 4):
        assert (D[k] >= D[1] - 1e-9).any()
        assert (D[k] <= D[5] + 1e-9).any()


def test_no_equal_discs_whatever_robot_and_margin():
    equal = np.eye(9)[:6] - np.eye(9)[1:7]
    bounds = [(0, None)] * 8 + [(0, None)]
    assert linprog(-np.eye(9)[8], A, B, equal, np.zeros(6), bounds=bounds).status == 2


def test_the_multipliers_prove_the_largest_margin():
    multipliers = -BEST.ineqlin.marginals
    total = multipliers @ A
    assert_allclose(total[:7], 0, atol=1e-9)
    assert_allclose(total[8], 1, atol=1e-9)
    assert_allclose(multipliers @ B - total[7] * MARGIN, BEST.x[8], atol=1e-7)
    held = [label for label, weight in zip(LABELS, multipliers, strict=True) if weight > 1e-6]
    assert sorted(held) == ["2 has a size", "3 has a size", "Table 1, 2–3 safe"]


def test_the_file_holds_the_sizes_found():
    assert_allclose(np.round(1000 * RADII), 1000 * fs.load_table(1).radii)


def test_least_variance_is_least():
    assert_allclose(1000 * LEVEL[[0, 5, 6]], 28.6, atol=0.1)
    rng, limit = np.random.default_rng(0), B - A[:, 7:] @ [MARGIN, BEST.x[8] - 1e-8]
    for step in rng.normal(0, 0.004, (2000, 7)):
        other = LEVEL + step
        if (A[:, :7] @ other <= limit).all():
            assert np.var(other) >= np.var(LEVEL) - 1e-12


def test_no_radii_trap_the_robot():
    assert fs.KheperaIV().diameter + MARGIN < NARROWEST
