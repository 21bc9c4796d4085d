"""Pictures of worlds, plans and runs: one palette, ticks in mm and degrees.

Every function draws on ``ax``, or on a new figure, and returns the axes. Data are
in metres and radians, as everywhere; only the ticks count in mm and degrees. What
is no plane ``Axes``, or cannot be drawn, raises `InvalidParameter`; what is no
world or no position, `InvalidQuery`.
"""

from freeseg.plotting.axes import PALETTE, count_in_degrees, count_in_mm, map_axes
from freeseg.plotting.collisions import plot_repairs, sketch_danger, sketch_loop
from freeseg.plotting.comparisons import plot_fronts, plot_intervals, plot_order
from freeseg.plotting.failures import plot_failures, plot_indices, plot_tails
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
from freeseg.plotting.horizons import (
    plot_change,
    plot_distances,
    plot_keep_out,
    plot_lookahead,
    plot_radii,
    plot_strip,
    plot_turn,
    sketch_horizon,
)
from freeseg.plotting.ledger import plot_outcomes
from freeseg.plotting.loops import plot_block_diagram, plot_bode, plot_gang_of_four, plot_nyquist
from freeseg.plotting.minima import plot_free_space, plot_potential
from freeseg.plotting.movers import (
    animate_plan,
    plot_moment,
    plot_opening,
    plot_space_time,
    sketch_graze,
    sketch_leave,
    sketch_slide,
)
from freeseg.plotting.plans import legend_below, plot_plan, plot_step
from freeseg.plotting.rivals import (
    plot_chase,
    plot_duels,
    plot_forces,
    plot_histogram,
    plot_tracks,
    plot_turns,
    plot_window,
)
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
from freeseg.plotting.sliding import (
    plot_denominator,
    plot_lyapunov_rate,
    plot_tradeoff,
    sketch_error,
    sketch_surface,
)
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
    "animate_plan",
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
    "plot_block_diagram",
    "plot_bode",
    "plot_case",
    "plot_change",
    "plot_chase",
    "plot_circle",
    "plot_clearance",
    "plot_counts",
    "plot_denominator",
    "plot_detours",
    "plot_distances",
    "plot_drive",
    "plot_duels",
    "plot_endpoints",
    "plot_errors",
    "plot_failures",
    "plot_forces",
    "plot_free_space",
    "plot_fronts",
    "plot_gang_of_four",
    "plot_group",
    "plot_growth",
    "plot_histogram",
    "plot_indices",
    "plot_intervals",
    "plot_keep_out",
    "plot_leads",
    "plot_limits",
    "plot_lookahead",
    "plot_lyapunov_rate",
    "plot_met",
    "plot_moment",
    "plot_nyquist",
    "plot_on_axes",
    "plot_opening",
    "plot_order",
    "plot_outcomes",
    "plot_path",
    "plot_plan",
    "plot_potential",
    "plot_pull",
    "plot_quantiles",
    "plot_query",
    "plot_radii",
    "plot_ranges",
    "plot_reference",
    "plot_repairs",
    "plot_round",
    "plot_run",
    "plot_segments",
    "plot_space_time",
    "plot_starts",
    "plot_step",
    "plot_strip",
    "plot_tails",
    "plot_tracking",
    "plot_tracks",
    "plot_tradeoff",
    "plot_turn",
    "plot_turns",
    "plot_wheels",
    "plot_window",
    "plot_world",
    "sketch_danger",
    "sketch_error",
    "sketch_graze",
    "sketch_horizon",
    "sketch_leave",
    "sketch_literal_circle",
    "sketch_loop",
    "sketch_pose",
    "sketch_segment",
    "sketch_slide",
    "sketch_step",
    "sketch_sum",
    "sketch_surface",
    "sketch_tangent",
    "sketch_turn",
]
