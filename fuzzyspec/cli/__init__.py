"""The command line: one module a command, each with ``register``; heavy imports happen when a command runs."""
