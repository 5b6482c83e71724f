# SPDX-License-Identifier: MIT
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def kill_at(tmp_path_factory):
    """kill_at(step, number): an environment in which a program gets that signal at that step of
    saving a file; steps are the calls of kill_at.c, before and after."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if not compiler:
        pytest.skip("no C compiler to build the preloaded library")
    library = tmp_path_factory.mktemp("kill") / "kill_at.so"
    source = Path(__file__).with_name("kill_at.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)

    def environment(step, number=signal.SIGKILL):
        return os.environ | {
            "LD_PRELOAD": str(library),
            "KILL_AT": str(step),
            "KILL_SIGNAL": str(int(number)),
            "ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0",
        }

    return environment
