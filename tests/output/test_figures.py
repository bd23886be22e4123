"""Pictures in files."""

import pytest

from porousmold.output.figures import plt, save


@pytest.mark.parametrize("name", ["$x^{$ <b>t</b>", "100 $ or $\\nothing{$", "plain", "$\\phi$"])
def test_a_name_that_is_no_formula_is_drawn_as_text(tmp_path, name):
    figure, axes = plt.subplots()
    axes.plot([0.0, 1.0], label=name)
    axes.set_xticks([0.0], [name])
    axes.legend()
    assert save(figure, tmp_path / "picture.png").stat().st_size > 1000
