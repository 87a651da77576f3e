"""Plots of a build's report (ldp build --report room.json): where the time went, and how good which direction is.

  report_plots.py room.json plots.png            to be read from top to bottom, like a notebook
"""
import json
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

report_file, picture = sys.argv[1:]
report = json.loads(pathlib.Path(report_file).read_text())
if "failure" in report:
    sys.exit(f"{report_file}: that build failed: {report['failure']['text']}")
figure, ((time, directions), (photos, layers)) = plt.subplots(2, 2, figsize=(11, 7), constrained_layout=True)
figure.suptitle(f"{report['options']['capture']}: {report['quality']['verdict']}")

# Seconds of all processors together, by stage; the sums are left out.
stages = {stage: s for stage, s in report["processor_seconds"].items() if stage not in ("total", "whole") and s > 0.01}
time.barh(list(stages)[::-1], list(stages.values())[::-1])
time.set_xlabel("processor seconds")

# What new views in each direction are expected to reach, beside what the photographs get back.
for name, label in (("expected_view_psnr_db", "new views, expected"), ("photos_back_psnr_db", "photographs rendered back")):
    parts = report["quality"]["by_direction"]
    directions.plot([(part["from_deg"] + part["to_deg"]) / 2 for part in parts], [part[name] for part in parts], "o-", label=label)
directions.set(xlabel="degrees from the first photograph", ylabel="dB")
directions.legend()

# Photographs that agree little with the panorama are those to look at.
agreeing = report["consistency"]["photos"]
photos.bar([photo["name"] for photo in agreeing], [photo["psnr_db"] for photo in agreeing])
photos.set_ylabel("rendered back, dB")
photos.tick_params(axis="x", rotation=90, labelsize=6)

layers.bar([f"layer {index + 1}" for index in range(len(report["coverage"]))], [100 * share for share in report["coverage"]])
layers.set_ylabel("% of the grid that is there")
figure.savefig(picture, dpi=100)
