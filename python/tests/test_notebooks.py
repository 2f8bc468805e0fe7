"""Notebooks run, and their pages show what they do."""

import importlib.util
import re

import pytest

from conftest import ROOT

pytest.importorskip("matplotlib")
pytest.importorskip("zarr")

FOLDER = ROOT / "docs" / "notebooks"
_found = importlib.util.spec_from_file_location("make", FOLDER / "make.py")
make = importlib.util.module_from_spec(_found)
_found.loader.exec_module(make)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", make.names())
def test_val_page_of_a_notebook(name, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    page = make.page(name, tmp_path)
    assert page == (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[.+\]\(pictures/(.+)\)", page)
    assert pictures
    for picture in pictures:
        assert (tmp_path / picture).stat().st_size > 0
        assert (FOLDER / "pictures" / picture).stat().st_size < 150_000
