"""Methods among movers: ``python tests/benchmarks/avoid_movers.py STORE``.

Runs the study of `freeseg.studies.moving` on ``--count`` scenes, with ORCA as a further method,
keeps its rows in the folder STORE, where a run that was stopped goes on, and prints tables.
``--write`` runs nothing: it stores what STORE has so far in ``data/movers.npz``. ``--noises``
drives in some of the scenes with more noise, in another STORE, and writes
``data/movers_noise.npz``. Without a folder, it prints how long it takes to plan again among many
movers, by the processor's own time; ``--quick`` tries fewer. ``--tune`` searches the gains of the
offline plan, MPC, ORCA and the reactive laws, all by the same search with as many evaluations, in
scenes of their own, and stores them in ``data/movers_gains.csv``: 50 minutes.

ORCA (J. van den Berg, S. Guy, M. Lin, D. Manocha, *ISRR* 2009; the package is in ``peers.txt``)
chooses the velocity nearest to the wanted one that avoids all collisions within a time horizon.
What stands it avoids by itself; of what moves, it takes it that every agent does its half of
that. Movers here do not yield, and it is not told so: it finds out at the next step. Its robot
has the margin of the others that plan, is told the estimates that they are told, and turns
towards the velocity chosen as re-planning does.
"""

import argparse
import math
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

import freeseg as fs
from freeseg.data import write_csv
from freeseg.following import Following
from freeseg.geometry import unit, wrap_angle
from freeseg.reactive.sensing import check_drive, steer
from freeseg.reference import SPEED
from freeseg.replanning import SIGHT_NOISE, Estimates, Replanning
from freeseg.segments import MARGIN
from freeseg.studies import moving, reacting, store

#: Corners of the polygon round a disc that stands.
STANDING_CORNERS = 16


#: Evaluations of a search, and its seed.
BUDGET, SEED = 48, 19

#: Scenes in which the noise is varied, and the methods for which it makes no difference.
NOISY_SCENES, UNSEEING = 200, (moving.OFFLINE, moving.BLIND)

#: What searches begin with, besides the reactive laws' gains in worlds that stand still.
FIRST = {
    "MPC": {"horizon": 30.0, "keep_out": 100.0},
    "ORCA": {"horizon": 4.0, "standing": 4.0, "steering": 6.0, "turn_rate": 3.0},
}


@dataclass(frozen=True)
class Orca:
    """ORCA as a law: the gains of the package's simulator."""

    horizon: float = 4.0
    standing: float = 4.0
    reach: float = 2.0
    margin: float = 2 * MARGIN
    steering: float = 6.0
    turn_rate: float = 3.0
    noise: float = SIGHT_NOISE

    def start(self, scene, goal, robot, dt):
        """The law for one drive."""
        import pyrvo

        goal, robot = check_drive(scene, goal, robot, dt)
        estimates = Estimates(scene, dt, self.noise, SPEED)
        others = len(scene.movers)
        radius = robot.radius + self.margin / 2
        simulator = pyrvo.RVOSimulator(
            dt, self.reach, others, self.horizon, self.standing, radius, SPEED
        )
        for _ in range(1 + others):
            simulator.add_agent((0.0, 0.0))
        # What stands is avoided in full, not by half.
        corners = unit(2 * np.pi / STANDING_CORNERS * np.arange(STANDING_CORNERS))
        for disc in scene.world:
            ring = disc.center + disc.radius / np.cos(np.pi / STANDING_CORNERS) * corners
            simulator.add_obstacle([tuple(corner) for corner in ring])
        simulator.process_obstacles()

        velocity_now = (0.0, 0.0)

        def law(t, pose):
            nonlocal velocity_now
            for agent, mover in enumerate(estimates.at(t).movers, 1):
                simulator.set_agent_position(agent, tuple(mover.obstacle.center))
                simulator.set_agent_velocity(agent, tuple(mover.velocity))
                simulator.set_agent_pref_velocity(agent, tuple(mover.velocity))
                simulator.set_agent_radius(agent, mover.obstacle.radius)
            to = goal - pose[:2]
            left = math.hypot(*to)
            wanted = to / left * min(SPEED, left / dt) if left else to
            simulator.set_agent_position(0, tuple(pose[:2]))
            simulator.set_agent_velocity(0, velocity_now)
            simulator.set_agent_pref_velocity(0, tuple(wanted))
            simulator.do_step()
            chosen = simulator.get_agent_velocity(0)
            x, y = chosen.x, chosen.y
            error = wrap_angle(math.atan2(y, x) - pose[2])
            v, omega = steer(error, math.hypot(x, y), self.steering, self.turn_rate)
            velocity_now = v * math.cos(pose[2]), v * math.sin(pose[2])
            return v, omega

        return law


def crowd(count, seed):
    """A scene of so many movers on a square with as much room for each as the study's densest."""
    side = moving.SQUARE * math.sqrt(count / moving.CROWDS[-1])
    rng = np.random.default_rng(seed)
    start, goal = np.array([-0.15, side / 2]), np.array([side + 0.15, side / 2])
    movers = []
    while len(movers) < count:
        disc = fs.Disc(rng.uniform(0, side, 2), rng.uniform(0.015, 0.06))
        if min(math.dist(disc.center, start), math.dist(disc.center, goal)) > 0.3:
            velocity = 0.5 * SPEED * unit(rng.uniform(-np.pi, np.pi))
            movers.append(fs.Mover(disc, velocity=velocity))
    return fs.Scene(fs.World([]), movers), start, goal


