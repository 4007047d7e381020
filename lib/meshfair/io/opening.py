"""A file before it is parsed: whether it is one, what it looks like, and its bytes."""

import codecs
import gzip
import io
import re
import zlib
from pathlib import Path
from typing import BinaryIO

from meshfair.io.errors import file_error, quoted

# Meshes shrink 3 to 30 times when packed. What grows far more is no mesh, and
# would fill the memory.
LARGEST_RATIO = 100
NEVER_TOO_LARGE = PIECE = 1 << 24

GZIP = "gzip-compressed data"
# How files begin that are found under the name of a mesh. A format of meshes is
# here to tell in the message what the file is; its own reader checks all of it.
SIGNATURES = {
    GZIP: rb"\A\x1f\x8b",
    "a zip archive": rb"\APK(\x03\x04|\x05\x06)",
    "bzip2-compressed data": rb"\ABZh\d",
    "xz-compressed data": rb"\A\xfd7zXZ",
    "zstd-compressed data": rb"\A\x28\xb5\x2f\xfd",
    "a 7z archive": rb"\A7z\xbc\xaf",
    "a rar archive": rb"\ARar!",
    "a git-LFS pointer": rb"\Aversion https://git-lfs",
    "an HTML or XML page": rb"\A\s*<",
    "JSON": rb"\A\s*[{\[]",
    "glTF": rb"\AglTF",
    "a document or an image": rb"\A(%PDF|\x89PNG|\xff\xd8\xff|GIF8)",
    "UTF-16 text": rb"\A(\xff\xfe|\xfe\xff)",
    "PLY": rb"\A\s*ply\s",
    "OFF": rb"\A\s*(ST|C|N|4)*OFF\s",
    "binary data": rb"\0",
    "STL": rb"\A\s*(?i:solid)\b",
    "OBJ": rb"(\A|[\r\n])[ \t]*v[ \t]+[-+.\d]",
}


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading; reading from a pipe or device may never end."""
    try:
        if path.is_file():
            return path.open("rb")
        found = "it is a folder, pipe or device" if path.exists() else "there is no such file"
    except OSError as error:
        found = str(error.strerror)
    raise file_error("opening", found, "a regular file was expected", "check the path")


def check_content(stream: BinaryIO, *expected: str) -> str | None:
    """The kind that a stream begins like, if any; an error if it is not an expected one."""
    head = stream.read(4096)
    stream.seek(0)
    if not head:
        raise file_error("byte 0", "the file is empty", f"{expected[0]} was expected")
    beginning = head.removeprefix(codecs.BOM_UTF8)
    kind = next((kind for kind, sign in SIGNATURES.items() if re.search(sign, beginning)), None)
    if kind not in (None, *expected):
        found = f"the file looks like {kind} and begins with {quoted(head)}"
        advice = "name it by what it is, or download or export it again"
        raise file_error("byte 0", found, f"{expected[0]} was expected", advice)
    return kind


def decompressed(file: BinaryIO) -> BinaryIO:
    """The content of a gzip file as a stream, unless it grows beyond reason."""
    check_content(file, GZIP)
    content = io.BytesIO()
    try:
        unpacked = gzip.GzipFile(fileobj=file)
        while piece := unpacked.read(PIECE):
            content.write(piece)
            if content.tell() > max(NEVER_TOO_LARGE, LARGEST_RATIO * file.tell()):
                raise file_error(
                    f"byte {file.tell()}",
                    f"it has grown to {content.tell()} bytes when unpacked",
                    "a mesh would be smaller",
                    "unpack it with gunzip if it is to be trusted",
                )
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise file_error(
            f"byte {file.tell()}", str(error), "whole gzip data was expected"
        ) from None
    content.seek(0)
    return content
