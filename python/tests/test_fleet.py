"""A fleet of small recordings: one machine, and clusters of two workers, make the same table."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import preslide

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples"))

from fleet import PARTS, by_dask, by_ray, make_fleet, part_of

#: Whether the clusters are asked, as `cargo xtask test --all python` does.
LONG = os.environ.get("PRESLIDE_LONG") == "1"
#: Axes and days: the issue's 500 with clusters, fewer without.
AXES, DAYS = (20, 26) if LONG else (3, 6)


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet")
    make_fleet(folder, AXES, DAYS)
    (folder / "axis2" / "2026-11-03.csv").write_text("no recording\n")
    return folder


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("alone") / "fleet.parquet"


@pytest.fixture(scope="module")
def alone(fleet, path):
    """The table of one machine."""
    return preslide.fleet(fleet, output=path, fit_only=True)


def assert_same(table, other):
    """But for the seconds that each row took."""
    assert list(table) == list(other)
    for name in set(table) - {"seconds"}:
        np.testing.assert_array_equal(table[name], other[name], err_msg=name)


def test_a_row_a_recording(alone):
    assert len(alone["file"]) == AXES * DAYS
    assert sum(1 for error in alone["error"] if error) == 1
    worn = (alone["axis"] == "axis1") & (alone["file"] == f"axis1/2026-11-{DAYS:02}.csv")
    assert alone["alarm"][worn] == "true" and "coulomb_N" in alone["changed"][worn][0]


def test_the_table_is_read_by_polars_and_duckdb(alone, path):
    duckdb, polars = pytest.importorskip("duckdb"), pytest.importorskip("polars")
    read = polars.read_parquet(path)
    assert read.columns == list(alone)
    np.testing.assert_array_equal(read["coulomb_N"].to_numpy(), alone["coulomb_N"])
    [(count,)] = duckdb.sql(f"select count(*) from '{path}' where error is null").fetchall()
    assert count == AXES * DAYS - 1


WORKER = "import preslide, sys; preslide.fleet(sys.argv[1], output=sys.argv[2], fit_only=True, part=sys.argv[3], jobs=1)"


@pytest.mark.skipif(LONG, reason="the clusters do")
def test_parts_make_the_table_of_one_machine(fleet, alone, tmp_path):
    table = tmp_path / "fleet.parquet"
    for part in ("1/2", "2/2"):
        subprocess.run([sys.executable, "-c", WORKER, str(fleet), str(table), part], check=True)
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)


def rows_of(journal):
    """Files of the rows that a journal has; a line that was being written may be torn."""
    files = []
    for line in journal.read_text(encoding="utf-8").splitlines()[1:]:
        try:
            files.append(json.loads(line)["file"])
        except ValueError:
            continue
    return files


def test_killed_half_way_nothing_but_the_file_in_hand_is_lost(fleet, alone, tmp_path):
    table = tmp_path / "fleet.parquet"
    code = "import preslide, sys; preslide.fleet(sys.argv[1], output=sys.argv[2], fit_only=True, jobs=1)"
    worker = subprocess.Popen([sys.executable, "-c", code, str(fleet), str(table)])
    journal = tmp_path / "fleet.parquet.rows.jsonl"
    while not journal.exists() or len(journal.read_bytes().splitlines()) < AXES * DAYS // 2:
        assert worker.poll() is None
    worker.kill()
    worker.wait()
    kept = len(rows_of(journal))
    assert kept < AXES * DAYS and not table.exists()
    asked = []
    found = preslide.fleet(fleet, output=table, fit_only=True, progress=lambda what, done, all_of_it: asked.append(all_of_it))
    assert max(asked) == AXES * DAYS - kept
    assert_same(found, alone)


def dying(fleet, table, once):
    """What a worker does, but that the first to make the third part is killed half way."""
    make = part_of(fleet, table, True)
    journal = table.with_name(f"{table.name}.rows.3-of-{PARTS}.jsonl")
    half = AXES * DAYS // PARTS // 2

    def kill():
        while not journal.exists() or len(journal.read_bytes().splitlines()) <= half:
            time.sleep(1e-3)
        os.kill(os.getpid(), signal.SIGKILL)

    def make_or_die(item):
        if item["part"].startswith("3/") and not once.exists():
            once.touch()
            threading.Thread(target=kill, daemon=True).start()
        return make(item)

    return make_or_die


def assert_made_once(fleet, alone, table):
    """All parts were made, one of them by two workers, of which the second went on where the first was killed."""
    journals = sorted(table.parent.glob(f"{table.name}.rows.*.jsonl"))
    assert len(journals) == PARTS
    # Who goes on begins a line. Dask asks once more for parts whose answers the worker held, too; their rows are there.
    assert "" in table.with_name(f"{table.name}.rows.3-of-{PARTS}.jsonl").read_text(encoding="utf-8").splitlines()
    files = [file for journal in journals for file in rows_of(journal)]
    assert len(files) == AXES * DAYS and set(files) == set(alone["file"])
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)


needs_clusters = pytest.mark.skipif(not LONG, reason="clusters are asked by `cargo xtask test --all python`")


@needs_clusters
def test_dask_makes_the_table_of_one_machine_though_a_worker_is_killed(fleet, alone, tmp_path):
    from dask.distributed import Client, LocalCluster

    table = tmp_path / "fleet.parquet"
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        by_dask(client, dying(fleet, table, tmp_path / "once"))
    assert_made_once(fleet, alone, table)


@needs_clusters
def test_ray_data_makes_the_table_of_one_machine_though_a_worker_is_killed(fleet, alone, tmp_path):
    import ray

    table = tmp_path / "fleet.parquet"
    ray.init(num_cpus=2, include_dashboard=False)
    try:
        by_ray(dying(fleet, table, tmp_path / "once"))
    finally:
        ray.shutdown()
    assert_made_once(fleet, alone, table)
