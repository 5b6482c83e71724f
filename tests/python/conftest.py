# SPDX-License-Identifier: MIT
import csv
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture(scope="session")
def source():
    return Path(os.environ.get("LCOR_SOURCE", Path(__file__).parents[2]))


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


@pytest.fixture(scope="session")
def golden(source):
    """Read one golden table as a list of rows by column name."""

    def read(name):
        with open(source / "tests" / "data" / "golden" / f"{name}.csv", newline="") as file:
            return [{k: number(v) for k, v in row.items()} for row in csv.DictReader(file)]

    return read


def columns(table, names):
    """Columns of a table side by side."""
    return np.array([[row[name] for name in names.split()] for row in table])


def check(command, **options):
    """Run a command that must succeed."""
    done = subprocess.run(command, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def random():
    return np.random.default_rng(20260107)
