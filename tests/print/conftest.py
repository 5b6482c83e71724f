# SPDX-License-Identifier: MIT
import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

FILTER = Path(os.environ["LCOR_BINDIR"]) / "rastertolcor"


class Result:
    def __init__(self, process: "subprocess.CompletedProcess[bytes]"):
        self.code, self.out = process.returncode, process.stdout
        self.log = process.stderr.decode()
        self.errors = [line for line in self.log.splitlines() if line.startswith("ERROR: ")]


@pytest.fixture
def correct(tmp_path):
    """rastertolcor on the bytes of a raster; `env` adds to an environment without CUPS."""

    def run(
        data: bytes, options: str = "lcor-contrast=23.4", env: dict[str, str] | None = None
    ) -> Result:
        bare = {k: v for k, v in os.environ.items() if k != "PPD" and not k.startswith("CUPS_")}
        return Result(
            subprocess.run(
                [FILTER, "1", "user", "title", "1", options],
                input=data,
                capture_output=True,
                timeout=120,
                check=False,
                env=bare | {"TMPDIR": str(tmp_path)} | (env or {}),
            )
        )

    return run
