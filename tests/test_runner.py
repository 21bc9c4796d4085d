"""Studies give the same rows wherever they run, and whatever ends them."""

import os
import pickle
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from joblib import parallel_config
from numpy.testing import assert_array_equal
from pyarrow import parquet

import freeseg as fs
from freeseg import studies
from freeseg.studies import runner
from freeseg.studies import store as store_module
from freeseg.triangulation import triangulate

TESTS = Path(__file__).parent
SEED = 7

pytestmark = pytest.mark.skipif(os.name != "posix", reason="processes are killed by signals")


def draw(case, seed, pause=0.0, dies=None):
    """A row that only its seed decides; case 5 of every 17 fails, 6 gives two rows, 7 none."""
    if dies is not None and case == 30 and not dies.exists():
        # Once, the worker dies with this case.
        dies.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(pause)
    number = float(np.random.default_rng(seed).normal())
    if case % 17 == 5:
        raise fs.NoPath(f"none for {number}")
    row = {"number": number, "name": f"case {case}", "share": 1 if number > 0 else number}
    return {6: [row, row], 7: []}.get(case % 17, row)


def where(case, seed):
    return {"process": os.getpid()}


def content(store):
    """A store's rows, sorted, as the bytes of one file."""
    sink = pa.BufferOutputStream()
    parquet.write_table(studies.load(store).to_table().sort_by("case").combine_chunks(), sink)
    return sink.getvalue().to_pybytes()


def in_pieces(store, count, **given):
    """Run the study in chunks of some milliseconds."""
    return list(studies.run(draw, range(count), store, SEED, chunk_time=0.01, **given))


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """Content of the study's store, from one process and one chunk after the other."""
    store = tmp_path_factory.mktemp("expected")
    rows = studies.run(draw, range(200), store, SEED, jobs=1)
    assert list(rows) == studies.run(draw, range(200), seed=SEED, jobs=1)
    return content(store)


def chunks_of(store):
    return {path.name: path.read_bytes() for path in store.glob("[!_]*.parquet")}


# --- rows


def test_rows_come_in_order_with_their_seeds(tmp_path):
    rows = studies.run(draw, range(10), seed=SEED, jobs=1)
    assert [row["case"] for row in rows] == [0, 1, 2, 3, 4, 5, 6, 6, 8, 9]
    spawned = np.random.SeedSequence(SEED).spawn(10)
    for row in rows:
        seed = int(spawned[row["case"]].generate_state(1, np.uint64)[0])
        assert row["case_seed"] == seed == studies.runner.case_seed(SEED, row["case"])
        number = np.random.default_rng(seed).normal()
        assert row["number"] in (number, None)
        assert row["failure"] == (f"NoPath: none for {number}" if row["case"] == 5 else None)
    assert studies.run(draw, [], jobs=1) == list(studies.run(draw, [], tmp_path)) == []


def test_a_failing_case_is_run_again_alone(tmp_path):
    rows = list(studies.run(draw, iter(range(10)), tmp_path, SEED, jobs=1))
    (failed,) = (row for row in rows if row["failure"])
    with pytest.raises(fs.NoPath) as raised:
        studies.replay(tmp_path, failed)
    assert failed["failure"] == f"NoPath: {raised.value}"
    assert studies.replay(tmp_path, 3)["number"] == rows[3]["number"]
    with pytest.raises(fs.NoPath, match=str(raised.value)):
        studies.run(draw, range(10), seed=SEED, jobs=1, strict=True)
    with pytest.raises(fs.InvalidData, match="no case 10"):
        studies.replay(tmp_path, 10)
    (tmp_path / runner.FUNCTION).write_bytes(b"none")
    with pytest.raises(fs.InvalidData, match="cannot be read"):
        studies.replay(tmp_path, 3)


def test_a_bar_shows_rate_and_remaining_time(capsys):
    studies.run(draw, range(40), jobs=1, chunk_time=0.01, progress=True)
    shown = capsys.readouterr().err
    assert "40/40" in shown
    assert "case/s" in shown
    assert "<00:00" in shown
    studies.run(draw, range(40), jobs=1)
    assert not capsys.readouterr().err


# --- wherever it runs


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_rows_are_equal_for_any_number_of_workers(backend, expected, tmp_path):
    for jobs in (1, 2, 4):
        with parallel_config(backend):
            in_pieces(tmp_path / f"{jobs}", 200, jobs=jobs)
        assert content(tmp_path / f"{jobs}") == expected


