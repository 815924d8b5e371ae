"""The document's types for the page's modules, made from `types.py`: `web/types.d.ts`.

    declarations    the text of the file

`python -m cbpt.page.document.typescript` writes it; a test compares it with what is committed.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

SOURCES = tuple(map(Path(__file__).with_name, ("types.py", "drive_types.py")))
TARGET = Path(__file__).parents[1] / "web" / "types.d.ts"
_HEAD = """\
/**
 * The page's document; made from `page/document/types.py` by
 * `python -m cbpt.page.document.typescript`.
 */
"""
_NAMES = {
    "str": "string",
    "int": "number",
    "float": "number",
    "bool": "boolean",
    "None": "null",
    "Any": "Any",
}
_ANY = "// deno-lint-ignore no-explicit-any\nexport type Any = any;\n"
_WIDTH = 100


def declarations() -> str:
    """The file as it has to be."""
    files = (ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES)
    body = [node for file in files for node in file.body]
    parts = [_HEAD, _ANY]
    for node, below in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef):
            parts.append("".join(_interface(node)))
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if name != "__all__":
                parts.append(_comment(_text(below), "") + _alias(name, node.value))
    return "\n".join(parts)


def _interface(node: ast.ClassDef) -> Iterator[str]:
    yield _comment(ast.get_docstring(node), "")
    bases = [b.id for b in node.bases if isinstance(b, ast.Name) and b.id != "TypedDict"]
    more = f" extends {', '.join(bases)}" if bases else ""
    yield f"export interface {node.name}{more} {{\n"
    for field, below in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            yield _comment(_text(below), "  ")
            yield _field(field.target.id, field.annotation)
    yield "}\n"


def _alias(name: str, value: ast.expr) -> str:
    if isinstance(value, ast.Call):  # TypedDict("Name", {"key": type})
        fields = value.args[1]
        assert isinstance(fields, ast.Dict)
        inside = "".join(
            _field(ast.literal_eval(key), kind)
            for key, kind in zip(fields.keys, fields.values, strict=True)
            if key is not None
        )
        return f"export interface {name} {{\n{inside}}}\n"
    return f"export type {name} = {_type(value)};\n"


def _field(name: str, annotation: ast.expr) -> str:
    optional = ""
    if isinstance(annotation, ast.Subscript) and _name(annotation.value) == "NotRequired":
        annotation, optional = annotation.slice, "?"
    line = f"  {name}{optional}: {_type(annotation)};\n"
    if len(line) <= _WIDTH:
        return line
    choices = "".join(f"\n    | {part}" for part in _type(annotation).split(" | "))
    return f"  {name}{optional}:{choices};\n"


def _type(node: ast.expr) -> str:
    if isinstance(node, ast.Constant) and node.value is None:
        return "null"
    if isinstance(node, ast.Name):
        return _NAMES.get(node.id, node.id)
    if isinstance(node, ast.BinOp):
        sides = [*_type(node.left).split(" | "), *_type(node.right).split(" | ")]
        return " | ".join(dict.fromkeys(sides))
    assert isinstance(node, ast.Subscript), ast.dump(node)
    inside = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    kind = _name(node.value)
    if kind == "Literal":
        return " | ".join(f'"{ast.literal_eval(choice)}"' for choice in inside)
    types = [_type(each) for each in inside]
    if kind == "list":
        return f"({types[0]})[]" if "|" in types[0] else f"{types[0]}[]"
    if kind == "tuple":
        return f"[{', '.join(types)}]"
    assert kind == "dict", kind
    return f"Record<{types[0]}, {types[1]}>"


def _name(node: ast.expr) -> str:
    assert isinstance(node, ast.Name), ast.dump(node)
    return node.id


def _text(node: ast.stmt | None) -> str | None:
    """The text that stands below something as its description."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return str(node.value.value)
    return None


def _comment(text: str | None, indent: str) -> str:
    lines = [line.strip() for line in (text or "").split("\n") if line.strip()]
    if not lines:
        return ""
    if len(lines) == 1:
        return f"{indent}/** {lines[0]} */\n"
    inside = "".join(f"{indent} * {line}\n" for line in lines)
    return f"{indent}/**\n{inside}{indent} */\n"


if __name__ == "__main__":
    TARGET.write_text(declarations(), encoding="utf-8")
