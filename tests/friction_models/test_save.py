"""Saved folders: what is written, and that a hostile folder is refused in one sentence."""

from __future__ import annotations

import io
import json
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fmus.source.reading import read_source
from friction_models import load_model
from friction_models.common import InputError
from friction_models.families.registry import make_model
from friction_models.loads import DataSet

from .made_up import anywhere, campaign

FRAME = campaign(6, 20)
SMALL: dict[str, dict[str, int | tuple[int, ...]]] = {
    "ffnn": {"hidden": (4, 3), "members": 2, "epochs": 2},
    "gradient_boosting": {"trees": 6, "min_points": 5, "leaves": 8},
}
#: Damage to what a file holds.
CardChange = Callable[[dict[str, Any]], object]
ArrayChange = Callable[[dict[str, NDArray[Any]]], object]


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("models")
    return {
        family: make_model(family, **SMALL.get(family, {})).fit_frame(FRAME).save(root / family)
        for family in ("linear", "polynomial", "power_law", "gradient_boosting", "ffnn")
    }


@pytest.fixture
def linear(folders: dict[str, Path], tmp_path: Path) -> Path:
    return copied(folders["linear"], tmp_path)


def copied(folder: Path, tmp_path: Path) -> Path:
    target = tmp_path / "model"
    target.mkdir(parents=True)
    for file in folder.iterdir():
        (target / file.name).write_bytes(file.read_bytes())
    return target


def edit_card(folder: Path, change: CardChange) -> None:
    card = json.loads((folder / "card.json").read_text())
    change(card)
    (folder / "card.json").write_text(json.dumps(card))


def edit_arrays(folder: Path, change: ArrayChange) -> None:
    with np.load(folder / "parameters.npz") as stored:
        arrays = dict(stored)
    change(arrays)
    np.savez(folder / "parameters.npz", **arrays)


def refused(folder: Path, words: str) -> None:
    """The folder is refused in one short sentence that names it and holds `words`."""
    with pytest.raises(InputError) as caught:
        load_model(folder)
    message = str(caught.value)
    assert str(folder) in message
    assert words in message
    assert "\n" not in message and len(message) < 400 + len(str(folder))


def test_the_four_files_are_written_and_nothing_else(folders: dict[str, Path]) -> None:
    for folder in folders.values():
        assert sorted(p.name for p in folder.iterdir()) == [
            "card.json",
            "card.md",
            "model.onnx",
            "parameters.npz",
        ]


def test_saving_twice_gives_the_same_bytes(folders: dict[str, Path], tmp_path: Path) -> None:
    for family, folder in folders.items():
        again = load_model(folder).save(tmp_path / family)
        for file in folder.iterdir():
            assert (again / file.name).read_bytes() == file.read_bytes(), file


def test_saving_replaces_a_model_but_nothing_else(tmp_path: Path) -> None:
    model = make_model("linear").fit_frame(FRAME)
    assert model.save(tmp_path / "m") == tmp_path / "m"
    model.save(tmp_path / "m")
    mine = tmp_path / "thesis"
    mine.mkdir()
    (mine / "chapter.txt").write_text("years of work")
    with pytest.raises(InputError, match=r"holds other files and no card\.json; allowed: a new or empty"):
        model.save(mine)
    with pytest.raises(InputError, match="is a file; allowed: a new or empty folder"):
        model.save(mine / "chapter.txt")
    assert (mine / "chapter.txt").read_text() == "years of work"
    with pytest.raises(InputError, match="not fitted"):
        make_model("linear").save(tmp_path / "n")
    assert not (tmp_path / "n").exists()


