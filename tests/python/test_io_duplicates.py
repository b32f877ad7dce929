"""Duplicates in memory and in archives are treated as the BAL reader treats them."""

import io
from pathlib import Path

import numpy as np
import pytest

from raylign import FormatError, OptionsError
from raylign.io import read_bal, read_npz, resolve_duplicates, write_bal, write_npz, write_ply
from raylign.scene import BalProblem
from tiny_problem import make_tiny_problem

POLICIES = ["first", "mean", "keep"]


def with_repeats(seed: int = 3) -> BalProblem:
    """The tiny problem's observations, many twice or more, with different pixels, shuffled."""
    problem = make_tiny_problem()
    rng = np.random.default_rng(seed)
    order = rng.permutation(np.append(np.arange(80), rng.integers(0, 80, 60)))
    pixels = problem.observations[order] + rng.normal(0.0, 5.0, (len(order), 2))
    return problem.replace(
        camera_index=problem.camera_index[order],
        point_index=problem.point_index[order],
        observations=pixels,
    )


@pytest.mark.parametrize("policy", POLICIES)
def test_same_bits_as_the_text_reader(tmp_path: Path, policy: str) -> None:
    problem = with_repeats()
    text, archive = tmp_path / "a.txt", tmp_path / "a.npz"
    write_bal(problem, text)
    write_npz(problem, archive)
    expected = read_bal(text, duplicates=policy)
    assert expected.num_observations == (140 if policy == "keep" else 80)
    assert resolve_duplicates(problem, duplicates=policy) == expected
    assert read_npz(archive, duplicates=policy) == expected


def test_error_is_the_default_and_names_the_same_observation(tmp_path: Path) -> None:
    problem = with_repeats()
    text, archive = tmp_path / "a.txt", tmp_path / "a.npz"
    write_bal(problem, text)
    write_npz(problem, archive)
    with pytest.raises(FormatError) as from_text:
        read_bal(text)
    with pytest.raises(FormatError) as from_archive:
        read_npz(archive)
    assert from_archive.value.field == from_text.value.field
    assert from_archive.value.file == str(archive)
    with pytest.raises(FormatError, match="<memory>"):
        resolve_duplicates(problem)


def test_nothing_to_do_and_nonsense() -> None:
    problem = make_tiny_problem()
    assert resolve_duplicates(problem) is problem
    with pytest.raises(OptionsError, match="last"):
        resolve_duplicates(problem, duplicates="last")


@pytest.mark.parametrize("as_stream", [False, True])
def test_other_formats_are_called_by_name(tmp_path: Path, as_stream: bool) -> None:
    write_npz(make_tiny_problem(), tmp_path / "a.npz")
    write_ply(make_tiny_problem(), tmp_path / "a.ply")
    for name, words in (("a.npz", "read_npz"), ("a.ply", "writes but does not read")):
        path = tmp_path / name
        with pytest.raises(FormatError, match=words):
            read_bal(io.BytesIO(path.read_bytes()) if as_stream else path)
