#!/usr/bin/python3
"""Evaluations a second of Dask's submit(): as many bytes, as little work, as many worker processes as dispatch/20k.

Prints one number. Needs python3-distributed (Debian); evograsp itself does not.
"""
import os
import sys
import time

from distributed import Client, LocalCluster

WORKERS, TASKS, BYTES = 2, 2000, 20000


def evaluate(genome):
    return len(genome)


def generation(client):
    genomes = [os.urandom(16) + bytes(BYTES - 16) for _ in range(TASKS)]
    start = time.perf_counter()
    futures = [client.submit(evaluate, genome, pure=False) for genome in genomes]
    results = client.gather(futures)
    seconds = time.perf_counter() - start
    if results != [BYTES] * TASKS:
        sys.exit("dask: wrong results")
    return TASKS / seconds


def main():
    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, processes=True, dashboard_address=None,
                      silence_logs=50) as cluster, Client(cluster) as client:
        generation(client)
        print(f"{max(generation(client) for _ in range(2)):.1f}")


if __name__ == "__main__":
    main()
