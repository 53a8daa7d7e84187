"""Fetching the on-board log from the autopilot over the link, after landing.

The recorder alone owns the link: it records what comes, and sends on what it is asked to. A
download follows its record and asks for what is missing, until every byte is there.
"""

from gsapp.telemetry.log_download.log_fetcher import DownloadedLog, LogFetcher, parse_log_link
from gsapp.telemetry.log_download.log_protocol import DownloadState, LogEntry

__all__ = ["DownloadState", "DownloadedLog", "LogEntry", "LogFetcher", "parse_log_link"]
