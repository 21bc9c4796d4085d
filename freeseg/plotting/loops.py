"""Control loops: block diagrams, Bode and Nyquist plots, and the gang of four.

A transfer function is any function of a complex frequency s (1/s) that takes
arrays, such as a system of python-control, or ``lambda s: system(np.exp(s * dt))``
for a sampled one.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.patches import Circle, FancyBboxPatch
from matplotlib.ticker import MultipleLocator

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, check_color, new_axes, several_axes
from freeseg.plotting.sketches import arrow, sketch_axes, write

#: Half the width of a block, unless it is told; half its height; radius of a sum.
HALF_WIDTH, BLOCK_HALF_HEIGHT, SUM = 0.75, 0.42, 0.17
#: Radii that a Nyquist plot has rings for.
RINGS = (1, 10, 100, 1000)
#: What the four functions of a loop answer, in the order of their pictures.
GANG = (
    "$S=1/(1+L)$\nhow much of a disturbance of $y$ is left",
    "$T=L/(1+L)$\nhow much of the measurement's noise $y$ follows",
    "$PS$\nwhat a disturbance of the input does to $y$",
    "$CS$\nwhat the measurement's noise does to the input",
)


def plot_block_diagram(blocks, links, ax=None):
    """A block diagram: boxes, sums, and the signals between them.

    Parameters
    ----------
    blocks : dict of str to tuple
        By name: the centre x, y, the text in the box, and optionally half the
        width of the box. Without a text, it is the circle of a sum.
    links : sequence of tuple
        For each signal its name, to be written above its first piece, and
        its stops: names of blocks, with a minus sign in front where the
        signal is subtracted, and points (x, y) on the way. Between two stops
        that are not beside or above one another, it first runs horizontally.
        A signal that begins at a point of one drawn before branches off there.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    blocks = _check_blocks(blocks)
    wires = [_wire(link, blocks) for link in checks.sequence("links", links, "signals")]
    places = np.array([(x, y) for x, y, _, _ in blocks.values()])
    places = np.vstack([places, *(points for _, points, _ in wires)])
    (left, low), (right, high) = places.min(0), places.max(0)
    width = max(half for *_, half in blocks.values())
    size = 0.75 * (right - left + 2 * width), 0.75 * (high - low + 1.6)
    ax = sketch_axes(ax, size, (left - width - 0.1, right + width + 0.1), (low - 0.8, high + 0.8))
    for x, y, text, half in blocks.values():
        if text:
            style = {"boxstyle": "round,pad=0,rounding_size=0.1", "fc": PALETTE["robot"]}
            corner = x - half, y - BLOCK_HALF_HEIGHT
            box = FancyBboxPatch(corner, 2 * half, 2 * BLOCK_HALF_HEIGHT, alpha=0.35, lw=0, **style)
            ax.add_patch(box)
            write(ax, text, (x, y), size=11)
        else:
            ax.add_patch(Circle((x, y), SUM, fc="white", ec="black", lw=1.4, zorder=5))
    for number, (name, points, minus) in enumerate(wires):
        _draw_wire(ax, name, points, minus, [before for _, before, _ in wires[:number]])
    return ax


def _check_blocks(blocks):
    """By name, centre, text and half the width of each block; or `InvalidParameter`."""
    checks.instance("blocks", blocks, Mapping, "names and (x, y, text), such as {'G': (0, 0, 'G')}")
    found = {}
    for name, block in blocks.items():
        try:
            x, y, text, *half = block
            (half,) = half or [HALF_WIDTH if text else SUM]
        except (TypeError, ValueError):
            text = None
        if not isinstance(text, str) or not isinstance(name, str):
            raise InvalidParameter(
                f"blocks[{checks.shown(name)}] is {checks.shown(block)}; give x, y, a text and "
                "perhaps half the width, under a name"
            )
        x, y = checks.array("blocks: a centre", (x, y), (2,), unit="x, y").tolist()
        found[name] = x, y, text, checks.positive("blocks: half the width", half)
    if not found:
        raise InvalidParameter("blocks is empty; give at least one")
    return found


