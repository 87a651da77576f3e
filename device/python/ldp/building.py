"""From photographs to a panorama, by the program `ldp`: in a process of its own, whose memory ends with it."""

from __future__ import annotations

import os
import pathlib
import signal
import subprocess
import tempfile
from collections.abc import Callable

from ldp.errors import BuildError
from ldp.panorama import Panorama, open, open_bytes


def _words(options: dict[str, object]) -> list[str]:
    words = []
    for name, value in options.items():
        if value is not None and value is not False:
            words.append("--" + name.replace("_", "-"))
            words += [] if value is True else [str(value)]
    return words


def _run(command: list[str], progress: Callable[[str, float], object] | None) -> None:
    reading, writing = os.pipe()
    with os.fdopen(reading, encoding="utf-8") as lines:
        try:
            process = subprocess.Popen([*command, "--progress-fd", str(writing)], pass_fds=[writing],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        finally:
            os.close(writing)
        try:
            for line in lines:
                fraction, stage = line.rstrip("\n").split(" ", 1)
                if progress:
                    progress(stage, float(fraction))
            _, said = process.communicate()
        except BaseException:  # Ctrl-C, or what progress raised: the program leaves no partial file
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    if process.returncode == -signal.SIGINT or process.returncode == 130:
        raise KeyboardInterrupt
    if process.returncode != 0:
        raise BuildError(said.strip().split("\n")[-1] or f"ended with status {process.returncode}", process.returncode)


def build(photos: str | os.PathLike, output: str | os.PathLike | None = None, *,
          progress: Callable[[str, float], object] | None = None, program: str = "ldp", **options: object) -> Panorama:
    """Builds a panorama from a folder of photographs of one sweep, and opens it.

    output: the .ldp file to write; None: none is kept. progress(stage, fraction): called as the work goes on, fraction 0 to
    1 of the stage; a stage "so far: ..." is none but what is wrong with the sweep. options: those of `ldp build`, as layers=2, cameras="transforms.json", strict=True, report="r.json".
    Raises BuildError with the program's words and exit status; FileNotFoundError where there is no such program."""
    with tempfile.TemporaryDirectory() as room:
        file = pathlib.Path(output) if output is not None else pathlib.Path(room) / "built.ldp"
        _run([program, "build", os.fspath(photos), "-o", str(file), *_words(options)], progress)
        return open(file) if output is not None else open_bytes(file.read_bytes())
