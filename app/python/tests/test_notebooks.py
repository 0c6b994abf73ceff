"""Runs the notebooks of docs/notebooks in a kernel of Jupyter: each cell has to succeed, and pictures and tables to show
themselves. `python test_notebooks.py [NAME…]` runs those named, else all; `--code DIR` writes their code, for mypy."""

import sys
import time
from pathlib import Path
from typing import Any

import nbformat

NOTEBOOKS = Path(__file__).resolve().parents[3] / "docs" / "notebooks"

SHOWN = {
    "costly-voxels": {"image/png": 1, "text/html": 2},
    "own-structure": {},
    "paper-tables": {"image/png": 2, "text/html": 1},
}
"""What each shows, at least: so many outputs of a kind."""


def read(name: str) -> Any:
    # Its functions have no types.
    library: Any = nbformat
    notebook = library.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    library.validate(notebook)
    return notebook


def code(name: str) -> str:
    notebook = read(name)
    return "\n\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code") + "\n"


def run(name: str) -> None:
    from nbclient import NotebookClient

    begin = time.monotonic()
    notebook = read(name)
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [kind for output in outputs for kind in output.get("data", {})]
    for kind, count in SHOWN[name].items():
        assert shown.count(kind) >= count, f"{name}: {shown.count(kind)} outputs of {kind}, expected {count}"
    assert not any(output.get("name") == "stderr" for output in outputs), f"{name}: it writes to stderr"
    print(f"{name}: {len(outputs)} outputs in {time.monotonic() - begin:.1f} s")


if __name__ == "__main__":
    assert sorted(SHOWN) == sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb"))
    arguments = sys.argv[1:]
    if arguments[:1] == ["--code"]:
        for name in SHOWN:
            Path(arguments[1], f"{name.replace('-', '_')}.py").write_text(code(name))
    else:
        for name in arguments or SHOWN:
            run(name)
