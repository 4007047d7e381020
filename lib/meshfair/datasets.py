"""The real meshes: where they are downloaded from, and where they are kept.

None of them is part of the project; ``make data`` downloads them, once, into
the platform's cache folder, and checks each against its sha256.
"""

import os
import shutil
from pathlib import Path
from typing import NamedTuple

from meshfair.checks import needed_for

FOLDER_VARIABLE = "MESHFAIR_DATA"
MIRROR_VARIABLE = "MESHFAIR_MIRROR"


class Source(NamedTuple):
    """One file to download."""

    file: str
    """Its name in the folder of downloads."""
    repository: str
    """Repository and commit on GitHub, as in its raw addresses."""
    path: str
    """Where it lies in the repository."""
    sha256: str
    """Its checksum, in hexadecimal digits."""
    note: str
    """What it is."""


_OPEN3D = "isl-org/Open3D/ed30e3b61fbe031e106fa64030bec3f698b316b4"
_PIXAR = "mwelponer/PixarUSDWriter/c45f848673db6d621b2d147821795b84d99a7767"
_MODELS = "alecjacobson/common-3d-test-models/8a4f8642acaf43f9cd7b67858a1502e1055ef202"
_GUIDED = "bldeng/GuidedDenoising/b32e79665f6adb6d52db056fd86865306c76a72d"

SOURCES = {
    "knot-open3d": Source(
        "KnotMesh.ply", _OPEN3D, "examples/test_data/knot.ply",
        "bda544c52e075b34effc1d0c5140a47df0d8de3fc6a9ed23418544dc2ddadd06",
        "the knot of the original report",
    ),
    "f16": Source(
        "f16.ply", _PIXAR, "data/f16.ply",
        "ff637f2add56e7214e8d40e41f36657ca00156ddfc810dfa11a718a9b3450699",
        "the F-16 with missiles of the original report, from J. Burkardt's collection",
    ),
    "bunny": Source(
        "stanford-bunny.obj", _MODELS, "data/stanford-bunny.obj",
        "1eb35d1e21ce99e5ce911353b6be278990713448dd9e8f5c9387f9de39b32205",
        "the Stanford bunny (Stanford Computer Graphics Laboratory; non-commercial use)",
    ),
    "fandisk-clean": Source(
        "GuidedDenoising-Fandisk0.3-Original.obj", _GUIDED, "models/Fandisk0.3/Original.obj",
        "d05a56a399db3f8efdff97e95e9db18f055b26d86ef2922dc3f5b64d3e40a0ed",
        "Fandisk, noise-free",
    ),
    "fandisk-noisy": Source(
        "GuidedDenoising-Fandisk0.3-Noisy.obj", _GUIDED, "models/Fandisk0.3/Noisy.obj",
        "acae4757eeb8efdd76f186b4d80318dc109f19302dcb5a7f5ab1d3812a7b2c2f",
        "Fandisk, Gaussian noise of 0.3 mean edge lengths",
    ),
    "bunny-clean": Source(
        "GuidedDenoising-Bunny0.2-Original.obj", _GUIDED, "models/Bunny0.2/Original.obj",
        "67faef9c36fee1e0061c645be4f6a3c6e180dadcef9257ee90a73051ff377cd0",
        "Bunny, noise-free",
    ),
    "bunny-noisy": Source(
        "GuidedDenoising-Bunny0.2-Noisy.obj", _GUIDED, "models/Bunny0.2/Noisy.obj",
        "f95269e503f678281ed884b6230c6153d05e68b27c91d3df4967d5a87c3fd6e5",
        "Bunny, Gaussian noise of 0.2 mean edge lengths",
    ),
}  # fmt: skip


class DownloadError(OSError):
    """A real mesh that could not be fetched; the message says why and what to do."""


def folder() -> Path:
    """The folder the real meshes are kept in.

    Returns
    -------
    pathlib.Path
        The environment variable MESHFAIR_DATA where it is set, else the
        platform's cache folder for this package.
    """
    with needed_for("a real mesh"):
        import pooch

    return Path(os.environ.get(FOLDER_VARIABLE) or pooch.os_cache("meshfair"))


def find(name: str) -> Path | None:
    """The file of a real mesh, where it has been downloaded and is whole.

    Parameters
    ----------
    name : str
        One of `SOURCES`.

    Returns
    -------
    pathlib.Path or None
        None where it is not there; `fetch` gets it.

    Raises
    ------
    ValueError
        No such name.
    """
    with needed_for("a real mesh"):
        import pooch

    source = _source(name)
    path = folder() / source.file
    whole = path.is_file() and pooch.file_hash(str(path)) == source.sha256
    return path if whole else None


def fetch(name: str) -> Path:
    """The file of a real mesh, downloaded where it is not there yet.

    With the environment variable MESHFAIR_MIRROR the files are copied from
    that folder and nothing is downloaded. Either way a file only appears
    under its name once its checksum is right.

    Parameters
    ----------
    name : str
        One of `SOURCES`.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    DownloadError
        No network, no such file, a wrong checksum, or a full disk.
    ValueError
        No such name.
    """
    with needed_for("a real mesh"):
        import pooch

    source = _source(name)
    address = f"https://raw.githubusercontent.com/{source.repository}/{source.path}"
    mirror = os.environ.get(MIRROR_VARIABLE)
    origin = str(Path(mirror) / source.file) if mirror else address
    store = pooch.create(
        folder(), base_url="", registry={source.file: f"sha256:{source.sha256}"},
        urls={source.file: origin},
    )  # fmt: skip
    pooch.get_logger().setLevel("ERROR")
    download = _copy if mirror else pooch.HTTPDownloader(timeout=30)
    try:
        return Path(store.fetch(source.file, downloader=download))
    except ValueError as error:  # pooch's word for a wrong checksum
        raise DownloadError(
            f"{source.file}: what {origin} holds is not the file expected (sha256 should be "
            f"{source.sha256}); nothing was kept, try again or report it"
        ) from error
    except OSError as error:  # that of the download too, by requests
        reason = getattr(error, "strerror", None) or type(error).__name__
        raise DownloadError(
            f"{source.file}: cannot be had from {origin} ({reason}); check the network or the "
            f"disk, or set {MIRROR_VARIABLE} to a folder that holds the file"
        ) from error


def _source(name: str) -> Source:
    if name not in SOURCES:
        raise ValueError(f"no real mesh is called {name!r}; there are {', '.join(SOURCES)}")
    return SOURCES[name]


def _copy(origin: str, target: str, _: object) -> None:
    """Pooch's downloader for a mirror folder; pooch itself knows no file addresses."""
    shutil.copyfile(origin, target)
