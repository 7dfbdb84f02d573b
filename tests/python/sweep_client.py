"""A client that sweeps: python sweep_client.py EXECUTOR FOLDER ROWS."""

import sys

import steadyarm as sa
import sweep_jobs

if __name__ == "__main__":
    executor, folder, rows = sys.argv[1:]
    over = {"number": range(int(rows))}
    found = sa.sweep(sweep_jobs.slow, over, executor=executor, out=folder, chunk_seconds=0.1)
    print(len(found), "rows")
