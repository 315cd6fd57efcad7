"""CasADi's DaeBuilder: mu and its derivatives along the loads, by the FMU's directional derivatives."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from tests.interop.children.common import done, job


def main() -> None:
    import casadi

    work = job()
    folder = Path(work["folder"]) / "unpacked"
    with zipfile.ZipFile(work["fmu"]) as archive:
        archive.extractall(folder)
    dae = casadi.DaeBuilder("friction", str(folder))
    inputs = dae.u()
    mu = dae.y().index("mu")  # all outputs are asked for, the Boolean one too
    function = dae.create("friction", ["u"], ["y"])
    jacobian = function.factory("slope", ["u"], ["jac:y:u"])
    order = [work["inputs"].index(name) for name in inputs]
    rows = np.array(work["series"])[:, order]
    values = [[float(function(row)[mu])] for row in rows]
    back = np.argsort(order)
    slopes = [np.array(jacobian(row))[mu][back].tolist() for row in rows]
    done(values, slopes=slopes)


if __name__ == "__main__":
    main()
