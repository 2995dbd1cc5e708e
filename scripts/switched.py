"""A copy of the workspace in which many faults are compiled at once, each behind a switch, and the running of its tests.

For `scripts/faults` and `scripts/mutants-at-once`. The variable SPPM_FAULT names the fault that is in force when a program
starts; the crate in `faults/` reads it. The sources hold no switch.
"""

import contextlib
import fcntl
import json
import os
import re
import resource
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Built crates of both scripts: what the workspace depends on is built once.
BUILT = ROOT / "target" / "faults" / "target"
# The Python package asks for other features of these.
BUILT_PYTHON = ROOT / "target" / "faults" / "python"
# All but the Python package.
PACKAGES = "sppm scene files lanes reference fast compare render importers figure view plots ladder tuner".split()

# As Rust's tests tell it, and as pytest does.
FAILED = re.compile(r"^test (\S+)(?: - should panic)? \.\.\. .*FAILED|^(\S+\.py::.*?) (?:FAILED|ERROR)\b")
RESULT = re.compile(r"^test (\S+) ")
# Address space that a suite may take: what a fault asks for beyond this must not be taken from other programs.
MEMORY = 16 << 30


@dataclass
class Suite:
    """A program of tests, and the folder that it runs in."""

    program: Path
    folder: Path
    environment: dict[str, str] = field(default_factory=dict)

    def command(self, filters: list[str], excused: set[str]) -> list[str]:
        """Runs the tests that match a filter, but for those that are excused."""
        skips = [word for test in sorted(excused) for word in ("--skip", test)]
        return [str(self.program), *filters, *skips, "--test-threads=2"]


class PythonSuite(Suite):
    """The tests of the Python package. Its filters are files of python/tests."""

    def command(self, filters: list[str], excused: set[str]) -> list[str]:
        tests = [f"python/tests/{name}" for name in filters or [""]]
        skips = [word for test in sorted(excused) for word in ("--deselect", test)]
        options = ["-vv", "-p", "no:cacheprovider", "-c", "python/pyproject.toml", "--rootdir", "python"]
        return ["scripts/python", "-m", "pytest", *options, *tests, *skips]


def fail(message: str):
    sys.exit(f"scripts/{Path(sys.argv[0]).name}: {message}")


