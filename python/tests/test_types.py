"""Types and documentation: complete, and as the running module has them."""

from __future__ import annotations

import inspect
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sppm

PACKAGE = Path(sppm.__file__).parent
HERE = Path(__file__).parent


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, check=False)


def test_stubs_are_those_of_the_module(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    allowed = tmp_path / "allowed"
    # Only builds for tests have `break_down`, in the list of names too.
    allowed.write_text("sppm._sppm.break_down\nsppm._sppm.__all__\n")
    done = run("-m", "mypy.stubtest", "sppm", "--allowlist", allowed, "--ignore-unused-allowlist")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "no issues found" in done.stdout


@pytest.fixture(scope="module")
def found_types(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What pyright finds in the package, in its right use and in a wrong one."""
    pytest.importorskip("pyright")
    # It looks at nothing outside of its project.
    project = tmp_path_factory.mktemp("types")
    shutil.copytree(PACKAGE, project / "sppm")
    shutil.copy(HERE / "typed.py", project)
    wrong = 'import sppm\n\nfilm: int = sppm.render(sppm.Scene.load("cornell"), engine="gpu")\n'
    (project / "wrong.py").write_text(wrong)
    settings = {"typeCheckingMode": "strict", "pythonVersion": "3.11"}
    (project / "pyrightconfig.json").write_text(json.dumps(settings))
    done = run("-m", "pyright", "-p", project, "--pythonpath", sys.executable, "--outputjson")
    report = json.loads(done.stdout)
    assert report["summary"]["filesAnalyzed"] >= 2 + len(list(PACKAGE.glob("*.py")))
    found = report["generalDiagnostics"]
    return [f"{Path(one['file']).name}:{one['range']['start']['line'] + 1}: {one['message']}" for one in found]


def test_the_package_and_its_use_have_strict_types(found_types: list[str]) -> None:
    assert [one for one in found_types if not one.startswith("wrong.py:")] == []


def test_wrong_types_are_found(found_types: list[str]) -> None:
    assert len([one for one in found_types if one.startswith("wrong.py:3:")]) >= 2


def members(thing: object, name: str):
    yield name, thing
    if inspect.isclass(thing):
        for key, value in vars(thing).items():
            is_callable = inspect.isfunction(value) or isinstance(value, (property, classmethod, staticmethod))
            if is_callable and not key.startswith("_"):
                yield f"{name}.{key}", value


def test_every_public_name_is_documented() -> None:
    assert set(sppm.__all__) <= set(dir(sppm))
    public = [name for name in vars(sppm) if not name.startswith("_") and not inspect.ismodule(getattr(sppm, name))]
    assert sorted([*sppm.__all__, "annotations"]) == sorted({*public, "annotations"})
    checked = 0
    for name in sppm.__all__:
        for member, value in members(getattr(sppm, name), name):
            if name == "Material":  # a union of types
                continue
            assert (inspect.getdoc(value) or "").strip(), f"{member} has no docstring"
            checked += 1
    assert checked > 70


def test_every_field_is_documented() -> None:
    """Each annotated attribute of a class has a string after it, which the documentation shows."""
    import ast

    for path in sorted(PACKAGE.glob("*.py")):
        for klass in ast.walk(ast.parse(path.read_text())):
            if not isinstance(klass, ast.ClassDef):
                continue
            for line, following in zip(klass.body, [*klass.body[1:], None], strict=True):
                if isinstance(line, ast.AnnAssign):
                    documented = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
                    assert documented, f"{path.name}: {klass.name}.{ast.unparse(line.target)}"


def test_docstrings_name_what_is_raised() -> None:
    """Functions that raise errors of the package themselves say so."""
    for name in ("render", "trace", "compare", "Scene.add_spheres", "Scene.save", "Film.save", "Render.resume"):
        thing = sppm
        for part in name.split("."):
            thing = getattr(thing, part)
        doc = " ".join((inspect.getdoc(thing) or "").split())
        assert "Raises " in doc or "raises" in doc, name
