"""``python -m tests.kernels``: compile the kernels and upset the usual specimens once, before several processes do it at the same time."""

from __future__ import annotations

from tempfile import TemporaryDirectory

import pandas as pd

from forming import ForwardRodExtrusion
from sct_twin import SctTwin, virtual_lab
from sct_twin.virtual_lab.plans import PSI_LEVELS

TEST = {"v_set": 50.0, "T_tool": 100.0, "sigma_set": 1000.0, "sd_set": 5.0}


def main() -> None:
    """Press a little, and evaluate short tests of the virtual laboratory, which keeps its upsetting runs."""
    ForwardRodExtrusion(mesh_size=1.0).run(0.05, stroke=0.5)
    shapes = pd.DataFrame([{**TEST, "psi_set": psi} for psi in PSI_LEVELS])
    with TemporaryDirectory() as folder:
        lab = virtual_lab.Campaign(plan=pd.DataFrame([TEST]), seed=1, lubricant="polymer")
        SctTwin().run(lab.run(f"{folder}/lab", jobs=1), jobs=1)
        virtual_lab.Campaign(plan=shapes, seed=1).run(f"{folder}/plain", jobs=1)


if __name__ == "__main__":
    main()
