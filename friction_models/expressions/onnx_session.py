"""Sessions of ONNX Runtime: on one thread, and silent, because our own errors say what is wrong."""

from __future__ import annotations

from typing import Any

#: ONNX Runtime's most severe level, "fatal".
_SILENT = 4


def onnx_session(content: bytes) -> Any:
    """Return an `onnxruntime.InferenceSession` of the content of an ONNX file, on one thread of the processor.

    Raises what ONNX Runtime raises where it refuses the graph; its classes are not public.
    """
    import onnxruntime

    onnxruntime.set_default_logger_severity(_SILENT)  # its allocator does not ask the session
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = _SILENT
    return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
