"""The steps of a graph as C statements, for one contact point or for a block of them side by side.

A block keeps one value a point for everything that depends on loads or states; what depends on system
variables alone is computed once. The statements of both forms do the same arithmetic in the same order.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from . import ops
from .c_variables import Buffers, Place
from .tables import Tables, literal
from .tensors import Graph, Step, Tensor, refuse
from .trees import tree_tables

T = TypeVar("T")

#: Points of a block: four vectors of AVX2.
BLOCK = 16

#: C names of the graph's inputs; a d in front for the derivatives' seeds.
_INPUTS = {"loads": "L", "state": "S", "system": "P"}


class Writer:
    """Writes the statements that compute one output (`role`) of the graph; `tables` takes the constants.

    With `lanes` for a block of points instead of one, with `seeded` forward derivatives beside the values (one point only).
    """

    def __init__(
        self, graph: Graph, role: str, tables: Tables, where: str, lanes: bool = False, seeded: bool = False
    ) -> None:
        self.tables = tables
        self.where = where
        self.lanes = lanes
        self.seeded = seeded
        self.lines: list[str] = []
        self.buffers = Buffers()
        self._values: dict[int, Place] = {}
        self._seeds: dict[int, Place] = {}
        self._count = 0
        for name, tensor in graph.inputs.items():
            if name == "dt":
                self._values[id(tensor)] = Place("dt", 1, scalar=True)
                continue
            per_point = lanes and name != "system"
            self._values[id(tensor)] = Place(_INPUTS[name], tensor.size, lanes=per_point)
            if seeded:
                self._seeds[id(tensor)] = Place(f"d{_INPUTS[name]}", tensor.size)
        steps = graph.needed_for(role)
        output = graph.outputs[role]
        self._wanted = _carrying(steps, output) if seeded else set()
        self._last = {id(t): n for n, step in enumerate(steps) for t in step.inputs if t is not None}
        self._last[id(output)] = len(steps)
        for number, step in enumerate(steps):
            self._step(number, step)
        self._finish(output)

    # --- places ----------------------------------------------------------------------------------------

    def place(self, tensor: Tensor) -> Place:
        """Return where the values of a tensor stand."""
        if tensor.constant is not None:
            return Place(self.tables.add(np.ravel(tensor.constant).astype(float)), tensor.size)
        return self._values[id(tensor)]

    def _element(self, tensor: Tensor, index: str | int) -> str:
        if tensor.constant is not None and tensor.size == 1:
            return literal(float(np.ravel(tensor.constant)[0]))
        return self.place(tensor).at(index)

    def _is_lanes(self, tensors: Sequence[Tensor]) -> bool:
        return any(t.constant is None and self._values[id(t)].lanes for t in tensors)

    def _array(self, size: int, lanes: bool) -> Place:
        name = self.buffers.take(size * (BLOCK if lanes else 1))
        return Place(name, size, lanes=lanes, buffer=name)

    def _store(self, tensor: Tensor, place: Place, seed: bool = False) -> None:
        self.buffers.hold(place.buffer)
        (self._seeds if seed else self._values)[id(tensor)] = place

    def _scalar(self, expression: str, prefix: str = "t") -> Place:
        self._count += 1
        name = f"{prefix}{self._count}"
        self.lines.append(f"const double {name} = {expression};")
        return Place(name, 1, scalar=True)

    # --- steps -----------------------------------------------------------------------------------------

    def _step(self, number: int, step: Step) -> None:
        if step.op in ops.ELEMENTWISE or step.op == "Cast":
            self._elementwise(number, step)
        elif step.op in {"MatMul", "Gemm"}:
            self._product(step)
        elif step.op == "ReduceSum":
            self._reduce(step)
        elif step.op == "TreeEnsemble":
            self._trees(step)
        else:
            self._pick(step)
        for tensor in {id(t): t for t in (*step.inputs, step.output) if t is not None}.values():
            if self._last.get(id(tensor), -1) <= number and tensor.constant is None:
                for places in (self._values, self._seeds):
                    if id(tensor) in places:
                        self.buffers.release(places[id(tensor)].buffer)

    def _finish(self, output: Tensor) -> None:
        loop = (
            "for (int l = 0; l < TF_BLOCK; ++l)" if self.lanes else f"for (int i = 0; i < {output.size}; ++i)"
        )
        at = "l" if self.lanes else "i"
        self.lines.append(f"{loop} out[{at}] = {self._element(output, '0' if self.lanes else 'i')};")
        if self.seeded:
            seed = self._seeds.get(id(output))
            self.lines.append(f"{loop} dout[i] = {seed.at('i') if seed else '0.0'};")

    def _index(self, tensor: Tensor, step: Step) -> str:
        if tensor.size == 1:
            return "0"
        if tensor.size != step.output.size:
            raise refuse(self.where, f"{step.op} spreads {tensor.shape} over {step.output.shape}")
        return "i"

    def _elementwise(self, number: int, step: Step) -> None:
        size = step.output.size
        tensors = [t for t in step.inputs if t is not None]
        indices = [self._index(t, step) for t in tensors]
        lanes = self._is_lanes(tensors)
        function = ops.FUNCTIONS.get(step.op)
        if function and (lanes or size > 1):
            self._function(number, step, function, lanes)
        elif lanes and all(t.size == (size if self._is_lanes([t]) else 1) for t in tensors):
            # Elements and points in one loop: no operand is spread.
            place = self._array(size, True)
            operands = [
                self._values[id(t)].flat("k") if self._is_lanes([t]) else self._element(t, 0) for t in tensors
            ]
            total = f"{size} * TF_BLOCK" if size > 1 else "TF_BLOCK"
            expression = self._expression(step, operands)
            self.lines.append(f"for (int k = 0; k < {total}; ++k) {place.name}[k] = {expression};")
            self._store(step.output, place)
        else:
            operands = [self._element(t, i) for t, i in zip(tensors, indices)]
            self._store(step.output, self._assign(size, lanes, self._expression(step, operands)))
        if id(step.output) in self._wanted:
            self._seed_elementwise(step, tensors, indices)

    def _assign(self, size: int, lanes: bool, expression: str, prefix: str = "t") -> Place:
        """Write an expression of the index i (and the point l) for every element."""
        if size == 1 and not lanes:
            return self._scalar(expression, prefix)
        place = self._array(size, lanes)
        loops = f"for (int i = 0; i < {size}; ++i) " if size > 1 else ""
        loops += "for (int l = 0; l < TF_BLOCK; ++l) " if lanes else ""
        self.lines.append(f"{loops}{place.at('i')} = {expression};")
        return place

    def _function(self, number: int, step: Step, function: str, lanes: bool) -> None:
        """Write a call for all elements, in place where nothing else needs the operand."""
        tensor, size = step.inputs[0], step.output.size
        assert tensor is not None
        held = self._values.get(id(tensor))
        free = self._last.get(id(tensor)) == number and not self.seeded
        if held is not None and free and held.size == size and self.buffers.sole(held.buffer):
            place = held
        else:
            place = self._assign(size, lanes, self._element(tensor, "i"))
        total = f"{size} * TF_BLOCK" if lanes else str(size)
        self.lines.append(f"{function}_n({place.pointer()}, {total}, fused);")
        self._store(step.output, place)

    def _expression(self, step: Step, operands: Sequence[str]) -> str:
        return ops.ELEMENTWISE[ops.plain_name(step)](self._adapted(step, operands))

    def _adapted(self, step: Step, operands: Sequence[str]) -> list[str]:
        if step.op == "Cast":
            return [ops.cast(step, operands[0])]
        return self._limits(step, operands, "(-INFINITY)", "INFINITY")

    def _limits(self, step: Step, operands: Sequence[T], low: T, high: T) -> list[T]:
        """Put in what stands for a limit that a Clip leaves out."""
        if step.op != "Clip":
            return list(operands)
        given = iter(operands)
        present = [t is not None for t in (*step.inputs, None, None)[:3]]
        return [next(given) if p else absent for p, absent in zip(present, (low, low, high))]

    def _seed_elementwise(self, step: Step, tensors: Sequence[Tensor], indices: Sequence[str]) -> None:
        operands = self._adapted(step, [self._element(t, i) for t, i in zip(tensors, indices)])
        seeds = [self._seeds[id(t)].at(i) if id(t) in self._seeds else None for t, i in zip(tensors, indices)]
        seeds = self._limits(step, seeds, None, None)
        y = self._values[id(step.output)].at("i")
        expression = ops.derivative(ops.plain_name(step), y, operands, seeds)
        if expression is not None:
            self._store(step.output, self._assign(step.output.size, False, expression, "d"), seed=True)

    def _product(self, step: Step) -> None:
        x, w = step.inputs[0], step.inputs[1]
        assert x is not None and w is not None and w.constant is not None
        alpha = step.attributes.number("alpha", 1.0) if step.op == "Gemm" else 1.0
        beta = step.attributes.number("beta", 1.0) if step.op == "Gemm" else 1.0
        weights = w.constant.astype(float)
        weights = alpha * (weights.T if step.attributes.whole("transB", 0) else weights)
        inputs, outputs = weights.shape
        bias = step.inputs[2] if len(step.inputs) > 2 else None
        start = "NULL"
        if bias is not None:
            if bias.constant is None:
                raise refuse(self.where, "the bias of a Gemm is computed in the graph")
            start = self.tables.add(np.broadcast_to(beta * bias.constant.astype(float), (1, outputs)))
        matrix = self.tables.add(np.ascontiguousarray(weights))

        def write(source: Place, offset: str) -> Place:
            place = self._array(outputs, source.lanes)
            call = "tf_dense_block" if source.lanes else "tf_dense"
            self.lines.append(
                f"{call}({place.name}, {source.pointer()}, {matrix}, {offset}, {inputs}, {outputs}, fused);"
            )
            return place

        self._store(step.output, write(self.place(x), start))
        if id(x) in self._seeds and id(step.output) in self._wanted:
            self._store(step.output, write(self._seeds[id(x)], "NULL"), seed=True)

    def _reduce(self, step: Step) -> None:
        x = step.inputs[0]
        assert x is not None

        def write(source: Place) -> Place:
            place = self._array(1, source.lanes)
            points = "for (int l = 0; l < TF_BLOCK; ++l) " if source.lanes else ""
            self.lines.append(f"{points}{place.at(0)} = {source.at(0)};")
            if source.size > 1:
                elements = f"for (int i = 1; i < {source.size}; ++i) "
                self.lines.append(f"{elements}{points}{place.at(0)} += {source.at('i')};")
            return place

        self._store(step.output, write(self.place(x)))
        if id(x) in self._seeds and id(step.output) in self._wanted:
            self._store(step.output, write(self._seeds[id(x)]), seed=True)

    def _pick(self, step: Step) -> None:
        picked = ops.picks(step.op, step.attributes, step.inputs, self.where)
        first, start = picked[0]
        run = all(t is first and i == start + k for k, (t, i) in enumerate(picked))
        if run:  # what stands together is used where it stands
            self._store(step.output, self.place(first).part(start, len(picked)))
            if id(first) in self._seeds:
                self._store(step.output, self._seeds[id(first)].part(start, len(picked)), seed=True)
            return
        lanes = self._is_lanes([t for t, _ in picked])
        self._store(step.output, self._gathered([self._element(t, i) for t, i in picked], lanes))
        if id(step.output) in self._wanted and any(id(t) in self._seeds for t, _ in picked):
            seeds = [self._seeds[id(t)].at(i) if id(t) in self._seeds else "0.0" for t, i in picked]
            self._store(step.output, self._gathered(seeds, False), seed=True)

    def _gathered(self, elements: Sequence[str], lanes: bool) -> Place:
        place = self._array(len(elements), lanes)
        points = "for (int l = 0; l < TF_BLOCK; ++l) " if lanes else ""
        self.lines += [f"{points}{place.at(k)} = {text};" for k, text in enumerate(elements)]
        return place

    def _trees(self, step: Step) -> None:
        x = step.inputs[0]
        assert x is not None
        nodes, trees, count = tree_tables(step.attributes, x.size, self.tables, self.where)
        source = self.place(x)
        if source.lanes:
            place = self._array(1, True)
            self.lines.append(f"tf_trees_block({place.name}, {source.pointer()}, {nodes}, {trees}, {count});")
        else:
            place = self._scalar(f"tf_trees({source.pointer()}, {nodes}, {trees}, {count})")
        self._store(step.output, place)


def _carrying(steps: Sequence[Step], output: Tensor) -> set[int]:
    """Return the values whose derivative reaches that of the output."""
    wanted = {id(output)}
    for step in reversed(steps):
        if id(step.output) in wanted:
            wanted |= {id(t) for t in ops.differentiated(step)}
    return wanted
