import pytest

from andante.evaluation import ErrorFigures, Figures, figures_of
from andante.evaluation.verdict import verdict


def figures(median, mean, p95, unit="m"):
    errors = figures_of([], unit)
    values = {"median": median, "mean": mean, "p95": p95}
    if unit == "m":
        known = {f"{name}_m": value for name, value in values.items()}
    else:
        known = {"places": type(errors.places)(**values)}
    unknown = dict.fromkeys(("coverage_90", "heading_median_deg", "ms_per_image", "ms_localize", "lost_share"))
    return Figures(n_errors=9, n=9, unlocalized=0, statuses={}, answered=ErrorFigures(n_errors=0), **known, **unknown)


@pytest.mark.parametrize(
    ("own", "others", "said"),
    [
        ((1, 2, 3), {}, None),
        ((1, 2, 3), {"a": (2, 3, 4)}, "The map is better than every baseline in median, mean and 95 % error."),
        ((1, 2, 3), {"a": (1, 2, 3)}, "The best baseline is as good as the map in median, mean and 95 % error."),
        ((1.0001, 2, 3), {"a": (1.0, 3, 3)}, "The map is better than every baseline in mean."),
        (
            (1, 2, 3),
            {"a": (0.5, 1.5, 9), "b": (0.7, 9, 9)},
            "The map does not win everywhere: a is better in median (0.500 against 1.000 m) and mean (1.500 "
            "against 2.000 m). It is better than every baseline in 95 % error.",
        ),
        (
            (1, 2, 3),
            {"a": (0.5, 2, 3), "b": (1, 1, 3)},
            "The map does not win: a is better in median (0.500 against 1.000 m); b is better in mean "
            "(1.000 against 2.000 m).",
        ),
    ],
)
def test_sentence(own, others, said):
    assert verdict(figures(*own), {name: figures(*values) for name, values in others.items()}) == said


def test_places_are_compared_in_places():
    said = verdict(figures(3, 3, 3, "place"), {"nearest-1": figures(1, 3, 3, "place")})
    assert said == "The map does not win: nearest-1 is better in median (1.0 against 3.0 places)."


def test_nothing_to_compare():
    assert verdict(figures(None, None, None), {"a": figures(1, 1, 1)}) is None
