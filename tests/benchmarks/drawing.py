"""Time the picture of a large world: ``python tests/benchmarks/drawing.py [discs]``."""

import sys
import time
from io import BytesIO

import matplotlib.pyplot as plt

import freeseg as fs


def main(discs=10_000):
    """Print how long drawing and saving take (s)."""
    world = fs.random_world(discs, seed=0)
    begin = time.perf_counter()
    figure = fs.plotting.plot_world(world).figure
    drawn = time.perf_counter()
    figure.savefig(BytesIO(), format="png")
    saved = time.perf_counter()
    plt.close(figure)
    spans = {f"draw {discs} discs": drawn - begin, "save them as PNG": saved - drawn}
    for label, seconds in (spans | {"both": saved - begin}).items():
        print(f"{label:20s} {seconds:6.2f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
