"""A rate instead of a single run: a suite of your own, each trial judged by the checker.

python examples/08_run_a_campaign.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import duckdb

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.engines import make_engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.statistics import wilson

SUITE = """
version: 1
suite: pair
worlds:
  - {name: clutter, sampler: generated, kind: clutter, size: [10, 6], obstacles: [6, 12],
     team: {shape: column, spacing: 0.9, robots: 2}, seeds: 6}
"""
QUERY = "SELECT count(*), count_if(success), sum(contacts) FROM read_parquet(?) WHERE feasible"

if __name__ == "__main__":  # the campaign's processes import this file
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="cavalcade-"))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pair.yaml").write_text(SUITE, encoding="utf-8")
    engine = make_engine("local", workers=2)
    run_campaign(define_campaign(folder / "pair.yaml"), folder / "pair", engine, resume=True)

    table = str(folder / "pair" / "trials.parquet")
    ((worlds, solved, contacts),) = duckdb.execute(QUERY, [table]).fetchall()
    low, high = wilson(solved, worlds)
    print(f"{solved} of {worlds} feasible worlds solved, 95 % interval {low:.0%} to {high:.0%}")
    print(f"{contacts} collisions")
    print("see", folder / "pair" / "report.html")
