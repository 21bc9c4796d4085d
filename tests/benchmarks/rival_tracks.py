"""Where rivals from elsewhere drive: ``python tests/benchmarks/rival_tracks.py``.

Notebook 13 draws all rivals in two worlds, and is to be run without the packages of
``peers.txt``. So their tracks are stored, in ``data/rival_tracks.csv``; see ``rivals.py``
beside this for what they are.
"""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from freeseg.data import DATA, write_csv
from freeseg.studies import rivals

#: The two questions: all segments are danger, and an open world.
CASES = ("paper", "16c"), ("sparse", 11)

#: Decimals of a position (m).
DECIMALS = 5


def tracks(cases=CASES):
    """A row a point of every track of every rival from elsewhere."""
    spec = spec_from_file_location("rivals", Path(__file__).with_name("rivals.py"))
    script = module_from_spec(spec)
    spec.loader.exec_module(script)
    found = script.installed()
    script.warm_up(found)
    rows = []
    for kind, number in cases:
        question = rivals.pose_question((kind, number))
        for name in script.ELSEWHERE:
            for x, y in found[name](*question):
                place = {"x": round(float(x), DECIMALS), "y": round(float(y), DECIMALS)}
                rows.append({"set": kind, "question": number, "rival": name} | place)
    return rows


if __name__ == "__main__":
    write_csv(DATA / "rival_tracks.csv", tracks())
