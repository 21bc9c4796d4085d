"""Time from a slider to the picture: ``python tests/benchmarks/dragging.py [drags]``.

Planning, driving and drawing, with the picture encoded as it is sent to the browser; what
the browser and the connection add is not in it.
"""

import statistics
import sys
import time

import freeseg as fs


def drag(explorer, name, values):
    """Times (ms) on the clock and of the processor that a slider's values take to be drawn."""
    times = []
    for value in values:
        clock, processor = time.perf_counter(), time.process_time()
        explorer.controls[name].value = value
        times.append((time.perf_counter() - clock, time.process_time() - processor))
    return [[1e3 * one for one in some] for some in zip(*times, strict=True)]


def main(drags=40):
    """Print median and slowest for a few sliders."""
    explorer = fs.Explorer()
    for name, unit in {
        "start x": 5,
        "goal y": 5,
        "margin": 1,
        "robot": 1,
        "disturbance": 0.25,
    }.items():
        slider = explorer.controls[name]
        first, span = slider.value, round((slider.max - slider.min) / unit)
        values = [slider.min + unit * ((7 * k + 3) % min(span, 12)) for k in range(drags)]
        drag(explorer, name, values[:3])
        clock, processor = drag(explorer, name, values)
        print(
            f"{name:12s} median {statistics.median(clock):6.1f} ms, slowest {max(clock):6.1f} ms; "
            f"processor {statistics.median(processor):6.1f} ms"
        )
        slider.value = first


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
