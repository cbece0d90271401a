"""A fleet of small recordings: one machine, and clusters of two workers, make the same table."""

import contextlib
import json
import multiprocessing
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


def dying(fleet, table, asked):
    """What a worker does, every call told to a file; but the first to make the third part is killed half way."""
    make = part_of(fleet, table, True)
    journal = table.with_name(f"{table.name}.rows.3-of-{PARTS}.jsonl")
    half = AXES * DAYS // PARTS // 2

    def kill():
        while not journal.exists() or len(journal.read_bytes().splitlines()) <= half:
            time.sleep(1e-3)
        os.kill(os.getpid(), signal.SIGKILL)

    def make_or_die(item):
        with asked.open("a+") as file:
            file.seek(0)
            is_first = item["part"] not in file.read().split()
            file.write(f"{item['part']} {os.getpid()}\n")
        if item["part"].startswith("3/") and is_first:
            threading.Thread(target=kill, daemon=True).start()
        return make(item)

    return make_or_die


def run_cluster(engine, fleet, table, asked):
    """A cluster of two workers makes all parts."""
    make = dying(fleet, table, asked)
    if engine == "ray":
        import ray

        ray.init(num_cpus=2, include_dashboard=False)
        by_ray(make)
        ray.shutdown()
    else:
        from dask.distributed import Client, LocalCluster

        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            by_dask(client, make)


def calls(asked):
    """Parts and the processes that were asked for them."""
    return [tuple(line.split()) for line in asked.read_text().splitlines()] if asked.exists() else []


@pytest.mark.skipif(not LONG, reason="clusters are asked by `cargo xtask test --all python`")
@pytest.mark.parametrize("engine", ["dask", "ray"])
def test_a_cluster_makes_the_table_of_one_machine_though_it_is_killed(engine, fleet, alone, tmp_path):
    """First a worker half way through a part, then both workers and what asked them half way through the fleet."""
    table, asked = tmp_path / "fleet.parquet", tmp_path / "asked"

    def start():
        process = multiprocessing.get_context("spawn").Process(target=run_cluster, args=(engine, fleet, table, asked))
        process.start()
        return process

    def journals():
        return {path: path.read_bytes() for path in sorted(tmp_path.glob(f"{table.name}.rows.*.jsonl"))}

    def files():
        return [file for path in journals() for file in rows_of(path)]

    cluster = start()
    while len(files()) < AXES * DAYS // 2:
        assert cluster.is_alive()
        time.sleep(0.05)
    cluster.kill()
    before = calls(asked)
    for process in {process for _, process in before}:
        with contextlib.suppress(ProcessLookupError):
            os.kill(int(process), signal.SIGKILL)
    cluster.join()
    kept, rows = journals(), files()
    assert len(rows) < AXES * DAYS and not table.exists()
    # The engine asked again for what the worker that was killed had in hand or had not yet handed over, and for nothing else.
    killed = next(process for part, process in before if part.startswith("3/"))
    again = {part for part, _ in before if [other for other, _ in before].count(part) > 1}
    assert f"3/{PARTS}" in again and all((part, killed) in before for part in again)

    cluster = start()
    cluster.join()
    assert cluster.exitcode == 0
    after = calls(asked)[len(before):]
    assert sorted(part for part, _ in after) == sorted(f"{i + 1}/{PARTS}" for i in range(PARTS))
    # What was there is there, and no row was made twice: but the recordings in hand nothing was lost.
    assert all(journal.startswith(kept.get(path, b"")) for path, journal in journals().items())
    assert sorted(files()) == sorted(alone["file"])
    print(f"{engine}: killed with {len(rows)} of {AXES * DAYS} rows, {len(again)} parts asked again before; the rest made once")
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)
