"""Runs every command of device/examples/RECIPES.md, in its order, and looks at what each recipe leaves.

  PYTHONPATH=build/release/device/python recipes_test.py LDP_PROGRAM EXAMPLES FLEET
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, EXAMPLES, FLEET = map(os.path.realpath, sys.argv[1:4])
PAGE = pathlib.Path(EXAMPLES, "RECIPES.md").read_text()
# Of each recipe: what it writes, and words that it prints.
LEAVES = {1: ["room.ldp", "room.json", "room.html"], 2: [], 3: [], 4: ["view.png"], 5: ["room.webp", "frames/frame_003.png"],
          6: ["room.ply", "near.ply"], 7: ["set/transforms.json", "set/sparse_pc.ply"],
          8: ["transforms.json", "sparse/images.txt", "known.ldp", "cameras.json"], 9: ["plots.png"],
          10: ["panoramas/one.ldp", "panoramas/two.ldp", "all.html"]}
SAYS = {3: "(", 4: "nearest thing in it:", 10: "2 builds:"}


def commands_of(page):
    """Recipe number -> its indented lines, as a script."""
    recipes = {}
    for part in page.split("\n## ")[1:]:
        number = int(part.split(".")[0])
        recipes[number] = "\n".join(line[4:] for line in part.splitlines() if line.startswith("    "))
    return recipes


class Recipes(unittest.TestCase):
    def test_all_work(self):
        recipes = commands_of(PAGE)
        self.assertEqual(sorted(recipes), list(range(1, 11)))
        with tempfile.TemporaryDirectory() as room:
            self.prepare(pathlib.Path(room))
            for number, script in recipes.items():
                with self.subTest(recipe=number):
                    done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=room, capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, script + "\n" + done.stderr)
                    self.assertIn(SAYS.get(number, ""), done.stdout)
                    for name in LEAVES[number]:
                        self.assertGreater(os.path.getsize(os.path.join(room, name)), 0, name)

    def prepare(self, room):
        os.environ["PATH"] = f"{room}/bin:{os.environ['PATH']}"
        (room / "bin").mkdir()
        os.symlink(PROGRAM, room / "bin/ldp")
        os.symlink(sys.executable, room / "bin/python3")  # the one that the package is of
        os.symlink(FLEET, room / "fleet")
        for example in pathlib.Path(EXAMPLES).glob("*.py"):
            shutil.copy(example, room)
        subprocess.run(["ldp", "scene", "room", "-o", room / "made", "--size", "160x120", "--frames", "8", "--arc", "80",
                        "--no-novel"], check=True, stdout=subprocess.DEVNULL)
        for copy in ("photos", "sweeps/one", "sweeps/two"):
            shutil.copytree(room / "made/frames", room / copy)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
