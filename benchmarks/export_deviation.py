"""``python -m benchmarks.export_deviation``: how far hosts that take numbers stay from the model, as the table of docs/exports.md."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from fmus.exports import export
from fmus.interface.friction_source import parse_source
from friction_models.common import InputError

HOSTS = {"abaqus": {"tolerance": 1e-3, "start_memory": True}, "radioss": {}, "calculix": {}}
MODELS = (
    "linear",
    "polynomial",
    "power_law",
    "ffnn",
    "gradient_boosting",
    "linear + stribeck",
    "linear + thermal_breakdown",
    "linear + work_exhaustion",
    "linear + rate_state",
)


def main() -> None:
    """Print the table as markdown: largest deviation of mu at 10 000 points of the domain, and the largest mu there."""
    from fmus.exports.numbers.deviation import domain_points
    from tests.fmus.catalogue import content_of

    print("| model | mu | " + " | ".join(f"`{h}`" for h in HOSTS) + " |\n|" + "---|" * (2 + len(HOSTS)))
    for name in MODELS:
        source = parse_source(content_of(name), name)
        mu = domain_points(source)[1]
        cells = []
        for host, options in HOSTS.items():
            with tempfile.TemporaryDirectory() as place:
                try:
                    folder = export(source, Path(place) / host, host, **options)
                except InputError as error:
                    cells.append(str(error))
                    continue
                file = next(p for p in (folder / "table.json", folder / "fit.json") if p.is_file())
                cells.append(f"{json.loads(file.read_text())['remaining']['largest deviation']:.2g}")
        print(f"| {name} | {mu.min():.3f} to {mu.max():.3f} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
