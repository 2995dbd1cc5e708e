"""What each option of ``sppm farm`` comes to, without workers: everything that would begin is replaced by what notes it."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest

import sppm
from sppm import _sppm
from sppm.farm import __main__ as command
from sppm.farm import _cluster, _driver, _jobs

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

HERE = Path(__file__)

USUAL: dict[str, Any] = {
    "scenes": ["cornell"], "output": None, "sweeps": [], "quality": None,
    "settings": dict.fromkeys("iterations width height photons_per_iteration max_depth initial_radius seed filter "
                              "glint_samples".split()),
    "workers": None, "scheduler": None, "tls": {"ca": None, "certificate": None, "key": None},
    "threads": 1, "block": None, "every": 10.0, "viewer": None, "opened": False, "jobs": ["job"],
}  # fmt: skip
"""What comes of no option."""

TLS = ("--tls-ca", HERE, "--tls-cert", HERE)

OPTIONS: dict[str, tuple[tuple[object, ...], dict[str, Any]]] = {
    "--output": (("a.exr",), {"output": Path("a.exr")}),
    "--sweep": (("seed=1,2", "--sweep", "radius=3"), {"sweeps": ["seed=1,2", "radius=3"]}),
    "--iterations": ((7,), {"settings.iterations": 7}),
    "--width": ((7,), {"settings.width": 7}),
    "--height": ((7,), {"settings.height": 7}),
    "--photons": ((7,), {"settings.photons_per_iteration": 7}),
    "--depth": ((7,), {"settings.max_depth": 7}),
    "--glint-samples": ((7,), {"settings.glint_samples": 7}),
    "--radius": ((0.5,), {"settings.initial_radius": 0.5}),
    "--seed": ((0,), {"settings.seed": 0}),
    "--filter": (("gaussian",), {"settings.filter": "gaussian"}),
    "--quality": (("draft",), {"quality": "draft"}),
    "--workers": ((3,), {"workers": 3}),
    "--scheduler": (("tcp://head:8786",), {"scheduler": "tcp://head:8786"}),
    "--threads": ((3,), {"threads": 3}),
    "--block": ((5,), {"block": 5}),
    "--every": ((2.5,), {"every": 2.5}),
    "--view": ((), {"viewer": ("cornell.png", (None, None), None), "opened": True}),
    "--port": ((8000, "--view"), {"viewer": ("cornell.png", (None, 8000), None), "opened": True}),
    "--listen": (("::1", "--view"), {"viewer": ("cornell.png", ("::1", None), None), "opened": True}),
    "--no-open": (("--view",), {"viewer": ("cornell.png", (None, None), None)}),
    "--display": (("head:1",), {"viewer": ("cornell.png", None, "head:1")}),
    "--tls-ca": (TLS[1:], {"tls": {"ca": HERE, "certificate": HERE, "key": None}}),
    "--tls-cert": ((HERE, *TLS[:2]), {"tls": {"ca": HERE, "certificate": HERE, "key": None}}),
    "--tls-key": ((HERE, *TLS), {"tls": {"ca": HERE, "certificate": HERE, "key": HERE}}),
    "--quiet": ((), {}),
}
"""The rest of a command line that begins with each option, and what then is not as usual."""


@pytest.fixture
def outcome(monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, Any]]:
    found: dict[str, Any] = {}

    def jobs_of(scenes: Any, output: Any, settings: Any, sweeps: Any, quality: Any) -> list[Any]:
        found.update(scenes=scenes, output=output, settings=settings, sweeps=sweeps, quality=quality)
        return [SimpleNamespace(output=Path("cornell.png"), chosen="quality good: -n 2")]

    @contextmanager
    def client_of(workers: Any, scheduler: Any, **tls: Any) -> Generator[str]:
        found.update(workers=workers, scheduler=scheduler, tls=tls)
        yield "client"

    class Driver:
        def __init__(self, client: Any, *, viewer: Any, tell: Any, show: Any, **rest: Any) -> None:
            assert client == "client" and callable(tell) and callable(show)
            found.update(rest, viewer=viewer and viewer.given)

        def run(self, jobs: list[Any]) -> None:
            found.update(jobs=["job" for _ in jobs])

    class Viewer:
        def __init__(self, *given: Any) -> None:
            self.given, self.address = given, None if given[1] is None else "http://here"

        def open(self) -> None:
            found.update(opened=True)

    monkeypatch.setattr(_jobs, "jobs_of", jobs_of)
    monkeypatch.setattr(_cluster, "client_of", client_of)
    monkeypatch.setattr(_driver, "Driver", Driver)
    monkeypatch.setattr(_sppm, "Viewer", Viewer)

    def run(*words: object) -> dict[str, Any]:
        found.clear()
        found.update(opened=False)
        assert command.main(["cornell", *map(str, words)]) == 0
        return dict(found)

    return run


def test_every_option_reaches_what_it_is_for(outcome: Callable[..., dict[str, Any]], capsys: Any) -> None:
    assert outcome() == USUAL
    assert capsys.readouterr().err == "cornell.png: chosen for quality good: -n 2\n"
    for option, (rest, differs) in OPTIONS.items():
        expected = USUAL | {"settings": dict(USUAL["settings"])}
        for name, value in differs.items():
            place, _, setting = name.rpartition(".")
            (expected[place] if place else expected)[setting] = value
        assert outcome(option, *rest) == expected, option
        told = capsys.readouterr()
        assert told.out == ("http://here\n" if "viewer" in differs and differs["viewer"][1] else ""), option
        assert bool(told.err) == (option != "--quiet"), option
    known = {action.option_strings[-1] for action in command._parser()._actions if action.option_strings}
    assert known - {"--help"} == set(OPTIONS), "every option has a row"
    assert outcome("terrace.toml")["scenes"] == ["cornell", "terrace.toml"]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("--workers 0", "--workers 0 must be at least 1"),
        ("--threads 0", "--threads 0 must be at least 1"),
        ("--block 0", "--block 0 must be at least 1"),
        ("--block -3", "--block -3 must be at least 1"),
        ("--every 0", "--every 0.0 must be above 0 seconds"),
        ("--every nan", "--every nan must be above 0 seconds"),
        ("--workers 2 --scheduler tcp://head:1", "leave out one of the two"),
        ("--port 8000", "--port is of the page; ask for it by --view"),
        ("--listen ::1 --display head:1", "--listen is of the page"),
        ("--no-open", "--no-open is of the page"),
        ("--view --port 0", "--port 0 must be from 1 to 65535"),
        ("--view --port 65536", "--port 65536 must be from 1 to 65535"),
        (f"--tls-ca {HERE} --tls-cert nowhere.pem", "nowhere.pem: there is no such file (--tls-cert)"),
        (f"--tls-cert {HERE}", "TLS needs --tls-ca and --tls-cert"),
        (f"--tls-ca {HERE} --tls-key {HERE}", "TLS needs --tls-ca and --tls-cert"),
    ],
)
@pytest.mark.usefixtures("outcome")
def test_what_cannot_be_is_refused_before_anything_begins(words: str, why: str, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr(_cluster, "client_of", None)
    assert command.main(["cornell", *words.split()]) == 2
    told = capsys.readouterr()
    assert told.err.startswith("error: ") and why in told.err and told.err.count("\n") == 1
    assert told.out == ""


@pytest.mark.parametrize(
    ("ending", "code", "why"),
    [
        (sppm.InputError("no such scene"), 2, "error: no such scene"),
        (sppm.FileError("a.sppm: is in use"), 2, "error: a.sppm: is in use"),
        (sppm.Error("no workers"), 1, "error: no workers; what is done is kept, and the same command goes on from there"),
        (OSError("disk full"), 1, "error: disk full; what is done is kept, and the same command goes on from there"),
        (KeyboardInterrupt(), 130, "error: interrupted; what is done is kept, and the same command goes on from there"),
    ],
)
@pytest.mark.usefixtures("outcome")
def test_an_end_that_was_not_asked_for_says_what_is_left(
    ending: BaseException, code: int, why: str, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    def run(driver: Any, jobs: list[Any]) -> None:
        raise ending

    monkeypatch.setattr(_driver.Driver, "run", run)
    assert command.main(["cornell", "--quiet"]) == code
    assert capsys.readouterr().err == why + "\n"


def test_some_files_of_tls_are_enough_to_encrypt(monkeypatch: pytest.MonkeyPatch) -> None:
    """A certificate's file may hold its key."""
    made: dict[str, Any] = {}

    @contextmanager
    def client(address: str, **options: Any) -> Generator[str]:
        made.update(options, address=address)
        yield "client"

    distributed = SimpleNamespace(Client=client, Security=lambda **given: given)
    monkeypatch.setattr(_cluster.importlib, "import_module", lambda name: distributed)
    with _cluster.client_of(None, "tls://head:1", ca=HERE, certificate=HERE) as found:
        assert found == "client"
    security = made["security"]
    assert security["require_encryption"] and "tls_client_key" not in security
    names = {f"tls_{role}_cert" for role in ("client", "scheduler", "worker")}
    assert {name for name, file in security.items() if file == str(HERE)} == names | {"tls_ca_file"}
    with _cluster.client_of(None, "tcp://head:1"):
        assert made["security"] is None and made["address"] == "tcp://head:1"
