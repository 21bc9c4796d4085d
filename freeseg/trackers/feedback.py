"""What every tracker does alike: check its gains, and see its errors."""

from dataclasses import fields

from freeseg import checks
from freeseg.reference import Sample, tracking_error


def check_gains(tracker):
    """Make every float of a tracker one; `InvalidParameter` unless positive and finite."""
    for gain in fields(tracker):
        if gain.type is float:
            value = checks.positive(gain.name, getattr(tracker, gain.name))
            object.__setattr__(tracker, gain.name, value)


def watch(reference, dt):
    """What a law sees at a time step.

    A command is held for `dt`: the velocities that it is made from are those
    wanted at the middle of it.

    Parameters
    ----------
    reference : Reference
        What to follow.
    dt : float
        Time for which each command is held (s); zero for a law in continuous time.

    Returns
    -------
    callable
        ``see(t, pose) -> (error, middle)`` for a pose of shape (3,) or
        (3, n): the tracking error (7) at t, of the pose's shape, and the
        reference's `Sample` at t + dt / 2.
    """
    look = reference.sampler(dt)

    def see(t, pose):
        now_and_middle = look(t)
        middle = Sample(*(values[..., 1] for values in now_and_middle))
        return tracking_error(now_and_middle.pose[:, 0], pose), middle

    return see
