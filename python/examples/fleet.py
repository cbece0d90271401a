"""How many recordings a second a fleet takes: `python python/examples/fleet.py`, from the repository.

On one core, on two, and by workers of Ray Data and of Dask, two each, where they are installed (`pip install -r python/tests/long.txt`); each makes
the table of 520 small recordings anew. With `--diagnose` every recording is diagnosed, too, which takes longer.
"""

import os
import pathlib
import sys
import tempfile
import time

import numpy as np

import preslide

#: Axes and days, a recording each.
AXES, DAYS = 20, 26
#: Parts that workers are given.
PARTS = 16


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


def make_fleet(folder, axes=AXES, days=DAYS, seed=1):
    """A folder an axis and a recording a day; on the last day axis1 has a third more friction."""
    rng = np.random.default_rng(seed)
    for axis in range(axes):
        (folder / f"axis{axis}").mkdir()
        for day in range(days):
            wobble = 1 + 0.01 * rng.standard_normal(2)
            worn = 1.3 if axis == 1 and day == days - 1 else 1
            rows = recording(rng, 2 * wobble[0], 4 * wobble[1] * worn)
            file = folder / f"axis{axis}" / f"2026-11-{day + 1:02}.csv"
            np.savetxt(file, rows, delimiter=",", header="t_s,x_m,force_N", comments="", fmt="%.9g")


def part_of(folder, table, fit_only):
    """What a worker does: a part of the recordings, `{"part": "3/16"}`."""

    def make(item):
        preslide.fleet(folder, output=table, fit_only=fit_only, jobs=1, part=item["part"])
        return item

    return make


PARTS_TO_MAKE = [{"part": f"{i + 1}/{PARTS}"} for i in range(PARTS)]


def by_ray(make):
    """All parts by Ray Data; the cluster must be there."""
    import ray

    ray.data.from_items(PARTS_TO_MAKE, override_num_blocks=PARTS).map(make).materialize()


def by_dask(client, make):
    """All parts by Dask's workers."""
    client.gather(client.map(make, PARTS_TO_MAKE, pure=False))


def main():
    fit_only = "--diagnose" not in sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "recordings"
        folder.mkdir()
        make_fleet(folder)

        def told(what, run):
            table = pathlib.Path(name) / f"{what.split()[0]}.parquet"
            start, own = time.perf_counter(), time.process_time()
            run(table)
            # Of parts it makes the table; of a whole fleet it has been made.
            preslide.fleet(folder, output=table, fit_only=fit_only)
            seconds, cpu = time.perf_counter() - start, time.process_time() - own
            # Of workers the other processes' time is not known here.
            took = "" if "workers" in what else f"; {cpu / (AXES * DAYS):.3f} s of a core each"
            print(f"{what}: {AXES * DAYS / seconds:.1f} recordings a second, {seconds:.0f} s in all{took}", flush=True)

        print(f"{'fits' if fit_only else 'diagnoses'} of {AXES * DAYS} recordings of 600 rows, {os.cpu_count()} cores")
        told("one core", lambda table: preslide.fleet(folder, output=table, fit_only=fit_only, jobs=1))
        told("two cores", lambda table: preslide.fleet(folder, output=table, fit_only=fit_only, jobs=2))
        try:
            import ray
        except ImportError:
            print("Ray is not installed")
        else:
            ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
            told("Ray Data, two workers", lambda table: by_ray(part_of(folder, table, fit_only)))
            ray.shutdown()
        try:
            from dask.distributed import Client, LocalCluster
        except ImportError:
            print("Dask is not installed")
        else:
            with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
                told("Dask, two workers", lambda table: by_dask(client, part_of(folder, table, fit_only)))


if __name__ == "__main__":
    main()
