"""Thesis chapter 8 once more: every method learns the border, then is asked along it, off it, and in other seasons."""

from __future__ import annotations

from collections.abc import Sequence

from andante.baselines import MapMethod, Method, MethodOptions, default_methods
from andante.evaluation.answers import Answers
from andante.evaluation.compare import OWN, Comparison, Entry, enter, require_success
from andante.evaluation.compare_report import mapped_positions, remarks
from andante.evaluation.compare_tables import cost_table, error_table, followed_table
from andante.evaluation.experiments.cache import code_hash
from andante.evaluation.experiments.comparison_world import MAPPED, MAPPED_FRAMES, SEASONAL, SPATIAL, TEMPORAL
from andante.evaluation.experiments.contenders import Contender, fit_map
from andante.evaluation.experiments.outcome import Cell, Outcome, Plot, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.trials import Bench
from andante.evaluation.hardware import Hardware
from andante.evaluation.split import check_split

_TESTS = (TEMPORAL, SPATIAL, *SEASONAL)
_NOTHING = (None,) * 3
# Median, mean, third quartile and maximum in metres; shares beyond 3 m are told in the text.
_THESIS_TEMPORAL: tuple[tuple[Cell, ...], ...] = (
    ("thesis 8.1: SFA", 0.48, 0.63, 0.78, 5.03, None, None, *_NOTHING),
    ("thesis 8.1: Active Search", 0.28, 0.42, 0.51, 5.82, None, None, *_NOTHING),
    ("thesis 8.1: PoseNet", 0.42, 0.66, 0.93, 3.79, None, None, *_NOTHING),
)
_THESIS_SPATIAL: tuple[tuple[Cell, ...], ...] = (
    ("thesis 8.2: SFA", 0.72, 1.04, 1.41, 10.37, None, 3.0, *_NOTHING),
    ("thesis 8.2: Active Search", 0.38, 2.52, 1.81, 94.65, None, 20.0, *_NOTHING),
    ("thesis 8.2: PoseNet", 1.65, 1.95, 2.82, 7.32, None, 20.0, *_NOTHING),
)
# Seconds: mapping (preprocessing, mapping), localizing 284 images (preprocessing, localization).
_THESIS_SECONDS = {
    "thesis 8.3: SFA": (44.0, 5.0, 12.0, 2.0),
    "thesis 8.3: 3D reconstruction (GPU), Active Search": (90.0, 43334.0, 185.0, 294.0),
    "thesis 8.3: PoseNet (GPU)": (120.0, 18000.0, 32.0, 10.0),
}
_GOAL_MEDIAN_M, _GOAL_MEAN_M, _GOAL_OVER_3M, _GOAL_FOLLOWED_M = 0.40, 0.80, 0.03, 0.20