def print_ticks(counts=(10, 50), scenes=10, ticks=40):
    """Time of a command of re-planning, for numbers of movers and for reaches of sight."""
    robot, dt = fs.KheperaIV(), 0.05
    for count in counts:
        for reach in (math.inf, 1.0):
            spent, missed = [], 0
            for seed in range(scenes):
                scene, start, goal = crowd(count, seed)
                law = Replanning(reach=reach).start(scene, goal, robot, dt)
                pose = np.array([*start, 0.0])
                for tick in range(ticks):
                    begin = time.process_time()
                    v, omega = law(tick * dt, pose)
                    spent.append(1e3 * (time.process_time() - begin))
                    pose = robot.move(pose, robot.to_wheels(v, omega), dt)
                missed += law.missed
            median, p95 = np.quantile(spent[1:], [0.5, 0.95])
            print(
                f"{count:3d} movers, reach {reach:3g} m: median {median:6.2f} ms, p95 {p95:6.2f} "
                f"ms, longest {max(spent[1:]):6.1f} ms, without a plan {missed} of {len(spent)}"
            )


def law_with(method, gains):
    """A method with some gains."""
    return Orca(**gains) if method == "ORCA" else moving.with_gains(method, gains)


def tune(budget=BUDGET):
    """Search the gains of all that have some, print what they score, and store them."""
    ranges, rows = moving.MOVERS_RANGES | moving.PEER_RANGES, []
    standing = reacting.load_laws()["random"]
    for method in ranges:
        law = Following() if method == moving.OFFLINE else standing.get(method)
        first = FIRST.get(method) or {gain: getattr(law, gain) for gain in ranges[method]}
        noise = 0.0 if method == moving.OFFLINE else SIGHT_NOISE

        def cost(gains, method=method, noise=noise):
            try:
                return moving.score_among_movers(law_with(method, gains), noise=noise)
            except fs.InvalidParameter:
                # Such as thresholds in the wrong order.
                return math.inf

        gains, score = reacting.search(cost, ranges[method], first, SEED, budget)
        before = cost(first)
        print(f"{method:16s} {before:.3f} -> {score:.3f}  {gains}", flush=True)
        scores = {"score_before": round(before, 6), "score": round(score, 6)}
        rows += [{"method": method, "gain": k, "value": v} | scores for k, v in gains.items()]
    write_csv(moving.MOVERS_GAINS, rows)


def print_tables(rows):
    """What the study says."""
    for by in ((), ("movers", "ratio")):
        for row in moving.summarise(rows, by):
            kind = " ".join(f"{row[name]:g}" for name in by)
            shares = " ".join(
                f"{name} {100 * row[name].share:5.1f} [{100 * row[name].low:5.1f}, "
                f"{100 * row[name].high:5.1f}] %"
                for name in ("collided", "arrived")
            )
            print(
                f"{kind:7s} {row['method']:22s} {row['scenes'] - row['impossible']:4d} scenes  "
                f"{shares}  delay {100 * row['delay']:6.2f} [{100 * row['delay_low']:6.2f}, "
                f"{100 * row['delay_high']:6.2f}] % of {row['delayed']:3d} "
                f"({100 * row['proved_delay']:6.2f} % of {row['proved']:3d} proved)  "
                f"{row['median_ms']:6.2f} ms, p95 {row['p95_ms']:6.2f}, over {row['over']:.4f}, "
                f"no plan {row['missed']:.4f}"
            )
    methods = len({row["method"] for row in rows})
    print(Counter((row["possible"], row["proved"]) for row in rows[::methods]))
    if len(rows) > 100:
        for pair in moving.pairs(rows):
            print(
                f"{pair.first} - {pair.second}: {pair.mean:.3f} [{pair.low:.3f}, {pair.high:.3f}]"
            )


def main():
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("store", nargs="?")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--tune", action="store_true")
    parser.add_argument("--noises", action="store_true")
    told = parser.parse_args()
    if told.quick:
        print_ticks((10,), 1, 3)
        print_tables(moving.compare([0], {moving.BLIND: moving.methods()[moving.BLIND]}))
        return
    if told.tune:
        tune()
        return
    if told.store is None:
        print_ticks()
        return
    given = moving.methods() | {"ORCA": Orca(**moving.load_gains()["ORCA"])}
    if told.noises:
        count = min(told.count, NOISY_SCENES)
        seeing = {name: law for name, law in given.items() if name not in UNSEEING}
        rows = []
        for noise in moving.NOISES:
            laws, folder = moving.told_noise(seeing, noise), f"{told.store}/{1000 * noise:g}_mm"
            rows += moving.compare(range(count), laws, noise, store=folder)
        moving.save_drives(rows, moving.NOISY_DRIVES)
        return
    if told.write:
        rows = store.load(told.store).to_table().to_pylist()
        moving.save_drives(rows)
    else:
        rows = moving.compare(range(told.count), given, store=told.store)
    print_tables(rows)


if __name__ == "__main__":
    main()
