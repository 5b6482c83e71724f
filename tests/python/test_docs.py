# SPDX-License-Identifier: MIT
"""What is written is true: doctests, types, and a documentation site without a warning."""

import doctest
import importlib
import importlib.util
import inspect
import os
import pkgutil
import subprocess
import sys

import lcor
import pytest

EXTRAS = {"dask": "dask.array", "plots": "matplotlib", "paper": "matplotlib"}
MODULES = [
    name for _, name, _ in pkgutil.iter_modules(lcor.__path__) if name not in ("_core", "emulator")
]


@pytest.mark.parametrize("name", ["", *MODULES])
def test_doctests(name):
    if name in EXTRAS:
        pytest.importorskip(EXTRAS[name])
    module = importlib.import_module(f"lcor.{name}".rstrip("."))
    failed, _ = doctest.testmod(module)
    assert failed == 0


@pytest.mark.parametrize("name", lcor.__all__)
def test_every_name_is_documented_with_an_example(name):
    thing = getattr(lcor, name)
    if name == "__version__":
        return
    assert inspect.getdoc(thing), name
    if inspect.isfunction(thing):
        assert ">>>" in thing.__doc__
    if inspect.isclass(thing) and hasattr(thing, "__init__") and not issubclass(thing, Exception):
        own = [v for k, v in vars(thing).items() if not k.startswith("_")]
        methods = [v for v in own if inspect.isfunction(v)]
        assert all(inspect.getdoc(method) for method in methods), name


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_types_are_strict_and_catch_a_wrong_call(tmp_path):
    (tmp_path / "right.py").write_text(
        "import lcor\n"
        "plan = lcor.Plan(23.4, r_mean=0.5)\n"
        "pixels: int = plan.apply([0.5] * 3, 1.0)[1].pixels\n"
    )
    (tmp_path / "wrong.py").write_text('import lcor\nplan = lcor.Plan("23.4", r_mean=0.5)\n')
    options = ["--strict", "--no-incremental", "--cache-dir", os.devnull]
    modules = ["right", "wrong", *(f"lcor.{name}" for name in MODULES)]
    words = [word for name in modules for word in ("-m", name)]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, "--untyped-calls-exclude", "dask", *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert done.returncode == 1 and len(errors) == 1, done.stdout + done.stderr
    assert errors[0].startswith("wrong.py:2") and '"Plan" has incompatible type "str"' in errors[0]
    for file in ("_core.pyi", "py.typed"):
        assert os.path.exists(os.path.join(lcor.__path__[0], file))
