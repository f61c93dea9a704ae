"""Draw the pictures of README and documentation: ``python docs/images/make.py``."""

from pathlib import Path

import numpy as np

from selfmotion.report.svg import write_png
from selfmotion.report.weights_figures import weights_figure
from selfmotion.studies.demonstration import demonstrate

HERE = Path(__file__).parent


def main() -> None:
    """Draw weights.png, from the people of `selfmotion demo`."""
    shown = demonstrate()
    truth = {
        condition: tuple(
            np.exp(np.mean([np.log(p.weights[condition]) for p in shown.made.people], axis=0))
        )
        for condition in shown.reaching.conditions
    }
    figure = weights_figure(shown.reaching.weights, truth=truth)
    figure.set_facecolor("white")
    write_png(figure, str(HERE / "weights.png"))


if __name__ == "__main__":
    main()