def _wire(link, blocks):
    """Name of a signal, the corners of its line, and whether it is subtracted at the end."""
    try:
        name, *stops = link
        known = isinstance(name, str) and len(stops) > 1
    except (TypeError, ValueError):
        known = False
    if not known:
        raise InvalidParameter(
            f"links has {checks.shown(link)}; give the name of a signal and two stops or more"
        )
    points, ends = [], []
    for stop in stops:
        block = blocks.get(stop.lstrip("-")) if isinstance(stop, str) else None
        if isinstance(stop, str) and block is None:
            raise InvalidParameter(
                f"links: {checks.shown(stop)} is no block; give one of {', '.join(blocks)}"
            )
        x, y = block[:2] if block else checks.array("links: a stop", stop, (2,), unit="x, y")
        if points and x != points[-1][0] and y != points[-1][1]:
            points.append((x, points[-1][1]))
        points.append((x, y))
        ends.append(block)
    points = np.array(points, dtype=float)
    # A line ends at the edge of its block.
    for end, inner, block in ((0, 1, ends[0]), (-1, -2, ends[-1])):
        if block:
            way = np.sign(points[inner] - points[end])
            points[end] += way * (block[3], BLOCK_HALF_HEIGHT if block[2] else SUM)
    return name, points, isinstance(stops[-1], str) and stops[-1].startswith("-")


def _draw_wire(ax, name, points, minus, before):
    """The line of a signal with its arrow, its name, a dot where it branches off, and its sign."""
    ax.plot(*points[:-1].T, color="black", lw=1.4, solid_joinstyle="miter")
    arrow(ax, points[-2], points[-1], "black", lw=1.4)
    for other in before:
        low, high = np.minimum(other[1:], other[:-1]), np.maximum(other[1:], other[:-1])
        if ((low <= points[0]) & (points[0] <= high)).all(1).any():
            ax.plot(*points[0], "o", color="black", ms=5)
            break
    middle, upright = np.mean(points[:2], 0), points[0][0] == points[1][0]
    write(
        ax, name, middle + ((0.12, 0) if upright else (0, 0.22)), ha="left" if upright else "center"
    )
    if minus:
        way = np.sign(points[-2] - points[-1])
        write(ax, "−", points[-1] + 0.25 * way + 0.2 * np.abs(way[::-1]), size=14)


def _frequencies(omega):
    """Increasing positive frequencies, or `InvalidParameter`."""
    omega = checks.array("omega", omega, (None,), unit="rad/s")
    if len(omega) < 2 or omega[0] <= 0 or not (np.diff(omega) > 0).all():
        raise InvalidParameter(
            f"omega is {checks.shown(omega)}; give increasing frequencies above 0"
        )
    return omega


def _response(name, system, s):
    """Values of a transfer function at complex frequencies, or `InvalidParameter`."""
    checks.function(name, system, "a transfer function of s that takes arrays", s)
    found = np.asarray(system(s))
    if found.shape != s.shape or found.dtype.kind not in "fc" or not np.isfinite(found).all():
        raise InvalidParameter(
            f"{name} is {checks.shown(system)}, which gives {checks.shown(found)}; give one with a "
            "finite value at each frequency, such as no pole there"
        )
    return found


def _check_label(label):
    """`label`, a text or None, or `InvalidParameter`."""
    return label if label is None else checks.instance("label", label, str, "a text")