def alone():
    """Waits until no other script holds the built programs, and holds them until this one ends: those of another set of
    faults would take the place of these while they are run, without a word."""
    BUILT.mkdir(parents=True, exist_ok=True)
    lock = open(BUILT / "lock", "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        print("another script has faults built and runs them; waiting for it to end", file=sys.stderr, flush=True)
        fcntl.flock(lock, fcntl.LOCK_EX)
    return lock


def switch(number: int) -> str:
    """The expression that tells whether a fault is in force."""
    return f"faults::is({number})"


def files() -> list[str]:
    """The files of the repository that exist, as they are now."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listing = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True).stdout
    return [name for name in listing.decode().split("\0") if name and (ROOT / name).is_file()]


def write(path: Path, data: bytes):
    """Writes a file unless it holds that already, so that cargo need not build again."""
    if not path.exists() or path.read_bytes() != data:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def make_copy(copy: Path, changed: dict[str, bytes], faults: list[str]):
    """Copies the repository, with other texts of some files, to which the faults of these names belong."""
    names = files()
    crates = {Path(name).parts[0] if not name.startswith("src/") else "." for name in changed}
    for name in names:
        data = changed.get(name) or (ROOT / name).read_bytes()
        if name == "Cargo.toml":
            data = data.replace(b"members = [", b'members = ["faults", ', 1)
            # The switches stand in parentheses, whether these are needed or not.
            data = data.replace(b"\n[workspace.lints.rust]\n", b'\n[workspace.lints.rust]\nunused_parens = "allow"\n', 1)
        folder = str(Path(name).parent)
        if Path(name).name == "Cargo.toml" and folder in crates:
            at = "faults" if folder == "." else "../faults"
            line = f'\n[dependencies]\nfaults = {{ path = "{at}" }}\n'.encode()
            data = data.replace(b"\n[dependencies]\n", line, 1)
        if name == "faults/Cargo.toml":
            data = data.replace(b"\n[workspace]\n", b"")
        if name == "faults/src/names.rs":
            quoted = ", ".join(json.dumps(fault) for fault in faults)
            data = data.replace(b"&[];", f"&[{quoted}];".encode())
        if name != "Cargo.lock":
            write(copy / name, data)
            shutil.copymode(ROOT / name, copy / name)
    if not (copy / "Cargo.lock").exists():
        shutil.copy(ROOT / "Cargo.lock", copy / "Cargo.lock")
    for path in copy.rglob("*.rs"):
        if str(path.relative_to(copy)) not in names:
            path.unlink()


def cargo(copy: Path, *words: str) -> tuple[bool, list[dict]]:
    """Runs cargo in the copy. Returns whether it went well, and its messages."""
    # Without a network from here on: the copy's lock file gains the crate of the switches, and nothing else may change.
    subprocess.run(["cargo", "fetch", "--locked"], cwd=ROOT, check=True)
    command = ["cargo", *words, "--offline", "--message-format=json"]
    environment = {**os.environ, "CARGO_TARGET_DIR": str(BUILT)}
    done = subprocess.run(command, cwd=copy, env=environment, stdout=subprocess.PIPE, text=True)
    messages = [json.loads(line) for line in done.stdout.splitlines()]
    if done.returncode and not errors(messages):
        fail(f"cargo {words[0]} failed in {copy}")
    return done.returncode == 0, messages


def errors(messages: list[dict]) -> list[dict]:
    """What the compiler refuses, each as rustc tells it."""
    told = [message["message"] for message in messages if message["reason"] == "compiler-message"]
    return [message for message in told if message["level"].startswith("error")]


def suite_name(target: dict) -> str:
    if "test" in target["kind"]:
        return target["name"]
    # The library and the program of a package have the same name.
    return f"{target['name']}, {'program' if 'bin' in target['kind'] else 'unit tests'}"


def selection(copy: Path, suites: Iterable[str]) -> list[str]:
    """The words by which cargo builds these suites."""
    packages, targets = [], []
    for name in suites:
        crate, _, is_of_crate = name.partition(", ")
        places = {package: copy / ("" if package == "sppm" else package) / "tests" for package in PACKAGES}
        owners = [p for p, tests in places.items() if (tests / f"{name}.rs").exists() or (tests / name / "main.rs").exists()]
        packages += [crate] if is_of_crate else owners
        targets.append("--lib" if is_of_crate else f"--test={name}")
    return [*(f"--package={package}" for package in dict.fromkeys(packages)), *dict.fromkeys(targets)]


def build(copy: Path, suites: Iterable[str] | None = None) -> tuple[dict[str, Suite], list[dict]]:
    """Builds these suites, or the tests of all crates. Returns the suites by name, and what the compiler refuses."""
    everything = [word for package in PACKAGES for word in ("-p", package)]
    went, messages = cargo(copy, "test", "--no-run", *(everything if suites is None else selection(copy, suites)))
    if not went:
        return {}, errors(messages)
    suites = {}
    for message in messages:
        if message["reason"] == "compiler-artifact" and message["executable"] and message["profile"]["test"]:
            folder = Path(message["manifest_path"]).parent
            suites[suite_name(message["target"])] = Suite(Path(message["executable"]), folder)
    return suites, []


def build_python(copy: Path) -> PythonSuite:
    """Builds the command and the Python package, and installs the latter."""
    (copy / "target").mkdir(exist_ok=True)
    needed = {"SPPM_REQUIREMENTS": "python/requirements.lock"}
    # The packages that it needs are installed once, in the repository.
    subprocess.run(["scripts/python", "--version"], cwd=ROOT, env=os.environ | needed, check=True, stdout=subprocess.DEVNULL)
    for installed in (ROOT / "target").glob("python-" + "?" * 12):
        link = copy / "target" / installed.name
        if not link.exists():
            link.symlink_to(installed)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(BUILT_PYTHON)}
    subprocess.run(["cargo", "build", "--quiet", "--offline", "-p", "sppm"], cwd=copy, env=environment, check=True)
    wheel = subprocess.run(["scripts/python-wheel"], cwd=copy, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    needed |= {"PYTHONPATH": wheel.stdout.strip(), "SPPM": str(BUILT_PYTHON / "debug" / "sppm")}
    return PythonSuite(BUILT_PYTHON / "debug" / "lib_sppm.so", copy, needed)


def run(suite: Suite, filters: list[str], fault: str | None, excused: set[str], limit: float) -> Iterator[str]:
    """Runs a suite. Yields the tests that fail as they do; stops the suite when it is closed. One that takes more than
    `limit` seconds does not end, which a person would notice."""
    environment = {k: v for k, v in os.environ.items() if k != "SPPM_FAULT"} | suite.environment
    if fault is not None:
        environment["SPPM_FAULT"] = fault
    environment["RUST_BACKTRACE"] = "0"
    # A fault may be in the reference alone, where the tests of physics find it if that renders all of their pictures.
    environment["SPPM_PHYSICS_ENGINE"] = "reference"
    began, seen = time.monotonic(), False
    process = subprocess.Popen(
        suite.command(filters, excused),
        cwd=suite.folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )
    # Linux gives a session its share of the processor whatever the niceness of its processes, unless it has one itself.
    with contextlib.suppress(OSError):
        Path(f"/proc/{process.pid}/autogroup").write_text(str(os.nice(0)))
    rest, test = "", None
    try:
        while True:
            ready, _, _ = select.select([process.stdout], [], [], 1.0)
            chunk = os.read(process.stdout.fileno(), 1 << 16) if ready else b""
            rest += chunk.decode(errors="replace")
            *lines, rest = rest.split("\n")
            for line in lines:
                if match := RESULT.match(line):
                    test = match[1]
                if (match := FAILED.match(line)) or line == "FAILED":
                    seen = True
                    yield match[match.lastindex] if match else test
            if time.monotonic() - began > limit:
                yield f"no end within {limit:.0f} s"
                return
            if ready and not chunk:
                break
        if process.wait() and not seen:
            yield "the suite broke off"
    finally:
        # Programs that the suite has started and that do not end outlive it.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, 9)
        process.wait()


def entries(suites: list[str]) -> list[tuple[str, list[str]]]:
    """Suites as a table lists them, each with the filters of tests that run."""
    return [(name, filters.split()) for name, _, filters in (entry.partition(": ") for entry in suites)]


def limit_memory():
    """From here on, this script and what it starts take no more than `MEMORY`."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def baseline(suites: dict[str, Suite], names: set[str], known_file: Path) -> dict[str, dict]:
    """Per suite the tests that fail without a fault, and its seconds. What is known of a program that was not built anew
    is kept."""
    limit_memory()
    known = json.loads(known_file.read_text()) if known_file.exists() else {}
    for name in sorted(names):
        if name not in suites:
            fail(f"there is no suite {name}; there are {', '.join(sorted(suites))}")
        built = suites[name].program.stat().st_mtime
        if known.get(name, {}).get("built") != built:
            began = time.monotonic()
            failing = sorted(run(suites[name], [], None, set(), float("inf")))
            seconds = time.monotonic() - began
            known[name] = {"built": built, "failing": failing, "seconds": seconds}
            known_file.write_text(json.dumps(known, indent=1))
            told = f", but for {', '.join(failing)}" if failing else ""
            print(f"without a fault: {name} passes in {seconds:.0f} s{told}", flush=True)
    return known
