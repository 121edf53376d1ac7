"""Compiled code must not outlive the sources it was made of."""

from backends.virtual.plant.compiled import sources_digest
from backends.virtual.plant.run import advance


def test_cache_is_named_after_the_sources():
    assert sources_digest() in advance._cache._cache_file._index_name


def test_digest_follows_every_module(tmp_path):
    (tmp_path / "a.py").write_text("x = 1")
    (tmp_path / "b.py").write_text("y = 1")
    before = sources_digest.__wrapped__(tmp_path)
    (tmp_path / "b.py").write_text("y = 2")
    assert sources_digest.__wrapped__(tmp_path) != before