def plot_bode(loop, omega, axes=None, color=PALETTE["planned"], label=None):
    """Magnitude and phase of an open loop; thick strokes are its margins.

    Parameters
    ----------
    loop : callable
        Transfer function of the open loop.
    omega : array_like, shape (n,)
        Frequencies (rad/s), increasing.
    axes : sequence of 2 matplotlib Axes, optional
        Where to draw magnitude and phase.
    color : color, optional
        Of the lines.
    label : str, optional
        For the legend.

    Returns
    -------
    list of 2 matplotlib Axes

    Notes
    -----
    The strokes run from the curve to 1 at each frequency where the phase is
    -180 degrees, and from the curve to -180 degrees wherever the gain is 1.
    """
    omega, color = _frequencies(omega), check_color(color)
    _check_label(label)
    response = _response("loop", loop, 1j * omega)
    gain, phase = np.abs(response), np.degrees(np.unwrap(np.angle(response)))
    phase -= 360 * np.round((phase[0] + 180) / 360)
    magnitudes, phases = several_axes(axes, 2, 1, (6.4, 4.6))
    magnitudes.loglog(omega, gain, color=color, lw=1.8, label=label)
    phases.semilogx(omega, phase, color=color, lw=1.8)
    stroke = {"color": color, "lw": 6, "alpha": 0.45, "solid_capstyle": "butt"}
    for at in _crossings(omega, phase + 180):
        magnitudes.plot([at, at], [1, np.exp(np.interp(at, omega, np.log(gain)))], **stroke)
    for at in _crossings(omega, np.log(gain)):
        phases.plot([at, at], [-180, np.interp(at, omega, phase)], **stroke)
    magnitudes.axhline(1, color="0.6", lw=0.8)
    phases.axhline(-180, color="0.6", lw=0.8)
    magnitudes.set(ylabel="$|L|$", xlim=omega[[0, -1]])
    phases.yaxis.set_major_locator(MultipleLocator(90))
    phases.set(ylabel="phase of $L$ (°)", xlabel="frequency (rad/s)", xlim=omega[[0, -1]])
    return [magnitudes, phases]


def _crossings(omega, values):
    """Frequencies at which values pass zero, between those given."""
    left = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    share = values[left] / (values[left] - values[left + 1])
    return omega[left] + share * (omega[left + 1] - omega[left])


def plot_nyquist(loop, lowest, highest, ax=None, color=PALETTE["planned"]):
    """The whole curve of an open loop, so that its turns about -1 can be counted.

    Parameters
    ----------
    loop : callable
        Transfer function of the open loop; of its poles on the imaginary axis,
        all are at zero.
    lowest : float
        Radius (rad/s) of the half circle on which s passes zero on the right.
    highest : float
        Where s turns back (rad/s): such as pi / dt for a sampled loop, or where
        the loop's gain is next to nothing.
    ax : matplotlib Axes, optional
        Where to draw.
    color : color, optional
        Of the curve.

    Returns
    -------
    matplotlib Axes

    Notes
    -----
    Directions are true; distances from zero beyond 1 are drawn as
    1 + log10, so that all of the curve is in the picture. That moves no point
    across the ray to the left of -1. Where the curve passes that ray, a
    triangle says in which sense it turns about -1: clockwise passes, less
    those counter-clockwise, are the unstable poles of the closed loop, if the
    open loop has none.
    """
    lowest, highest = checks.positive("lowest", lowest), checks.positive("highest", highest)
    if highest <= lowest:
        raise InvalidParameter(f"highest is {highest:g} rad/s; give more than lowest, {lowest:g}")
    color, ax = check_color(color), new_axes(ax, (5.6, 5.6))
    up = 1j * np.geomspace(lowest, highest, 3000)
    past_zero = lowest * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 1000)[1:-1])
    values = _response("loop", loop, np.concatenate([-up[::-1], past_zero, up]))
    drawn = _compressed(values)
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 300))
    for ring in RINGS:
        ring_drawn = _compressed(ring * circle)
        ax.plot(ring_drawn.real, ring_drawn.imag, color="0.85", lw=0.8, zorder=0)
        ax.annotate(f"{ring:g}", (0, ring_drawn.real[0]), fontsize=8, color="0.5", ha="center")
    for span, style, width, label in (
        (slice(0, len(up)), "--", 1.2, r"$\omega<0$"),
        (slice(len(up) - 1, -len(up) + 1), ":", 1.4, "$s$ passes zero"),
        (slice(-len(up), None), "-", 2.0, r"$\omega>0$"),
    ):
        ax.plot(drawn[span].real, drawn[span].imag, style, color=color, lw=width, label=label)
    _mark_passes(ax, values, drawn)
    ax.plot(-1, 0, "+", color="black", ms=11, mew=2.2, zorder=6, label="$-1$")
    most = 1.1 * np.abs(drawn).max()
    ax.set(aspect="equal", xlim=(-most, most), ylim=(-most, most))
    ax.set_axis_off()
    return ax


