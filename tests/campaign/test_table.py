import copy
import math
import random

import duckdb
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.campaign.table import COLUMNS, columns_and_rows, write_table
from cavalcade.errors import OutputError


def line(number=0, **changes):
    return {
        "trial": f"clutter.{number:04d}.cavalcade",
        "suite": "s",
        "scenario": "clutter",
        "variant": "cavalcade",
        "disturbance": "none",
        "seed": number,
        "outcome": "arrived",
        "detail": "",
        "success": True,
        "feasible": True,
        "level": 20.0,
        "level_name": "obstacles",
        "contacts": 0,
        "avoidable": 0,
        "violations": [],
        "measured": {"time_ratio": 1.5},
        "summary": {
            "name": f"clutter-{number}",
            "seed": 99,
            "success": False,
            "reason": "arrived",
            "involved": [],
            "sim_time_s": 31.25 + number / 3.0,
            "collisions": {"robot_robot": 0, "robot_obstacle": 0},
            "formation_error_m": {"mean": 0.1, "p95": 0.2, "max": 0.3},
            "path_length_m": [12.0, None, 12.5],
            "versions": {"python": "3.12", "numpy": "2.4.6"},
        },
        **changes,
    }


def crashed(number=0):
    return line(number, outcome="crashed", success=False, level=None, measured={}, summary={})


def read(path):
    with duckdb.connect() as connection:
        found = connection.execute(f"SELECT * FROM '{path}'")
        names = [column[0] for column in found.description]
        kinds = {column[0]: str(column[1]) for column in found.description}
        return [dict(zip(names, row, strict=True)) for row in found.fetchall()], kinds


def test_what_is_written_reads_back_equal(tmp_path):
    lines = [line(3), crashed(1), line(2, detail='it\'s "so"; 100 %\u2028é')]
    path = write_table(tmp_path, lines)
    rows, kinds = read(path)
    assert rows == columns_and_rows(lines)[1]
    assert kinds == dict(COLUMNS)
    assert [row["seed"] for row in rows] == [1, 2, 3]
    assert rows[2]["sim_time_s"] == 31.25 + 3 / 3.0
    assert rows[2]["path_length_m"] == [12.0, None, 12.5]
    assert rows[2]["formation_error_m.p95"] == 0.2
    assert rows[2]["versions.numpy"] == "2.4.6"
    assert rows[2]["measured.time_ratio"] == 1.5
    assert [entry.name for entry in tmp_path.iterdir()] == ["trials.parquet"]


def test_the_first_columns_are_the_contracts():
    first = (
        "trial, suite, scenario, variant, disturbance, seed, outcome, success, feasible, level, "
        "contacts, avoidable, detail"
    )
    assert ", ".join(list(COLUMNS)[:13]) == first


def test_the_campaigns_word_stands_over_the_summarys():
    (row,) = columns_and_rows([line(4)])[1]
    assert row["seed"] == 4
    assert row["success"] is True


@pytest.mark.parametrize("lines", [[], [crashed()], [line()], [crashed(), line(1)]])
def test_types_do_not_depend_on_the_trials(tmp_path, lines):
    rows, kinds = read(write_table(tmp_path, lines))
    assert kinds == dict(COLUMNS)
    assert len(rows) == len(lines)


def test_same_content_gives_same_bytes_whatever_the_order(tmp_path):
    lines = [line(k) for k in range(50)] + [crashed(k + 50) for k in range(5)]
    first = write_table(tmp_path, lines).read_bytes()
    random.Random(3).shuffle(lines)
    assert write_table(tmp_path, lines).read_bytes() == first


def test_a_folder_named_like_a_column_is_none(tmp_path):
    lines = [line(number) for number in range(3)]
    folder = tmp_path / "seed=42"
    folder.mkdir()
    assert write_table(folder, lines).read_bytes() == write_table(tmp_path, lines).read_bytes()


