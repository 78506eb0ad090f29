from andante.evaluation.standings import COSTS, ERRORS, SHARES, standings


def errors(median, mean, largest):
    return {"median_m": median, "mean_m": mean, "max_m": largest}


def test_who_beats_us_is_said_first():
    values = {"andante": errors(0.05, 0.06, 0.5), "nearest-5": errors(0.04, 0.06, 9.0), "ridge": errors(0.045, 1, 0.4)}
    assert standings("andante", values, ERRORS) == (
        "nearest-5 has the smaller median: 0.040 against 0.050 m (so does ridge); "
        "ridge has the smaller largest error: 0.400 against 0.500 m; "
        "no other method has a smaller mean than andante"
    )


def test_as_precisely_as_tables():
    values = {"andante": errors(0.05, 0.06, 0.5), "other": errors(0.0499, 0.0599, 0.4999)}
    assert standings("andante", values, ERRORS) == (
        "no other method has a smaller median, mean or largest error than andante"
    )


def test_unknown_values():
    values = {"andante": errors(None, 0.1, 0.1), "other": errors(0.4, None, 0.4)}
    assert standings("andante", values, ERRORS) == (
        "andante has no median; no other method has a smaller mean or largest error than andante"
    )


def test_nothing_to_compare():
    assert standings("andante", {"ridge": errors(1, 1, 1), "other": errors(2, 2, 2)}, ERRORS) == ""
    assert standings("andante", {"andante": errors(1, 1, 1)}, ERRORS) == ""


def test_costs():
    values = {
        "andante": {"learning_s": 5.0, "ms_per_image": 2.0, "bytes": 200_000},
        "one": {"learning_s": 1.0, "ms_per_image": 3.0, "bytes": 10_000},
    }
    assert standings("andante", values, COSTS) == (
        "one maps faster: 1.0 against 5.0 s; one is smaller: 10 against 200 kB; "
        "no other method has a smaller time to localize than andante"
    )


def test_shares_and_headings():
    values = {
        "andante": {"share_over_3m": 0.02, "heading_median_deg": 0.1},
        "one": {"share_over_3m": 0.0, "heading_median_deg": None},
    }
    assert standings("andante", values, SHARES) == (
        "one has the smaller share beyond 3 m: 0.0 against 2.0 %; "
        "no other method has a smaller error of the heading than andante"
    )
