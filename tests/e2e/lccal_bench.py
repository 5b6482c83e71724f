# SPDX-License-Identifier: MIT
"""The real lccal against emulated instruments."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

SOURCE = Path(os.environ["LCOR_SOURCE"])
LCCAL = Path(os.environ["LCOR_BINDIR"]) / "lccal"
DEADLINE = 240  # seconds; reached only when something hangs
PATIENCE = 100  # seconds that lccal may wait for a reading that is sure to come

sys.path.insert(0, str(SOURCE / "bindings" / "python"))

from lcor.emulator import bench  # noqa: E402
from lcor.emulator.__main__ import arguments  # noqa: E402
from lcor.emulator.channel import Unplugged  # noqa: E402

bench.UNSEEN = float("inf")  # lccal shows when it listens, however late a busy machine lets it


def environment():
    env = dict(os.environ)
    env["PYTHONPATH"] = str(SOURCE / "bindings" / "python")
    return env


COMMA_LOCALE = """\
LC_NUMERIC
decimal_point ","
thousands_sep "."
grouping 3;3
END LC_NUMERIC
""" + "".join(
    f'{name}\ncopy "POSIX"\nEND {name}\n'
    for name in ("LC_CTYPE", "LC_COLLATE", "LC_TIME", "LC_MESSAGES", "LC_MONETARY")
)


def comma_environment(folder):
    """An environment in which C's own functions write 1,5; the locale is made in the folder."""
    if not shutil.which("localedef"):
        pytest.skip("localedef is missing")
    source, locale = folder / "comma", folder / "xx_XX"
    source.write_text(COMMA_LOCALE)
    command = ["localedef", "-c", "-i", source, "-f", "ISO-8859-1", locale]
    subprocess.run(command, capture_output=True, check=False)
    assert (locale / "LC_NUMERIC").exists()
    return environment() | {"LOCPATH": str(folder), "LC_ALL": locale.name}


class Emulator:
    """An emulated instrument on a pseudo-terminal, `port`; it lives on a thread."""

    def __init__(self, *options):
        hand, self.hand = os.pipe()
        self.bench = bench.Bench(arguments(list(map(str, options))), hand)
        self.port = self.bench.channel.name
        self.spoken_to = threading.Event()
        self.said = threading.Semaphore(0)
        self.bench.instrument.receive = self.hear
        self.bench.instrument.press = self.say
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        with contextlib.suppress(Unplugged):
            self.bench.run()
        self.bench.channel.close()
        os.close(self.bench.hand)

    def hear(self, data):
        type(self.bench.instrument).receive(self.bench.instrument, data)
        self.spoken_to.set()

    def say(self, density):
        try:
            type(self.bench.instrument).press(self.bench.instrument, density)
        finally:
            self.said.release()

    def press(self, *densities):
        """Somebody reads patches of these densities (emulators without --auto-press); returns
        when all of them are on the wire."""
        os.write(self.hand, "".join(f"{density}\n" for density in densities).encode())
        for _ in densities:
            assert self.said.acquire(timeout=DEADLINE)

    def unplug(self):
        os.close(self.hand)
        self.hand = None
        self.thread.join(DEADLINE)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        if self.hand is not None:
            os.close(self.hand)


def lccal(*arguments, **options):
    """Run lccal to its end."""
    options.setdefault("env", environment())
    return subprocess.run(
        [LCCAL, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
        **options,
    )


def in_time(measure, words):
    """The run of measure(seconds) that ends in these words. What it waits for needs more seconds
    on a busy machine."""
    for seconds in (2, 10, PATIENCE):
        run = measure(seconds)
        if words in run.stderr:
            break
    return run


def events(text):
    return [json.loads(line) for line in text.splitlines()]


class Session:
    """A guided lccal whose prompts and events a test answers."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            [LCCAL, *map(str, arguments), "--json"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self.watchdog = threading.Timer(DEADLINE, self.process.kill)
        self.watchdog.start()
        self.seen = []

    def until(self, name, **fields):
        """Read events until one of this name with these fields."""
        for line in self.process.stdout:
            event = json.loads(line)
            self.seen.append(event)
            if event["event"] == name and all(event[key] == fields[key] for key in fields):
                return event
        raise AssertionError(f"lccal ended without {name} {fields}: {self.seen}")

    def answer(self, text=""):
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def end(self):
        """Exit code, after the program ended by itself."""
        output, errors = self.process.communicate(timeout=DEADLINE)
        self.seen += events(output)
        self.errors = errors
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.watchdog.cancel()
        self.process.kill()
        self.process.communicate()


def together(call, cases, factory):
    """{case: call(case, folder)}: cases that spend their time waiting do so side by side.

    Each has a folder of its own, made beforehand since pytest's factory is not for threads.
    """
    folders = [factory.mktemp("-".join(case)) for case in cases]
    with ThreadPoolExecutor(len(cases)) as pool:
        return dict(zip(cases, pool.map(call, cases, folders)))


def keyword(path, name):
    """A keyword of a CGATS file."""
    for line in Path(path).read_text().splitlines():
        key, _, value = line.partition(" ")
        if key == name:
            return value.strip().strip('"')
    return None


def rows(path):
    """The data rows of a CGATS file."""
    lines = Path(path).read_text().splitlines()
    start, end = lines.index("BEGIN_DATA"), lines.index("END_DATA")
    return [[field.strip('"') for field in line.split("\t")] for line in lines[start + 1 : end]]
