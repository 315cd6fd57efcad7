"""Storage of the values of a graph in a C function: names, elements, reused buffers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """The values of one tensor."""

    name: str  #: C variable or array.
    size: int  #: Elements of the tensor.
    offset: int = 0  #: First element within the array.
    lanes: bool = False  #: Whether every element stands for a block of points, one value a point.
    scalar: bool = False  #: Whether `name` is a plain variable.
    #: The buffer that must not be used again as long as this place is needed; empty for none.
    buffer: str = ""

    def at(self, index: str | int) -> str:
        """Return element `index`; of the point `l` in a block."""
        if self.scalar:
            return self.name
        where = _sum(self.offset, "0" if self.size == 1 else index)
        if not self.lanes:
            return f"{self.name}[{where}]"
        if where.isdigit():
            return f"{self.name}[{_sum('l', '' if where == '0' else f'{where} * TF_BLOCK')}]"
        return f"{self.name}[({where}) * TF_BLOCK + l]"

    def flat(self, index: str) -> str:
        """Return value `index` when elements and points are counted through."""
        return f"{self.name}[{_sum(index, f'{self.offset} * TF_BLOCK' if self.offset else '')}]"

    def pointer(self) -> str:
        """Return the address of the first element."""
        if self.scalar:
            return f"&{self.name}"
        pitch = " * TF_BLOCK" if self.lanes else ""
        return f"{self.name} + {self.offset}{pitch}" if self.offset else self.name

    def part(self, first: int, size: int) -> Place:
        """Return `size` elements from `first` on, at the same place."""
        return Place(self.name, size, self.offset + first, self.lanes, self.scalar, self.buffer)


def _sum(*terms: str | int) -> str:
    texts = [str(t) for t in terms if str(t) not in {"", "0"}]
    if len(texts) > 1 and all(t.isdigit() for t in texts):
        return str(sum(map(int, texts)))
    return " + ".join(texts) or "0"


class Buffers:
    """Arrays of a function; one that is free again is used for the next values of its length."""

    def __init__(self) -> None:
        self._lengths: dict[str, int] = {}
        self._free: list[str] = []
        self._users: dict[str, int] = {}

    def take(self, length: int) -> str:
        """Return a free array of `length` doubles (the shortest that is long enough, or a new one)."""
        fitting = [b for b in self._free if self._lengths[b] == length]
        if fitting:
            self._free.remove(fitting[-1])
            return fitting[-1]
        name = f"b{len(self._lengths)}"
        self._lengths[name] = length
        return name

    def hold(self, buffer: str) -> None:
        """Count one more user."""
        if buffer:
            self._users[buffer] = self._users.get(buffer, 0) + 1

    def release(self, buffer: str) -> None:
        """Count one user less; without any the array is free."""
        if not buffer:
            return
        self._users[buffer] -= 1
        if not self._users[buffer]:
            self._free.append(buffer)

    def sole(self, buffer: str) -> bool:
        """Whether an array has one user."""
        return bool(buffer) and self._users.get(buffer) == 1

    def declarations(self) -> list[str]:
        """Return the definitions of all arrays."""
        return [f"double {name}[{length}];" for name, length in self._lengths.items()]

    def offsets(self) -> dict[str, int]:
        """Return where each array begins when they stand in one."""
        found, at = {}, 0
        for name, length in self._lengths.items():
            found[name], at = at, at + length
        return found

    def total(self) -> int:
        """Return the doubles of all arrays."""
        return sum(self._lengths.values())
