"""Live sliders: a world, a query, a robot, its tracker and what disturbs it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
import shapely
from matplotlib.figure import Figure

from freeseg import metrics
from freeseg.disturbance import Disturbance
from freeseg.errors import FreesegError
from freeseg.paper import load_table
from freeseg.plan import Plan, Planner
from freeseg.planners import literal_plan, plan, plan_rooms, shortest_path
from freeseg.plotting import plot_band, plot_path, plot_query, plot_run, plot_world
from freeseg.random_worlds import random_world
from freeseg.reference import SMOOTHING, make_reference
from freeseg.robot import KheperaIV
from freeseg.simulate import Run, simulate
from freeseg.studies.tracking import DISTURBANCE
from freeseg.trackers import Kanayama, Lqr, Pid, PurePursuit, SlidingMode, Stanley
from freeseg.trackers.feedback import Tracker
from freeseg.world import World

#: What can be chosen, by the name that is shown.
WORLDS: dict[str, Callable[[], World]] = {
    **{f"Table {k}": partial(load_table, k) for k in range(1, 6)},
    "30 random obstacles": partial(random_world, 30, 0),
}
PLANNERS: dict[str, Planner] = {
    "the paper's": plan,
    "the paper's words alone": literal_plan,
    "rooms": plan_rooms,
    "the shortest path": shortest_path,
}
TRACKERS: dict[str, Tracker] = {
    "sliding mode": SlidingMode(),
    "PID": Pid(),
    "LQR": Lqr(),
    "Kanayama": Kanayama(),
    "Stanley": Stanley(),
    "pure pursuit": PurePursuit(),
}

#: Sliders: name to first value, smallest, largest, step and unit.
SLIDERS = {
    "start x": (0, 0, 900, 5, "mm"),
    "start y": (0, -100, 900, 5, "mm"),
    "goal x": (750, 0, 900, 5, "mm"),
    "goal y": (750, -100, 900, 5, "mm"),
    "margin": (5, 0, 60, 1, "mm"),
    "robot": (141, 40, 240, 1, "mm across"),
    "disturbance": (1, 0, 4, 0.25, "times the usual"),
}

ENDS = "start", "goal"

#: Width and height of the picture (inches), and dots per inch.
PICTURE, RESOLUTION = (5.5, 5.5), 80


class Explorer:
    """Sliders, and the picture that follows them.

    Show it as the last line of a cell. The world is drawn once; what a slider
    changes is drawn over it, so that a drag is followed at once.

    Attributes
    ----------
    controls : dict
        Name to its ipywidgets slider or menu.
    message : ipywidgets HTML
        How long the path is and how well it is tracked, or why there is none.
    plan, run : Plan, Run or None
        What is shown.
    """

    plan: Plan | None
    run: Run | None
    _over: list[Any]

    def __init__(self) -> None:
        # Imported here: they come with the extra [notebooks] only.
        import ipywidgets
        from ipympl.backend_nbagg import Canvas, FigureManager

        menus = {"world": [*WORLDS], "planner": [*PLANNERS], "tracker": [*TRACKERS]}
        self.controls: dict[str, Any] = {
            name: ipywidgets.Dropdown(options=options, description=name)
            for name, options in menus.items()
        }
        for name, (value, low, high, step, unit) in SLIDERS.items():
            self.controls[name] = ipywidgets.FloatSlider(
                value,
                min=low,
                max=high,
                step=step,
                description=name,
                readout_format=".2f" if step < 1 else ".0f",
            )
            self.controls[name].tooltip = f"{name} ({unit})"
        self.message = ipywidgets.HTML()
        self.canvas = Canvas(Figure(PICTURE, dpi=RESOLUTION, layout="constrained"))
        FigureManager(self.canvas, 0)
        # Else the page is sent a picture that it cannot read before it has asked for one.
        self.canvas.syncing_data_url = False
        self.canvas.header_visible = self.canvas.footer_visible = False
        self.canvas.mpl_connect("draw_event", self._keep_world)
        self._choose_world()
        for name, control in self.controls.items():
            follow = self._choose_world if name == "world" else self._update
            control.observe(lambda _, follow=follow: follow(), names="value")
        left = ipywidgets.VBox(
            [*self.controls.values(), self.message], layout={"min_width": "310px"}
        )
        self._box = ipywidgets.HBox([left, self.canvas])

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        """Sliders where there is a kernel, and elsewhere the picture as it is now."""
        # This readies the canvas as well, with its size and a first picture.
        still = self.canvas._repr_mimebundle_()["image/png"]
        shown: dict[str, Any] = self._box._repr_mimebundle_(**kwargs)
        return shown | {"image/png": still, "text/plain": "sliders and a picture"}

    def _choose_world(self) -> None:
        """Draw another world, and keep its picture to draw over."""
        self.world = WORLDS[self.controls["world"].value]()
        self.canvas.figure.clear()
        self.ax = plot_world(self.world, self.canvas.figure.add_subplot())
        self._set_limits()
        self._over = []
        self.canvas.draw()
        self._update()

    def _set_limits(self) -> None:
        """Let the picture and the sliders hold the paper's map and the world."""
        corners = np.concatenate([self.world.edges.reshape(-1, 2), [(0, -0.1), (0.9, 0.9)]])
        low, high = np.round(corners.min(0), 2), np.round(corners.max(0), 2)
        self.ax.set(xlim=(low[0] - 0.1, high[0] + 0.1), ylim=(low[1] - 0.1, high[1] + 0.1))
        for axis, least, most in zip("xy", 1000 * low, 1000 * high, strict=True):
            for end in ENDS:
                slider = self.controls[f"{end} {axis}"]
                with slider.hold_trait_notifications():
                    slider.min, slider.max = least, most

    def _update(self) -> None:
        """Plan, drive and draw with the values that the controls have."""
        began, self.plan, self.run = perf_counter(), None, None
        try:
            self.plan = self._plan()
            reference = make_reference(self.plan, smoothing=SMOOTHING)
            tracker = TRACKERS[self.controls["tracker"].value]
            disturbed = _times(self.controls["disturbance"].value, DISTURBANCE)
            self.run = simulate(tracker, reference, disturbance=disturbed)
            said = _verdict(self.world, self.plan, self.run, perf_counter() - began)
        except FreesegError as error:
            said = f"<b>{type(error).__name__}</b>: {error}"
        self.message.value = f'<div style="width:280px;line-height:1.4">{said}</div>'
        self._draw()

    def _plan(self) -> Plan:
        planner = PLANNERS[self.controls["planner"].value]
        diameter = self.controls["robot"].value / 1000
        # The wheels of a small one move inwards, so that it covers them.
        robot = KheperaIV(min(KheperaIV().wheel_base, diameter), diameter)
        start, goal = self._ends()
        return planner(self.world, start, goal, robot, self.controls["margin"].value / 1000)

    def _ends(self) -> list[list[float]]:
        """Start and goal (m)."""
        return [[self.controls[f"{end} {axis}"].value / 1000 for axis in "xy"] for end in ENDS]

    def _draw(self) -> None:
        """Draw plan and run over the picture of the world, and nothing else again."""
        for artist in self._over:
            artist.remove()
        before = set(self.ax.get_children())
        if self.plan is not None and self.run is not None:
            plot_band(self.plan.path, self.plan.robot, self.ax)
            plot_path(self.plan.path, self.ax, lw=5)
            plot_run(self.run, self.ax, robots=3)
        start, goal = self._ends()
        plot_query(start, goal, self.ax)
        added = [artist for artist in self.ax.get_children() if artist not in before]
        self._over = sorted(added, key=lambda artist: artist.get_zorder())
        for artist in self._over:
            # What is animated is left out where the world is drawn.
            artist.set_animated(True)
        self.canvas.restore_region(self._world_alone)
        self._draw_over()
        self.canvas.blit()

    def _draw_over(self) -> None:
        for artist in self._over:
            self.ax.draw_artist(artist)

    def _keep_world(self, _: Any) -> None:
        """The picture has been drawn anew, perhaps in another size: keep it to draw over."""
        self._world_alone = self.canvas.copy_from_bbox(self.canvas.figure.bbox)
        self._draw_over()


def _times(factor: float, disturbance: Disturbance) -> Disturbance:
    """A disturbance whose noise and slip are so many times as large; lag and delay stay."""
    if factor == 0:
        return Disturbance()
    return replace(
        disturbance,
        position_noise=factor * disturbance.position_noise,
        heading_noise=factor * disturbance.heading_noise,
        slip=float(factor * np.mean(disturbance.slip)),
        slip_fluctuation=factor * disturbance.slip_fluctuation,
    )


def _verdict(world: World, plan: Plan, run: Run, took: float) -> str:
    """What came out in words, and how long it took (s)."""
    rms = metrics.tracking(run)["position_rms_m"]
    driven = shapely.LineString(run.pose[:2].T)
    left = world.distances(driven).min() - plan.robot.radius
    touch = f"comes within {1000 * left:.0f} mm of an obstacle" if left > 0 else "hits an obstacle"
    return (
        f"A path of {1000 * plan.path.length:.0f} mm, tracked to {1000 * rms:.1f} mm (RMS). The "
        f"robot's body {touch}. Planned and driven in {1000 * took:.0f} ms."
    )
