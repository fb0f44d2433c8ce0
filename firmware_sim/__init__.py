"""The robots' world: circular differential-drive robots that run a generated controller and see each other, no more.

A user of the compiler's library like any other: it goes through `fuzzyspec.api` alone.
"""
