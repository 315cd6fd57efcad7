"""``python -m benchmarks.sct_worker CAMPAIGN``: what a process of the twin's pool does, in one that imports nothing else.

Prints the median time of one twin [s] and the peak memory of the process [MB].
"""

from __future__ import annotations

import re
import statistics
import sys
import time
from pathlib import Path

from sct_twin import SctTwin
from sct_twin.ingest.raw_campaign import RawCampaign


def main(folder: str) -> None:
    """Run twenty tests of the campaign one by one."""
    raw = RawCampaign.load(folder)
    twin = SctTwin()
    ids = [str(name) for name in raw.tests["test_id"]][:: max(1, len(raw) // 20)][:20]
    twin.evaluate(raw.record(ids[0]), raw.moving_mass)  # loads the compiled kernels
    taken = []
    for name in ids:
        record = raw.record(name)
        began = time.perf_counter()
        twin.evaluate(record, raw.moving_mass)
        taken.append(time.perf_counter() - began)
    status = Path("/proc/self/status")
    peak = re.search(r"VmHWM:\s+(\d+) kB", status.read_text()) if status.is_file() else None
    print(statistics.median(taken), int(peak[1]) / 1024.0 if peak else float("nan"))


if __name__ == "__main__":
    main(sys.argv[1])
