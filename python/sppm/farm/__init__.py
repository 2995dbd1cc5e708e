"""A farm: renders on many machines, by Dask distributed, to the bits of a single one.

    python -m sppm.farm cornell -n 4096 -o cornell.exr                               four workers on this machine
    python -m sppm.farm cornell -n 4096 -o cornell.exr --scheduler tcp://head:8786   those of a cluster

Iterations with global radii are independent, and their sums are exact. So a farm renders blocks of iterations in any
order and on any workers, repeats those that are lost, and adds them up in whatever order they come.
"""

from __future__ import annotations

from ._driver import Driver, FarmError
from ._jobs import Job, jobs_of

__all__ = ["Driver", "FarmError", "Job", "jobs_of"]
