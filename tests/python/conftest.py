"""What every test of the Python face starts from."""

import signal

# Who starts the tests in the background may ignore Ctrl-C, and programs that they run inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
