import numpy as np
import pytest

from andante.baselines import PrincipalComponents, training_frames
from andante.mapping import build_map
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout


@pytest.mark.parametrize(
    ("kind", "readout"),
    [("local", LocalReadout), ("polynomial", PolynomialReadout), ("gaussian-process", GaussianProcessReadout)],
)
def test_it_reads_out_as_the_map_does(slowmap, make_drive, kind, readout):
    drives = [make_drive(1), make_drive(2)]
    config = slowmap.config.with_values({"readout": {"kind": kind, "inputs": 4}})
    other = build_map(drives, config)
    baseline = PrincipalComponents.fit(other, training_frames(other, drives))
    assert baseline.name == "pca + same readout"
    assert type(baseline.readout) is readout is type(other.readout)
    assert baseline.pca.output_dim == other.model.output_dim
    assert baseline.position(other.front_end.features(make_drive(3).load(make_drive(3).infos[4]))).shape == (2,)


def test_the_readout_has_the_settings_of_the_map_and_no_metric(slowmap, make_drive):
    baseline = PrincipalComponents.fit(slowmap, training_frames(slowmap, [make_drive(1), make_drive(2)]))
    assert baseline.readout.consensus_m == slowmap.readout.consensus_m
    assert baseline.readout.neighbours == slowmap.readout.neighbours
    assert len(baseline.readout.xy) == len(slowmap.readout.xy)
    assert np.all(baseline.readout.metric == 1)
