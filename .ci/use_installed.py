"""Use freeseg as it is installed, outside of its checkout: plan, track, draw, load tuned gains."""

import sys
from pathlib import Path

import freeseg as fs

checkout = Path(__file__).resolve().parent.parent
assert checkout not in Path(fs.__file__).resolve().parents, fs.__file__
assert not {"control", "IPython", "joblib", "pytest"} & set(sys.modules)

for name, case in fs.load_cases().items():
    world = fs.load_table(case.table)
    plan = fs.plan(world, case.start, case.goal)
    assert plan.path.clearance(world) > fs.KheperaIV().radius - 1e-9, name
reference = fs.make_reference(plan, speed=0.1, smoothing=0.03)
tuned = fs.studies.tuning.load_gains()
for tracker in (fs.SlidingMode(), fs.Pid(), fs.Mpc(), tuned["Lqr"][0].tracker):
    run = fs.simulate(tracker, reference)
    assert fs.metrics.tracking(run, world)["position_rms_m"] < 0.005, tracker
ax = fs.plotting.plot_tracking(world, plan, run)
ax.figure.savefig("tracked.png")
assert Path("tracked.png").stat().st_size > 10_000
print(f"freeseg {fs.__version__} of {Path(fs.__file__).parent}: plans, tracks, draws, has its data")
