"""Where the measurements come from and under which licence, as the data's own README says."""

from __future__ import annotations

from typing import NamedTuple


class Origin(NamedTuple):
    """What a table is, its source and its licence."""

    title: str
    what: str
    source: str
    licence: str


_MIBA = (
    "GPax by giorgia-nadizar at f674b29, `datasets/regression/friction_{dyn,stat}_one-hot_{train,test}.csv`",
    "MIT (of the repository; the origin of the tables is not stated there, they are known as friction systems of Miba "
    "from papers on symbolic regression)",
)
_PLA = (
    "Friction-Measurements-Between-PLA-and-Silicone by tolstoys19 at b970d33, `CoF-Measurements.csv`; "
    "P. E. Tortós-Vinocour et al., IEEE RA-L 2024, doi 10.1109/LRA.2024.3376975",
    "MIT",
)

ORIGINS: dict[str, Origin] = {
    "motor_oil": Origin(
        "Motor oil between steel and glass",
        "A rotating steel flat (8 mm) on glass in 20W-50 motor oil, 16 loads at 3 speeds. The drag of the bearing was "
        "subtracted: below about 1.5 N the values are unreliable.",
        "NewportFrictionDataRead by UEF-BBC-LUPE at cc304c4",
        "MIT",
    ),
    "sepiolite": Origin(
        "Sepiolite gouge",
        "Rock friction at 30 MPa, one step of the speed from 0.2 to 2 micrometres a second; thinned to about 5000 rows, the "
        "speed is a smoothed gradient.",
        "steadystate by pgiacomel, branch Demo-velocity-stepping-tests at bfb4c1d; Giacomel et al. 2024, Geosphere, "
        "doi 10.1130/GES02739.1",
        "MIT",
    ),
    "pla_dragonskin": Origin(
        "Printed PLA on silicone Dragon Skin",
        "A plate of 4 x 4 mm under 70 rising loads on one track; one mean of mu a turn. Order and load are the same thing.",
        *_PLA,
    ),
    "pla_sil950": Origin(
        "Printed PLA on silicone Sil 950",
        "A plate of 4 x 4 mm under 59 rising loads on one track; one mean of mu a turn. Order and load are the same thing.",
        *_PLA,
    ),
    "pneumatic_seal": Origin(
        "Seal rings of a printed pneumatic cylinder",
        "Seven rings under 1, 3, 5 and 7 bar, ten strokes each. mu is force over pressure times area; the squeeze of the ring "
        "without air makes it about mu0 + F0 / (p A) by definition.",
        "3D-printed-pneumatic-actuator by EvaZillen at 6e0bcb4, `results_pneumatic-actuator/data/friction/*.csv`",
        "CC0 1.0",
    ),
    "al10cu_composites": Origin(
        "Aluminium alloy and three composites",
        "Pin on disc, 50 N, dry, 333 mm/s, 7 minutes, three runs a material. Adapted: force divided by the load, time made "
        "distance, every run thinned to 400 points.",
        "ML-Models-in-Tribology-and-Mechanics-for-hybrid-Al-based-composites by mihail-15 (2025) at 377af46, `*/*.dwf`",
        "CC BY 4.0 (https://creativecommons.org/licenses/by/4.0/)",
    ),
    "miba_dynamic": Origin(
        "Fourteen friction systems, dynamic friction",
        "2016 mean values at six pressures and four speeds, six readings each while the parts warm up. The scale of the "
        "pressure is unknown; T follows pressure times speed.",
        *_MIBA,
    ),
    "miba_static": Origin(
        "Fourteen friction systems, static friction",
        "2016 mean values of the same systems: pressure and temperature only, no speed.",
        *_MIBA,
    ),
}
