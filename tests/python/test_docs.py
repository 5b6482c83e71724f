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
from conftest import check

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
    installed = os.path.dirname(lcor.__file__)
    options = ["--strict", "--no-incremental", "--cache-dir", str(tmp_path / "cache")]
    mypy = [sys.executable, "-m", "mypy", *options]
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(
        "import lcor\n"
        "plan = lcor.Plan(23.4, r_mean=0.5)\n"
        "pixels: int = plan.apply([0.5] * 3, 1.0)[1].pixels\n"
    )
    wrong.write_text('import lcor\nplan = lcor.Plan("23.4", r_mean=0.5)\n')
    check([*mypy, str(right)], cwd=tmp_path)
    done = subprocess.run([*mypy, str(wrong)], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and '"Plan" has incompatible type "str"' in done.stdout
    assert os.path.exists(os.path.join(installed, "_core.pyi"))
    assert os.path.exists(os.path.join(installed, "py.typed"))
    modules = [word for name in MODULES for word in ("-m", f"lcor.{name}")]
    check([*mypy, "--untyped-calls-exclude", "dask", *modules], cwd=tmp_path)
