"""The wheel: its list of files holds, pip installs it without a network, and it works by what it brought along alone.

  wheel_test.py TOOLCHAIN_FOLDER BUILD_FOLDER GOLDEN_FOLDER      Status 77 where this Python has no pip
"""
import base64
import csv
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile

USE = """
import pathlib, sys, ldp
p = ldp.open(sys.argv[1])
view = p.render(p.path("sway", 1, (80, 60))[0])
assert view.depth.max() > 0 and view.rgb.any()
loaded = {line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}
here = str(pathlib.Path(ldp.__file__).parent)
for name in ("_ldp.", "libldp.so", "libjpeg.so", "libpng16.so", "libwebp.so"):
    own = [file for file in loaded if "/" + name in file]
    assert len(own) == 1 and own[0].startswith(here), (name, own)
"""


def check_list(file):
    with zipfile.ZipFile(file) as wheel:
        assert wheel.testzip() is None
        record = next(name for name in wheel.namelist() if name.endswith("/RECORD"))
        rows = list(csv.reader(wheel.read(record).decode().splitlines()))
        assert sorted(row[0] for row in rows) == sorted(wheel.namelist())
        for name, digest, size in rows:
            content = wheel.read(name)
            expected = "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            assert (digest, size) == (("", "") if name == record else (expected, str(len(content)))), name


def main(toolchain, build, golden):
    if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
        print(f"wheel_test: skipped: {sys.executable} has no pip")
        return 77
    with tempfile.TemporaryDirectory() as room:
        for folder in ("first", "second"):
            subprocess.run([f"{toolchain}/wheel", f"{room}/{folder}", "--build", build], check=True)
        (wheel,) = pathlib.Path(room, "first").iterdir()
        assert wheel.read_bytes() == pathlib.Path(room, "second", wheel.name).read_bytes(), "the same build, other bytes"
        check_list(wheel)
        subprocess.run([sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--no-cache-dir", "--target",
                        f"{room}/installed", wheel], check=True, stdout=subprocess.DEVNULL)
        clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LD_"))}
        subprocess.run([sys.executable, "-c", USE, f"{golden}/whole_strips.ldp"], check=True, cwd=room,
                       env=clean | {"PYTHONPATH": f"{room}/installed"})
    return 0


sys.exit(main(*sys.argv[1:]))
