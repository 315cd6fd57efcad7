"""The list of cases: nulls for every recipe of noise and every plan, single laws, pairs, triples, and laws outside the catalogue."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from benchmarks.blind.laws import LAWS

SPLIT_SEED = 20261123
WEAK = 4.0  # non-centrality of a weak case: an oracle finds it in half of the campaigns


@dataclass(frozen=True)
class Case:
    """One campaign: what is hidden, and how it was measured.

    `laws` holds keys and strengths. A strength of -40 scales the law until the oracle's non-centrality is 40; 0 stands for weak.
    """

    name: str
    kind: str
    base: str
    plan: str
    noise: str
    laws: tuple[tuple[str, float], ...] = ()
    metadata: tuple[str, ...] = ()
    half: str = field(default="", compare=False)
    seed: int = 0

    def words(self, *what: object) -> tuple[object, ...]:
        """What the random numbers of this case depend on."""
        return (self.name, *what, *([self.seed] if self.seed else []))


# noise: (plan, base, columns of the test table that mean nothing)
NULLS = """
white: factorial27 linear -, latin30 constant batch Ra, full81 polynomial -
quiet: factorial36 linear material, latin30 polynomial -, repeats36 power_law -
skewed: factorial27 linear batch, latin30 constant -, half81 number Ra order
heteroscedastic: factorial36 linear -, latin30 power_law operator, unbalanced32 constant -
proportional: factorial27 constant Ra, latin30 linear -, factorial36 power_law batch
quantised: factorial27 linear -, latin30 constant viscosity, pressure48 number -
hum: factorial36 linear -, latin30 constant order, half81 power_law -
random_walk: factorial27 linear -, latin30 constant batch, repeats36 polynomial -
drift: factorial27 constant humidity, latin30 linear -, unbalanced32 number batch
offsets: factorial36 linear batch Ra operator, latin30 constant material viscosity order, half81 linear humidity lot
odd_tests: factorial27 linear material, latin30 constant -, repeats36 linear batch
spikes: factorial36 linear -, latin30 number -, factorial27 polynomial Ra
red: factorial27 linear order, latin30 constant -, half81 power_law lot
two_kinds: factorial36 linear operator batch, latin30 constant -, repeats36 linear Ra
wandering_rig: factorial27 linear batch, latin30 constant material, unbalanced32 linear -
white: few8 constant -, averages50 linear batch Ra, correlated30 constant order, warming30 constant Ra, ramps20 linear -, steps18 constant batch
offsets: few8 linear -, averages81 constant lot, correlated30 linear -, warming30 linear -, unbalanced32 polynomial operator
proportional: few12 linear batch, averages50 power_law -, correlated30 number -, warming30 number material
"""

SINGLES = """
stribeck_lorentz: factorial36 white linear 1, latin30 offsets constant @40, few12 white constant 1.2, averages50 white linear 1.5
stribeck_tanh: latin60 hum polynomial 1, unbalanced32 heteroscedastic constant @60
stribeck_ramp: factorial36 quantised number 1
eyring_asinh: latin30 skewed constant @40, factorial36 spikes linear 1.5
slip_two_thirds: correlated30 white constant @40, latin60 random_walk linear 0
saturating_speed: factorial36 red linear 1.2
lubrication_number: latin60 proportional constant @60, factorial36 drift linear 1.5
load_share: pressure48 white power_law 1
couette_vogel: latin60 white constant 1, factorial36 hum linear 1.2
couette_walther: latin30 skewed linear 1.3
johnson_cook: factorial45 odd_tests constant @60, latin30 offsets linear 0
log_log_temperature: factorial45 white linear 1.5, correlated30 heteroscedastic number 1
arrhenius_film: warming30 white constant 1, latin60 spikes constant @50
desorption_erf: factorial45 quantised linear @100, latin30 white polynomial 1.2
melting_ramp: latin30 red constant @60, warming30 skewed linear 1.3
film_defect: factorial45 heteroscedastic linear 1, averages81 offsets constant 1.3
blok_pressure: latin60 white linear 1.3, factorial45 spikes constant @80
bearing_strength: full81 proportional linear 1.2
flash_ashby: pressure48 white linear 1.5
flash_molinari: latin60 quiet linear 1, factorial36 proportional constant @50
wanheim_bay: pressure48 hum constant @60, latin30 white linear 1.5
shaw_tanh: pressure48 offsets constant 1, ramps20 red linear 1
orowan_cap: ramps20 white constant 1, latin60 odd_tests linear 1
hertz_third: factorial36 two_kinds constant @40
briscoe: latin30 random_walk constant 1.2, few8 white constant 1.5
fresh_surface: latin30 spikes linear 1.3, half81 white linear 0
torn_film: latin30 skewed constant @60, factorial36 odd_tests linear 1
film_over_roughness: averages50 proportional constant @50
running_in_double: latin30 offsets linear 1, factorial27 quantised constant 1
running_in_hyperbolic: few8 white linear 1, half81 random_walk power_law 1
running_in_rising: factorial27 hum linear 1
tribofilm: latin30 red constant @80, unbalanced32 drift linear 0
breakaway: factorial27 white linear 1, latin30 proportional constant 0.8
bristles: few12 spikes constant 1
worn_through: latin30 white constant @150, factorial36 drift linear 1.2
weibull_film: few12 skewed constant 1, half81 two_kinds linear @150
energy_budget: pressure48 white linear 1, latin60 red constant @150
avrami_work: factorial36 offsets constant 1, latin60 heteroscedastic power_law 1
slip_steps: steps18 white constant 1
two_states: steps18 offsets linear 1
lots_normal: factorial36 white linear 1, averages50 white linear @50
one_bad_lot: latin30 proportional constant 1.2
deliveries: half81 odd_tests linear 1
materials: latin30 skewed linear @50, factorial36 two_kinds constant 1
operators: factorial36 red linear @40
oil_grade: latin30 white constant @50
humid_soap: factorial36 offsets linear 0, half81 quantised constant 1
rough_root: factorial36 white linear 1, unbalanced32 offsets constant @30
rough_film: latin30 hum linear 1
warming_cell: factorial36 white linear 1, latin30 red constant @60
zero_force: pressure48 white linear @60, ramps20 spikes constant 1
cold_twin: warming30 white linear 1.5
"""

PAIRS = """
stribeck_lorentz+arrhenius_film: latin60 white constant 1.2 1
stribeck_tanh+worn_through: factorial36 white linear 1.2 1
lots_normal+running_in_double: factorial36 skewed linear 1.2 1
rough_root+stribeck_lorentz: half81 white linear 1.2 1.2
torn_film+running_in_hyperbolic: latin30 offsets constant 1.3 1
wanheim_bay+tribofilm: pressure48 hum constant 1 1
orowan_cap+desorption_erf: latin60 red constant 1 1
melting_ramp+breakaway: factorial45 heteroscedastic linear 1.2 1
johnson_cook+fresh_surface: latin60 white constant 1 1.2
eyring_asinh+hertz_third: latin60 proportional constant 1.2 1.2
materials+worn_through: half81 offsets linear 1.5 1
briscoe+running_in_double: ramps20 white constant 1 1
stribeck_lorentz+fresh_surface: full81 white linear 1.2 1.3
energy_budget+oil_grade: latin60 white constant 1 1.2
couette_vogel+torn_film: latin60 spikes linear 1.3 1.2
desorption_erf+film_over_roughness: latin30 quantised constant 1 1
slip_steps+rough_film: steps18 white constant 1 1
log_log_temperature+weibull_film: correlated30 white constant 1 1
saturating_speed+humid_soap: factorial36 drift linear 1.5 1
warming_cell+torn_film: averages50 white linear 1.2 1.3
"""

TRIPLES = """
stribeck_lorentz+running_in_double+lots_normal: factorial36 white linear 1.2 1 1.2
desorption_erf+torn_film+worn_through: latin60 white constant 1 1 1
orowan_cap+tribofilm+rough_root: pressure48 offsets constant 1 1 1.5
arrhenius_film+stribeck_tanh+breakaway: full81 proportional constant 1 1 1
materials+fresh_surface+running_in_hyperbolic: half81 quantised linear 1.3 1.5 1
johnson_cook+energy_budget+oil_grade: latin60 hum constant 1 1.2 1.2
"""

OUTSIDE = """
temperature_window: factorial45 white linear 1, latin60 offsets constant 1
temperature_wave: latin60 skewed constant 1
resonance: latin30 white linear 1, factorial36 hum constant 1
turning_marks: factorial27 red linear 1
pockets: latin30 offsets constant 1
pressure_minimum: pressure48 heteroscedastic constant 1
crossing_speed_heat: factorial45 white linear 1
polish_or_wear: latin60 proportional constant 1
expansion_hump: latin60 white linear 1
wlf_ridge: latin60 quiet constant 1
entrapment: full81 spikes linear 1
one_material_hot: half81 white linear 1
ploughing_rise: pressure48 white constant 1
feeding_dimples: latin30 red constant 1
debris_hump: factorial36 quantised linear 1
hot_tribofilm: latin60 white constant 1
pressure_memory: ramps20 white constant 1
evaporation: latin30 skewed constant 1
checkerboard: latin60 two_kinds constant 1
chatter_window: latin60 odd_tests linear 1
"""


def _lines(text: str) -> list[tuple[str, list[list[str]]]]:
    out = []
    for line in text.strip().splitlines():
        head, _, rest = line.partition(":")
        out.append((head, [part.split() for part in rest.split(",")]))
    return out


def _metadata(laws: tuple[tuple[str, float], ...], index: int) -> tuple[str, ...]:
    """The columns that the laws need, and in two of three campaigns one or two that mean nothing."""
    needed = [m for key, _ in laws for m in LAWS[key].metadata if m != "T_tool"]
    spare = [m for m in ("batch", "Ra", "operator", "viscosity", "order", "material") if m not in needed]
    return (*needed, *[spare[(index + j) % len(spare)] for j in range(index % 3)])


def all_cases(seed: int = 0) -> list[Case]:
    """All cases, each in its half: `a` for development, `b` kept apart (drawn within each kind). Other seeds draw other tests and noise."""
    cases: list[Case] = []
    for noise, entries in _lines(NULLS):
        for plan, base, *columns in entries:
            cases.append(
                Case(
                    f"null-{noise}-{plan}-{base}",
                    "null",
                    base,
                    plan,
                    noise,
                    (),
                    tuple(m for m in columns if m != "-"),
                )
            )
    for kind, text in (("single", SINGLES), ("pair", PAIRS), ("triple", TRIPLES), ("outside", OUTSIDE)):
        for head, entries in _lines(text):
            for plan, noise, base, *strengths in entries:
                laws = tuple(
                    (key, float(s.replace("@", "-")))
                    for key, s in zip(head.split("+"), strengths, strict=True)
                )
                name = f"{kind}-{head.replace('+', '.')}-{plan}-{noise}-{base}"
                cases.append(Case(name, kind, base, plan, noise, laws, _metadata(laws, len(cases))))
    if len({c.name for c in cases}) != len(cases):
        raise ValueError("two cases have one name")
    rng = np.random.default_rng(SPLIT_SEED)
    halves: dict[str, str] = {}
    for kind in ("null", "single", "pair", "triple", "outside"):
        mine = [c.name for c in cases if c.kind == kind]
        for rank, i in enumerate(rng.permutation(len(mine))):
            halves[mine[i]] = "ab"[rank % 2]
    return [
        Case(c.name, c.kind, c.base, c.plan, c.noise, c.laws, c.metadata, halves[c.name], seed) for c in cases
    ]
