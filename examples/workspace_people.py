"""Hold the hands of recorded people against the workspaces predicted for them.

    python examples/workspace_people.py FOLDER STUDY.toml OUT

FOLDER holds marker files, STUDY.toml says how they are named (as docs/donders_study.toml does for
the data set of docs/workspace_people.md). Written into OUT: workspace_people.csv (a row a person
and condition), workspace_people_totals.csv, and workspace_people.png (everybody's hand, taken from
the shoulder in lengths of the arm).
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from selfmotion.report.svg import write_png
from selfmotion.report.workspace_people_figures import people_figure
from selfmotion.studies.people import load_people
from selfmotion.studies.study_file import load_study_file
from selfmotion.studies.workspace_people import people_frame, totals_frame, workspace_people


def main(words: Sequence[str]) -> int:
    if len(words) != 3:
        print(__doc__)
        return 2
    folder, study, out = (Path(word) for word in words)
    out.mkdir(parents=True, exist_ok=True)
    people = workspace_people(load_people([folder], load_study_file(study)))
    table = people_frame(people)
    totals = totals_frame(table)
    table.to_csv(out / "workspace_people.csv", index=False, float_format="%.1f")
    totals.to_csv(out / "workspace_people_totals.csv", index=False, float_format="%.2f")
    write_png(people_figure(people), str(out / "workspace_people.png"))
    print(totals.to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
