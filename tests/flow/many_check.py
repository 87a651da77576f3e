"""What schedulers need of ldp: an estimate, builds that are done once, exit statuses told apart, a summary.

  many_check.py LDP_PROGRAM
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

PROGRAM = sys.argv[1]
SANITIZED = bool(os.environ.get("LDP_SANITIZED"))  # their shadow is in what is taken of memory
QUICK = ["--layers", "1", "--iterations", "1", "--labels", "4"]


def run(*words, prefix=()):
    return subprocess.run([*prefix, PROGRAM, *map(str, words)], capture_output=True, text=True)


class Many(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.room = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.room)
        made = run("scene", "courtyard", "-o", cls.room / "made", "--size", "240x180", "--frames", "8", "--arc", "70",
                   "--no-novel")
        assert made.returncode == 0, made.stderr
        shutil.copytree(cls.room / "made/frames", cls.room / "photos")

    def build(self, *words, name="a.ldp"):
        return run("build", self.room / "photos", "-o", self.room / name, *QUICK, *words)

    def needed(self, *words, name="a.ldp"):
        """Whether a build was needed: what was there keeps its time otherwise."""
        before = (self.room / name).stat().st_mtime_ns if (self.room / name).exists() else 0
        done = self.build("--if-needed", *words, name=name)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (self.room / name).stat().st_mtime_ns != before

    def test_a_build_is_done_once(self):
        self.assertTrue(self.needed())
        self.assertFalse(self.needed())
        self.assertFalse(self.needed("--threads", "1"))
        told = json.loads(self.build("--if-needed", "--json").stdout)
        self.assertTrue(told["made_already"])
        self.assertIn(told["quality"]["verdict"], ("good", "fair", "sweep_again"))

    def test_other_options_photos_and_inputs_need_another_build(self):
        self.needed()
        self.assertTrue(self.needed("--block", "16"))
        self.assertTrue(self.needed())
        self.assertTrue(self.needed("--cameras", self.room / "made/transforms.json"))
        self.assertFalse(self.needed("--cameras", self.room / "made/transforms.json"))
        os.utime(self.room / "made/transforms.json")
        self.assertTrue(self.needed("--cameras", self.room / "made/transforms.json"))
        self.needed()
        last = sorted((self.room / "photos").iterdir())[-1]
        os.rename(last, self.room / "away.png")
        self.assertTrue(self.needed(), "a photo less")
        os.rename(self.room / "away.png", last)
        self.assertTrue(self.needed(), "a photo more, older than the file")
        os.utime(last)
        self.assertTrue(self.needed(), "a photo that is newer")
        self.assertTrue(self.needed("--report", self.room / "a.json"), "the report is not there")
        self.assertFalse(self.needed("--report", self.room / "a.json"))
        self.assertFalse(self.needed("--report", "/dev/null"), "it keeps nothing, whatever it is told")

    def test_photos_in_a_list_in_an_archive_and_beside_their_panorama_are_built_once_too(self):
        own = shutil.copytree(self.room / "photos", self.room / "own")
        photos, names, archive = sorted(own.iterdir()), self.room / "list.txt", self.room / "photos.zip"
        names.write_text("".join(f"{photo}\n" for photo in photos))
        with zipfile.ZipFile(archive, "w") as out:
            for photo in photos:
                out.write(photo, photo.name)
        for capture, made, touched in ((own, own / "a.ldp", photos[0]), (f"@{names}", self.room / "l.ldp", names),
                                       (archive, self.room / "z.ldp", archive)):
            words = ["build", capture, "-o", made, *QUICK, "--if-needed"]
            self.assertNotIn("made already", run(*words).stdout, capture)
            self.assertIn("made already", run(*words).stdout, capture)
            os.utime(touched)
            self.assertNotIn("made already", run(*words).stdout, f"{capture}, newer")

    def test_a_damaged_file_and_one_made_otherwise_need_another_build(self):
        self.needed()
        with open(self.room / "a.ldp", "r+b") as file:
            file.seek(-40, os.SEEK_END)
            byte = file.read(1)
            file.seek(-40, os.SEEK_END)
            file.write(bytes([byte[0] ^ 1]))
        self.assertTrue(self.needed(), "damaged")
        self.assertEqual(self.build().returncode, 0)
        self.assertTrue(self.needed(), "made without --if-needed: how is not known")

    def test_an_ordinary_build_keeps_no_recipe(self):
        self.build(name="plain.ldp")
        self.needed(name="once.ldp")
        told = [json.loads(run("info", self.room / name, "--json").stdout)["metadata"] for name in ("plain.ldp", "once.ldp")]
        self.assertEqual(set(told[1]) - set(told[0]), {"made_from"})

    def test_strict_tells_an_old_verdict_again(self):
        shutil.copytree(self.room / "photos", self.room / "few")
        for photo in sorted((self.room / "few").iterdir())[1::2]:
            photo.unlink()
        words = ["build", self.room / "few", "-o", self.room / "few.ldp", *QUICK, "--if-needed", "--strict"]
        first, second = run(*words), run(*words)
        self.assertEqual((first.returncode, first.stderr.splitlines()[-1:]), (second.returncode, second.stderr.splitlines()[-1:]))
        self.assertIn("made already", second.stdout)

    def test_an_estimate_holds(self):
        made = run("scene", "room", "-o", self.room / "room", "--size", "480x360", "--frames", "8", "--arc", "90", "--no-novel")
        self.assertEqual(made.returncode, 0, made.stderr)
        before = set(self.room.iterdir())
        told = run("build", self.room / "room", "--estimate", "--json")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual(set(self.room.iterdir()), before, "an estimate writes nothing")
        estimate = json.loads(told.stdout)
        built = json.loads(run("build", self.room / "room", "-o", self.room / "b.ldp", "--json").stdout)
        # Held to 1.3 on photos, by core/estimate/decisions.md; here other tests' work is in the seconds.
        for name, true, most in (("processor_seconds", built["processor_seconds"]["whole"], 2.5),
                                 ("file_bytes", built["bytes"]["file"], 1.4), ("memory_bytes", built["peak_memory_bytes"], 1.4)):
            if SANITIZED and name == "memory_bytes":
                continue
            self.assertTrue(1 / most < estimate[name] / true < most, (name, estimate[name], true))
        self.assertLess(estimate["spent_seconds"], estimate["processor_seconds"])
        self.assertRegex(run("build", self.room / "room", "--estimate").stdout, r"about \d+ s of processor time, \d+ MB of memory")

    def test_a_failure_is_in_its_report(self):
        (self.room / "one").mkdir()
        shutil.copy(sorted((self.room / "photos").iterdir())[0], self.room / "one/a.png")
        report = self.room / "one.json"
        for words, status in ((["build", self.room / "one", "-o", self.room / "c.ldp", "--report", report], 1),
                              (["build", self.room / "none", "-o", self.room / "c.ldp", "--report", report], 2)):
            refused = run(*words)
            self.assertEqual(refused.returncode, status, refused.stderr)
            failure = json.loads(report.read_text())["failure"]
            self.assertEqual((failure["status"], f"ldp build: {failure['text']}\n"), (status, refused.stderr))

    def test_a_summary_tells_what_became_of_each(self):
        many = self.room / "many"
        (many / "inner").mkdir(parents=True)
        done = run("build", self.room / "photos", "-o", many / "inner/done.ldp", "--report", many / "inner/done.json", *QUICK)
        self.assertEqual(done.returncode, 0, done.stderr)
        shutil.copy(many / "inner/done.ldp", many / "bare.ldp")
        run("build", self.room / "none", "-o", many / "<b>.ldp", "--report", many / "<b>.json")
        (many / "cut.ldp").write_bytes((many / "bare.ldp").read_bytes()[:1000])
        (many / "empty.ldp").touch()
        (many / "notes.json").write_text("{}")
        (many / "not json.json").write_text("{")
        told = json.loads(run("summary", many, "--json").stdout)
        by_name = {outcome["name"]: outcome for outcome in told["outcomes"]}
        self.assertEqual(set(by_name), {"<b>", "bare", "cut", "empty", "inner/done"})
        verdict = by_name["bare"]["verdict"]
        self.assertEqual((by_name["inner/done"]["verdict"], told["failed"], told[verdict]), (verdict, 3, 2))
        self.assertEqual((by_name["<b>"]["exit_status"], by_name["inner/done"]["photos"]), (2, 8))
        self.assertGreater(by_name["inner/done"]["processor_seconds"], 0)
        self.assertIn("damaged", by_name["cut"]["reasons"])
        self.assertTrue(by_name["empty"]["reasons"].startswith("the file is empty: "))
        table = run("summary", many, "--html", self.room / "all.html").stdout.splitlines()
        self.assertEqual(len(table), 5 + 3)
        self.assertRegex(table[-2], r"^5 builds: .* 3 failed, 0 unknown$")
        self.assertRegex(table[-1], r"^[\d.]+ MB of files, [\d.]+ hours of processor time, \d+ MB of memory at the peak$")
        lone = self.room / "lone"
        lone.mkdir()
        (lone / "bare.ldp").write_bytes((many / "bare.ldp").read_bytes())
        table = run("summary", lone).stdout.splitlines()
        self.assertRegex(table[-2], "^1 build: ")
        self.assertRegex(table[-1], r"^[\d.]+ MB of files$", "what no report tells was not measured")
        page = (self.room / "all.html").read_text()
        self.assertEqual(page.count("data:image/jpeg;base64,/9j/"), 2)
        self.assertIn("<b>&lt;b></b>: failed<br>", page)
        self.assertLess(page.index('class="failed"'), page.index(f'class="{verdict}"'))
        self.assertEqual(run("summary", many, "--html", self.room / "all.html").returncode, 0)
        (self.room / "own.html").write_text("<title>mine</title>")
        self.assertEqual(run("summary", many, "--html", self.room / "own.html").returncode, 2)
        refused = run("summary", self.room / "none")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("there is no such folder: check the name", refused.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
