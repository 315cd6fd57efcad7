"""SSP 1.0: a system of FMUs with its connections and start values in one archive, as many simulators load it.

The archive holds `SystemStructure.ssd` and ``resources/*.fmu``; replacing one resource swaps a component.
SSP says nothing about the master algorithm. The communication step therefore stands in annotations, as
libcosim (``com.opensimulationplatform``) and OMSimulator (``org.openmodelica``) write them, and what only
this project knows (order, what to record, whether data is synthetic) in one of its own, which others skip.
"""

from __future__ import annotations

from dataclasses import dataclass, field

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
OWN = "urn:tribofmu:ssp:1"
#: Types of our annotations.
OWN_TYPE, OSP_TYPE, OMS_TYPE = "tribofmu", "com.opensimulationplatform", "org.openmodelica"

DESCRIPTION = "SystemStructure.ssd"
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
Value = bool | int | float | str


@dataclass(frozen=True)
class Connector:
    """A variable of a component, or of the whole system, that connections or values refer to.

    Attributes
    ----------
    name : str
        Of the FMU's variable, ``v_rel[3]`` included.
    kind : {"input", "output", "parameter"}
    type : str
        One of `TYPES`.
    unit : str
        Empty without one.

    Examples
    --------
    >>> Connector("T", "input", unit="degC").type
    'Real'
    """

    name: str
    kind: str
    type: str = "Real"
    unit: str = ""


@dataclass
class Component:
    """An FMU of the system.

    Attributes
    ----------
    source : str
        Path in the archive, ``resources/friction.fmu``; components may share it.
    start : dict of str to value
        Start values by variable.

    Examples
    --------
    >>> Component("friction", "resources/friction.fmu", [Connector("T", "input")], start={"T": 80.0}).start
    {'T': 80.0}
    """

    name: str
    source: str
    connectors: list[Connector] = field(default_factory=list)
    start: dict[str, Value] = field(default_factory=dict)


@dataclass
class Structure:
    """What `SystemStructure.ssd` says.

    Attributes
    ----------
    connections : list of tuple
        Start component, start variable, end component, end variable; "" as component is the system itself.
    connectors : list of Connector
        Of the system.
    start : dict of str to value
        Start values of the system, by the name of its connector or by ``component.variable``.
    stop, step : float or None
        End of the default experiment and communication step [s].
    notes : dict
        What this project keeps beside it; plain JSON.

    Examples
    --------
    >>> system = Structure("law", [Component("friction", "resources/friction.fmu")], stop=1.0)
    >>> [c.source for c in system.components], system.connections
    (['resources/friction.fmu'], [])
    """

    name: str
    components: list[Component] = field(default_factory=list)
    connections: list[tuple[str, str, str, str]] = field(default_factory=list)
    connectors: list[Connector] = field(default_factory=list)
    start: dict[str, Value] = field(default_factory=dict)
    stop: float | None = None
    step: float | None = None
    notes: dict[str, object] = field(default_factory=dict)
