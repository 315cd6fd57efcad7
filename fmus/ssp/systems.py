"""SSP 1.0: a system of FMUs with its connections and start values in one archive, as many simulators load it.

The archive holds `SystemStructure.ssd` and ``resources/*.fmu``; replacing one resource swaps a component.
SSP says nothing about the master algorithm. The communication step therefore stands in annotations, as
libcosim (``com.opensimulationplatform``) and OMSimulator (``org.openmodelica``) write them, and what only
this project knows (order, what to record, whether data is synthetic) in one of its own, which others skip.
"""

from __future__ import annotations

from dataclasses import dataclass, field

#: Namespaces by their prefixes.
SPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "tribofmu": "urn:tribofmu:ssp:1",
}
#: Types of our annotations.
OWN_TYPE, OSP_TYPE, OMS_TYPE = "tribofmu", "com.opensimulationplatform", "org.openmodelica"

DESCRIPTION = "SystemStructure.ssd"
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
Value = bool | int | float | str


@dataclass(frozen=True)
class Connector:
    """A variable of a component, or of the whole system, that connections or values refer to."""

    name: str  #: Of the FMU's variable, ``v_rel[3]`` included.
    kind: str  #: ``input``, ``output`` or ``parameter``.
    type: str = "Real"  #: One of `TYPES`.
    unit: str = ""  #: Empty without one.


@dataclass
class SspComponent:
    """An FMU of the system."""

    name: str
    source: str  #: Path in the archive, ``resources/friction.fmu``; components may share it.
    connectors: list[Connector] = field(default_factory=list)
    start: dict[str, Value] = field(default_factory=dict)  #: Start values by variable.


@dataclass
class Structure:
    """What `SystemStructure.ssd` says."""

    name: str
    components: list[SspComponent] = field(default_factory=list)
    #: Start component, start variable, end component, end variable; "" as component is the system itself.
    connections: list[tuple[str, str, str, str]] = field(default_factory=list)
    connectors: list[Connector] = field(default_factory=list)  #: Of the system.
    #: Start values of the system, by the name of its connector or by ``component.variable``.
    start: dict[str, Value] = field(default_factory=dict)
    stop: float | None = None  #: End of the default experiment [s].
    step: float | None = None  #: Communication step [s].
    notes: dict[str, object] = field(default_factory=dict)  #: What this project keeps beside it; plain JSON.
