"""The command line: adapters without algorithms, one module per command."""

from andante.cli.app import app as app
from andante.cli.app import main as main