def test_keys_that_nobody_knew_come_after_the_others():
    odd = copy.deepcopy(line())
    odd["summary"]["zeal"] = 1
    odd["summary"]["energy"] = {"total_j": 5, "parts_j": [1, 2.5], "note": None}
    odd["measured"]["zest"] = True
    more = copy.deepcopy(line(1))
    more["summary"]["zeal"] = 1.5
    columns = columns_and_rows([odd, more])[0]
    assert list(columns)[len(COLUMNS) :] == [
        "energy.parts_j",
        "energy.total_j",
        "measured.zest",
        "zeal",
    ]
    assert columns["zeal"] == "DOUBLE"
    assert columns["energy.parts_j"] == "DOUBLE[]"
    assert columns["measured.zest"] == "BOOLEAN"
    assert columns["energy.total_j"] == "BIGINT"


def test_numbers_that_are_none_become_null(tmp_path):
    odd = copy.deepcopy(line())
    odd["summary"]["sim_time_s"] = math.nan
    odd["summary"]["path_length_m"] = [math.inf, 1.0]
    odd["level"] = -math.inf
    rows, _ = read(write_table(tmp_path, [odd]))
    assert rows[0]["sim_time_s"] is None
    assert rows[0]["path_length_m"] == [None, 1.0]
    assert rows[0]["level"] is None


def test_values_of_another_type_than_the_columns_become_null_or_text(tmp_path):
    odd = copy.deepcopy(line())
    odd["summary"]["sim_time_s"] = "soon"
    odd["summary"]["reason"] = 7
    odd["summary"]["robots"] = True
    rows, _ = read(write_table(tmp_path, [odd]))
    assert rows[0]["sim_time_s"] is None
    assert rows[0]["reason"] == "7"
    assert rows[0]["robots"] is None


def test_no_paths_process_ids_or_hosts():
    odd = line(detail="FileNotFoundError: /home/me/run.yaml, pid 77")
    odd["violations"] = ["1.0 s: /tmp/x/y.mcap is short"]
    odd["summary"] = {**odd["summary"], "pid": 77, "host": "box", "folder": "/x/y"}
    (row,) = columns_and_rows([odd])[1]
    assert not {"pid", "host", "folder"} & set(row)
    assert "/" not in repr(row["detail"]) + repr(row["violations"])
    assert "77" not in row["detail"]


def test_odd_keys_and_texts_do_not_spoil_the_table(tmp_path):
    odd = line(
        detail="half a pair: \ud800", summary={"Zeal": 1, "zeal": 2, "NAME": 3, "a\x00'\"b": 4}
    )
    rows, kinds = read(write_table(tmp_path, [odd, line(1, summary={"huge": 2**70, "": 1})]))
    assert list(kinds)[len(COLUMNS) :] == ["Zeal", "a'\"b", "huge"]
    assert rows[0]["detail"] == "half a pair: ?"
    assert rows[1]["huge"] is None


def test_of_two_lines_of_a_trial_the_last_counts():
    (row,) = columns_and_rows([crashed(), line()])[1]
    assert row["outcome"] == "arrived"


def test_a_folder_that_is_not_there_is_an_output_error(tmp_path):
    with pytest.raises(OutputError, match=r"trials\.parquet"):
        write_table(tmp_path / "missing", [line()])


def test_a_full_disk_leaves_the_old_table(tmp_path, monkeypatch):
    path = write_table(tmp_path, [line()])
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("cavalcade.campaign.table.os.replace", full)
    with pytest.raises(OutputError, match="No space left"):
        write_table(tmp_path, [line(), line(1)])
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["trials.parquet"]


def test_a_thousand_trials_with_many_robots(tmp_path):
    rng = np.random.default_rng(0)
    lines = [line(k) for k in range(1000)]
    for each in lines:
        each["summary"]["path_length_m"] = rng.random(16).round(6).tolist()
    rows, _ = read(write_table(tmp_path, lines))
    assert rows == columns_and_rows(lines)[1]


json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**62), 2**62) | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(min_size=1, max_size=6), inner, max_size=3)
    ),
    max_leaves=6,
)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.dictionaries(st.text(min_size=1, max_size=6), json_values, max_size=4), max_size=4)
)
def test_whatever_a_summary_holds_can_be_written(tmp_path_factory, summaries):
    lines = [{**line(k), "summary": summary} for k, summary in enumerate(summaries)]
    rows, _ = read(write_table(tmp_path_factory.mktemp("table"), lines))
    assert len(rows) == len(summaries)
