"""What the problem sets in ``notebooks/assignments/`` share, and their tests."""

from freeseg.teaching.check import check, quietly
from freeseg.teaching.own_work import NotOwn, without
from freeseg.teaching.seeds import variant_seed

__all__ = ["NotOwn", "check", "quietly", "variant_seed", "without"]
