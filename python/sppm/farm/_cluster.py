"""The cluster: workers on this machine, or those of a scheduler."""

from __future__ import annotations

import importlib
import logging
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import sppm

if TYPE_CHECKING:
    from collections.abc import Generator
    from pathlib import Path


_QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "5s",
}
"""What Dask does many times a second in each process, to show it on pages that nobody opens here. It would take some percent of a
core for each worker."""


@contextmanager
def client_of(
    workers: int | None,
    scheduler: str | None,
    *,
    ca: Path | None = None,
    certificate: Path | None = None,
    key: Path | None = None,
) -> Generator[Any]:
    """A client of the scheduler at an address, or of so many new workers on this machine.

    With ``ca``, ``certificate`` and ``key``, files in PEM, all connections are by TLS, and both sides show certificates.
    """
    distributed: Any = importlib.import_module("distributed")
    files = {"tls_ca_file": ca, "tls_client_cert": certificate, "tls_client_key": key}
    security = None
    if any(files.values()):
        names = {name: os.fspath(file) for name, file in files.items() if file is not None}
        roles = {f"tls_{role}_{what}": names[f"tls_client_{what}"] for role in ("scheduler", "worker")
                 for what in ("cert", "key") if f"tls_client_{what}" in names}
        security = distributed.Security(require_encryption=True, **names, **roles)
    if scheduler is not None:
        with distributed.Client(scheduler, security=security, timeout=30, set_as_default=False) as client:
            yield client
        return
    count = workers or default_workers()
    dask: Any = importlib.import_module("dask")
    with dask.config.set(_QUIET), distributed.LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        processes=True,
        dashboard_address=":0",
        security=security,
        host="127.0.0.1",
        # The driver says what happens to workers.
        silence_logs=logging.ERROR,
    ) as cluster, distributed.Client(cluster, security=security, set_as_default=False) as client:
        yield client


def default_workers() -> int:
    """One worker per core, each of which renders on one thread: so there is always one that is not merging."""
    return max(1, sppm.cores())
