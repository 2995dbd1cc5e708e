"""The package is what its wheel says."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

import pytest

import sppm

tomllib = pytest.importorskip("tomllib")
PROJECT = Path(__file__).parents[1]


def test_versions_agree() -> None:
    cargo = tomllib.loads((PROJECT.parent / "Cargo.toml").read_text())
    assert sppm.__version__ == cargo["workspace"]["package"]["version"]


def test_the_builder_is_pinned_alike() -> None:
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())
    (builder,) = project["build-system"]["requires"]
    lines = (PROJECT / "requirements.in").read_text().splitlines()
    assert builder in [line.split()[0] for line in lines if line.startswith("maturin")]


def test_the_wheel_is_complete() -> None:
    try:
        files = importlib.metadata.files("sppm")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("not installed from a wheel")
    names = {str(file) for file in files or []}
    assert {"sppm/__init__.py", "sppm/py.typed", "sppm/_sppm.pyi", "sppm/_sppm.abi3.so"} <= names
    meta = importlib.metadata.metadata("sppm")
    assert meta["Requires-Python"] == ">=3.10" and meta["Version"] == sppm.__version__
    assert [need for need in meta.get_all("Requires-Dist") if "extra" not in need] == ["numpy>=1.26", "tqdm>=4.60"]
