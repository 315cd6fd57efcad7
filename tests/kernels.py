"""``python -m tests.kernels``: compile the kernels once, before several processes of tests would do it at the same time."""

from __future__ import annotations

from tempfile import TemporaryDirectory

import pandas as pd

from forming import ForwardRodExtrusion
from sct_twin import SctTwin, virtual_lab


def main() -> None:
    """Press a little, and evaluate a short test of the virtual laboratory."""
    ForwardRodExtrusion(mesh_size=1.0).run(0.05, stroke=0.5)
    plan = pd.DataFrame([{"v_set": 50.0, "T_tool": 100.0, "sigma_set": 1000.0, "sd_set": 5.0}])
    with TemporaryDirectory() as folder:
        SctTwin().run(
            virtual_lab.Campaign(plan=plan, seed=1, lubricant="polymer").run(f"{folder}/lab", jobs=1), jobs=1
        )


if __name__ == "__main__":
    main()
