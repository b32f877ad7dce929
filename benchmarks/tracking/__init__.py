"""The parts of benchmarks/track.py, one module each."""
