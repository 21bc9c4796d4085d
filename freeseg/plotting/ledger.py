"""What came of judging the claims of the paper."""

from collections import Counter
from collections.abc import Mapping

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, new_axes
from freeseg.studies.ledger_rules import Outcome

#: Colour of each verdict, from what holds to what does not, and what is open.
OUTCOME_COLORS = {
    Outcome.HOLDS: PALETTE["safe"],
    Outcome.ASSUMED: PALETTE["robot"],
    Outcome.PART: PALETTE["turning"],
    Outcome.FAILS: PALETTE["danger"],
    Outcome.OPEN: PALETTE["obstacle"],
}


def plot_outcomes(counts, ax=None):
    """How often each verdict was given, a bar for each kind of claim.

    Parameters
    ----------
    counts : dict
        Kind to a count by verdict, as `studies.ledger.count_outcomes` returns it.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidParameter
        For what are no counts, or are none at all.
    """
    checks.instance("counts", counts, Mapping, "what count_outcomes returns")
    if not counts or not all(isinstance(one, Counter) for one in counts.values()):
        raise InvalidParameter(
            f"counts is {checks.shown(counts)}; give what count_outcomes returns"
        )
    ax = new_axes(ax, (8, 0.5 * len(counts) + 1.2))
    begun = dict.fromkeys(counts, 0)
    for outcome, color in OUTCOME_COLORS.items():
        widths = [one[outcome] for one in counts.values()]
        bars = ax.barh(list(counts), widths, left=list(begun.values()), color=color, label=outcome)
        dark = outcome in (Outcome.HOLDS, Outcome.FAILS)
        labels = [str(width or "") for width in widths]
        ax.bar_label(bars, labels, label_type="center", color="white" if dark else "black")
        begun = {kind: begun[kind] + one[outcome] for kind, one in counts.items()}
    ax.invert_yaxis()
    ax.set(xlabel="claims")
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.legend(loc="upper center", bbox_to_anchor=(0.45, -0.25), ncols=3, frameon=False)
    return ax
