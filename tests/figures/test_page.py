"""The docs' pages: tables are those of the stored results, which are of the shipped weights."""

import json

import pytest
from figures import page

from urushi.nets.weights import default_model


@pytest.mark.parametrize("name", page.names())
def test_the_docs_show_the_stored_results(name):
    """Tables and sources."""
    assert page.tables(name)
    for path, text in page.shown(name).items():
        assert path.read_text() == text


#: Figures without networks, whose results no weights change.
WALKS = {"simulator_biases", "slabs"}


@pytest.mark.parametrize("name", sorted({*page.names()} - WALKS))
def test_results_of_networks_are_of_the_shipped_weights(name):
    found = json.loads((page.FOLDER / name / "results.json").read_text())
    assert found["weights"] == default_model().fingerprint, "stale: run `make figures`"


def test_a_table_is_replaced_whole_and_the_text_beside_it_stays():
    old, new = (page.table(["a", "b"], rows) for rows in ([["1", "2"]], [["3", "4"], ["5", "6"]]))
    assert new == "| a | b |\n|---|---|\n| 3 | 4 |\n| 5 | 6 |"
    other = page.table(["a", "c"], [["7", "8"]])
    for text in (f"One.\n\n{{}}\n\nTwo.\n\n{other}\n", f"{other}\n\n{{}}"):
        assert page.replaced(text.format(old), new) == text.format(new)
    for text, count in ((other, 0), (f"{old}\n\n{old}", 2)):
        with pytest.raises(ValueError, match=f"the page has {count} tables"):
            page.replaced(text, new)
