"""Tests send Ctrl-C to themselves, which a shell has background jobs ignore."""

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
