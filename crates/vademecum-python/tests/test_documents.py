"""The lines of the documents run as they stand."""

import re
from pathlib import Path

import pytest

CRATE = Path(__file__).parents[1]
HOW_TO = CRATE.parents[1] / "docs/how-to"
PAGES = [CRATE / "README.md", HOW_TO / "python.md", HOW_TO / "gradients.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_lines_of_a_page_run(page, beam, tmp_path, monkeypatch, capsys):
    beam.save(tmp_path / "body.vdm")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, str(page), "exec"), {})
    assert capsys.readouterr().out.startswith("[")
