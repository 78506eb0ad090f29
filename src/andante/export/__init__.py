"""A map in, a file for other runtimes out."""

from andante.export.onnx_file import ExportedMap as ExportedMap
from andante.export.onnx_file import export_onnx as export_onnx
