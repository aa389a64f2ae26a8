"""Throughput of a sweep here and on a Dask scheduler with two workers, side by side.

A sweep is computed in pieces, each of the same number of its members. ``python -m
tests.benchmarks.cluster`` computes the same pieces alternately by two threads and by two workers of
one thread each. It prints members per second and the overhead of the cluster. Wall time varies on a
busy machine, so the fastest of several alternating rounds counts.
"""

import argparse
import tempfile
import time
from pathlib import Path

from fivtui.io import output_path
from fivtui.model.parameters import Parameters
from fivtui.sweeps.cluster import cluster_engine
from fivtui.sweeps.design import Design, Range
from fivtui.sweeps.run import Engine, local_engine, sweep_to_file
from fivtui.sweeps.store import default_piece_size
from fivtui.sweeps.study import Study
from tests.support.dask_cluster import loopback_cluster

WORKERS = 2


def sweep_seconds(study: Study, out: Path, engine: Engine, size: int) -> float:
    start_time = time.perf_counter()
    sweep_to_file(study, output_path(out, force=True), engine, size=size)
    return time.perf_counter() - start_time


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--members", type=int, default=120_000)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    design = Design({"F": Range(10.0, 120.0), "mu": Range(0.1, 1.0)}, "sobol", args.members)
    study = Study(design, Parameters())
    size = default_piece_size(study)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        local_path, dask_path = folder / "here.parquet", folder / "there.parquet"
        with loopback_cluster(folder, WORKERS) as cluster, cluster_engine(cluster.address) as dask:
            warm_up_study = Study(Design({"F": Range(10.0, 120.0, 64)}), Parameters())
            for out, engine in ((local_path, local_engine(WORKERS)), (dask_path, dask)):
                sweep_seconds(warm_up_study, out, engine, 1)
            durations: dict[str, list[float]] = {"local": [], "dask": []}
            for _ in range(args.rounds):
                durations["local"].append(
                    sweep_seconds(study, local_path, local_engine(WORKERS), size)
                )
                durations["dask"].append(sweep_seconds(study, dask_path, dask, size))
        identical = local_path.read_bytes() == dask_path.read_bytes()
    pieces = -(-study.members // size)
    print(f"{study.members} members, {pieces} pieces of {size}, {WORKERS} threads or workers")
    for engine_name, times in durations.items():
        best, listed_times = min(times), ", ".join(f"{t:.2f}" for t in times)
        print(
            f"{engine_name:5} {best:6.2f} s  {study.members / best:7.0f} members/s  "
            f"{best * WORKERS / pieces:.2f} s a piece  (rounds: {listed_times})"
        )
    overhead = min(durations["dask"]) / min(durations["local"]) - 1.0
    print(f"overhead of dask {overhead:+.1%}; files {'the same' if identical else 'DIFFERENT'}")


if __name__ == "__main__":
    main()
