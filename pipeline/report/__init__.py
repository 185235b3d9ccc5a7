"""The report of a finished run: one HTML page that needs nothing but itself."""

from pipeline.report.write import write_report

__all__ = ["write_report"]
