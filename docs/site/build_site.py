"""The documentation site: `make docs`, or `python docs/site/build_site.py [--rust DIR]`.

The build needs no network, and neither does the site. Steps, each in a file of its own:

- here: the pages of docs/, CONTRIBUTING.md and CHANGELOG.md are copied to a folder of sources;
- `api_pages`, `command_page`, `answer_page`, `notebook_page`: pages that follow from the program;
- `pictures`: the pictures, and the gallery that shows them;
- `conf`: Sphinx makes HTML of it, and a warning ends the build;
- `check_site`: every link inside the site has its target, and nothing is loaded from elsewhere.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import answer_page
import api_pages
import check_site
import command_page
import notebook_page
import pictures

HERE = Path(__file__).parent
TOP = HERE.parents[1]
DOCS = TOP / "docs"
SCRIPTS = ("site", "claims")  # folders of docs/ that hold no pages
OUTSIDE = {  # pages that lie elsewhere in the repository, and their names on the site
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
LINK = re.compile(r"(\]\()([^)\s#]+)((?:#[^)\s]*)?\))")
PICTURE = re.compile(r"^<!-- picture: (\S+) \| (.+) -->$", re.MULTILINE)
NOT_RUN = re.compile(r"^ *<!-- *not run:.*-->\n", re.MULTILINE)


def place_on_site(path: Path) -> str:
    """The place of a file of the repository among the staged pages."""
    inside = path.relative_to(TOP).as_posix()
    if inside in OUTSIDE:
        return OUTSIDE[inside]
    if inside.startswith("docs/"):
        return inside.removeprefix("docs/")
    raise SystemExit(f"{inside} is linked to, but it has no place on the site")


def for_site(page: Path) -> str:
    """The text of a page with its links and pictures as the site has them."""
    folder = Path(place_on_site(page)).parent

    def from_here(place: str) -> str:
        return os.path.relpath(place, folder).replace(os.sep, "/")

    def link(found: re.Match[str]) -> str:
        if "://" in found[2]:
            return found[0]
        target = Path(os.path.normpath(page.parent / found[2]))
        return found[1] + from_here(place_on_site(target)) + found[3]

    text = NOT_RUN.sub("", page.read_text(encoding="utf-8"))
    text = LINK.sub(link, text)
    return PICTURE.sub(lambda m: f"![{m[2]}]({from_here(f'pictures/{m[1]}')})", text)


def stage(source: Path) -> None:
    """Copy every page to the folder of sources, and the pictures that are kept."""
    shutil.rmtree(source, ignore_errors=True)
    pages = [page for page in DOCS.rglob("*.md") if page.relative_to(DOCS).parts[0] not in SCRIPTS]
    for page in [*pages, TOP / "CONTRIBUTING.md", TOP / "CHANGELOG.md"]:
        copy = source / place_on_site(page)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(for_site(page), encoding="utf-8")
    shutil.copytree(DOCS / "img", source / "img")


def sphinx(source: Path, out: Path) -> None:
    """HTML of the sources; a warning ends the build."""
    command = [sys.executable, "-m", "sphinx", "--quiet", "--builder", "html"]
    command += ["--fail-on-warning", "--jobs", "auto"]
    command += ["--conf-dir", str(HERE), "--doctree-dir", str(source.with_name("docs-doctrees"))]
    if subprocess.run([*command, str(source), str(out)], check=False).returncode:
        raise SystemExit("Sphinx found something wrong with the pages: see above")


def main() -> int:
    parser = argparse.ArgumentParser(description="Build the documentation site.")
    parser.add_argument("--out", type=Path, default=TOP / "out" / "docs", help="folder of the site")
    parser.add_argument("--rust", type=Path, metavar="DIR", help="what `cargo doc` has built")
    keep = "take the pictures of the last build, which is quicker"
    parser.add_argument("--keep-pictures", action="store_true", help=keep)
    options = parser.parse_args()
    out: Path = options.out.absolute()
    source = out.with_name("docs-source")
    began = time.perf_counter()

    def told(step: str) -> None:
        print(f"{time.perf_counter() - began:6.1f} s  {step}", flush=True)

    stage(source)
    told("pages staged")
    api_pages.write(source)
    command_page.write(source)
    answer_page.write(source)
    notebook_page.write(source)
    told("pages of the Python API, the command line, the JSON answer and the notebook")
    pictures.write(source, out.with_name("docs-pictures"), options.keep_pictures)
    told("pictures and gallery")
    shutil.rmtree(out, ignore_errors=True)
    sphinx(source, out)
    told("Sphinx")
    if options.rust:
        shutil.copytree(options.rust, out / "rust")
    else:
        print("        no --rust: the pages of the Rust API are left out, and links to them fail")
    wrong = check_site.problems(out)
    for line in wrong:
        print(line, file=sys.stderr)
    told(f"links checked: {len(wrong)} problems")
    if not wrong:
        print(f"{out / 'index.html'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