def test_all_cores_by_default_and_what_the_caller_configures():
    processes = {row["process"] for row in studies.run(where, range(20), chunk_time=1e-6)}
    assert os.getpid() not in processes
    with parallel_config("threading"):
        (row,) = studies.run(where, [0])
    assert row["process"] == os.getpid()


def test_a_worker_that_dies_takes_nothing_along(expected, tmp_path):
    study = partial(draw, dies=tmp_path / "died")
    rows = list(studies.run(study, range(200), tmp_path / "store", SEED, jobs=2, chunk_time=0.01))
    assert (tmp_path / "died").exists()
    assert rows == studies.run(draw, range(200), seed=SEED, jobs=1)
    assert content(tmp_path / "store") == expected


def ends_its_worker(case, seed):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_case_that_ends_every_worker_ends_the_study(monkeypatch):
    monkeypatch.setattr(runner, "MOST_DEATHS", 1)
    with pytest.raises(fs.FreesegError, match="failed 2 times with the cases from 0 on"):
        studies.run(ends_its_worker, [0], jobs=2)


def test_a_cluster_of_processes_gives_the_same_though_one_dies(expected, tmp_path, monkeypatch):
    from distributed import Client, LocalCluster

    # Its workers are to find this module.
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(TESTS), *sys.path]))
    study = partial(draw, dies=tmp_path / "died")
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with (
        LocalCluster(processes=True, silence_logs=50, **options) as cluster,
        Client(cluster) as client,
        parallel_config("dask"),
    ):
        # With one of them, joblib would stay in this process.
        client.wait_for_workers(2)
        found = {row["process"] for row in studies.run(where, range(40), chunk_time=1e-6)}
        studies.run(study, range(200), tmp_path / "store", SEED, chunk_time=0.01)
        client.wait_for_workers(2)
        monkeypatch.setattr(runner, "MOST_DEATHS", 0)
        with pytest.raises(fs.FreesegError, match=r"failed 1 times.*KilledWorker"):
            studies.run(ends_its_worker, [0])
    assert (tmp_path / "died").exists()
    assert content(tmp_path / "store") == expected
    assert os.getpid() not in found


def plan_in(case, seed, world):
    """Plan, and say how often this process has prepared a world."""
    fs.plan_rooms(world, *fs.random_query(world, case))
    return {"process": os.getpid(), "prepared": triangulate.cache_info().misses}


def test_worlds_keep_their_caches_in_workers():
    study = partial(plan_in, world=fs.random_world(8, 1))
    rows = studies.run(study, range(40), jobs=2, chunk_time=1e-6, strict=True)
    for process in {row["process"] for row in rows}:
        # Many chunks, in each of which the world was received anew.
        assert len({row["prepared"] for row in rows if row["process"] == process}) == 1


def test_a_world_is_the_same_object_whenever_it_is_received():
    holed = fs.Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (2, 1), (2, 2)]])
    world = fs.World([fs.Disc((6, 6), 1), holed], [(-1, -1), (9, -1), (9, 9), (-1, 9)])
    sent = pickle.dumps(world)
    found = pickle.loads(sent)
    assert pickle.loads(sent) is found
    # What was prepared is not sent, and does not make it another one.
    assert len(world.cores) == 3
    assert pickle.loads(pickle.dumps(world)) is found
    assert pickle.loads(pickle.dumps(fs.World(world.obstacles[:1]))) is not found
    assert_array_equal(found.edges, world.edges)
    assert_array_equal(found.radii, world.radii)
    assert_array_equal(found.boundary, world.boundary)
    assert found.frame == 2
    for obstacle in found:
        assert not any(ring.flags.writeable for ring in obstacle.rings)


# --- whatever ends it

STUDY = """
from test_runner import *
print("ready", flush=True)
studies.run(partial(draw, pause=0.01), range(1000), sys.argv[1], SEED, jobs=2, chunk_time=0.05)
"""


def test_ten_kills_at_random_moments_lose_nothing(tmp_path):
    store, chance = tmp_path / "store", random.Random(0)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])}
    kept, sizes = {}, []
    for kill in range(10):
        killed = subprocess.Popen(
            [sys.executable, "-c", STUDY, store],
            stdout=subprocess.PIPE,
            env=environment,
            start_new_session=True,
        )
        assert killed.stdout.readline() == b"ready\n"
        # Every second time it gets as far as a chunk more; else it may not even begin.
        while kill % 2 and chunks_of(store).keys() <= kept.keys():
            assert killed.poll() is None
            time.sleep(0.01)
        time.sleep(chance.uniform(0, 0.7))
        os.killpg(killed.pid, signal.SIGKILL)
        assert killed.wait() == -signal.SIGKILL
        killed.stdout.close()
        found = chunks_of(store)
        assert kept.items() <= found.items()
        kept = found
        sizes.append(len(kept))
    assert len(set(sizes)) >= 5
    study = partial(draw, pause=0.01)
    studies.run(study, range(1000), store, SEED, jobs=4)
    assert kept.items() <= chunks_of(store).items()
    studies.run(draw, range(1000), tmp_path / "whole", SEED, jobs=1)
    assert content(store) == content(tmp_path / "whole")


