import pickle

from andante.errors import MissingExtraError


def test_a_missing_extra_is_told_from_another_process_as_well():
    error = MissingExtraError("embreex", "sim")
    assert str(error) == "embreex is not installed; install it with: pip install 'andante[sim]'"
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
