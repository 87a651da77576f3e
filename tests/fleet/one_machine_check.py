"""Lists of captures on one machine: what is built, tried again, refused and left alone.

  one_machine_check.py LDP FLEET

A stand-in for ldp, which is quick and fails as it is told to, takes its place where only the scripts are looked at.
"""
import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, FLEET = map(os.path.realpath, sys.argv[1:3])
# Says what it was asked; the name of a capture holds the statuses that its builds end with, the last for good.
STAND_IN = """#!/bin/bash
name=$(basename "$2")
case $1 in
  summary) exec "$REAL" "$@" ;;
  build) [[ " $* " == *' --estimate '* ]] && { case $name in bad*) exit 2 ;; esac; echo '{"memory_bytes": 30000000, "processor_seconds": 3}'; exit; } ;;
esac
echo "$name" >>"$ASKED"
statuses=(${name#*_})
statuses=(${statuses//-/ })
n=$(grep -cx "$name" "$ASKED")
status=${statuses[$((n - 1))]:-${statuses[-1]}}
[ "$status" -lt 128 ] || kill -"$((status - 128))" $$
echo "ldp build: status $status" >&2
[ "$status" != 0 ] || echo panorama >"$4"
exit "$status"
"""


class OneMachine(unittest.TestCase):
    def setUp(self):
        self.room = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.room)
        self.out = self.room / "out"
        (self.room / "stand_in").write_text(STAND_IN)
        (self.room / "stand_in").chmod(0o755)
        self.asked_file = self.room / "asked"
        self.asked_file.touch()
        self.environment = {**os.environ, "LDP": str(self.room / "stand_in"), "REAL": PROGRAM, "ASKED": str(self.asked_file)}

    def run_list(self, names, program="on_one_machine"):
        for name in names:
            (self.room / name).mkdir(exist_ok=True)
        (self.room / "list").write_text("".join(f"{self.room / name}\n" for name in names))
        return subprocess.run([f"{FLEET}/{program}", self.room / "list", self.out], env=self.environment, text=True,
                              capture_output=True)

    def asked(self):
        names = self.asked_file.read_text().split()
        return {name: names.count(name) for name in names}

    @unittest.skipUnless(shutil.which("parallel"), "GNU parallel is absent")
    def test_the_machine_s_faults_are_tried_again_and_the_captures_are_not(self):
        done = self.run_list(["a_0", "b_75-0", "c_2", "d_137-143-0", "e_1", "f_70"])
        self.assertEqual(self.asked(), {"a_0": 1, "b_75-0": 2, "c_2": 1, "d_137-143-0": 3, "e_1": 1, "f_70": 1}, done.stderr)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(sorted(file.name for file in self.out.glob("*.ldp")), ["a_0.ldp", "b_75-0.ldp", "d_137-143-0.ldp"])

    @unittest.skipUnless(shutil.which("parallel"), "GNU parallel is absent")
    def test_what_is_left_is_done_the_next_time(self):
        self.assertEqual(self.run_list(["a_0", "b_75-75-75-0"]).returncode, 75)
        self.assertEqual(self.run_list(["a_0", "b_75-75-75-0"]).returncode, 0)
        self.assertEqual(self.asked(), {"a_0": 1, "b_75-75-75-0": 4})
        self.assertEqual(self.run_list(["a_0", "b_75-75-75-0"]).returncode, 0)
        self.assertEqual(sum(self.asked().values()), 5, "nothing was left")

    def test_a_plan_adds_a_third_and_refuses_what_cannot_be_told_apart(self):
        self.assertEqual(self.run_list(["a_0", "bad_0"], "plan").stdout, "2 40 4\n")
        self.assertEqual(self.run_list(["bad_0"], "plan").returncode, 2)
        (self.room / "inner").mkdir()
        refused = self.run_list(["a_0", "inner/a_0"], "plan")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("would have one name, a_0", refused.stderr)

    def test_a_task_does_its_share_whatever_becomes_of_one(self):
        names = ["a_0", "b_2", "c_0", "d_75", "e_0", "f_0"]
        self.run_list(names, "plan")
        for index, status in ((0, 0), (1, 75)):
            ended = subprocess.run([f"{FLEET}/task", str(index), "2", self.room / "list", self.out], env=self.environment,
                                   capture_output=True)
            self.assertEqual(ended.returncode, status, ended.stderr)
        self.assertEqual(self.asked(), dict.fromkeys(names, 1))

    def test_a_capture_is_not_built_twice_at_the_same_time(self):
        (self.room / "a_0").mkdir()
        (self.out / ".fleet/locks").mkdir(parents=True)
        with open(self.out / ".fleet/locks/a_0", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            words = [f"{FLEET}/build_one", self.out, self.room / "a_0"]
            self.assertEqual(subprocess.run(words, env=self.environment, capture_output=True).returncode, 75)
        self.assertEqual(subprocess.run(words, env=self.environment, capture_output=True).returncode, 0)

    def test_real_builds(self):
        subprocess.run([PROGRAM, "scene", "room", "-o", self.room / "made", "--size", "160x120", "--frames", "8", "--arc", "60",
                        "--no-novel"], check=True, stdout=subprocess.DEVNULL)
        shutil.copytree(self.room / "made/frames", self.room / "sweep")
        self.environment["LDP"] = PROGRAM
        for _ in range(2):
            ended = subprocess.run([f"{FLEET}/build_one", self.out, self.room / "sweep", "--layers", "1", "--labels", "4"],
                                   env=self.environment, capture_output=True)
            self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertIn("made already", (self.out / "sweep.log").read_text())
        self.assertIn("quality", json.loads((self.out / "sweep.json").read_text()))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