def test_more_cases_are_added_to_what_is_there(expected, tmp_path):
    in_pieces(tmp_path, 50, jobs=1)
    kept = chunks_of(tmp_path)
    in_pieces(tmp_path, 200, jobs=1)
    assert kept.items() <= chunks_of(tmp_path).items()
    assert content(tmp_path) == expected


@pytest.mark.parametrize("damage", [lambda whole: whole[:-1], lambda whole: b"\0" + whole[1:]])
def test_a_damaged_chunk_is_named_and_computed_again(damage, expected, tmp_path):
    in_pieces(tmp_path, 200, jobs=1)
    broken = sorted(tmp_path.glob("0*.parquet"))[3]
    broken.write_bytes(damage(broken.read_bytes()))
    with pytest.raises(fs.InvalidData, match=f"{broken.name} is damaged"):
        studies.load(tmp_path)
    with pytest.warns(UserWarning, match=f"{broken.name} is damaged"):
        in_pieces(tmp_path, 200, jobs=1)
    assert content(tmp_path) == expected
    assert (tmp_path / f"_damaged-{broken.name}").exists()


def test_two_runs_at_once_make_no_row_twice(expected, tmp_path):
    in_pieces(tmp_path / "one", 200, jobs=1)
    studies.run(draw, range(200), tmp_path / "two", SEED, jobs=1)
    for name, whole in islice(chunks_of(tmp_path / "two").items(), 1, None, 2):
        (tmp_path / "one" / name).write_bytes(whole)
    assert content(tmp_path / "one") == expected


def fill(case, seed, folder, full):
    """The disk gets full with case 50, once."""
    if case == 50 and not full.exists():
        full.touch()
        (folder / store_module.UNFINISHED).unlink(missing_ok=True)
        (folder / store_module.UNFINISHED).symlink_to("/dev/full")
    return draw(case, seed)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a full disk ready")
def test_a_full_disk_loses_nothing(expected, tmp_path):
    store = tmp_path / "store"
    study = partial(fill, folder=store, full=tmp_path / "full")
    with pytest.raises(fs.InvalidData, match=r"No space left.*run the study again"):
        studies.run(study, range(200), store, SEED, jobs=1, chunk_time=0.001)
    kept = chunks_of(store)
    assert 0 < studies.load(store).count_rows() <= 50
    (store / store_module.UNFINISHED).unlink()
    studies.run(study, range(200), store, SEED, jobs=1)
    assert kept.items() <= chunks_of(store).items()
    assert content(store) == expected


@pytest.fixture
def read_only():
    """A folder that this process cannot write into, though it be root's."""
    with tempfile.TemporaryDirectory() as folder:
        user = os.geteuid()
        Path(folder).chmod(0o555)
        if user == 0:
            os.seteuid(65534)
        yield Path(folder)
        os.seteuid(user)


def count(case, seed, made):
    made.append(case)
    return {}


def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_computed(read_only):
    for store in (read_only, read_only / "deeper"):
        with pytest.raises(fs.InvalidData, match=r"cannot be written.*writable"):
            studies.run(partial(count, made=(made := [])), range(3), store, jobs=1)
        assert made == []


def test_a_complete_study_can_be_read_where_nothing_can_be_written(expected, read_only):
    user = os.geteuid()
    os.seteuid(read_only.stat().st_uid)
    read_only.chmod(0o755)
    rows = in_pieces(read_only, 50, jobs=1)
    read_only.chmod(0o555)
    os.seteuid(user)
    assert in_pieces(read_only, 50, jobs=1) == rows
    with pytest.raises(fs.InvalidData, match="cannot be written"):
        in_pieces(read_only, 60, jobs=1)


# --- what is refused


def gives(case, seed, what=None):
    return what[case]


def test_another_study_is_refused(tmp_path):
    study = partial(gives, what=[{"x": 1}, {"x": 2}])
    studies.run(study, [0, 1], tmp_path, jobs=1, chunk_time=1e-6)
    kept = chunks_of(tmp_path)
    for function, cases, seed, named in (
        (partial(gives, what=[{"x": 1}, {"x": 3}]), [0, 1], 0, "another study"),
        (draw, [0, 1], 0, "another study"),
        (study, [0, 1], 1, "another study"),
        (study, [0, 0], 0, "other cases than those from 1 to 1"),
        (study, [0], 0, "cases up to number 1, more than"),
    ):
        with pytest.raises(fs.InvalidData, match=named):
            studies.run(function, cases, tmp_path, seed, jobs=1)
        assert chunks_of(tmp_path) == kept


