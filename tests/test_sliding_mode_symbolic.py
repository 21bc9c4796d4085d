"""Section 4 by computer algebra: what the paper states, and what the package computes."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from sympy import atan, cos, diff, simplify, sin, symbols

import freeseg as fs
from freeseg.path import Arc

T = symbols("t")
V, W, V_R, W_R, V_R_DOT = symbols("V w V_r w_r Vdot_r", real=True)
X, Y, A = symbols("x_e y_e alpha_e", real=True)
C = symbols("c", positive=True)
K1, K2, SAT1, SAT2 = symbols("k_1 k_2 sat_1 sat_2", real=True)
GAMMA = atan(V_R * Y / C)
#: Rates of the tracking error.
X_DOT, Y_DOT, A_DOT = Y * W - V + V_R * cos(A), -X * W + V_R * sin(A), W_R - W


def test_error_dynamics_follow_from_1_and_7():
    x, y, alpha, x_r, y_r, alpha_r = (
        sympy.Function(name)(T) for name in ("x", "y", "alpha", "x_r", "y_r", "alpha_r")
    )
    rotation = sympy.Matrix([[cos(alpha), sin(alpha), 0], [-sin(alpha), cos(alpha), 0], [0, 0, 1]])
    error = rotation * sympy.Matrix([x_r - x, y_r - y, alpha_r - alpha])
    model = {
        x.diff(T): V * cos(alpha),
        y.diff(T): V * sin(alpha),
        alpha.diff(T): W,
        x_r.diff(T): V_R * cos(alpha_r),
        y_r.diff(T): V_R * sin(alpha_r),
        alpha_r.diff(T): W_R,
    }
    stated = sympy.Matrix([X_DOT, Y_DOT, A_DOT]).subs(dict(zip((X, Y, A), error, strict=True)))
    assert simplify(error.diff(T).subs(model) - stated) == sympy.zeros(3, 1)


def test_lyapunov_step_9():
    rate = (diff(Y**2 / 2, Y) * Y_DOT).subs(A, -GAMMA).subs(C, 1)
    assert simplify(rate - (-X * Y * W - V_R * Y * sin(atan(V_R * Y)))) == 0
    on_surface = -((V_R * Y) ** 2) / sympy.sqrt(1 + (V_R * Y) ** 2)
    assert simplify(rate.subs(X, 0) - on_surface) == 0
    assert on_surface.is_nonpositive
    # Off the surface, w decides.
    assert rate.subs({X: -1, Y: 1, V_R: 1, W: 1}) > 0


def test_derivatives_13():
    assert simplify(diff(GAMMA, V_R).subs(C, 1) - Y / (1 + (V_R * Y) ** 2)) == 0
    assert simplify(diff(GAMMA, Y).subs(C, 1) - V_R / (1 + (V_R * Y) ** 2)) == 0


@pytest.fixture(scope="module")
def solved():
    """V and w that make s1 and s2 of (10) obey (11)."""
    s1_dot = X_DOT
    s2_dot = A_DOT + diff(GAMMA, V_R) * V_R_DOT + diff(GAMMA, Y) * Y_DOT
    (solution,) = sympy.solve([s1_dot + K1 * SAT1, s2_dot + K2 * SAT2], [V, W], dict=True)
    return solution


def test_law_solves_12(solved):
    numerator = W_R + diff(GAMMA, V_R) * V_R_DOT + diff(GAMMA, Y) * V_R * sin(A) + K2 * SAT2
    denominator = 1 + diff(GAMMA, Y) * X
    assert simplify(solved[W] - numerator / denominator) == 0
    assert simplify(solved[V] - (Y * solved[W] + V_R * cos(A) + K1 * SAT1)) == 0
    (singular,) = sympy.solve(denominator, X)
    assert simplify(singular + C / V_R * (1 + (V_R * Y / C) ** 2)) == 0


def test_the_package_computes_the_solution_of_12(solved):
    symbols_in = (X, Y, A, V_R, W_R, V_R_DOT, SAT1, SAT2, C, K1, K2)
    stated = sympy.lambdify(symbols_in, [solved[V], solved[W]])
    reference = fs.make_reference(fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 2.5)]), speed=0.2)
    gains = fs.SlidingMode()
    law, scale = gains.start(reference, None, 0.0), 0.2 * gains.length_scale
    rng = np.random.default_rng(8)
    for t in rng.uniform(0, reference.duration, 200):
        pose, v_r, omega_r, v_r_dot, _ = reference.at(t)
        here = pose + rng.normal(0, [0.01, 0.01, 0.5])  # so near that no floor acts
        error = fs.tracking_error(pose, here)
        s = np.array([error[0], error[2] + np.arctan(v_r * error[1] / scale)])
        sat = np.clip(s / (gains.phi1, gains.phi2), -1, 1)
        values = (*error, v_r, omega_r, v_r_dot, *sat, scale, gains.k1, gains.k2)
        assert_allclose(law(t, here), stated(*values), rtol=1e-9, atol=1e-12)
