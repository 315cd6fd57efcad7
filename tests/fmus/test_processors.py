"""The same model on processors without AVX2 and of another kind, in an emulator: the plain build, bit by bit."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from fmus.interface.friction_source import parse_source
from fmus.native import compile as compiling
from fmus.native.generate import generate
from tests.fmus.catalogue import content_of

#: Without powers, which come from the C library of the machine.
MODEL = "ffnn + rate_state + tool_roughness"
#: Prints whether the wide kernels are taken, and mu of 64 points alone and in blocks, by the bits.
PROGRAM = """\
#include <stdio.h>
#include "model.h"
int main(void) {
    unsigned seed = 1;
    double l[5 * TF_BLOCK], s[TF_STATES * TF_BLOCK], p[TF_SYSTEM], mu[TF_BLOCK];
    for (int k = 0; k < TF_SYSTEM; ++k) p[k] = 0.4;
    printf("%d\\n", tf_wide());
    for (int start = 0; start < 64; start += TF_BLOCK) {
        for (int i = 0; i < (5 + TF_STATES) * TF_BLOCK; ++i) {
            seed = seed * 1664525u + 1013904223u;
            const double value = (seed >> 8) / 16777216.0;
            if (i < 5 * TF_BLOCK) l[i] = 300.0 * value;
            else s[i - 5 * TF_BLOCK] = value;
        }
        tf_model_mu_block(l, s, p, mu);
        for (int i = 0; i < TF_BLOCK; ++i) {
            double point[5], state[TF_STATES], alone;
            for (int k = 0; k < 5; ++k) point[k] = l[k * TF_BLOCK + i];
            for (int k = 0; k < TF_STATES; ++k) state[k] = s[k * TF_BLOCK + i];
            tf_model_mu(point, state, p, &alone);
            printf("%a %a\\n", alone, mu[i]);
        }
    }
    return 0;
}
"""


def build(folder: Path, target: str, *flags: str) -> str:
    zig = compiling.zig_command()
    if zig is None:
        pytest.skip("the Zig compiler (extra [cross]) is not installed: other processors cannot be built for")
    source = parse_source(content_of(MODEL), MODEL)
    (folder / "model.h").write_text(generate(source, source.interface(1)), encoding="utf-8")
    (folder / "main.c").write_text(PROGRAM, encoding="utf-8")
    options = ["-target", target, *compiling._FLAGS, *flags]
    subprocess.run([*zig, *options, "main.c", "-o", target, "-lm"], cwd=folder, check=True)
    return str(folder / target)


def output(*command: str) -> list[str]:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


@pytest.mark.parametrize(
    ("emulator", "target"),
    [
        (("qemu-x86_64", "-cpu", "Nehalem"), "x86_64-linux-gnu.2.17"),
        (("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"), "aarch64-linux-gnu.2.17"),
    ],
    ids=["no AVX2", "ARM"],
)
def test_processors_without_avx2_take_the_plain_build_of_the_same_bits(
    emulator: tuple[str, ...], target: str, tmp_path: Path
) -> None:
    if shutil.which(emulator[0]) is None:
        pytest.skip(f"{emulator[0]} is not installed: no processor of this kind can be tried")
    if emulator[-1].startswith("/") and not Path(emulator[-1]).is_dir():
        pytest.skip(f"{emulator[-1]} is not installed: programs for this processor cannot be run")
    wide, *values = output(*emulator, build(tmp_path, target))
    assert wide == "0"
    assert len(set(values)) > 40
    assert values[::2] == values[1::2]
    host = compiling.host_platform()
    if not host.name.endswith("-linux"):
        pytest.skip("the plain build can be compared with that of this machine on Linux only")
    (tmp_path / "here").mkdir()
    assert output(build(tmp_path / "here", host.target, "-DTF_PLAIN_ONLY"))[1:] == values