@pytest.mark.parametrize("name", ["parameters.npz", "model.onnx"])
def test_a_file_of_another_model_is_refused(linear: Path, tmp_path: Path, name: str) -> None:
    other = make_model("linear").fit_frame(FRAME.assign(mu=FRAME["mu"] + 0.02)).save(tmp_path / "other")
    (linear / name).write_bytes((other / name).read_bytes())
    refused(linear, f"{name} and card.json are of two models (SHA-256 ")
    # The card of an earlier version names no hashes.
    edit_card(linear, lambda card: card.pop("sha256"))
    assert load_model(linear).family == "linear"


def test_a_model_that_was_edited_in_its_card_is_refused_where_it_predicts_and_where_it_is_packed(
    folders: dict[str, Path], tmp_path: Path
) -> None:
    """Commands that predict read the card, `pack` the graph: each would give another mu."""
    model = make_model("linear").fit_frame(FRAME) + "stribeck"
    folder = model.fit_frame(FRAME).save(tmp_path / "model")

    def halved(card: dict[str, Any]) -> None:
        card["model"]["learned"]["amplitudes"][0]["delta_s"] *= 0.5

    edit_card(folder, halved)
    refused(folder, "the model in card.json was changed after it was saved")
    with pytest.raises(InputError, match=r"the model in card\.json was changed after it was saved"):
        read_source(folder)
    # The card of an earlier version has the hashes of the files only.
    edit_card(folder, lambda card: card["sha256"].pop("model"))
    assert load_model(folder).is_fitted and read_source(folder).onnx
    # A remark beside the model changes no mu.
    plain = copied(folders["linear"], tmp_path / "plain")
    edit_card(plain, lambda card: card.update(remark="for the thesis"))
    assert load_model(plain).is_fitted


@pytest.mark.parametrize("nonsense", [None, 5, [], {}, {"parameters.npz": 1, "model.onnx": []}])
def test_hashes_that_are_none_are_refused(linear: Path, nonsense: Any) -> None:
    edit_card(linear, lambda card: card.update(sha256=nonsense))
    refused(linear, "parameters.npz and card.json are of two models")


def test_a_missing_file_is_named(linear: Path) -> None:
    (linear / "parameters.npz").unlink()
    refused(linear, "parameters.npz: no such file")
    (linear / "card.json").unlink()
    refused(linear, "no card.json in this folder")


def test_no_folder_at_all(tmp_path: Path) -> None:
    refused(tmp_path / "nothing", "no such folder")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not JSON"),
        (b"{", "not JSON"),
        (b"\xff\xfe\x00", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b"[]", "not the card"),
        (b'{"format": "other"}', "not the card"),
        (b'{"format": "tribofmu-model", "format_version": 2}', "format_version 2"),
        (b'{"format": "tribofmu-model", "format_version": 1}', "key 'model' is missing"),
        (
            b'{"format": "tribofmu-model", "format_version": 1, "model": "banana"}',
            "key 'model' has the value \"banana\"; allowed",
        ),
        (
            b'{"format": "tribofmu-model", "format_version": 1, "model": null}',
            "key 'model' has the value null; allowed",
        ),
        (b'{"format": "tribofmu-model", "format_version": 1, "model": {}}', "does not describe a model"),
        (
            b'{"format": "tribofmu-model", "format_version": 1, "model": {"family": "linaer"}}',
            "did you mean 'linear'",
        ),
    ],
)
def test_a_card_that_is_none(linear: Path, content: bytes, words: str) -> None:
    (linear / "card.json").write_bytes(content)
    refused(linear, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m["params"].update(depth=3), "unknown parameter 'depth'"),
        (lambda m: m.update(params=[]), ""),
        (lambda m: m.update(params=3), "does not describe a model"),
        (lambda m: m.update(domain=None), "domain"),
        (lambda m: m["domain"].update(T=[300.0, 20.0]), "domain: 'T'"),
        (lambda m: m["domain"].update(T=["a", "b"]), "domain"),
        (lambda m: m["domain"].update(T=[float("nan"), 1.0]), "domain: 'T'"),
        (lambda m: m.pop("learned"), "does not describe a model"),
        (lambda m: m.update(training=5), "does not describe a model"),
        (lambda m: m.update(errors={"train": 5}), "does not describe a model"),
        (lambda m: m.update(family=["linear"]), "unknown model"),
    ],
)
def test_a_card_with_nonsense(linear: Path, change: CardChange, words: str) -> None:
    edit_card(linear, lambda card: change(card["model"]))
    edit_card(linear, lambda card: card["sha256"].pop("model"))
    if words:
        refused(linear, words)
    else:
        assert load_model(linear).family == "linear"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda a: a.pop("coef"), "array 'coef' is missing; present: intercept"),
        (
            lambda a: a.update(coef=np.zeros(4)),
            "array 'coef' is float64 of shape (4,), allowed: floats of shape (5)",
        ),
        (lambda a: a.update(coef=np.zeros((5, 1))), "of shape (5, 1)"),
        (lambda a: a.update(coef=np.arange(5)), "is int64"),
        (lambda a: a.update(coef=np.full(5, np.nan)), "not finite"),
        (lambda a: a.update(coef=np.array(["a"] * 5)), "holds <U1; allowed: numbers"),
        (lambda a: a.update(coef=np.array([None] * 5, dtype=object)), "holds object; allowed: numbers"),
        (lambda a: a.update(intercept=np.array([np.inf])), "not finite"),
    ],
)
def test_arrays_with_nonsense(linear: Path, change: ArrayChange, words: str) -> None:
    edit_arrays(linear, change)
    refused(linear, words)


