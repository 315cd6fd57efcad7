"""fmpy, model exchange: `simulate_fmu` with an input table; memory is integrated by CVode."""

from __future__ import annotations

import numpy as np

from tests.interop.children.common import done, job


def main() -> None:
    from fmpy import simulate_fmu

    work = job()
    rows = np.array(work["series"])
    times = work["step"] * np.arange(len(rows))
    names = work["inputs"]
    table = np.array(
        [(t, *row) for t, row in zip(times, rows)], dtype=[("time", float), *((n, float) for n in names)]
    )
    result = simulate_fmu(
        work["fmu"],
        fmi_type="ModelExchange",
        start_time=0.0,
        stop_time=float(times[-1]),
        output_interval=work["step"],
        relative_tolerance=1e-9,
        input=table,
        output=work["outputs"],
        start_values={"n": work["n"]} if work.get("n", 1) > 1 else {},
    )
    # The integrator stops where it likes, too: take the rows at the wanted times.
    at = [int(np.argmin(np.abs(result["time"] - t))) for t in times]
    done(np.column_stack([result[n][at].reshape(len(at), -1) for n in work["outputs"]]).tolist())


if __name__ == "__main__":
    main()
