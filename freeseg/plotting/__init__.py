"""Pictures of worlds, plans and runs: one palette, ticks in mm and degrees.

Every function draws on ``ax``, or on a new figure, and returns the axes. Data are
in metres and radians, as everywhere; only the ticks count in mm and degrees. What
is no plane ``Axes``, or cannot be drawn, raises `InvalidParameter`; what is no
world or no position, `InvalidQuery`.
"""

from freeseg.plotting.axes import PALETTE, count_in_degrees, count_in_mm, map_axes
from freeseg.plotting.collisions import plot_repairs, sketch_danger, sketch_loop
from freeseg.plotting.figures import (
    plot_across,
    plot_agreement,
    plot_leads,
    plot_on_axes,
    plot_pull,
    plot_quantiles,
    plot_reference,
    plot_starts,
)
from freeseg.plotting.minima import plot_free_space, plot_potential
from freeseg.plotting.plans import legend_below, plot_plan, plot_step
from freeseg.plotting.robots import (
    draw_robot,
    move_robot,
    plot_drive,
    plot_limits,
    sketch_pose,
    sketch_step,
    sketch_sum,
    sketch_turn,
)
from freeseg.plotting.routes import plot_case, plot_clearance, plot_counts, plot_round
from freeseg.plotting.runs import animate, plot_errors, plot_run, plot_tracking, plot_wheels
from freeseg.plotting.scales import plot_bars, plot_growth, plot_met
from freeseg.plotting.sizes import plot_ranges
from freeseg.plotting.tangents import (
    plot_detours,
    sketch_literal_circle,
    sketch_segment,
    sketch_tangent,
)
from freeseg.plotting.worlds import (
    plot_band,
    plot_circle,
    plot_endpoints,
    plot_group,
    plot_path,
    plot_query,
    plot_segments,
    plot_world,
)

__all__ = [
    "PALETTE",
    "animate",
    "count_in_degrees",
    "count_in_mm",
    "draw_robot",
    "legend_below",
    "map_axes",
    "move_robot",
    "plot_across",
    "plot_agreement",
    "plot_band",
    "plot_bars",
    "plot_case",
    "plot_circle",
    "plot_clearance",
    "plot_counts",
    "plot_detours",
    "plot_drive",
    "plot_endpoints",
    "plot_errors",
    "plot_free_space",
    "plot_group",
    "plot_growth",
    "plot_leads",
    "plot_limits",
    "plot_met",
    "plot_on_axes",
    "plot_path",
    "plot_plan",
    "plot_potential",
    "plot_pull",
    "plot_quantiles",
    "plot_query",
    "plot_ranges",
    "plot_reference",
    "plot_repairs",
    "plot_round",
    "plot_run",
    "plot_segments",
    "plot_starts",
    "plot_step",
    "plot_tracking",
    "plot_wheels",
    "plot_world",
    "sketch_danger",
    "sketch_literal_circle",
    "sketch_loop",
    "sketch_pose",
    "sketch_segment",
    "sketch_step",
    "sketch_sum",
    "sketch_tangent",
    "sketch_turn",
]
