"""A fleet of small recordings: one machine, and clusters of two workers, make the same table."""

import os
import subprocess
import sys

import numpy as np
import pytest

import preslide

#: Whether the clusters are asked, as `cargo xtask test --all python` does.
CLUSTERS = os.environ.get("PRESLIDE_CLUSTERS") == "1"
#: Axes and days: the issue's 500 with clusters, fewer without.
AXES, DAYS = (20, 26) if CLUSTERS else (3, 6)


def recording(rng, mass, level):
    """Three seconds of a mass on Coulomb and viscous friction with two blocks."""
    t = np.arange(0, 3, 5e-3)
    x = 0.03 * np.sin(6.2 * t) + 0.01 * np.sin(16.4 * t + 1)
    v = np.gradient(x, t)
    force = mass * np.gradient(v, t) + 20 * v + 0.05 * rng.standard_normal(len(t))
    z, stiffness, share = np.zeros(2), np.array([4e4, 1.5e4]), np.array([0.6, 0.4])
    bound = share * level / stiffness
    for i in range(1, len(t)):
        z = np.clip(z + x[i] - x[i - 1], -bound, bound)
        force[i] += stiffness @ z
    return np.c_[t, x, force]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet")
    rng = np.random.default_rng(1)
    for axis in range(AXES):
        (folder / f"axis{axis}").mkdir()
        for day in range(DAYS):
            wobble = 1 + 0.01 * rng.standard_normal(2)
            worn = 1.3 if axis == 1 and day == DAYS - 1 else 1
            rows = recording(rng, 2 * wobble[0], 4 * wobble[1] * worn)
            np.savetxt(folder / f"axis{axis}" / f"2026-11-{day + 1:02}.csv", rows, delimiter=",", header="t_s,x_m,force_N", comments="", fmt="%.9g")
    (folder / "axis2" / "2026-11-03.csv").write_text("no recording\n")
    return folder


@pytest.fixture(scope="module")
def alone(fleet, tmp_path_factory):
    return preslide.fleet(fleet, output=tmp_path_factory.mktemp("alone") / "fleet.parquet", fit_only=True)


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


def test_the_table_is_read_by_polars_and_duckdb(fleet, tmp_path):
    duckdb, polars = pytest.importorskip("duckdb"), pytest.importorskip("polars")
    path = tmp_path / "fleet.parquet"
    table = preslide.fleet(fleet, output=path, fit_only=True)
    read = polars.read_parquet(path)
    assert read.columns == list(table)
    np.testing.assert_array_equal(read["coulomb_N"].to_numpy(), table["coulomb_N"])
    [(count,)] = duckdb.sql(f"select count(*) from '{path}' where error is null").fetchall()
    assert count == AXES * DAYS - 1


WORKER = "import preslide, sys; preslide.fleet(sys.argv[1], output=sys.argv[2], fit_only=True, part=sys.argv[3], jobs=1)"


def test_parts_make_the_table_of_one_machine(fleet, alone, tmp_path):
    table = tmp_path / "fleet.parquet"
    for part in ("1/2", "2/2"):
        subprocess.run([sys.executable, "-c", WORKER, str(fleet), str(table), part], check=True)
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)


needs_clusters = pytest.mark.skipif(not CLUSTERS, reason="clusters are asked by `cargo xtask test --all python`")


@needs_clusters
def test_killed_half_way_nothing_but_the_file_in_hand_is_lost(fleet, alone, tmp_path):
    table = tmp_path / "fleet.parquet"
    worker = subprocess.Popen([sys.executable, "-c", WORKER, str(fleet), str(table), "1/1"])
    journal = tmp_path / "fleet.parquet.rows.1-of-1.jsonl"
    while not journal.exists() or len(journal.read_bytes().splitlines()) < AXES * DAYS // 2:
        assert worker.poll() is None
    worker.kill()
    worker.wait()
    kept = len(journal.read_bytes().splitlines()) - 1
    asked = []
    found = preslide.fleet(fleet, output=table, fit_only=True, progress=lambda what, done, all_of_it: asked.append(all_of_it))
    # The line that was being written may be torn.
    assert AXES * DAYS - kept <= max(asked) <= AXES * DAYS - kept + 1
    assert_same(found, alone)


@needs_clusters
def test_dask_makes_the_table_of_one_machine(fleet, alone, tmp_path):
    from dask.distributed import Client, LocalCluster

    table, parts = tmp_path / "fleet.parquet", 16
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        done = [client.submit(preslide.fleet, fleet, output=table, fit_only=True, jobs=1, part=f"{i + 1}/{parts}") for i in range(parts)]
        client.gather(done)
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)


@needs_clusters
def test_ray_makes_the_table_of_one_machine(fleet, alone, tmp_path):
    import ray

    table, parts = tmp_path / "fleet.parquet", 16
    ray.init(num_cpus=2, include_dashboard=False)
    try:
        part = ray.remote(preslide.fleet)
        ray.get([part.remote(fleet, output=table, fit_only=True, jobs=1, part=f"{i + 1}/{parts}") for i in range(parts)])
    finally:
        ray.shutdown()
    assert_same(preslide.fleet(fleet, output=table, fit_only=True), alone)
