"""Download the real meshes into the cache folder, each checked by its sha256.

MESHFAIR_MIRROR=DIR takes them from a folder instead of the network,
MESHFAIR_DATA=DIR keeps them elsewhere.
"""

import argparse
import sys

from meshfair import datasets


def main() -> int:
    """Fetch the meshes named, or all; one line a file, exit code 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"which (default all): {', '.join(datasets.SOURCES)}",
    )
    names = parser.parse_args().names or list(datasets.SOURCES)
    failed = 0
    for name in names:
        try:
            print(f"{name}: {datasets.fetch(name)}")
        except (ValueError, datasets.DownloadError) as error:
            failed = 1
            print(f"{name}: {error}", file=sys.stderr)
    return failed


if __name__ == "__main__":
    sys.exit(main())
