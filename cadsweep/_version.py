"""The version, alone, so that `cadsweep --version` imports nothing else."""

__version__ = "0.1.0"