def test_what_cannot_be_stored_is_named(tmp_path):
    rows = [{"x": object()}, {"x": 1}, {"x": "one"}, {"case": 1}, 5, {1: 2}]
    study = partial(gives, what=rows)
    in_memory = studies.run(study, range(1, 6), jobs=1)
    for row, told in zip(
        in_memory[2:], ("none of them called case", "int", "dict of texts"), strict=True
    ):
        assert told in row["failure"]
    with pytest.raises(fs.InvalidParameter, match="no record can be kept"):
        studies.run(study, [0], tmp_path / "object", jobs=1)
    with pytest.raises(fs.InvalidParameter, match="no record can be kept"):
        studies.run(lambda case, seed: {}, [0], tmp_path / "lambda", jobs=1)
    with pytest.raises(fs.InvalidParameter, match="no record can be kept"):
        studies.run(draw, [{1, 2}], tmp_path / "set", jobs=1)
    with pytest.raises(fs.InvalidParameter, match=r"values x that cannot be stored"):
        studies.run(unstorable, [0], tmp_path / "unstorable", jobs=1)
    with pytest.raises(fs.InvalidData, match="column of several kinds"):
        studies.run(
            partial(gives, what=rows[1:3]), [0, 1], tmp_path / "kinds", jobs=1, chunk_time=1e-6
        )


def unstorable(case, seed):
    return {"x": object()}


def test_a_folder_of_something_else_is_refused(tmp_path):
    parquet.write_table(pa.table({"x": [1]}), tmp_path / "mine.parquet")
    for call in (studies.load, lambda store: studies.run(draw, [1], store)):
        with pytest.raises(fs.InvalidData, match=r"mine\.parquet is no chunk"):
            call(tmp_path)
    with pytest.raises(fs.InvalidData, match="cannot be written"):
        studies.run(draw, [1], tmp_path / "mine.parquet")
    with pytest.raises(fs.InvalidData, match="holds no rows"):
        studies.load(tmp_path / "nowhere")


def test_parameters_are_recorded_and_can_be_read(tmp_path):
    world = fs.World([fs.Disc((0, 1), 0.5)])
    study = partial(draw, pause=np.float64(0), dies=None)
    studies.run(
        partial(ignores, parts=[world, fs.Pid(), np.arange(2), where, tmp_path, study]),
        [0],
        tmp_path,
    )
    (path,) = tmp_path.glob("0*.parquet")
    told = parquet.read_schema(path).metadata[b"study"].decode()
    for part in (
        '"center": [0.0, 1.0], "radius": 0.5',
        '"kp_x"',
        "[0, 1]",
        ".where",
        str(tmp_path),
    ):
        assert part in told
    assert '"pause": 0.0' in told


def ignores(case, seed, parts):
    return {"parts": len(parts)}


def test_the_page_s_study_runs(tmp_path):
    page = (TESTS.parent / "docs" / "from_laptop_to_cluster.md").read_text(encoding="utf-8")
    study = re.search(r"```python\n(.*?)```", page, re.S)[1].replace("range(1000)", "range(3)")
    (tmp_path / "study.py").write_text(study)
    told = {"cwd": tmp_path, "capture_output": True, "text": True, "check": True}
    done = subprocess.run([sys.executable, "study.py"], **told)
    assert "error: [[0.00" in done.stdout
    assert studies.load(tmp_path / "results" / "pid").to_table()["failure"].null_count == 3


# --- how much memory it takes

MANY = """
import resource
from test_runner import *
runner.MOST_CASES = 2000
def highest(rows, store):
    found = studies.run(many, iter(range(rows)), store, jobs=1)
    assert sum(1 for row in found) == rows
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
few = highest(20_000, sys.argv[1] + "few")
print(highest(120_000, sys.argv[1] + "many") - few)
"""


def many(case, seed):
    return {name: float(seed + place) for place, name in enumerate("abcdefgh")}


def test_memory_does_not_grow_with_the_number_of_rows(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])}
    told = {"env": environment, "capture_output": True, "text": True, "check": True}
    done = subprocess.run([sys.executable, "-c", MANY, tmp_path / "store"], **told)
    # Rows in memory, dicts of eight numbers and more, would take a hundred megabytes.
    assert float(done.stdout) < 30