def test_an_object_array_is_never_unpickled(linear: Path, tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[Any, ...]:
            return (Path.touch, (tmp_path / "exploded",))

    edit_arrays(linear, lambda a: a.update(coef=np.array([Bomb()] * 5, dtype=object)))
    refused(linear, "holds object")
    (linear / "parameters.npz").write_bytes(pickle.dumps(Bomb()))
    refused(linear, "not an archive of arrays")
    assert not (tmp_path / "exploded").exists()


def test_sizes_are_checked_before_anything_is_unpacked(linear: Path) -> None:
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999,), }"
    padded = header + b" " * (118 - len(header) - 1) + b"\n"
    lying = b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded
    with zipfile.ZipFile(linear / "parameters.npz", "w") as archive:
        archive.writestr("coef.npy", lying + b"\0" * 40)
    refused(linear, "larger than its file")
    with zipfile.ZipFile(linear / "parameters.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("coef.npy", b"\0" * (300 * 1024**2))
    assert (linear / "parameters.npz").stat().st_size < 2**20
    refused(linear, "allowed: 1000 arrays and 268435456 bytes")
    with (linear / "card.json").open("wb") as stream:
        stream.truncate(20 * 1024**2)
    refused(linear, "20971520 bytes, allowed: at most 16777216")


def test_a_broken_archive(linear: Path) -> None:
    content = (linear / "parameters.npz").read_bytes()
    for broken in (b"", content[:50], content[: len(content) // 2], b"PK\x03\x04" + b"\0" * 100):
        (linear / "parameters.npz").write_bytes(broken)
        refused(linear, "not an archive of arrays")
    with zipfile.ZipFile(linear / "parameters.npz", "w") as archive:  # a header that ends within a bracket
        archive.writestr("coef.npy", b"\x93NUMPY\x01\x00\x10\x00{'descr': (      ")
    refused(linear, "not an archive of arrays")
    buffer = io.BytesIO()
    np.save(buffer, np.zeros(5))
    (linear / "parameters.npz").write_bytes(buffer.getvalue())
    refused(linear, "not an archive of arrays")


def test_network_shapes_must_fit(folders: dict[str, Path], tmp_path: Path) -> None:
    folder = copied(folders["ffnn"], tmp_path)
    edit_card(folder, lambda c: c["model"]["params"].update(hidden=[4, 4]))
    refused(folder, "array 'weights0_1'")
    edit_card(folder, lambda c: c["model"]["params"].update(hidden=[10**9]))
    refused(folder, "hidden is 1000000000, allowed: a whole number from 1 to 1024")
    edit_card(folder, lambda c: c["model"]["params"].update(hidden="abc"))
    refused(folder, "hidden is 'abc'")
    edit_card(folder, lambda c: c["model"]["params"].update(hidden=[4, 3], activation=[]))
    refused(folder, "unknown activation")
    edit_card(folder, lambda c: c["model"]["params"].update(activation="tanh"))
    edit_arrays(folder, lambda a: a.update(scale=np.zeros(5)))
    refused(folder, "array 'scale' holds 0; allowed: numbers above 0")


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("left", lambda a: a * 0, "is no tree"),
        ("right", lambda a: a - 1, "is no tree"),
        ("nodes", lambda a: a * 0 + 64, "allowed: 5000 trees with 1 to 63"),
        ("nodes", lambda a: a[:-1], "of shape"),
        ("feature", lambda a: a + 5, "feature index"),
        ("threshold", lambda a: a * np.nan, "not finite"),
        ("leaf", lambda a: a[:-1], "of shape"),
    ],
)
def test_trees_must_be_trees(
    folders: dict[str, Path], tmp_path: Path, name: str, change: Callable[[Any], Any], words: str
) -> None:
    folder = copied(folders["gradient_boosting"], tmp_path)
    edit_arrays(folder, lambda a: a.update({name: change(a[name])}))
    refused(folder, words)


@pytest.mark.parametrize("name", ["card.json", "parameters.npz"])
def test_flipped_bytes_load_or_are_refused(folders: dict[str, Path], tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(0)
    folder = copied(folders["gradient_boosting"], tmp_path)
    content = (folder / name).read_bytes()
    outcomes = set()
    for _ in range(60):
        broken = bytearray(content)
        for place in rng.integers(0, len(content), 3):
            broken[place] = rng.integers(256)
        (folder / name).write_bytes(bytes(broken))
        try:
            mu = load_model(folder).predict(anywhere(4))
        except InputError as error:
            assert "\n" not in str(error)
            outcomes.add("refused")
        else:
            assert np.isfinite(mu).all() and (mu >= 0).all()
            outcomes.add("loaded")
    assert "refused" in outcomes


def test_any_single_edit_of_a_number_loads_or_is_refused(folders: dict[str, Path], tmp_path: Path) -> None:
    """Whatever stands in one field of the card: a working model or one sentence, never a traceback."""
    nonsense: list[Any] = [None, True, -1, 1e308, "x", [], {}, [[1]], {"a": 1}]
    for family in ("polynomial", "power_law", "gradient_boosting", "ffnn"):
        (tmp_path / family).mkdir()
        folder = copied(folders[family], tmp_path / family)
        edit_card(folder, lambda card: card["sha256"].pop("model"))
        original = (folder / "card.json").read_text()
        model = json.loads(original)["model"]
        places = [(a, None) for a in model] + [(a, b) for a in ("params", "learned") for b in model[a]]
        for outer, inner in places:
            for value in nonsense:
                content = json.loads(original)
                if inner is None:
                    content["model"][outer] = value
                else:
                    content["model"][outer][inner] = value
                (folder / "card.json").write_text(json.dumps(content))
                try:
                    mu = load_model(folder).predict(anywhere(4))
                except InputError as error:
                    assert "\n" not in str(error)
                else:
                    assert np.isfinite(mu).all() and (mu >= 0).all()


@pytest.mark.parametrize("nonsense", [None, 5, b"model", ["model"]])
def test_what_is_no_path_is_refused(nonsense: Any) -> None:
    with pytest.raises(InputError, match=r"is no path; allowed: the path of a saved model$"):
        load_model(nonsense)
    with pytest.raises(InputError, match="allowed: the path of a data set"):
        DataSet.load(nonsense)
