"""Packs a folder: `python3 pack.py FOLDER ARCHIVE`, of which the name ends in .tar.gz or .zip.

The same files give the same bytes: sorted, of nobody, readable by all, with SOURCE_DATE_EPOCH as their time.
"""

import gzip
import io
import os
import sys
import tarfile
import time
import zipfile
from pathlib import Path


def mode(folder: Path, file: Path) -> int:
    return 0o755 if file.is_dir() or file.parent == folder / "bin" else 0o644


def tar(folder: Path, files: list[Path], seconds: int) -> bytes:
    packed = io.BytesIO()
    with (
        gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=packed, mtime=0) as compressed,
        tarfile.open(fileobj=compressed, mode="w", format=tarfile.PAX_FORMAT) as archive,
    ):
        for file in files:
            entry = archive.gettarinfo(file, file.relative_to(folder.parent).as_posix())
            entry.uid = entry.gid = 0
            entry.uname = entry.gname = ""
            entry.mtime = seconds
            entry.mode = mode(folder, file)
            if file.is_dir():
                archive.addfile(entry)
            else:
                with file.open("rb") as content:
                    archive.addfile(entry, content)
    return packed.getvalue()


def zipped(folder: Path, files: list[Path], seconds: int) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file in files:
            if file.is_dir():
                continue
            entry = zipfile.ZipInfo(file.relative_to(folder.parent).as_posix(), time.gmtime(seconds)[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = mode(folder, file) << 16
            archive.writestr(entry, file.read_bytes())
    return packed.getvalue()


def main() -> None:
    folder, archive = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    seconds = int(os.environ["SOURCE_DATE_EPOCH"])
    files = sorted([folder, *folder.rglob("*")], key=Path.as_posix)
    pack = zipped if archive.suffix == ".zip" else tar
    part = archive.with_name(archive.name + ".part")
    part.write_bytes(pack(folder, files, seconds))
    part.replace(archive)


main()
