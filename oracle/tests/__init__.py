"""Tests of the oracle: what it must accept, and what it must not."""
