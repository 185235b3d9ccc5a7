"""The report of a finished run, one HTML page that needs nothing but itself, and the gallery of its transforms."""

from pipeline.report.write import write_report

__all__ = ["write_report"]
