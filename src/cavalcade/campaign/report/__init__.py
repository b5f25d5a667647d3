"""The report of a campaign: Markdown with figures, one self-contained page, and the table."""

from __future__ import annotations

from cavalcade.campaign.report.writing import write_report

__all__ = ["write_report"]
