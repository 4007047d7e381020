import hashlib

import pytest

from meshfair import datasets


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MESHFAIR_DATA", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_from_a_mirror(mirror, own_folder):
    assert datasets.find("f16") is None
    path = datasets.fetch("f16")
    assert path == datasets.find("f16") == own_folder / "f16.ply"
    assert hashlib.sha256(path.read_bytes()).hexdigest() == datasets.SOURCES["f16"].sha256


def test_the_registry_names_the_mirrors_files(mirror):
    for source in datasets.SOURCES.values():
        content = (mirror / source.file).read_bytes()
        assert hashlib.sha256(content).hexdigest() == source.sha256


def test_a_damaged_file_in_the_cache_is_not_used_and_fetched_again(mirror, own_folder):
    path = datasets.fetch("f16")
    path.write_bytes(path.read_bytes()[:1000])
    assert datasets.find("f16") is None
    assert datasets.fetch("f16") == datasets.find("f16")


def test_a_wrong_checksum_leaves_nothing(tmp_path, monkeypatch, own_folder):
    (tmp_path / "f16.ply").write_text("ply\n")
    monkeypatch.setenv("MESHFAIR_MIRROR", str(tmp_path))
    with pytest.raises(datasets.DownloadError, match=r"f16.ply.*not the file expected"):
        datasets.fetch("f16")
    assert list(own_folder.iterdir()) == []


def test_a_missing_file_names_the_place(tmp_path, monkeypatch, own_folder):
    monkeypatch.setenv("MESHFAIR_MIRROR", str(tmp_path))
    with pytest.raises(datasets.DownloadError, match=r"No such file.*MESHFAIR_MIRROR"):
        datasets.fetch("bunny")
    assert list(own_folder.iterdir()) == []


def test_no_network(monkeypatch, own_folder):
    monkeypatch.delenv("MESHFAIR_MIRROR", raising=False)
    # Port 9 of this machine: nothing listens there, so the proxy refuses at once.
    for name in ("HTTPS_PROXY", "https_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    with pytest.raises(datasets.DownloadError, match=r"cannot be had .*check the network") as error:
        datasets.fetch("f16")
    assert "\n" not in str(error.value)
    assert list(own_folder.iterdir()) == []


def test_an_unknown_name():
    with pytest.raises(ValueError, match="no real mesh is called 'teapot'; there are knot-open3d"):
        datasets.fetch("teapot")
