"""fmpy.ssp: the archive validated and simulated."""

from __future__ import annotations

from tests.interop.children.common import done, job


def main() -> None:
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import read_ssd

    work = job()
    read_ssd(work["ssp"], validate=True)
    steps = work["steps"]
    # It adds up its steps: half a step less leaves no doubt about the last one.
    result = simulate_ssp(work["ssp"], stop_time=(steps - 0.5) * work["step"], step_size=work["step"])
    done([[float(row[name]) for name in work["outputs"]] for row in result])


if __name__ == "__main__":
    main()
