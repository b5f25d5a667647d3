"""The same trials on a real Ray cluster of two nodes, one of which is killed on the way."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("ray")

from cavalcade.campaign.definition import Definition
from cavalcade.campaign.dispatch import dispatch
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.engines.ray import ClusterError, RayEngine
from cavalcade.campaign.runner import run_campaign

# Ray leaves sockets and files to the end of the process.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

Table = Callable[[Path], list[dict[str, Any]]]


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch, planted: Any) -> Iterator[Any]:
    """Two nodes of one core each."""
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    import ray
    from ray.cluster_utils import Cluster

    node = {"num_cpus": 1, "object_store_memory": 80_000_000, "include_dashboard": False}
    made = Cluster(initialize_head=True, head_node_args=node)
    try:
        made.second = made.add_node(num_cpus=1, object_store_memory=80_000_000)
        made.wait_for_nodes()
        monkeypatch.setenv("RAY_ADDRESS", made.address)
        yield made
    finally:
        ray.shutdown()
        made.shutdown()


@pytest.mark.usefixtures("no_report")
def test_two_nodes_and_one_killed_on_the_way(
    cluster: Any,
    tiny_plan: Definition,
    table: Table,
    tmp_path: Path,
    planted: Any,
    in_this_process: Engine,
) -> None:
    run_campaign(tiny_plan, tmp_path / "local", in_this_process)
    run_campaign(tiny_plan, tmp_path / "ray", RayEngine())
    assert table(tmp_path / "ray") == table(tmp_path / "local")

    # Both nodes are in the middle of a trial when one of them goes.
    killed: list[float] = []

    def kill_one() -> None:
        waiting = list(planted.FOLDER.glob("pid-*"))
        if len(waiting) >= 2 and not killed:
            killed.append(time.monotonic())
            cluster.remove_node(cluster.second, allow_graceful=False)
            (planted.FOLDER / "go").touch()

    with RayEngine() as engine:
        assert engine.workers == 2
        work = planted.waits_once
        lines = list(dispatch(engine, tiny_plan.trials, 60.0, work=work, tick=kill_one))
    assert killed
    assert sorted(line["trial"] for line in lines) == sorted(t.id for t in tiny_plan.trials)
    assert all(line["success"] for line in lines)


def test_time_limits_and_crashes(
    tiny_plan: Definition, planted: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    chosen = [trial for trial in tiny_plan.trials if trial.disturbance == "none"]
    with RayEngine(2) as engine:
        lines = list(dispatch(engine, chosen, 1.5, work=planted.sleeps))
        late = {line["trial"]: line["detail"] for line in lines if line["outcome"] == "overtime"}
        assert late == {"short.0001.cavalcade.none": "not done within 1.5 s"}
        lines = list(dispatch(engine, chosen, 30.0, work=planted.dies_always))
        crashed = [line["trial"] for line in lines if line["outcome"] == "crashed"]
        assert crashed == ["short.0001.cavalcade.none"]
        assert (planted.FOLDER / f"deaths-{crashed[0]}").read_text() == "xx"
        (line,) = dispatch(engine, chosen[:1], 30.0, work=planted.notes_threads)
        assert line["detail"] == "1"
        assert engine.workers == 2
    import ray

    assert not ray.is_initialized()


@pytest.mark.parametrize("address", ["127.0.0.1:1", "ray://127.0.0.1:1", "127.0.0.1:99999"])
def test_a_cluster_that_is_not_there(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAY_ADDRESS", address)
    with pytest.raises(ClusterError, match=f"cannot be reached: RAY_ADDRESS={address}: "):
        RayEngine(1).__enter__()