def run_comparison(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """All methods that can be had here; at less than the thesis' scale with less time to learn for those that are slow.

    A run that was killed goes on after the last finished method, on the same machine.
    """
    quick = scale.frames < MAPPED_FRAMES
    methods, left_out = default_methods(MethodOptions(quick=quick))
    found = compared(bench, methods, quick=quick)
    notes = (*_notes(found, quick=quick), *left_out)
    maps = tuple(Contender(one.name, one.config, fit_map) for one in methods if isinstance(one, MapMethod))
    return Outcome(_tables(found), _plots(found), found.as_dict(), maps, notes)


def compared(bench: Bench, methods: Sequence[Method], *, quick: bool) -> Comparison:
    """``andante.evaluation.compare`` on the drives of a bench, with every finished method kept."""
    mapped, tests = bench.recording(MAPPED), tuple(bench.recording(name) for name in _TESTS)
    check_split([mapped], tests, "reference")
    entries = list[Entry]()
    for done, method in enumerate(methods):
        bench.progress("methods", done, len(methods))
        entries.append(entered(bench, method, MAPPED, _TESTS, quick=quick))
    bench.progress("methods", len(methods), len(methods))
    require_success(entries)
    return Comparison((mapped,), tests, "reference", tuple(entries), Hardware.here())


def entered(bench: Bench, method: Method, mapped: str, tests: Sequence[str], *, quick: bool) -> Entry:
    """One method on sessions of a bench, kept once it is finished."""
    key = {
        "compared": method.name,
        "quick": quick,
        "sessions": {name: bench.plan.fingerprint(name) for name in (mapped, *tests)},
        "hardware": Hardware.here().as_dict(),
        "code": code_hash(comparing=True),
    }
    stored = bench.store.load(key)
    if stored is None:
        recordings = [bench.recording(name) for name in tests]
        stored = enter(method, [bench.recording(mapped)], recordings, progress=bench.progress).stored()
        # A library that was missing may be there next time.
        if stored["failure"] is None:
            bench.store.save(key, stored)
    return Entry.restored(stored)


def _tables(found: Comparison) -> tuple[Table, ...]:
    titles = {
        TEMPORAL: ("Along the mapped border half an hour later (thesis table 8.1)", _THESIS_TEMPORAL),
        SPATIAL: ("Across the lawn, where nobody drove (thesis table 8.2)", _THESIS_SPATIAL),
        SEASONAL[0]: ("Along the mapped border in autumn", ()),
        SEASONAL[1]: ("Along the mapped border in snow", ()),
        SEASONAL[2]: ("Across the lawn in autumn", ()),
    }
    errors = [error_table(found.entries, test, title=titles[test][0], thesis=titles[test][1]) for test in _TESTS]
    followed = followed_table(found.entries)
    return (*errors, *((followed,) if followed.rows else ()), _seconds_table(found), cost_table(found.entries))


def _seconds_table(found: Comparison) -> Table:
    """Table 8.3: seconds to learn, and to localize the second run along the border image by image in one thread."""
    done = [one for one in found.entries if one.failure is None]
    rows = {one.name: _seconds(one) for one in done}
    own, images = rows.get(OWN), len(done[0].tests[TEMPORAL].errors)
    shown = [_seconds_row(name, row, own) for name, row in rows.items()]
    thesis = [_seconds_row(name, row, _THESIS_SECONDS["thesis 8.3: SFA"]) for name, row in _THESIS_SECONDS.items()]
    columns = (
        "method",
        *("mapping: preprocessing [s]", "mapping [s]", "total [s]", "times slow features"),
        *(f"localizing {images} images: preprocessing [s]", "localization [s]", "total [s] ", "times slow features "),
    )
    frames = sum(len(one.infos) for one in found.mapped)
    return Table(f"Times for {frames} mapped and {images} localized images (thesis table 8.3: 1083 and 284)", columns,
                 (*shown, *thesis))  # fmt: skip


def _seconds(entry: Entry) -> tuple[float, float, float, float]:
    """Sums, so that a few slow images count; decoding belongs to preprocessing."""
    decode, prepare, locate = entry.tests[TEMPORAL].seconds.sum(axis=0).tolist()
    return entry.preprocessing_s or 0.0, entry.mapping_s or 0.0, decode + prepare, locate


def _seconds_row(
    name: str, row: tuple[float, float, float, float], own: tuple[float, float, float, float] | None
) -> tuple[Cell, ...]:
    mapping, localizing = row[0] + row[1], row[2] + row[3]
    ratios = (None, None) if own is None else (mapping / (own[0] + own[1]), localizing / (own[2] + own[3]))
    shown = [None if ratio is None else f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.2g}" for ratio in ratios]
    return (name, row[0], row[1], mapping, shown[0], row[2], row[3], localizing, shown[1])


def _notes(found: Comparison, *, quick: bool) -> tuple[str, ...]:
    budget = "methods that learn for minutes were cut short (small scale); " if quick else ""
    return (
        f"{budget}measured on {found.hardware}; learning uses as many threads as each method does (PoseNet one), "
        "images are localized one by one in one thread. The thesis' times are those of an Intel i5-6500 and, where "
        "told, a GeForce RTX 2070",
        "errors are those of the best hypothesis of every image, whatever its status; an image without any answer "
        "counts as infinitely wrong in medians, quartiles and shares; single images without odometry, except for the "
        "rows that are followed",
        "the thesis' rows are of a real garden and other images, for orientation",
        *_goals(found),
        *remarks(found),
    )


def _goals(found: Comparison) -> tuple[str, ...]:
    """Whether the goals off the mapped path are met."""
    own = next((one for one in found.entries if one.name == OWN and one.failure is None), None)
    if own is None:
        return ()
    single, followed = own.tests[SPATIAL].figures(), own.followed.get(SPATIAL)
    if single.median_m is None or single.mean_m is None:
        return ()
    reached = (
        single.median_m <= _GOAL_MEDIAN_M and single.mean_m <= _GOAL_MEAN_M and single.share_over_3m <= _GOAL_OVER_3M
    )
    said = [
        f"goal across the lawn, single images: median <= {_GOAL_MEDIAN_M:.2f} m, mean <= {_GOAL_MEAN_M:.2f} m, "
        f"at most {100 * _GOAL_OVER_3M:.0f} % beyond 3 m: {'reached' if reached else 'not reached'} by {OWN} with "
        f"{single.median_m:.3f} m, {single.mean_m:.3f} m and {100 * single.share_over_3m:.1f} %"
    ]
    if followed is not None and (median := followed.figures().median_m) is not None:
        verdict = "reached" if median <= _GOAL_FOLLOWED_M else "not reached"
        said.append(
            f"goal across the lawn, followed: median <= {_GOAL_FOLLOWED_M:.2f} m: {verdict} with {median:.3f} m"
        )
    return tuple(said)


def _plots(found: Comparison) -> tuple[Plot, ...]:
    from andante.evaluation.compare_plots import error_distributions, error_maps

    told = {test: _by_method(found.entries, test) for test in _TESTS}
    mapped = mapped_positions(found)
    captions = {
        "temporal": (TEMPORAL, "Along the mapped border half an hour later (thesis figure 8.3)"),
        "spatial": (SPATIAL, "Across the lawn, where nobody drove (thesis figure 8.5)"),
        "spatial-autumn": (SEASONAL[2], "Across the lawn in autumn, mapped in summer"),
    }
    maps = [
        Plot(suffix, f"{caption}: mapped path grey, triangles beyond 3 m.", error_maps(told[test], mapped))
        for suffix, (test, caption) in captions.items()
    ]
    shares = error_distributions(told)
    return (Plot("", "How often how wrong, by what was tested on (thesis figures 8.4 and 8.6).", shares), *maps)


def _by_method(entries: Sequence[Entry], test: str) -> dict[str, Answers]:
    return {one.name: one.tests[test] for one in entries if one.failure is None}
