"""Experiments that redo the thesis' tables: record in the simulator, learn, localize, write down."""

from andante.evaluation.experiments.cache import default_cache as default_cache
from andante.evaluation.experiments.contenders import CONTENDERS as CONTENDERS
from andante.evaluation.experiments.contenders import Contender as Contender
from andante.evaluation.experiments.outcome import Experiment as Experiment
from andante.evaluation.experiments.outcome import Outcome as Outcome
from andante.evaluation.experiments.outcome import Table as Table
from andante.evaluation.experiments.plans import Scale as Scale
from andante.evaluation.experiments.registry import EXPERIMENTS as EXPERIMENTS
from andante.evaluation.experiments.registry import experiment_named as experiment_named
from andante.evaluation.experiments.running import Written as Written
from andante.evaluation.experiments.running import run_experiment as run_experiment
