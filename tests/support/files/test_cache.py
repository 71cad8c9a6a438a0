"""Entries of the cache are taken only as they were sealed, from folders of the user's own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from haptid.model.kernel.compiler import compile_shared
from haptid.support.files.cache import cache_folder, is_sealed, seal

SOURCE = {"one.c": "int one(void) { return 1; }\n"}


def test_an_entry_that_was_changed_or_truncated_is_not_taken(tmp_path: Path):
    entry = tmp_path / "a.so"
    entry.write_bytes(b"library")
    assert not is_sealed(entry)
    seal(entry)
    assert is_sealed(entry)
    entry.write_bytes(b"lib")
    assert not is_sealed(entry)


def test_a_folder_is_an_entry_too(tmp_path: Path):
    entry = tmp_path / "unpacked"
    (entry / "resources").mkdir(parents=True)
    (entry / "resources" / "a.py").write_text("1", encoding="utf-8")
    seal(entry)
    assert is_sealed(entry)
    (entry / "resources" / "b.py").write_text("2", encoding="utf-8")
    assert not is_sealed(entry)


@pytest.mark.skipif(os.name != "posix", reason="owners and modes are POSIX")
def test_what_others_may_write_and_links_are_not_taken(tmp_path: Path):
    entry = tmp_path / "a.so"
    entry.write_bytes(b"library")
    seal(entry)
    entry.chmod(0o777)
    assert not is_sealed(entry)
    entry.chmod(0o700)
    link = tmp_path / "b.so"
    link.symlink_to(entry)
    seal(link)
    assert not is_sealed(link)


def test_a_truncated_library_heals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HAPTID_CACHE", str(tmp_path))
    library = compile_shared(SOURCE, main=("one.c",))
    whole = library.read_bytes()
    library.write_bytes(whole[:100])
    assert compile_shared(SOURCE, main=("one.c",)) == library
    assert library.stat().st_size == len(whole)


def test_an_empty_variable_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HAPTID_CACHE", "")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder("x") == tmp_path / ".cache" / "haptid" / "x"


def test_a_home_that_is_a_file_costs_one_remark(tmp_path: Path):
    home = tmp_path / "home"
    home.write_text("", encoding="utf-8")
    environment = {**os.environ, "HOME": str(home)}
    environment.pop("HAPTID_CACHE", None)
    script = "from haptid.support.files.cache import cache_folder as f; print(f('a').is_dir(), f('b').is_dir())"
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.stdout.split() == ["True", "True"]
    assert done.stderr.count("\n") == 1
    assert "set HAPTID_CACHE to a folder of yours" in done.stderr


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_another_user_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HAPTID_CACHE", str(tmp_path))
    (tmp_path / "compiled").mkdir()
    os.chown(tmp_path / "compiled", 12345, 12345)
    library = compile_shared(SOURCE, main=("one.c",))
    assert not library.is_relative_to(tmp_path)