def _compressed(values):
    """Complex numbers with distances r from zero beyond 1 drawn as 1 + log10(r)."""
    size = np.maximum(np.abs(values), 1)
    return values / size * (1 + np.log10(size))


def _mark_passes(ax, values, drawn):
    """Triangles where a curve passes the ray to the left of -1."""
    place = np.flatnonzero(np.sign(values.imag[:-1]) * np.sign(values.imag[1:]) < 0)
    place = place[np.minimum(values.real[place], values.real[place + 1]) < -1]
    upwards = values.imag[place + 1] > values.imag[place]
    for chosen, mark, color, name in (
        (upwards, "^", "danger", "clockwise"),
        (~upwards, "v", "safe", "counter-clockwise"),
    ):
        at = drawn[place[chosen]].real
        label = f"{name}: {len(at)}"
        ax.plot(at, 0 * at, mark, color=PALETTE[color], mec="white", ms=10, zorder=7, label=label)
        # Of those for s and for its conjugate, one triangle hides the other.
        for x, times in zip(*np.unique(at.round(2), return_counts=True), strict=True):
            ax.annotate(f"{times}×", (x, 0), (7, 5), textcoords="offset points", fontsize=9)


def plot_gang_of_four(plant, controller, omega, axes=None, color=PALETTE["planned"], label=None):
    """The four functions that say what a loop does to all that comes in.

    Parameters
    ----------
    plant, controller : callable
        Transfer functions P and C of the loop L = PC.
    omega : array_like, shape (n,)
        Frequencies (rad/s), increasing.
    axes : sequence of 4 matplotlib Axes, optional
        Where to draw S, T, PS and CS.
    color : color, optional
        Of the lines.
    label : str, optional
        For the legend.

    Returns
    -------
    list of 4 matplotlib Axes
    """
    omega, color = _frequencies(omega), check_color(color)
    _check_label(label)
    p = _response("plant", plant, 1j * omega)
    c = _response("controller", controller, 1j * omega)
    four = several_axes(axes, 2, 2, (8.4, 5))
    sensitivity = 1 / (1 + p * c)
    functions = sensitivity, p * c * sensitivity, p * sensitivity, c * sensitivity
    for ax, function, title in zip(four, functions, GANG, strict=True):
        gain = np.abs(function)
        ax.loglog(omega, gain, color=color, lw=1.8, label=label)
        top = gain.argmax()
        ax.plot(omega[top], gain[top], "o", color=color, ms=4)
        ax.annotate(
            f"{gain[top]:.3g}",
            (omega[top], gain[top]),
            # A second loop's below its curve.
            (0, 5 if len(ax.texts) == 0 else -13),
            color=color,
            fontsize=8,
            textcoords="offset points",
            ha={0: "left", len(gain) - 1: "right"}.get(int(top), "center"),
        )
        ax.set_title(title, fontsize=9)
        ax.set_xlim(omega[[0, -1]])
        ax.margins(y=0.18)
        ax.grid(alpha=0.3)
    for ax in four[2:]:
        ax.set_xlabel("frequency (rad/s)")
    return four
