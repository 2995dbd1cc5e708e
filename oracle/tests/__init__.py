"""Tests of the oracle: it must accept correct results and reject wrong ones."""
